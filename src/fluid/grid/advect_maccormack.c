/* MacCormack: the change by a trace forward and back is twice the error. */
#include "fluid/grid/state.h"

static void advect(const ll_grid_advect *a)
{
    ll_grid_span span = ll_grid_span_of(a->g, a->place);
    double *there = a->out, *back = a->spare[0];
    ll_grid_trace(a, a->in, there, a->dt, a->donors);
    ll_grid_bounds(a->g, a->place, there);
    ll_grid_trace(a, there, back, -a->dt, NULL);
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int64_t k = ll_grid_k(a->g, span.i0, j), end = ll_grid_k(a->g, span.i1, j); k < end; k++)
            a->out[k] = there[k] + 0.5 * (a->in[k] - back[k]);
    if (a->g->solver.limiter)
        ll_grid_clamp(a);
}

const ll_advection ll_advection_maccormack = {
    .name = "maccormack",
    .help = "MacCormack: semi-Lagrangian, corrected by half of the change of a trace forward and back. Order "
            "2 for advected fields. Two traces per value.",
    .source = "Selle et al. 2008",
    .advect = advect,
};
