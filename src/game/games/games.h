/* The table of games: a row is the name of constants ll_game_NAME, ll_NAME_table (its parameters) and
 * ll_NAME_metrics (its own numbers) that a file of this room defines. The index is the choice `game`. */
#pragma once

#include <math.h>

#include "game/core/game.h"

/* clang-format off */
#define LL_GAMES(ROW) \
    ROW(race) \
    ROW(cannon) \
    ROW(gambetta) \
    ROW(shooter) \
    ROW(crates) \
    ROW(sea) \
    ROW(dam) \
    ROW(stack) \
    ROW(swarm)
/* clang-format on */

#define LL_GAME_DECLARE(NAME)                                                                                \
    extern const ll_game ll_game_##NAME;                                                                     \
    extern const ll_param_table ll_##NAME##_table;                                                           \
    extern const ll_metric_table ll_##NAME##_metrics;
LL_GAMES(LL_GAME_DECLARE)
#undef LL_GAME_DECLARE

/* The games' own numbers, as the end of a list. */
#define LL_GAME_METRIC_TABLE(NAME) &ll_##NAME##_metrics,
#define LL_GAME_METRIC_TABLES LL_GAMES(LL_GAME_METRIC_TABLE)

/* a * b + c on the machine that `env` stands for. Every integrator of a game uses it. */
static inline double ll_mul_add_as(bool fused, double a, double b, double c)
{
    return fused ? fma(a, b, c) : a * b + c;
}

static inline double ll_mul_add(const ll_game_env *env, double a, double b, double c)
{
    return ll_mul_add_as(env->fused, a, b, c);
}

/* Motion under a constant force and linear drag, v' = a - c v, solved exactly over one step of `dt`:
 *   v1 = v0 e + a f,  x1 = x0 + v0 f + a g,  with  e = exp(-c dt), f = (1 - e) / c, g = (dt - f) / c.
 * The result does not depend on how a time of constant input is divided into steps. */
typedef struct ll_drag {
    double e, f, g;
} ll_drag;

ll_drag ll_drag_over(double drag_per_s, double dt);

static inline void ll_drag_move_as(bool fused, const ll_drag *d, double a, double *x, double *v)
{
    double v0 = *v;
    *x += ll_mul_add_as(fused, v0, d->f, a * d->g);
    *v = ll_mul_add_as(fused, v0, d->e, a * d->f);
}

static inline void ll_drag_move(const ll_game_env *env, const ll_drag *d, double a, double *x, double *v)
{
    ll_drag_move_as(env->fused, d, a, x, v);
}
