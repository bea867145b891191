/* A sum of trochoidal waves: Gerstner (1802); Fournier and Reeves, SIGGRAPH 1986.
 *
 * Along a row of points, sine and cosine of a wave come from those at its start and from a table, by the
 * addition theorem, so that a point of a wave costs a dozen multiplications and additions. */
#include <math.h>
#include <string.h>

#include "base/detmath.h"
#include "base/rng.h"
#include "fluid/ocean/state.h"

#define TURN 6.283185307179586

/* Part of the block: the waves, then a table of n cosines and n sines along x for each. */

static ll_wave *waves_of(const ll_ocean *o)
{
    return ll_ocean_part(o, o->at_method);
}

static double *table_of(const ll_ocean *o, int64_t wave)
{
    return (double *)(waves_of(o) + o->setup.waves) + 2 * wave * o->setup.n;
}

static size_t size(const ll_ocean_setup *s)
{
    return (size_t)s->waves * (sizeof(ll_wave) + 2 * (size_t)s->n * sizeof(double));
}

/* Integer multiples of 2 pi / length around the wind; frequencies in equal ratios around the spectrum's
 * peak. */
static ll_wave choose(const ll_ocean_setup *s, int64_t index)
{
    double peak = 0.877 * s->gravity / (s->wind_speed > 1 ? s->wind_speed : 1), ratio = 3 / (double)s->waves;
    double low = 0.8 * peak * ll_exp(ratio * (double)index * 0.5), high = low * ll_exp(ratio * 0.5);
    double frequency = 0.5 * (low + high), k = frequency * frequency / s->gravity * s->length / TURN;
    uint64_t seed = (uint64_t)s->seed, counter = (uint64_t)index;
    double angle = s->wind_angle + 1.2 * (ll_rng_unit(seed, 0, counter) - 0.5);
    double most = (double)s->n / 2 - 1;
    bool fits = k >= 1 && k <= most; /* waves that do not fit are dropped, not moved to another wave vector */
    k = fmax(1, fmin(k, most));
    int64_t mx = (int64_t)floor(k * ll_cos(angle) + 0.5), mz = (int64_t)floor(k * ll_sin(angle) + 0.5);
    ll_wave w = ll_wave_of(s, mx, mx == 0 && mz == 0 ? 1 : mz);
    w.amplitude = fits ? sqrt(2 * ll_ocean_energy(s, frequency) * (high - low)) : 0;
    w.phase = TURN * ll_rng_unit(seed, 1, counter);
    return w;
}

static void init(ll_ocean *o)
{
    for (int64_t i = 0; i < o->setup.waves; i++) {
        ll_wave *w = &waves_of(o)[i];
        *w = choose(&o->setup, i);
        double *c = table_of(o, i), *s = c + o->setup.n, step = o->setup.length / (double)o->setup.n;
        for (int64_t j = 0; j < o->setup.n; j++) {
            c[j] = ll_cos(w->kx * step * (double)j);
            s[j] = ll_sin(w->kx * step * (double)j);
        }
    }
}

void ll_ocean_waves(const ll_ocean_setup *s, ll_wave *waves)
{
    for (int64_t i = 0; i < s->waves; i++)
        waves[i] = choose(s, i);
}

ll_ocean_point ll_ocean_point_of(const ll_ocean_setup *s, const ll_wave *waves, double x, double z, ll_time t)
{
    ll_ocean_point p = {0};
    for (int64_t i = 0; i < s->waves; i++) {
        const ll_wave *w = &waves[i];
        double angle = w->kx * x + w->kz * z - ll_wave_angle(s, w, t) + w->phase;
        double c = w->amplitude * ll_cos(angle), up = w->amplitude * ll_sin(angle), f = w->frequency;
        double along = -s->choppiness / w->k;
        p.height += c;
        p.dx += along * w->kx * up;
        p.dz += along * w->kz * up;
        p.v += f * up;
        p.u -= along * w->kx * f * c;
        p.w -= along * w->kz * f * c;
    }
    return p;
}

typedef struct row {
    double *restrict height, *restrict dx, *restrict dz;
    int64_t n;
} row;

/* Adds one wave to a row whose first point has angle `start`. */
static void add(const row *r, const double *restrict c, const double *restrict s, const ll_wave *w,
                double start, double choppiness)
{
    double cosine = ll_cos(start), sine = ll_sin(start), a = w->amplitude;
    double x = -choppiness * w->kx / w->k * a, z = -choppiness * w->kz / w->k * a;
    double *restrict height = r->height, *restrict dx = r->dx, *restrict dz = r->dz;
    double ac = a * cosine, as = a * sine;
    for (int64_t i = 0; i < r->n; i++) {
        double up = s[i] * cosine + c[i] * sine;
        height[i] += ac * c[i] - as * s[i];
        dx[i] += x * up;
        dz[i] += z * up;
    }
}

static void evaluate(ll_ocean *o, ll_time t)
{
    const ll_ocean_setup *s = &o->setup;
    int64_t n = s->n;
    double *height = ll_ocean_part(o, o->at_height), *dx = ll_ocean_part(o, o->at_dx);
    double *dz = ll_ocean_part(o, o->at_dz), step = s->length / (double)n;
    for (int64_t j = 0; j < n; j++) {
        row r = {height + j * n, dx + j * n, dz + j * n, n};
        memset(r.height, 0, (size_t)n * sizeof(double));
        memset(r.dx, 0, (size_t)n * sizeof(double));
        memset(r.dz, 0, (size_t)n * sizeof(double));
        for (int64_t i = 0; i < s->waves; i++) {
            const ll_wave *w = &waves_of(o)[i];
            double start = w->kz * step * (double)j - ll_wave_angle(s, w, t) + w->phase;
            add(&r, table_of(o, i), table_of(o, i) + n, w, start, s->choppiness);
        }
    }
}

/* A few trochoidal waves from the wind's spectrum, each added to every point: a dozen operations per wave
 * and point (Fournier and Reeves 1986). */
const ll_ocean_method ll_ocean_gerstner = {
    .size = size,
    .init = init,
    .evaluate = evaluate,
};
