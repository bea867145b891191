/* Cheat gain: the distance that a player's entity has covered on the server beyond what the game's rules
 * permit.
 *
 * It is the largest excess over any stretch of time since the player started to cheat: the distance covered
 * minus the farthest that an entity can move in that time at any initial speed (ll_game.farthest). Over the
 * stretch that starts with the first movement from rest, it is the distance minus the farthest from rest. So
 * a single leap, a burst and a rate that is slightly too high all show. */
#pragma once

#include "game/core/game.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_cheat_gain {
    double x, y;    /* at the last step */
    double since_s; /* the step before the first movement */
    double covered; /* m, since then */
    double excess;  /* m, over the worst stretch that ends now */
    double most;    /* m, over any stretch so far */
    uint8_t rested; /* it was at rest when first seen */
    uint8_t moved;
    uint8_t reserved[6];
} ll_cheat_gain;

#pragma GCC diagnostic pop

/* The entity of a player that does not cheat, or before the first step: measurement starts here. */
void ll_cheat_gain_watch(ll_cheat_gain *gain, const ll_entity *entity);

/* The entity of a cheating player after a step of the server that stands for `elapsed_s`. */
void ll_cheat_gain_step(ll_cheat_gain *gain, const ll_game *game, const ll_game_env *env,
                        const ll_entity *entity, double elapsed_s);
