#include "netcode/peer/float_mode.h"

#include <string.h>

#include "base/rng.h"
#include "netcode/state/client.h"

#define ULP_STREAM 0x756c70
#define ULP_EVERY 64 /* mean number of ticks between two errors */

/* Volatile: GCC 12 at -O3 vectorises a loop of such conversions and skips fields of the last entity. */
static void round_to_float(double *value)
{
    volatile float stored = (float)*value;
    *value = (double)stored;
}

static void round_to_floats(ll_world *world, int player, int64_t tick)
{
    (void)player;
    (void)tick;
    for (int i = 0; i < world->entities; i++) {
        ll_entity *e = &world->entity[i];
        round_to_float(&e->x);
        round_to_float(&e->y);
        round_to_float(&e->vx);
        round_to_float(&e->vy);
        round_to_float(&e->angle);
        round_to_float(&e->angular_velocity);
    }
}

/* Moves one number by one ulp away from zero; a zero stays. */
static void add_ulp(double *value)
{
    uint64_t bits;
    memcpy(&bits, value, sizeof bits);
    bits += *value != 0;
    memcpy(value, &bits, sizeof bits);
}

static void add_ulps_at_random(ll_world *world, int player, int64_t tick)
{
    uint64_t draw = ll_rng_u64(ULP_STREAM, (uint64_t)player, (uint64_t)tick);
    if (draw % ULP_EVERY != 0)
        return;
    ll_entity *e = &world->entity[draw / ULP_EVERY % (uint64_t)world->entities];
    double *const values[] = {&e->x, &e->y, &e->vx, &e->vy};
    add_ulp(values[draw >> 62]);
}

/* X(name, members). exact: the server's arithmetic. float: positions and speeds are stored as floats. fma: a
 * multiply and an add are rounded once. ulp: a number is off by one ulp once in ULP_EVERY ticks. */
#define MODES(X)                                                                                             \
    X(exact, .after = NULL)                                                                                  \
    X(float, .after = round_to_floats)                                                                       \
    X(fma, .fused = true)                                                                                    \
    X(ulp, .after = add_ulps_at_random)

#define ROW(name, ...) {__VA_ARGS__},
#define NAME(name, ...) #name,

const ll_float_mode ll_float_modes[] = {MODES(ROW)};
const char *const ll_float_mode_names[] = {MODES(NAME) NULL};

void ll_float_mode_step(const ll_client_setup *s, int player, ll_world *world, const ll_action *actions,
                        int64_t tick, ll_time now)
{
    const ll_float_mode *float_mode = &ll_float_modes[s->config->float_mode];
    if (float_mode->fused) {
        ll_game_env env = *s->env;
        env.fused = 1;
        s->game->step(world, &env, actions, now, NULL);
    } else {
        s->game->step(world, s->env, actions, now, NULL);
    }
    if (float_mode->after)
        float_mode->after(world, player, tick);
}
