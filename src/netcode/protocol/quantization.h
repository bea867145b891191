/* A world in whole steps of a grid: the form of quantised and delta-compressed snapshots.
 *
 * Both ends use the same functions, and rounding keeps a value that is already on the grid. So a client that
 * rounds a received world gets the numbers that the server sent. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "game/core/game.h"

/* Grid steps, in the precision in which they are sent. */
typedef struct ll_quantization {
    float m, mps, rad, radps;
} ll_quantization;

/* An entity in grid steps. `x` is LL_OFF_GRID if a member is not finite or is 2^31 steps or more from zero:
 * such an entity is sent bitwise. */
typedef struct ll_cell {
    int32_t x, y, vx, vy, angle, angular_velocity;
    uint64_t flags;
} ll_cell;

#define LL_OFF_GRID INT32_MIN

ll_cell ll_cell_of(const ll_entity *entity,
                   const ll_quantization *grid); /* the nearest: at most half a step off */
ll_entity ll_cell_entity(const ll_cell *cell, const ll_quantization *grid);

static inline bool ll_cell_fits(const ll_cell *cell)
{
    return cell->x != LL_OFF_GRID;
}

static inline bool ll_cell_rests(const ll_cell *cell)
{
    return cell->vx == 0 && cell->vy == 0 && cell->angular_velocity == 0;
}
