/* What a client predicts: one row, and one file, per scope.
 *
 * What is predicted is stepped from the server's last state to the tick of the client's newest input, by the
 * client's own inputs and, for others, by what their controls were at that state. */
#pragma once

#include "game/core/game.h"

typedef struct ll_prediction_scope {
    const char *name;
    const char *help;
    bool guesses; /* others are stepped too: states must tell their controls */

    /* Adds to `set` what is predicted for `horizon_s` from `world` on. */
    void (*choose)(const ll_game *game, const ll_game_env *env, const ll_world *world, int self,
                   double horizon_s, ll_entity_set *set);

    /* Whether a step of what was chosen depends on nothing else of the world's entities. */
    bool (*closed)(const ll_game *game);

    /* One step of what was chosen, to `now`. `actions` has one for each player. */
    void (*step)(const ll_game *game, const ll_game_env *env, ll_world *world, const ll_action *actions,
                 ll_time now, int self, const ll_entity_set *set);
} ll_prediction_scope;

extern const ll_prediction_scope ll_prediction_scope_own;
extern const ll_prediction_scope ll_prediction_scope_contacts;
extern const ll_prediction_scope ll_prediction_scope_all;

extern const ll_prediction_scope
    *const ll_scopes[]; /* NULL-terminated; the index is the choice `prediction_scope` */
extern const char *const ll_prediction_scope_names[];
