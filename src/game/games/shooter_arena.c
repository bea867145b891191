/* The yard of the shooter. */
#include "game/games/shooter.h"

const ll_box ll_shooter_covers[] = {
    {14, 15, 0, LL_SHOOTER_WALL},
    {LL_SHOOTER_WIDTH - 15, LL_SHOOTER_WIDTH - 14, 0, LL_SHOOTER_WALL},
    {27, 33, 9, 10},
};

enum { COVERS = sizeof ll_shooter_covers / sizeof ll_shooter_covers[0] };
const int ll_shooter_cover_count = COVERS;

void ll_shooter_arena(const ll_game_env *env, int players, ll_arena *arena)
{
    const ll_shooter_params *p = ll_shooter_params_of(env);
    *arena = (ll_arena){.players = players,
                        .bodies = players + (int)p->targets,
                        .teams = 2,
                        .covers = COVERS,
                        .player_radius = p->player_radius,
                        .target_radius = p->target_radius,
                        .projectile_speed = p->shell_speed,
                        .gravity = p->gravity,
                        .projectile_drag = p->drag,
                        .bounds = {0, LL_SHOOTER_WIDTH, 0, LL_SHOOTER_HEIGHT}};
    if (p->weapons != LL_SHOOTER_CANNON)
        arena->interval_s[LL_HITSCAN] = p->rifle_interval;
    if (p->weapons != LL_SHOOTER_RIFLE)
        arena->interval_s[LL_PROJECTILE] = p->cannon_interval;
    for (int i = 0; i < COVERS; i++)
        arena->cover[i] = ll_shooter_covers[i];
}
