/* An empty box: cosines (between walls) or Fourier modes (periodic) are the eigenvectors, so each coefficient
 * is divided by its eigenvalue. */
#include <string.h>

#include "base/detmath.h"
#include "fluid/core/fft.h"
#include "fluid/pressure/poisson.h"

#define PI 3.14159265358979323846

typedef struct parts {
    ll_fft *x, *y;
    double *eigen_x, *eigen_y;
    double *data, *work; /* 2 nx ny doubles each */
} parts;

static parts parts_of(void *work, int32_t nx, int32_t ny)
{
    parts a;
    char *at = work;
    size_t cells = 2 * (size_t)nx * (size_t)ny;
    a.x = (ll_fft *)at;
    a.y = (ll_fft *)(at + ll_fft_size(nx));
    a.eigen_x = (double *)(at + ll_fft_size(nx) + ll_fft_size(ny));
    a.eigen_y = a.eigen_x + nx;
    a.data = a.eigen_y + ny;
    a.work = a.data + cells;
    return a;
}

static size_t work_size(int32_t nx, int32_t ny)
{
    size_t doubles = (size_t)nx + (size_t)ny + 4 * (size_t)nx * (size_t)ny;
    return ll_fft_size(nx) + ll_fft_size(ny) + doubles * sizeof(double);
}

/* Of mode k: 2 - 2 cos(angle), without cancellation. */
static void eigenvalues(double *out, int32_t n, bool periodic)
{
    for (int32_t k = 0; k < n; k++) {
        double sine = ll_sin((periodic ? 2 : 1) * PI * k / (2 * n));
        out[k] = 4 * sine * sine;
    }
}

static void prepare(const ll_poisson *p)
{
    parts a = parts_of(p->work, p->nx, p->ny);
    ll_fft_init(a.x, p->nx);
    ll_fft_init(a.y, p->ny);
    eigenvalues(a.eigen_x, p->nx, p->periodic_x);
    eigenvalues(a.eigen_y, p->ny, p->periodic_y);
}

/* Rows of a solution, of `width` doubles per cell. */
typedef struct solution {
    const ll_poisson *p;
    parts a;
    double scale;
    int32_t width;
} solution;

/* The constant mode stays zero. */
static void divide_rows(void *context, ll_share rows, int part)
{
    const solution *s = context;
    const parts *a = &s->a;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int32_t i = 0; i < a->x->n; i++) {
            double eigen = a->eigen_x[i] + a->eigen_y[j], factor = i + j > 0 ? s->scale / eigen : 0;
            for (int32_t w = 0; w < s->width; w++)
                a->data[((int64_t)j * a->x->n + i) * s->width + w] *= factor;
        }
}

static void load_rows(void *context, ll_share rows, int part)
{
    const solution *s = context;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int32_t i = 0; i < s->p->nx; i++) {
            double *at = s->a.data + ((int64_t)j * s->p->nx + i) * s->width;
            at[0] = s->p->b[ll_cell(s->p, i, j)];
            if (s->width == 2)
                at[1] = 0;
        }
}

static void store_rows(void *context, ll_share rows, int part)
{
    const solution *s = context;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int32_t i = 0; i < s->p->nx; i++)
            s->p->x[ll_cell(s->p, i, j)] = s->a.data[((int64_t)j * s->p->nx + i) * s->width];
}

static void solve(ll_poisson *p)
{
    solution s = {.p = p, .a = parts_of(p->work, p->nx, p->ny), .scale = 1, .width = p->periodic_x ? 2 : 1};
    const parts *a = &s.a;
    ll_rows_run(p->team, p->ny, p->nx, load_rows, &s);
    if (s.width == 2) {
        s.scale = 1 / ((double)p->nx * p->ny);
        ll_fft_run_2d(a->x, a->y, (ll_complex *)a->data, (ll_complex *)a->work, LL_FFT_FORWARD, p->team);
        ll_rows_run(p->team, p->ny, p->nx, divide_rows, &s);
        ll_fft_run_2d(a->x, a->y, (ll_complex *)a->data, (ll_complex *)a->work, LL_FFT_INVERSE, p->team);
    } else {
        ll_dct_run_2d(a->x, a->y, a->data, a->work, LL_FFT_FORWARD, p->team);
        ll_rows_run(p->team, p->ny, p->nx, divide_rows, &s);
        ll_dct_run_2d(a->x, a->y, a->data, a->work, LL_FFT_INVERSE, p->team);
    }
    ll_rows_run(p->team, p->ny, p->nx, store_rows, &s);
    p->sweeps = 1;
    p->residual = ll_poisson_residual(p, NULL);
}

/* Cosine (or Fourier) transform: exact to rounding, in boxes without obstacles. About 20 log2(N)
 * operations per cell. Buzbee, Golub and Nielson 1970; Makhoul 1980. */
const ll_pressure_solver ll_pressure_direct = {
    .passes = 18, /* for N = 64 */
    .direct = true,
    .work_size = work_size,
    .prepare = prepare,
    .solve = solve,
};
