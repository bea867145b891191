/* M15: what a cheat brings: the distance that a player's entity has covered on the server beyond what the
 * game's rules let anybody cover.
 *
 * It is the largest excess over any stretch of time, since the player cheats: distance covered - the farthest
 * that one may come in that time, however fast one was (ll_game.farthest); and over the stretch from the
 * first movement, where it was at rest before: - the farthest from rest. A single leap, a burst and a rate
 * that is a little too high all show. */
#pragma once

#include "game/core/game.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_cheat_gain {
    double x, y;    /* at the last step */
    double since_s; /* the step before the first movement */
    double covered; /* m, since then */
    double excess;  /* m, over the stretch that is worst and ends now */
    double most;    /* m, over any stretch so far */
    uint8_t rested; /* it was at rest when it was first seen */
    uint8_t moved;
    uint8_t reserved[6];
} ll_cheat_gain;

#pragma GCC diagnostic pop

/* The entity of a player that does not cheat, or before the first step: from here on it is measured. */
void ll_cheat_gain_watch(ll_cheat_gain *gain, const ll_entity *entity);

/* The entity of a player that cheats after a step of the server's that stands for `elapsed_s`. */
void ll_cheat_gain_step(ll_cheat_gain *gain, const ll_game *game, const ll_game_env *env,
                        const ll_entity *entity, double elapsed_s);
