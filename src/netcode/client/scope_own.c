/* Own: the client's own entity alone, as in the paper. Others stand still in the prediction, so every touch
 * is mispredicted. Cost: one entity per step. */
#include "netcode/client/scope.h"

static void choose(const ll_game *game, const ll_game_env *env, const ll_world *world, int self,
                   double horizon_s, ll_entity_set *set)
{
    (void)game;
    (void)env;
    (void)world;
    (void)horizon_s;
    ll_entity_set_add(set, self);
}

static bool closed(const ll_game *game)
{
    return !game->own_reads_world;
}

static void step_scope(const ll_game *game, const ll_game_env *env, ll_world *world,
                       const ll_scope_step *step)
{
    game->step_own(world, env, step->self, step->own);
}

const ll_prediction_scope ll_prediction_scope_own = {
    .name = "own",
    .help = "The own entity alone.",
    .choose = choose,
    .closed = closed,
    .step = step_scope,
};
