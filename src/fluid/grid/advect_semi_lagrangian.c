/* Semi-Lagrangian: every value is what was where the flow comes from. */
#include "fluid/grid/state.h"

static void advect(const ll_grid_advect *a)
{
    ll_grid_trace(a, a->in, a->out, a->dt, a->donors);
}

const ll_advection ll_advection_semi_lagrangian = {
    .name = "semi_lagrangian",
    .help = "Semi-Lagrangian: stable at every step, of order 1; it smears. One trace a value.",
    .source = "Stam 1999",
    .advect = advect,
};
