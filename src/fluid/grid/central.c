/* Central fluxes through the faces of each value's own cell, by the strong-stability-preserving Runge-Kutta
 * method of order 3 (Shu and Osher 1988) with a projection after each of its three stages. Van Leer's limiter
 * keeps the dye from new extremes (Harlow and Welch 1965; van Leer 1974). What leaves a cell enters the next,
 * so that momentum and mass are conserved. Order 2, without numerical diffusion, but with oscillations where
 * cells are too large. */
#include <string.h>

#include "fluid/grid/state.h"

/* What the rows of a stage need. */
typedef struct stage {
    const ll_grid *g;
    double nu, share, dt;
    ll_grid_place place;
    double *value, *change;
    const double *start;
} stage;

/* change = -div(u u) + nu lap u at the left faces. */
static void change_u(void *context, ll_share rows, int part)
{
    const stage *t = context;
    const ll_grid *g = t->g;
    double nu = t->nu, *change = t->change;
    (void)part;
    const double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V);
    ll_grid_span span = ll_grid_span_of(g, LL_PLACE_U);
    int64_t s = g->stride;
    double per_h = 1 / g->config.h, per_h2 = nu * per_h * per_h;
    for (int32_t j = span.j0 + rows.begin; j < span.j0 + rows.end; j++)
        for (int64_t k = ll_grid_k(g, span.i0, j), end = ll_grid_k(g, span.i1, j); k < end; k++) {
            double right = u[k] + u[k + 1], left = u[k - 1] + u[k];
            double above = (u[k] + u[k + s]) * (v[k - 1 + s] + v[k + s]);
            double below = (u[k - s] + u[k]) * (v[k - 1] + v[k]);
            double out = 0.25 * ((right * right - left * left) + (above - below));
            double bend = (u[k - 1] + u[k + 1]) + (u[k - s] + u[k + s]) - 4 * u[k];
            change[k] = per_h2 * bend - per_h * out;
        }
}

static void change_v(void *context, ll_share rows, int part)
{
    const stage *t = context;
    const ll_grid *g = t->g;
    double nu = t->nu, *change = t->change;
    (void)part;
    const double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V);
    ll_grid_span span = ll_grid_span_of(g, LL_PLACE_V);
    int64_t s = g->stride;
    double per_h = 1 / g->config.h, per_h2 = nu * per_h * per_h;
    for (int32_t j = span.j0 + rows.begin; j < span.j0 + rows.end; j++)
        for (int64_t k = ll_grid_k(g, span.i0, j), end = ll_grid_k(g, span.i1, j); k < end; k++) {
            double above = v[k] + v[k + s], below = v[k - s] + v[k];
            double right = (v[k] + v[k + 1]) * (u[k + 1 - s] + u[k + 1]);
            double left = (v[k - 1] + v[k]) * (u[k - s] + u[k]);
            double out = 0.25 * ((above * above - below * below) + (right - left));
            double bend = (v[k - 1] + v[k + 1]) + (v[k - s] + v[k + s]) - 4 * v[k];
            change[k] = per_h2 * bend - per_h * out;
        }
}

/* The limiter's addition to the upstream value at a face: half of the harmonic mean of two differences. */
static double half_slope(double before, double after)
{
    double product = before * after;
    return product > 0 ? product / (before + after) : 0;
}

/* Flux from the cell at f[-step] into the one at f[0]. On the box's `edge` only the upstream value counts. */
static double flux(const double *f, int64_t step, double speed, bool edge)
{
    if (edge)
        return speed * (speed > 0 ? f[-step] : f[0]);
    double across = f[0] - f[-step];
    if (speed > 0)
        return speed * (f[-step] + half_slope(f[-step] - f[-2 * step], across));
    return speed * (f[0] - half_slope(f[step] - f[0], across));
}

static void change_dye(void *context, ll_share rows, int part)
{
    const stage *t = context;
    const ll_grid *g = t->g;
    double *change = t->change;
    (void)part;
    const double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V);
    const double *dye = ll_grid_field(g, LL_FIELD_DYE);
    int64_t s = g->stride;
    int32_t nx = g->config.nx, ny = g->config.ny;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int32_t i = 0; i < nx; i++) {
            int64_t k = ll_grid_k(g, i, j);
            double left = flux(dye + k, 1, u[k], i == 0);
            double right = flux(dye + k + 1, 1, u[k + 1], i == nx - 1);
            double below = flux(dye + k, s, v[k], j == 0);
            double above = flux(dye + k + s, s, v[k + s], j == ny - 1);
            change[k] = ((left - right) + (below - above)) / g->config.h;
        }
}

/* value = start + share (value + dt change - start). */
static void combine(void *context, ll_share rows, int part)
{
    const stage *t = context;
    const ll_grid *g = t->g;
    ll_grid_span span = ll_grid_span_of(g, t->place);
    double *value = t->value, share = t->share, dt = t->dt;
    const double *start = t->start, *change = t->change;
    (void)part;
    for (int32_t j = span.j0 + rows.begin; j < span.j0 + rows.end; j++)
        for (int64_t k = ll_grid_k(g, span.i0, j), end = ll_grid_k(g, span.i1, j); k < end; k++)
            value[k] = start[k] + share * (value[k] + dt * change[k] - start[k]);
}

static void run_rows(ll_team *team, stage *t, ll_rows_job *job)
{
    ll_grid_span span = ll_grid_span_of(t->g, t->place);
    ll_rows_run(team, span.j1 - span.j0, t->g->config.nx, job, t);
}

void ll_grid_step_central(ll_grid *g, double dt, const ll_fluid_run *run)
{
    static const double shares[3] = {1, 0.25, 2.0 / 3};
    static const struct {
        ll_grid_place place;
        ll_grid_field_kind value, start, change;
        ll_rows_job *job;
    } all[] = {{LL_PLACE_U, LL_FIELD_U, LL_FIELD_A, LL_FIELD_D, change_u},
               {LL_PLACE_V, LL_FIELD_V, LL_FIELD_B, LL_FIELD_E, change_v},
               {LL_PLACE_CELL, LL_FIELD_DYE, LL_FIELD_C, LL_FIELD_F, change_dye}};
    stage t[3];
    size_t bytes = (size_t)g->stride * (size_t)g->rows * sizeof(double);
    int from = g->config.frozen ? 2 : 0, end = g->config.dyed ? 3 : 2;
    for (int f = from; f < end; f++) {
        t[f] = (stage){.g = g,
                       .nu = g->config.viscosity * g->solver.viscosity_scale,
                       .dt = dt,
                       .place = all[f].place,
                       .value = ll_grid_field(g, all[f].value),
                       .change = ll_grid_field(g, all[f].change),
                       .start = ll_grid_field(g, all[f].start)};
        memcpy(ll_grid_field(g, all[f].start), t[f].value, bytes);
    }
    for (int n = 0; n < 3; n++) {
        for (int f = from; f < end; f++)
            run_rows(run->team, &t[f], all[f].job);
        if (!g->config.frozen)
            ll_grid_add_forces(g, ll_grid_field(g, LL_FIELD_D), ll_grid_field(g, LL_FIELD_E), 1);
        for (int f = from; f < end; f++) {
            t[f].share = shares[n];
            run_rows(run->team, &t[f], combine);
            ll_grid_bounds(g, t[f].place, t[f].value);
        }
        if (!g->config.frozen)
            ll_grid_project(g, run);
    }
}
