/* What a client predicts: one row, and one file, per scope.
 *
 * Predicted entities are stepped from the server's last snapshot to the tick of the client's newest input,
 * with the client's own inputs and, for others, with their controls in that snapshot. */
#pragma once

#include "game/core/game.h"

typedef struct ll_prediction_scope {
    const char *name;
    const char *help;
    bool guesses; /* others are stepped too: snapshots must contain their controls */

    /* Adds to `set` the entities to predict for `horizon_s` from `world` on. */
    void (*choose)(const ll_game *game, const ll_game_env *env, const ll_world *world, int self,
                   double horizon_s, ll_entity_set *set);

    /* Whether a step of the chosen entities depends on no other entity of the world. */
    bool (*closed)(const ll_game *game);

    /* One step of the chosen entities, to `now`. `actions` has one element per player. */
    void (*step)(const ll_game *game, const ll_game_env *env, ll_world *world, const ll_action *actions,
                 ll_time now, int self, const ll_entity_set *set);
} ll_prediction_scope;

extern const ll_prediction_scope ll_prediction_scope_own;
extern const ll_prediction_scope ll_prediction_scope_contacts;
extern const ll_prediction_scope ll_prediction_scope_all;

extern const ll_prediction_scope
    *const ll_scopes[]; /* NULL-terminated; the index is the choice `prediction_scope` */
extern const char *const ll_prediction_scope_names[];
