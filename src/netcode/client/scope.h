/* What a client predicts.
 *
 * Predicted entities are stepped from the server's last snapshot to the tick of the client's newest input,
 * with the client's own inputs and, for others, with their controls in that snapshot. */
#pragma once

#include "game/core/game.h"

/* A step to `now` that `self` predicts. */
typedef struct ll_scope_step {
    const ll_action *actions; /* one per player, of the first LL_PEERS_MAX */
    const ll_action *own;     /* that of `self` */
    ll_time now;              /* only where others are stepped too: a player's own step needs no time */
    int self;
    const ll_entity_set *set; /* the entities to step */
} ll_scope_step;

typedef struct ll_prediction_scope {
    const char *name;
    bool guesses; /* others are stepped too: snapshots must contain their controls */

    /* Adds to `set` the entities to predict for `horizon_s` from `world` on. */
    void (*choose)(const ll_game *game, const ll_game_env *env, const ll_world *world, int self,
                   double horizon_s, ll_entity_set *set);

    /* Whether a step of the chosen entities depends on no other entity of the world. */
    bool (*closed)(const ll_game *game);

    /* One step of the chosen entities. */
    void (*step)(const ll_game *game, const ll_game_env *env, ll_world *world, const ll_scope_step *step);
} ll_prediction_scope;

extern const ll_prediction_scope
    *const ll_scopes[]; /* NULL-terminated; the index is the choice `prediction_scope` */
extern const char *const ll_prediction_scope_names[];
