/* Sea: boats on a swell, seen from the side.
 *
 * Axis 0 drives a boat along x. The water is a sum of Gerstner waves (src/fluid, a periodic cut through the
 * ocean along x), a function of time alone. Its points, one entity each, are sent in snapshots, and what a
 * client draws between snapshots is compared with the water itself.
 *
 * A boat floats by linear buoyancy: its weight per draught of depth, with a torque from the depths of bow and
 * stern, and drag relative to the water's motion. */
#include <string.h>

#include "base/detmath.h"
#include "fluid/ocean/ocean.h"
#include "game/core/script.h"
#include "game/games/games.h"

typedef struct sea_params {
    int64_t points, waves, seed;
    double length, wind, choppiness, boat, draught, damping, speed, acceleration;
} sea_params;

typedef struct sea_tail {
    ll_time time[1]; /* ns: of each player's water, then of the points' */
} sea_tail;

#define WAVES_MAX 32
#define GRAVITY 9.81

static const ll_param rows[] = {
    {LL_PARAM_ROW("points", INT, sea_params, points), .min = 8, .max = LL_TOUCHING_MAX - LL_PEERS_MAX,
     .default_value = 80, .help = "Number of surface points in snapshots."},
    {LL_PARAM_ROW("waves", INT, sea_params, waves), .min = 1, .max = WAVES_MAX, .default_value = 8,
     .help = "Number of waves."},
    {LL_PARAM_ROW("seed", INT, sea_params, seed), .max = 9007199254740991, .default_value = 1,
     .help = "Random seed of the waves' directions and phases."},
    {LL_PARAM_ROW("length_m", REAL, sea_params, length), .min = 20, .max = 1000, .default_value = 120,
     .unit = "m", .help = "Length of the water, which repeats."},
    {LL_PARAM_ROW("wind_speed_mps", REAL, sea_params, wind), .max = 25, .default_value = 8, .unit = "m/s",
     .help = "Wind of a fully developed sea."},
    {LL_PARAM_ROW("choppiness", REAL, sea_params, choppiness), .max = 1, .default_value = 0.7,
     .help = "Scale of the horizontal displacement."},
    {LL_PARAM_ROW("boat_m", REAL, sea_params, boat), .min = 0.5, .max = 30, .default_value = 5, .unit = "m",
     .help = "Length of a boat."},
    {LL_PARAM_ROW("draught_m", REAL, sea_params, draught), .min = 0.1, .max = 5, .default_value = 0.6,
     .unit = "m", .help = "Draught of a boat at rest."},
    {LL_PARAM_ROW("damping_per_s", REAL, sea_params, damping), .min = 0, .max = 20, .default_value = 2.5,
     .unit = "1/s", .help = "Drag of a boat's heave and pitch relative to the water."},
    {LL_PARAM_ROW("speed_mps", REAL, sea_params, speed), .min = 0.5, .max = 30, .default_value = 6,
     .unit = "m/s", .help = "Speed of a boat."},
    {LL_PARAM_ROW("acceleration_mps2", REAL, sea_params, acceleration), .min = 0.1, .max = 50,
     .default_value = 3, .unit = "m/s2", .help = "Acceleration of a boat."},
};
const ll_param_table ll_sea_table = {
    .name = "sea", .help = "Parameters of the sea.", LL_PARAM_ROWS(rows, sea_params)};

static const sea_params *params_of(const ll_game_env *env)
{
    return (const sea_params *)env->params;
}

/* The water at a step. */
typedef struct water {
    ll_ocean_setup setup;
    ll_wave waves[WAVES_MAX];
} water;

static void raise(water *w, const sea_params *p)
{
    w->setup = (ll_ocean_setup){.length = p->length,
                                .gravity = GRAVITY,
                                .wind_speed = p->wind,
                                .choppiness = p->choppiness,
                                .seed = p->seed,
                                .n = 256,
                                .waves = p->waves};
    ll_ocean_waves(&w->setup, w->waves);
}

/* The surface point at x. Its rest position is found by fixed-point iteration, which converges while no wave
 * breaks. */
static ll_ocean_point at_place(const water *w, double x, ll_time t)
{
    double rest = x;
    ll_ocean_point p = ll_ocean_point_of(&w->setup, w->waves, rest, 0, t);
    for (int i = 0; i < 3; i++) {
        rest = x - p.dx;
        p = ll_ocean_point_of(&w->setup, w->waves, rest, 0, t);
    }
    return p;
}

static ll_extent extent(const void *params, int players)
{
    const sea_params *p = params;
    return (ll_extent){players + (int)p->points, (players + 1) * (int)sizeof(ll_time)};
}

static void prepare(ll_game_env *env, const void *params)
{
    memcpy(env->params, params, sizeof(sea_params));
}

static void place_points(ll_world *world, const sea_params *p, const water *w, ll_time t)
{
    for (int64_t k = 0; k < p->points; k++) {
        double x = p->length * (double)k / (double)(p->points - 1);
        ll_ocean_point at = ll_ocean_point_of(&w->setup, w->waves, x, 0, t);
        world->entity[world->players + k] =
            (ll_entity){.x = x + at.dx, .y = at.height, .vx = at.u, .vy = at.v};
    }
}

static void init(ll_world *world, const ll_game_env *env, const int32_t *lanes)
{
    const sea_params *p = params_of(env);
    water w;
    (void)lanes;
    raise(&w, p);
    for (int i = 0; i < world->players; i++) {
        world->entity[i].x = p->length * (i + 1) / (world->players + 1);
        world->entity[i].y = at_place(&w, world->entity[i].x, 0).height;
    }
    place_points(world, p, &w, 0);
}

/* ---- a step ---- */

static void sail(ll_entity *e, const ll_game_env *env, const water *w, double throttle, ll_time t)
{
    const sea_params *p = params_of(env);
    double dt = env->dt, most = p->acceleration * dt, stiff = GRAVITY / p->draught;
    double bow = e->x + p->boat / 2 * ll_cos(e->angle), stern = e->x - p->boat / 2 * ll_cos(e->angle);
    ll_ocean_point b = at_place(w, bow, t), s = at_place(w, stern, t);
    double level = (b.height + s.height) / 2, rise = (b.v + s.v) / 2;
    double slope = (b.height - s.height) / p->boat, turn = (b.v - s.v) / p->boat;
    e->vx += ll_clamp(p->speed * throttle - e->vx, -most, most);
    e->vy = ll_mul_add(env, stiff * (level - e->y) + p->damping * (rise - e->vy), dt, e->vy);
    e->angular_velocity = ll_mul_add(
        env, stiff * (slope - e->angle) + p->damping * (turn - e->angular_velocity), dt, e->angular_velocity);
    e->x = ll_mul_add(env, e->vx, dt, e->x);
    e->y = ll_mul_add(env, e->vy, dt, e->y);
    e->angle = ll_mul_add(env, e->angular_velocity, dt, e->angle);
    double kept = ll_clamp(e->x, p->boat / 2, p->length - p->boat / 2);
    if (kept != e->x)
        e->vx = 0;
    e->x = kept;
}

static ll_time pass(ll_world *world, const ll_game_env *env, int who)
{
    sea_tail *tail = ll_world_tail(world);
    return tail->time[who] += env->dt_ns;
}

static void step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    water w;
    raise(&w, params_of(env));
    sail(&world->entity[player], env, &w, (double)action->axis[0], pass(world, env, player));
}

static void step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const struct ll_past *past)
{
    water w;
    (void)now;
    (void)past;
    raise(&w, params_of(env));
    for (int i = 0; i < world->players; i++)
        sail(&world->entity[i], env, &w, (double)actions[i].axis[0], pass(world, env, i));
    place_points(world, params_of(env), &w, pass(world, env, world->players));
}

/* ---- scripts ---- */

/* `steady`: to and fro about its start, 4 s each way; `varied`: to random positions in slots of 4 +- 2 s. */
static ll_action drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                       ll_script script, ll_time t)
{
    const sea_params *p = params_of(env);
    const ll_entity *own = &world->entity[player];
    if (script == LL_SCRIPT_IDLE)
        return (ll_action){0};
    double home = p->length * (player + 1) / (world->players + 1);
    double away = (t + player * 900 * LL_MS) / (4 * LL_SECOND) % 2 ? 15 : -15;
    if (script != LL_SCRIPT_STEADY) {
        ll_slot slot = ll_script_slot(seed, player, LL_SCRIPT_SLOTS, t, 4 * LL_SECOND, 2 * LL_SECOND);
        away = 30 * (ll_script_unit(seed, player, LL_SCRIPT_OWN, slot.number) - 0.5);
    }
    return (ll_action){.axis = {(float)ll_clamp((home + away - own->x) / p->speed, -1, 1)}};
}

/* ---- reported values ---- */

#define VALUES(X)                                                                                            \
    X(number, water_m, "m", at_place(&w, own->x, tail->time[player]).height,                                 \
      "height of the water at the player's boat", NULL)                                                      \
    X(number, heave_m, "m", own->y, "height of the player's boat", NULL)                                     \
    X(number, pitch_rad, "rad", own->angle, "pitch angle of the player's boat", NULL)                        \
    X(number, speed_mps, "m/s", own->vx, "speed of the player's boat", NULL)

const ll_metric_table ll_sea_metrics = {LL_GAME_METRICS, .when = "Only in the game sea.",
                                        .help = "Values of the game for this player, now.",
                                        LL_METRICS_FROM(VALUES)};

static void describe(const ll_world *world, const ll_game_env *env, int player, double *values)
{
    const sea_tail *tail = ll_world_tail_const(world);
    const ll_entity *own = &world->entity[player];
    water w;
    raise(&w, params_of(env));
    LL_GAME_TELL(values, VALUES);
}

static ll_game_scene scene(const ll_game_env *env, int players)
{
    const sea_params *p = params_of(env);
    (void)players;
    return (ll_game_scene){
        .x_max = p->length, .y_min = -p->length / 12, .y_max = p->length / 12, .entity_length_m = p->boat};
}

static bool shape(const ll_game_env *env, int players, int index, ll_game_shape *shape)
{
    const sea_params *p = params_of(env);
    if (index >= players + p->points)
        return false;
    *shape = index < players ? (ll_game_shape){"player", p->boat, 2 * p->draught, false, 0, 0}
                             : (ll_game_shape){"water", 0.5, 0.5, true, 0, 0};
    return true;
}

const ll_game ll_game_sea = {
    .name = "sea",
    .help = "Boats on a swell, seen from the side.",
    .params = &ll_sea_table,
    .metrics = &ll_sea_metrics,
    LL_GAME_FUNCTIONS,
    .own_reads_world = true,
    .drive = drive,
    .shape = shape,
};
