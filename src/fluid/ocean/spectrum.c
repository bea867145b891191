/* A sea from its spectrum: Tessendorf, Simulating Ocean Water (SIGGRAPH course notes, 2001).
 *
 * h(k, t) = h0(k) exp(-i w t) + conj(h0(-k)) exp(i w t), so that h0(k) runs along k; displacement is
 * i k / |k| h. The surface is the inverse transform of both; height and dx share one, as real and imaginary
 * part. */
#include <math.h>

#include "base/detmath.h"
#include "base/rng.h"
#include "fluid/ocean/state.h"

#define TURN 6.283185307179586

/* Part of the block: h0 of every wave vector, the transform's plan, two fields and its work array. */

typedef struct parts {
    ll_complex *h0, *first, *second, *work;
    ll_fft *plan;
} parts;

static parts parts_of(const ll_ocean *o)
{
    int64_t points = o->setup.n * o->setup.n;
    ll_complex *at = ll_ocean_part(o, o->at_method);
    return (parts){at, at + points, at + 2 * points, at + 3 * points, (ll_fft *)(void *)(at + 4 * points)};
}

static size_t size(const ll_ocean_setup *s)
{
    return 4 * (size_t)(s->n * s->n) * sizeof(ll_complex) + ll_fft_size((int32_t)s->n);
}

static int64_t signed_index(int64_t i, int64_t n)
{
    return i < n / 2 ? i : i - n;
}

/* Energy of a wave vector: that of its frequency, spread over directions by the squared cosine to the
 * wind. */
static double energy(const ll_ocean_setup *s, const ll_wave *w)
{
    double along = (w->kx * ll_cos(s->wind_angle) + w->kz * ll_sin(s->wind_angle)) / w->k;
    if (along <= 0)
        return 0;
    double deep = sqrt(s->gravity * w->k), slope = 0.5 * s->gravity / deep; /* dw/dk */
    return ll_ocean_energy(s, deep) * slope / w->k * 4 / TURN * along * along;
}

static void init(ll_ocean *o)
{
    const ll_ocean_setup *s = &o->setup;
    parts p = parts_of(o);
    int64_t n = s->n;
    double cell = TURN / s->length * (TURN / s->length);
    ll_fft_init(p.plan, (int32_t)n);
    for (int64_t j = 0; j < n; j++)
        for (int64_t i = 0; i < n; i++) {
            int64_t mx = signed_index(i, n), mz = signed_index(j, n);
            /* No mean, and no Nyquist mode, which has no counterpart. */
            if ((mx == 0 && mz == 0) || 2 * i == n || 2 * j == n)
                continue;
            ll_wave w = ll_wave_of(s, mx, mz);
            double scale = sqrt(energy(s, &w) * cell / 4);
            /* By wave vector, not by index: a finer grid has the same waves and more. */
            uint64_t counter = (uint64_t)((mz + 4096) * 8192 + mx + 4096);
            p.h0[j * n + i] = (ll_complex){scale * ll_rng_normal((uint64_t)s->seed, 2, counter),
                                           scale * ll_rng_normal((uint64_t)s->seed, 3, counter)};
        }
}

/* h(k, t) at index (i, j) of the transform. */
static ll_complex height_of(const ll_ocean *o, const parts *p, const ll_wave *w, int64_t i, int64_t j,
                            ll_time t)
{
    int64_t n = o->setup.n;
    ll_complex a = p->h0[j * n + i], b = p->h0[(n - j) % n * n + (n - i) % n];
    double angle = ll_wave_angle(&o->setup, w, t), c = ll_cos(angle), s = ll_sin(angle);
    return (ll_complex){(a.re + b.re) * c + (a.im + b.im) * s, (a.im - b.im) * c - (a.re - b.re) * s};
}

static void evaluate(ll_ocean *o, ll_time t)
{
    parts p = parts_of(o);
    int64_t n = o->setup.n;
    for (int64_t j = 0; j < n; j++)
        for (int64_t i = 0; i < n; i++) {
            int64_t at = j * n + i, mx = signed_index(i, n), mz = signed_index(j, n);
            p.first[at] = p.second[at] = (ll_complex){0, 0};
            if (mx == 0 && mz == 0)
                continue;
            ll_wave w = ll_wave_of(&o->setup, mx, mz);
            ll_complex h = height_of(o, &p, &w, i, j, t);
            double x = o->setup.choppiness * w.kx / w.k, z = o->setup.choppiness * w.kz / w.k;
            /* height + i dx, with dx = i x h: the second i turns it into -x h */
            p.first[at] = (ll_complex){h.re - x * h.re, h.im - x * h.im};
            p.second[at] = (ll_complex){-z * h.im, z * h.re};
        }
    ll_fft_run_2d(p.plan, p.plan, p.first, p.work, LL_FFT_INVERSE, NULL);
    ll_fft_run_2d(p.plan, p.plan, p.second, p.work, LL_FFT_INVERSE, NULL);
    double *height = ll_ocean_part(o, o->at_height), *dx = ll_ocean_part(o, o->at_dx);
    double *dz = ll_ocean_part(o, o->at_dz);
    for (int64_t at = 0; at < n * n; at++) {
        height[at] = p.first[at].re;
        dx[at] = p.first[at].im;
        dz[at] = p.second[at].re;
    }
}

void ll_ocean_direct(const ll_ocean *o, ll_time t, int64_t i, int64_t j, double *height, double *dx,
                     double *dz)
{
    parts p = parts_of(o);
    int64_t n = o->setup.n;
    *height = *dx = *dz = 0;
    for (int64_t b = 0; b < n; b++)
        for (int64_t a = 0; a < n; a++) {
            int64_t mx = signed_index(a, n), mz = signed_index(b, n);
            if (mx == 0 && mz == 0)
                continue;
            ll_wave w = ll_wave_of(&o->setup, mx, mz);
            ll_complex h = height_of(o, &p, &w, a, b, t);
            double angle = TURN * (double)((a * i + b * j) % n) / (double)n, c = ll_cos(angle);
            double s = ll_sin(angle), across = o->setup.choppiness * (h.re * s + h.im * c);
            *height += h.re * c - h.im * s;
            *dx -= w.kx / w.k * across;
            *dz -= w.kz / w.k * across;
        }
}

/* As many waves as points, with random amplitudes from the wind's spectrum, by two fast Fourier
 * transforms and a sine and cosine per wave (Tessendorf 2001). */
const ll_ocean_method ll_ocean_spectrum = {
    .size = size,
    .init = init,
    .evaluate = evaluate,
};
