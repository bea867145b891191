#include "netcode/protocol/quantization.h"

#define LIMIT 2147483647.0

/* Clears `fits` if the grid has no such step, or for a NaN. */
static int32_t steps(double value, float step, bool *fits)
{
    double n = value / (double)step;
    if (!(n > -LIMIT && n < LIMIT)) {
        *fits = false;
        return 0;
    }
    return (int32_t)(n + (n < 0 ? -0.5 : 0.5));
}

ll_cell ll_cell_of(const ll_entity *e, const ll_quantization *grid)
{
    bool fits = true;
    ll_cell cell = {
        .x = steps(e->x, grid->m, &fits),
        .y = steps(e->y, grid->m, &fits),
        .vx = steps(e->vx, grid->mps, &fits),
        .vy = steps(e->vy, grid->mps, &fits),
        .angle = steps(e->angle, grid->rad, &fits),
        .angular_velocity = steps(e->angular_velocity, grid->radps, &fits),
        .flags = e->flags,
    };
    return fits ? cell : (ll_cell){.x = LL_OFF_GRID};
}

ll_entity ll_cell_entity(const ll_cell *cell, const ll_quantization *grid)
{
    return (ll_entity){
        .x = cell->x * (double)grid->m,
        .y = cell->y * (double)grid->m,
        .vx = cell->vx * (double)grid->mps,
        .vy = cell->vy * (double)grid->mps,
        .angle = cell->angle * (double)grid->rad,
        .angular_velocity = cell->angular_velocity * (double)grid->radps,
        .flags = cell->flags,
    };
}
