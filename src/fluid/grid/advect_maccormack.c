/* MacCormack: the change by a trace forward and back is twice the error. */
#include "fluid/grid/state.h"

static void advect(const ll_grid_advect *a)
{
    double *there = a->out, *back = a->spare[0];
    ll_grid_trace(a, a->in, there, a->dt, a->donors);
    ll_grid_bounds(a->g, a->place, there);
    ll_grid_trace(a, there, back, -a->dt, NULL);
    ll_grid_add_half(a, a->out, there, back);
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
