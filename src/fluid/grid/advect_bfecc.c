/* Back and forth error compensation and correction: the error is subtracted from a field before it is
 * advected. */
#include "fluid/grid/state.h"

static void advect(const ll_grid_advect *a)
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

const ll_advection ll_advection_bfecc = {
    .name = "bfecc",
    .help = "Back and forth error compensation and correction. Order 2 for advected fields. Three traces per "
            "value.",
    .source = "Dupont and Liu 2003; Kim et al. 2005",
    .advect = advect,
};
