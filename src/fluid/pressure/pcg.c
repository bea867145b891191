/* Conjugate gradients, preconditioned by a modified incomplete Cholesky factor without fill. */
#include <math.h>
#include <string.h>

#include "base/detmath.h"
#include "fluid/pressure/poisson.h"

enum { FIELDS = 4 };

static size_t field_count(int32_t stride, int32_t ny)
{
    return (size_t)stride * (size_t)(ny + 3);
}

static size_t work_size(int32_t nx, int32_t ny)
{
    return FIELDS * field_count(nx + 4, ny) * sizeof(double);
}

static double *field(const ll_poisson *p, int index)
{
    return (double *)p->work + (size_t)index * field_count(p->stride, p->ny);
}

/* Bridson, Fluid Simulation for Computer Graphics, 2nd ed., figure 5.7. Periodic couplings are left to the
 * iteration. */
static void prepare(const ll_poisson *p)
{
    const double tau = 0.97, sigma = 0.25;
    double *factor = field(p, 0);
    const double *ox = p->open_x, *oy = p->open_y;
    int64_t s = p->stride;
    memset(p->work, 0, work_size(p->nx, p->ny));
    for (int32_t j = 0; j < p->ny; j++)
        for (int32_t i = 0; i < p->nx; i++) {
            int64_t k = ll_cell(p, i, j);
            if (p->inverse[k] == 0)
                continue;
            double left = i > 0 ? ox[k] * factor[k - 1] : 0, below = j > 0 ? oy[k] * factor[k - s] : 0;
            double cross =
                left * left * (i > 0 ? oy[k - 1 + s] : 0) + below * below * (j > 0 ? ox[k - s + 1] : 0);
            double faces = 1 / p->inverse[k];
            double e = faces - left * left - below * below - tau * cross;
            factor[k] = 1 / ll_sqrt(e < sigma * faces ? faces : e);
        }
}

/* z = M^-1 r: forward and backward substitution. */
static void precondition(const ll_poisson *p, const double *r, double *z)
{
    const double *factor = field(p, 0), *ox = p->open_x, *oy = p->open_y;
    int64_t s = p->stride;
    for (int32_t j = 0; j < p->ny; j++)
        for (int32_t i = 0; i < p->nx; i++) {
            int64_t k = ll_cell(p, i, j);
            double left = i > 0 ? ox[k] * factor[k - 1] * z[k - 1] : 0;
            double below = j > 0 ? oy[k] * factor[k - s] * z[k - s] : 0;
            z[k] = factor[k] * (r[k] + left + below);
        }
    for (int32_t j = p->ny - 1; j >= 0; j--)
        for (int32_t i = p->nx - 1; i >= 0; i--) {
            int64_t k = ll_cell(p, i, j);
            double right = i < p->nx - 1 ? ox[k + 1] * z[k + 1] : 0;
            double above = j < p->ny - 1 ? oy[k + s] * z[k + s] : 0;
            z[k] = factor[k] * (z[k] + factor[k] * (right + above));
        }
}

static double dot(const ll_poisson *p, const double *a, const double *b)
{
    double sum = 0;
    for (int32_t j = 0; j < p->ny; j++)
        for (int64_t k = ll_cell(p, 0, j), end = ll_cell(p, p->nx, j); k < end; k++)
            sum += a[k] * b[k];
    return sum;
}

/* z = A d; returns d . z. */
static double apply(const ll_poisson *p, double *d, double *z)
{
    const double *ox = p->open_x, *oy = p->open_y;
    int64_t s = p->stride;
    double sum = 0;
    ll_poisson_wrap(p, d);
    for (int32_t j = 0; j < p->ny; j++)
        for (int64_t k = ll_cell(p, 0, j), end = ll_cell(p, p->nx, j); k < end; k++) {
            double across = ox[k] * (d[k] - d[k - 1]) + ox[k + 1] * (d[k] - d[k + 1]);
            double along = oy[k] * (d[k] - d[k - s]) + oy[k + s] * (d[k] - d[k + s]);
            z[k] = across + along;
            sum += d[k] * z[k];
        }
    return sum;
}

/* x += a d, r -= a z; returns max |r|. */
static double move(const ll_poisson *p, double a, const double *d, double *r, const double *z)
{
    double most = 0;
    for (int32_t j = 0; j < p->ny; j++)
        for (int64_t k = ll_cell(p, 0, j), end = ll_cell(p, p->nx, j); k < end; k++) {
            p->x[k] += a * d[k];
            r[k] -= a * z[k];
            most = fabs(r[k]) > most ? fabs(r[k]) : most;
        }
    return most;
}

static void solve(ll_poisson *p)
{
    double *r = field(p, 1), *z = field(p, 2), *d = field(p, 3);
    p->residual = ll_poisson_residual(p, r);
    precondition(p, r, z);
    memcpy(d, z, field_count(p->stride, p->ny) * sizeof *d);
    double old = dot(p, r, z);
    while (p->residual > p->tolerance * p->source && p->sweeps < p->sweeps_max && old > 0 &&
           ll_goes_on(p->pace)) {
        double slope = apply(p, d, z);
        if (!(slope > 0))
            break; /* nothing is left but rounding */
        p->residual = move(p, old / slope, d, r, z);
        precondition(p, r, z);
        double next = dot(p, r, z);
        for (int32_t j = 0; j < p->ny; j++)
            for (int64_t k = ll_cell(p, 0, j), end = ll_cell(p, p->nx, j); k < end; k++)
                d[k] = z[k] + next / old * d[k];
        old = next;
        p->sweeps++;
    }
    p->residual = ll_poisson_residual(p, NULL);
}

/* Conjugate gradients with the MIC(0) preconditioner. A sweep costs about 6 passes; somewhat fewer than N
 * of them converge. Bridson 2015, chapter 5. */
const ll_pressure_solver ll_pressure_pcg = {
    .passes = 6,
    .work_size = work_size,
    .prepare = prepare,
    .solve = solve,
};
