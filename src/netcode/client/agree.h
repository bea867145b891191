/* Compares a prediction with a snapshot of the server: the test of server reconciliation.
 *
 * An entity agrees if its flags are equal and its remaining differences, after subtraction of what the
 * snapshot grids may have rounded, are within the tolerance:
 *     |dx, dy| + horizon |dvx, dvy| <= tolerance, and |dangle| + horizon |dspin| <= tolerance at an arm of 1
 * m. That is the distance at the end of the horizon if both went on at their velocities. A tolerance of 0
 * without a grid is bitwise equality. */
#pragma once

#include "game/core/game.h"
#include "netcode/protocol/quantization.h"

#define LL_DRIFT_MAX_S 2.0 /* limit of the time over which a rounded velocity is allowed for */

typedef struct ll_agreement {
    double tolerance_m;
    double horizon_s;      /* from the snapshot to the end of what is drawn from it */
    double drift_s;        /* from the snapshot that the prediction started from to this one */
    ll_quantization begun; /* of the others in the snapshot that the prediction started from; all 0: none */
    ll_quantization state; /* of this snapshot */
    int exact; /* entity that no rounding has reached: the own one until others may touch it; -1: none */
} ll_agreement;

/* No entity of a set has this index or a higher one. */
static inline int ll_set_end(const ll_world *world)
{
    return world->entities < LL_TOUCHING_MAX ? world->entities : LL_TOUCHING_MAX;
}

bool ll_same_in(const ll_world *a, const ll_world *b, const ll_entity_set *set); /* bitwise */
bool ll_agrees_in(const ll_agreement *agreement, const ll_world *predicted, const ll_world *state,
                  const ll_entity_set *set);
