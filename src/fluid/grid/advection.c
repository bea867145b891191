/* Carrying a field along the flow, row by row. */
#include "fluid/grid/state.h"

#include "fluid/grid/trace.h"

/* Velocities through walls are unchanged. */
static void keep_walls(const ll_grid *g, ll_grid_place place, const double *in, double *out)
{
    int32_t nx = g->config.nx, ny = g->config.ny;
    if (place == LL_PLACE_U && !ll_grid_periodic_x(g))
        for (int32_t j = 0; j < ny; j++) {
            out[ll_grid_k(g, 0, j)] = in[ll_grid_k(g, 0, j)];
            out[ll_grid_k(g, nx, j)] = in[ll_grid_k(g, nx, j)];
        }
    if (place == LL_PLACE_V && !ll_grid_periodic_y(g))
        for (int32_t i = 0; i < nx; i++) {
            out[ll_grid_k(g, i, 0)] = in[ll_grid_k(g, i, 0)];
            out[ll_grid_k(g, i, ny)] = in[ll_grid_k(g, i, ny)];
        }
}

static void trace_rows(void *context, ll_share rows, int part)
{
    const ll_grid_tracer *t = context;
    const ll_grid_tracing *by = ll_grid_tracing_here();
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        by->trace(t, t->span.j0 + j);
}

void ll_grid_trace(const ll_grid_advect *a, const double *in, double *out, double dt, int32_t *donors)
{
    const ll_grid *g = a->g;
    ll_grid_tracer t = {.u = ll_grid_field(g, LL_FIELD_U),
                        .v = ll_grid_field(g, LL_FIELD_V),
                        .stride = g->stride,
                        .nx = g->config.nx,
                        .ny = g->config.ny,
                        .periodic_x = ll_grid_periodic_x(g),
                        .periodic_y = ll_grid_periodic_y(g),
                        .place = a->place,
                        .order = g->solver.backtrace,
                        .scale = dt / g->config.h,
                        .in = in,
                        .out = out,
                        .donors = donors,
                        .span = ll_grid_span_of(g, a->place)};
    ll_rows_run(a->team, t.span.j1 - t.span.j0, g->config.nx, trace_rows, &t);
    keep_walls(g, a->place, in, out);
}

static void clamp_rows(void *context, ll_share rows, int part)
{
    const ll_grid_advect *a = context;
    const ll_grid_tracing *by = ll_grid_tracing_here();
    int32_t first = ll_grid_span_of(a->g, a->place).j0;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        by->clamp(a, first + j);
}

void ll_grid_clamp(const ll_grid_advect *a)
{
    ll_grid_span span = ll_grid_span_of(a->g, a->place);
    ll_grid_advect same = *a;
    ll_rows_run(a->team, span.j1 - span.j0, a->g->config.nx, clamp_rows, &same);
}

typedef struct halving {
    const ll_grid *g;
    ll_grid_span span;
    double *out;
    const double *in, *base, *back;
} halving;

static void halve_rows(void *context, ll_share rows, int part)
{
    const halving *h = context;
    double *out = h->out;
    const double *in = h->in, *base = h->base, *back = h->back;
    (void)part;
    for (int32_t j = h->span.j0 + rows.begin; j < h->span.j0 + rows.end; j++)
        for (int64_t k = ll_grid_k(h->g, h->span.i0, j), end = ll_grid_k(h->g, h->span.i1, j); k < end; k++)
            out[k] = base[k] + 0.5 * (in[k] - back[k]);
}

void ll_grid_add_half(const ll_grid_advect *a, double *out, const double *base, const double *back)
{
    halving h = {a->g, ll_grid_span_of(a->g, a->place), out, a->in, base, back};
    ll_rows_run(a->team, h.span.j1 - h.span.j0, a->g->config.nx, halve_rows, &h);
}
