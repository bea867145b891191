/* Whether what a client predicted agrees with a state of the server's: the comparison of reconciliation.
 *
 * An entity agrees where its flags are the same and what is left of each difference, once what the grids of
 * snapshots may have rounded is taken off, is within the tolerance:
 *     |dx, dy| + horizon |dvx, dvy| <= tolerance, and |dangle| + horizon |dspin| <= tolerance at an arm of 1
 * m: as far as the two would be apart at the end of the horizon if they went on so. A tolerance of 0 without
 * a grid is equality to the bit. */
#pragma once

#include "game/core/game.h"
#include "netcode/protocol/quantization.h"

#define LL_DRIFT_MAX_S 2.0 /* of what a rounded velocity makes in longer, no more is let pass */

typedef struct ll_agreement {
    double tolerance_m;
    double horizon_s;      /* from the state to the end of what is drawn by it */
    double drift_s;        /* from the state that the prediction began with to this one */
    ll_quantization begun; /* that the others lay on in the state that it began with; all 0: none */
    ll_quantization state; /* and in this one */
    int exact; /* the entity that no rounding reached: the own one until others may touch it; -1: none */
} ll_agreement;

bool ll_same_in(const ll_world *a, const ll_world *b, const ll_entity_set *set); /* to the bit */
bool ll_agrees_in(const ll_agreement *agreement, const ll_world *predicted, const ll_world *state,
                  const ll_entity_set *set);
