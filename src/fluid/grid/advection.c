/* Carrying a field along the flow, row by row, and schemes that do so. */
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

/* ---- schemes ---- */

/* Semi-Lagrangian (Stam 1999): every value is the one at the point where the flow comes from. Stable at every
 * step, of order 1, with numerical diffusion. One trace per value. */
static void advect_semi_lagrangian(const ll_grid_advect *a)
{
    ll_grid_trace(a, a->in, a->out, a->dt, a->donors);
}

/* MacCormack (Selle et al. 2008): the change by a trace forward and back is twice the error. Order 2 for
 * advected fields. Two traces per value. */
static void advect_maccormack(const ll_grid_advect *a)
{
    double *there = a->out, *back = a->spare[0];
    ll_grid_trace(a, a->in, there, a->dt, a->donors);
    ll_grid_bounds(a->g, a->place, there);
    ll_grid_trace(a, there, back, -a->dt, NULL);
    ll_grid_add_half(a, a->out, there, back);
    if (a->g->solver.limiter)
        ll_grid_clamp(a);
}

/* Back and forth error compensation and correction (Dupont and Liu 2003; Kim et al. 2005): the error is
 * subtracted from a field before it is advected. Order 2 for advected fields. Three traces per value. */
static void advect_bfecc(const ll_grid_advect *a)
{
    double *there = a->spare[0], *mended = a->spare[1];
    ll_grid_trace(a, a->in, there, a->dt, a->donors);
    ll_grid_bounds(a->g, a->place, there);
    ll_grid_trace(a, there, mended, -a->dt, NULL);
    ll_grid_add_half(a, mended, a->in, mended);
    ll_grid_bounds(a->g, a->place, mended);
    ll_grid_trace(a, mended, a->out, a->dt, NULL);
    if (a->g->solver.limiter)
        ll_grid_clamp(a);
}

/* X(kind, name, function); central does whole steps, without splitting. */
#define SCHEMES(X)                                                                                           \
    X(SEMI_LAGRANGIAN, semi_lagrangian, advect_semi_lagrangian)                                              \
    X(MACCORMACK, maccormack, advect_maccormack)                                                             \
    X(BFECC, bfecc, advect_bfecc)                                                                            \
    X(CENTRAL, central, NULL)

#define ROW(kind, name, function) [LL_ADVECTION_##kind] = function,
#define NAME(kind, name, function) [LL_ADVECTION_##kind] = #name,

ll_advect *const ll_advections[LL_ADVECTIONS] = {SCHEMES(ROW)};
const char *const ll_advection_names[LL_ADVECTIONS + 1] = {SCHEMES(NAME)};
