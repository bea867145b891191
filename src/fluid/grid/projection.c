/* Projection onto fields without divergence. */
#include <string.h>

#include "fluid/grid/state.h"

#include "base/assert.h"

static void *work_of(const ll_grid *g)
{
    char *at = (char *)ll_grid_field(g, LL_FIELDS);
    size_t cells = (size_t)g->stride * (size_t)g->rows;
    return at + cells * sizeof(int32_t) + ((cells + 7) & ~(size_t)7);
}

void ll_grid_poisson(const ll_grid *g, ll_poisson *p)
{
    memset(p, 0, sizeof *p);
    p->nx = g->config.nx;
    p->ny = g->config.ny;
    p->stride = g->stride;
    p->periodic_x = ll_grid_periodic_x(g);
    p->periodic_y = ll_grid_periodic_y(g);
    p->empty = g->empty != 0;
    p->open_x = ll_grid_field(g, LL_FIELD_OPEN_X);
    p->open_y = ll_grid_field(g, LL_FIELD_OPEN_Y);
    p->inverse = ll_grid_field(g, LL_FIELD_INVERSE);
    p->x = ll_grid_field(g, LL_FIELD_PRESSURE);
    p->b = ll_grid_field(g, LL_FIELD_SOURCE);
    p->work = work_of(g);
}

/* Rows of a field and the pressure equation of its divergence. */
typedef struct projected {
    const ll_grid *g;
    const ll_poisson *p;
    double *u, *v;
} projected;

static void divergence_rows(void *context, ll_share rows, int part)
{
    const projected *q = context;
    const ll_grid *g = q->g;
    const double *u = q->u, *v = q->v;
    double *b = q->p->b;
    int64_t s = g->stride;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int64_t k = ll_grid_k(g, 0, j), end = ll_grid_k(g, q->p->nx, j); k < end; k++)
            b[k] = -((u[k + 1] - u[k]) + (v[k + s] - v[k]));
}

static void slope_rows(void *context, ll_share rows, int part)
{
    const projected *q = context;
    const ll_grid *g = q->g;
    const ll_poisson *p = q->p;
    ll_grid_span a = ll_grid_span_of(g, LL_PLACE_U), b = ll_grid_span_of(g, LL_PLACE_V);
    const double *x = p->x;
    double *u = q->u, *v = q->v;
    int64_t s = g->stride;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++) {
        for (int64_t k = ll_grid_k(g, a.i0, j), end = ll_grid_k(g, a.i1, j); k < end; k++)
            u[k] -= p->open_x[k] * (x[k] - x[k - 1]);
        for (int64_t k = ll_grid_k(g, b.i0, j), end = ll_grid_k(g, b.i1, j); j >= b.j0 && k < end; k++)
            v[k] -= p->open_y[k] * (x[k] - x[k - s]);
    }
}

void ll_grid_project(ll_grid *g, const ll_fluid_run *run)
{
    ll_poisson p;
    double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V);
    ll_grid_poisson(g, &p);
    p.tolerance = g->solver.tolerance;
    p.relaxation = g->solver.relaxation;
    p.sweeps_max = g->solver.sweeps;
    p.pace = run->pace;
    p.team = run->team;
    projected q = {g, &p, u, v};
    ll_grid_close(g, u, v);
    ll_rows_run(p.team, p.ny, p.nx, divergence_rows, &q);
    ll_pressure_solve((ll_pressure_kind)g->solver.pressure, &p);
    ll_poisson_wrap(&p, p.x);
    ll_rows_run(p.team, p.ny, p.nx, slope_rows, &q);
    ll_grid_bounds(g, LL_PLACE_U, u);
    ll_grid_bounds(g, LL_PLACE_V, v);
    LL_ASSERT(p.sweeps >= 0 && p.sweeps <= p.sweeps_max);
    g->solves++;
    g->sweeps += p.sweeps;
    g->last_sweeps = p.sweeps;
    g->last_residual = p.source > 0 ? p.residual / p.source : 0;
}
