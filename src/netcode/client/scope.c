#include "netcode/client/scope.h"

#include <stddef.h>

/* Own: the client's own entity alone, as in the paper. Others stand still in the prediction, so every touch
 * is mispredicted. Cost: one entity per step. */
static void choose_own(const ll_game *game, const ll_game_env *env, const ll_world *world, int self,
                       double horizon_s, ll_entity_set *set)
{
    (void)game, (void)env, (void)world, (void)horizon_s;
    ll_entity_set_add(set, self);
}

static bool closed_own(const ll_game *game)
{
    return !game->own_reads_world;
}

static void step_own(const ll_game *game, const ll_game_env *env, ll_world *world, const ll_scope_step *step)
{
    game->step_own(world, env, step->self, step->own);
}

/* Contacts: the own entity and every entity that may touch it before the next snapshot arrives, as the
 * game decides. Where nothing is near, the cost is that of `own` and the others are drawn as without
 * prediction. */
static void choose_contacts(const ll_game *game, const ll_game_env *env, const ll_world *world, int self,
                            double horizon_s, ll_entity_set *set)
{
    ll_entity_set_add(set, self);
    if (game->reach)
        game->reach(world, env, horizon_s, set);
}

static bool closed_contacts(const ll_game *game)
{
    return game->step_some || !game->own_reads_world;
}

static void step_contacts(const ll_game *game, const ll_game_env *env, ll_world *world,
                          const ll_scope_step *step)
{
    if (game->step_some)
        game->step_some(world, env, step->actions, step->now, step->set);
    else
        game->step_own(world, env, step->self, step->own);
}

/* All: the whole world, with the game's full step, to the client's present (as in Rocket League). Nothing is
 * drawn in the past. Every change of another player's controls is a misprediction until the client receives
 * it. */
static void choose_all(const ll_game *game, const ll_game_env *env, const ll_world *world, int self,
                       double horizon_s, ll_entity_set *set)
{
    (void)game, (void)env, (void)self, (void)horizon_s;
    for (int i = 0; i < world->entities; i++)
        ll_entity_set_add(set, i);
}

static bool closed_all(const ll_game *game)
{
    (void)game;
    return true;
}

static void step_all(const ll_game *game, const ll_game_env *env, ll_world *world, const ll_scope_step *step)
{
    game->step(world, env, step->actions, step->now, NULL);
}

#define SCOPES(X) X(own, false) X(contacts, true) X(all, true)

#define ROW(scope, guesses_)                                                                                 \
    &(const ll_prediction_scope){.name = #scope,                                                             \
                                 .guesses = guesses_,                                                        \
                                 .choose = choose_##scope,                                                   \
                                 .closed = closed_##scope,                                                   \
                                 .step = step_##scope},
#define NAME(scope, guesses) #scope,

const ll_prediction_scope *const ll_scopes[] = {SCOPES(ROW) NULL};
const char *const ll_prediction_scope_names[] = {SCOPES(NAME) NULL};
