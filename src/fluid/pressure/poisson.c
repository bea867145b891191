#include "fluid/pressure/poisson.h"

#include <math.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "fluid/core/fft.h"

#define PI 3.14159265358979323846

/* ---- faces ---- */

void ll_poisson_open(ll_poisson *p, const uint8_t *fluid, double *open_x, double *open_y, double *inverse)
{
    p->open_x = open_x;
    p->open_y = open_y;
    p->inverse = inverse;
    p->empty = true;
    for (int32_t j = 0; j < p->ny; j++)
        for (int32_t i = 0; i < p->nx; i++)
            p->empty = p->empty && fluid[ll_cell(p, i, j)];
    for (int32_t j = 0; j < p->ny; j++)
        for (int32_t i = 0; i <= p->nx; i++) {
            bool inside = (i > 0 && i < p->nx) || p->periodic_x;
            int64_t right = ll_cell(p, i < p->nx ? i : 0, j), left = ll_cell(p, i > 0 ? i - 1 : p->nx - 1, j);
            open_x[ll_cell(p, i, j)] = inside && fluid[left] && fluid[right];
        }
    for (int32_t j = 0; j <= p->ny; j++)
        for (int32_t i = 0; i < p->nx; i++) {
            bool inside = (j > 0 && j < p->ny) || p->periodic_y;
            int64_t above = ll_cell(p, i, j < p->ny ? j : 0),
                    below = ll_cell(p, i, j > 0 ? j - 1 : p->ny - 1);
            open_y[ll_cell(p, i, j)] = inside && fluid[below] && fluid[above];
        }
    for (int32_t j = 0; j < p->ny; j++)
        for (int32_t i = 0; i < p->nx; i++) {
            int64_t k = ll_cell(p, i, j);
            double faces = open_x[k] + open_x[k + 1] + open_y[k] + open_y[k + p->stride];
            LL_VALIDATE(faces >= 0 && faces <= 4);
            inverse[k] = faces > 0 ? 1 / faces : 0;
        }
}

void ll_poisson_wrap(const ll_poisson *p, double *field)
{
    if (p->periodic_x)
        for (int32_t j = 0; j < p->ny; j++) {
            field[ll_cell(p, -1, j)] = field[ll_cell(p, p->nx - 1, j)];
            field[ll_cell(p, p->nx, j)] = field[ll_cell(p, 0, j)];
        }
    if (p->periodic_y) {
        size_t row = (size_t)p->stride * sizeof *field;
        memcpy(field, field + (int64_t)p->ny * p->stride, row);
        memcpy(field + (int64_t)(p->ny + 1) * p->stride, field + p->stride, row);
    }
}

/* ---- sweeps ---- */

static void sweep_row(const ll_poisson *p, int32_t j, int32_t from, double relaxation)
{
    const double *ox = p->open_x, *oy = p->open_y, *inverse = p->inverse, *b = p->b;
    double *x = p->x;
    int64_t s = p->stride, end = ll_cell(p, p->nx, j);
    for (int64_t k = ll_cell(p, from, j); k < end; k += 2) {
        double around = ox[k] * x[k - 1] + ox[k + 1] * x[k + 1] + (oy[k] * x[k - s] + oy[k + s] * x[k + s]);
        x[k] += relaxation * (inverse[k] * (b[k] + around) - x[k]);
    }
}

typedef struct sweep {
    const ll_poisson *p;
    double relaxation;
    int32_t colour;
} sweep;

/* Cells of one colour read only those of the other. */
static void sweep_rows(void *context, ll_share rows, int part)
{
    const sweep *s = context;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        sweep_row(s->p, j, (j + s->colour) & 1, s->relaxation);
}

void ll_poisson_sweep(const ll_poisson *p, double relaxation)
{
    for (int32_t colour = 0; colour < 2; colour++) {
        ll_poisson_wrap(p, p->x);
        ll_rows_run(p->team, p->ny, p->nx, sweep_rows, &(sweep){p, relaxation, colour});
    }
}

typedef struct rest {
    const ll_poisson *p;
    double *r;
    double most[LL_TEAM_PARTS_MAX];
} rest;

static void rest_rows(void *context, ll_share rows, int part)
{
    rest *to = context;
    const ll_poisson *p = to->p;
    const double *ox = p->open_x, *oy = p->open_y, *b = p->b, *x = p->x;
    double *r = to->r, most = 0;
    int64_t s = p->stride;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int64_t k = ll_cell(p, 0, j), end = ll_cell(p, p->nx, j); k < end; k++) {
            double across = ox[k] * (x[k] - x[k - 1]) + ox[k + 1] * (x[k] - x[k + 1]);
            double along = oy[k] * (x[k] - x[k - s]) + oy[k + s] * (x[k] - x[k + s]);
            double left = b[k] - (across + along);
            if (r)
                r[k] = left;
            most = ll_rows_larger(most, fabs(left));
        }
    to->most[part] = most;
}

double ll_poisson_residual(const ll_poisson *p, double *r)
{
    rest to = {.p = p, .r = r};
    ll_poisson_wrap(p, p->x);
    int parts = ll_rows_run(p->team, p->ny, p->nx, rest_rows, &to);
    return ll_rows_largest(to.most, parts);
}

bool ll_poisson_done(ll_poisson *p)
{
    p->residual = ll_poisson_residual(p, NULL);
    LL_ASSERT(p->tolerance >= 0 && p->sweeps_max >= 0); /* or it would never end */
    return !ll_goes_on(p->pace) || p->residual <= p->tolerance * p->source || p->sweeps >= p->sweeps_max;
}

void ll_poisson_relax(ll_poisson *p, double relaxation)
{
    enum { LOOK_EVERY = 10 }; /* a check costs as much as a sweep */
    if (ll_poisson_done(p))
        return;
    do {
        ll_poisson_sweep(p, relaxation);
        p->sweeps++;
    } while ((p->sweeps % LOOK_EVERY != 0 && p->sweeps < p->sweeps_max) || !ll_poisson_done(p));
}

double ll_poisson_best_relaxation(const ll_poisson *p)
{
    int32_t n = p->nx > p->ny ? p->nx : p->ny;
    LL_ASSERT(n > 1); /* or the sine is not positive */
    double modes = p->periodic_x || p->periodic_y ? 2 : 1;
    return 2 / (1 + ll_sin(modes * PI / n));
}

void ll_poisson_take_mean_out(ll_poisson *p)
{
    double sum = 0;
    int64_t count = 0;
    for (int32_t j = 0; j < p->ny; j++)
        for (int64_t k = ll_cell(p, 0, j), end = ll_cell(p, p->nx, j); k < end; k++) {
            sum += p->inverse[k] > 0 ? p->b[k] : 0;
            count += p->inverse[k] > 0;
        }
    double mean = count > 0 ? sum / (double)count : 0;
    p->source = 0;
    for (int32_t j = 0; j < p->ny; j++)
        for (int64_t k = ll_cell(p, 0, j), end = ll_cell(p, p->nx, j); k < end; k++) {
            p->b[k] = p->inverse[k] > 0 ? p->b[k] - mean : 0;
            p->source = ll_rows_larger(p->source, fabs(p->b[k]));
        }
}
