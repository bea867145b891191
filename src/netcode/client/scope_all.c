/* All: the whole world, with the game's full step, to the client's present (as in Rocket League). Nothing is
 * drawn in the past. Every change of another player's controls is a misprediction until the client receives
 * it. */
#include "netcode/client/scope.h"

static void choose(const ll_game *game, const ll_game_env *env, const ll_world *world, int self,
                   double horizon_s, ll_entity_set *set)
{
    (void)game;
    (void)env;
    (void)self;
    (void)horizon_s;
    for (int i = 0; i < world->entities; i++)
        ll_entity_set_add(set, i);
}

static bool closed(const ll_game *game)
{
    (void)game;
    return true;
}

static void step_scope(const ll_game *game, const ll_game_env *env, ll_world *world,
                       const ll_scope_step *step)
{
    game->step(world, env, step->actions, step->now, NULL);
}

const ll_prediction_scope ll_prediction_scope_all = {
    .name = "all",
    .help = "The whole world.",
    .guesses = true,
    .choose = choose,
    .closed = closed,
    .step = step_scope,
};
