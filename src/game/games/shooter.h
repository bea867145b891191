/* Between the files of the shooter: its rules (shooter.c), its yard (shooter_arena.c) and its scripts
 * (shooter_drive.c). */
#pragma once

#include "game/core/weapons.h"
#include "game/games/games.h"

typedef struct ll_shooter_params {
    double strafe, target_speed, target_radius, turn, player_radius;
    double rifle_interval, cannon_interval, shell_speed, gravity, spread;
    int64_t targets;
    int32_t weapons; /* ll_shooter_weapons */
    int32_t reserved;
    double drag;
} ll_shooter_params;

_Static_assert(sizeof(ll_shooter_params) <= LL_GAME_PARAMS * sizeof(double),
               "a configuration has no room for more");

typedef enum ll_shooter_weapons { LL_SHOOTER_BOTH, LL_SHOOTER_RIFLE, LL_SHOOTER_CANNON } ll_shooter_weapons;

/* The yard, in m. */
#define LL_SHOOTER_WIDTH 60.0
#define LL_SHOOTER_HEIGHT 20.0
#define LL_SHOOTER_LIFT_LOW 1.0 /* range of the players' centres */
#define LL_SHOOTER_LIFT_HIGH 15.0
#define LL_SHOOTER_WALL 6.0 /* height of the walls in front of the towers */

#define LL_SHOOTER_QUARTER 1.5707963267948966 /* rad, per unit of axis 1 */

static inline const ll_shooter_params *ll_shooter_params_of(const ll_game_env *env)
{
    return (const ll_shooter_params *)env->params;
}

/* 1 to the right, -1 to the left: towers face each other. */
static inline double ll_shooter_facing(int player)
{
    return player % 2 == 0 ? 1 : -1;
}

extern const ll_box ll_shooter_covers[];
extern const int ll_shooter_cover_count;

void ll_shooter_arena(const ll_game_env *env, int players, ll_arena *arena);
ll_action ll_shooter_drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                           ll_script script, ll_time t);
