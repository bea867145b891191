#include "netcode/metrics/cheat_gain.h"

#include "base/detmath.h"

void ll_cheat_gain_watch(ll_cheat_gain *g, const ll_entity *e)
{
    *g = (ll_cheat_gain){.x = e->x, .y = e->y, .most = g->most, .rested = e->vx == 0 && e->vy == 0};
}

void ll_cheat_gain_step(ll_cheat_gain *g, const ll_game *game, const ll_game_env *env, const ll_entity *e,
                        double elapsed_s)
{
    if (!game->farthest)
        return;
    double dx = e->x - g->x, dy = e->y - g->y, covered = ll_sqrt(dx * dx + dy * dy);
    g->x = e->x;
    g->y = e->y;
    g->moved |= covered > 0;
    if (!g->moved)
        return;
    g->since_s += elapsed_s;
    g->covered += covered;
    g->excess += covered - game->farthest(env, elapsed_s, false);
    g->excess = g->excess > 0 ? g->excess : 0;
    double whole = g->rested ? g->covered - game->farthest(env, g->since_s, true) : 0;
    double beyond = whole > g->excess ? whole : g->excess;
    g->most = beyond > g->most ? beyond : g->most;
}
