/* Back and forth error compensation and correction: the error is subtracted from a field before it is
 * advected. */
#include "fluid/grid/state.h"

static void advect(const ll_grid_advect *a)
{
    ll_grid_span span = ll_grid_span_of(a->g, a->place);
    double *there = a->spare[0], *mended = a->spare[1];
    ll_grid_trace(a, a->in, there, a->dt, a->donors);
    ll_grid_bounds(a->g, a->place, there);
    ll_grid_trace(a, there, mended, -a->dt, NULL);
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int64_t k = ll_grid_k(a->g, span.i0, j), end = ll_grid_k(a->g, span.i1, j); k < end; k++)
            mended[k] = a->in[k] + 0.5 * (a->in[k] - mended[k]);
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
