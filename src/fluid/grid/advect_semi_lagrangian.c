/* Semi-Lagrangian: every value is the one at the point where the flow comes from. */
#include "fluid/grid/state.h"

static void advect(const ll_grid_advect *a)
{
    ll_grid_trace(a, a->in, a->out, a->dt, a->donors);
}

const ll_advection ll_advection_semi_lagrangian = {
    .name = "semi_lagrangian",
    .help =
        "Semi-Lagrangian: stable at every step, of order 1, with numerical diffusion. One trace per value.",
    .source = "Stam 1999",
    .advect = advect,
};
