/* A world in whole steps of a grid: what quantised and delta-coded snapshots are made of.
 *
 * Both ends use the same functions, and a value that lies on the grid is its own rounding: so a client that
 * rounds the world it was given gets the numbers that the server sent. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "game/core/game.h"

/* The steps, in the precision in which they travel. */
typedef struct ll_quantization {
    float m, mps, rad, radps;
} ll_quantization;

/* An entity in steps. `x` is LL_OFF_GRID for one with a member that is not finite or 2^31 steps and more from
 * zero: it travels to the bit. */
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
