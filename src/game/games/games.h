/* The rows of the table of games: one file per game. */
#pragma once

#include <math.h>

#include "game/core/game.h"

extern const ll_game ll_game_race;
extern const ll_game ll_game_cannon;
extern const ll_game ll_game_gambetta;
extern const ll_game ll_game_shooter;
extern const ll_game ll_game_crates;
extern const ll_game ll_game_sea;
extern const ll_game ll_game_dam;
extern const ll_game ll_game_stack;

extern const ll_param_table ll_race_table;
extern const ll_param_table ll_cannon_table;
extern const ll_param_table ll_gambetta_table;
extern const ll_param_table ll_shooter_table;
extern const ll_param_table ll_crates_table;
extern const ll_param_table ll_sea_table;
extern const ll_param_table ll_dam_table;
extern const ll_param_table ll_stack_table;

extern const ll_metric_table ll_race_metrics, ll_cannon_metrics, ll_gambetta_metrics, ll_shooter_metrics,
    ll_crates_metrics, ll_sea_metrics, ll_dam_metrics, ll_stack_metrics;

/* All of them, as a part of a list. */
#define LL_GAME_METRIC_TABLES                                                                                \
    &ll_race_metrics, &ll_cannon_metrics, &ll_gambetta_metrics, &ll_shooter_metrics, &ll_crates_metrics,     \
        &ll_sea_metrics, &ll_dam_metrics, &ll_stack_metrics

/* a * b + c on the machine that `env` stands for. Every integrator of a game uses it. */
static inline double ll_mul_add(const ll_game_env *env, double a, double b, double c)
{
    return env->fused ? fma(a, b, c) : a * b + c;
}

/* Motion under a constant force and linear drag, v' = a - c v, solved exactly over one step of `dt`:
 *   v1 = v0 e + a f,  x1 = x0 + v0 f + a g,  with  e = exp(-c dt), f = (1 - e) / c, g = (dt - f) / c.
 * The result does not depend on how a time of constant input is divided into steps. */
typedef struct ll_drag {
    double e, f, g;
} ll_drag;

ll_drag ll_drag_over(double drag_per_s, double dt);

static inline void ll_drag_move(const ll_game_env *env, const ll_drag *d, double a, double *x, double *v)
{
    double v0 = *v;
    *x += ll_mul_add(env, v0, d->f, a * d->g);
    *v = ll_mul_add(env, v0, d->e, a * d->f);
}
