/* Contacts: the own entity and every entity that may touch it before the next snapshot arrives, as the game
 * decides. Where nothing is near, the cost is that of `own` and the others are drawn as without prediction.
 */
#include "netcode/client/scope.h"

static void choose(const ll_game *game, const ll_game_env *env, const ll_world *world, int self,
                   double horizon_s, ll_entity_set *set)
{
    ll_entity_set_add(set, self);
    if (game->reach)
        game->reach(world, env, horizon_s, set);
}

static bool closed(const ll_game *game)
{
    return game->step_some || !game->own_reads_world;
}

static void step_scope(const ll_game *game, const ll_game_env *env, ll_world *world,
                       const ll_scope_step *step)
{
    if (game->step_some)
        game->step_some(world, env, step->actions, step->now, step->set);
    else
        game->step_own(world, env, step->self, step->own);
}

const ll_prediction_scope ll_prediction_scope_contacts = {
    .name = "contacts",
    .help = "The own entity and the entities that may touch it.",
    .guesses = true,
    .choose = choose,
    .closed = closed,
    .step = step_scope,
};
