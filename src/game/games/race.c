/* Race: cars on parallel lanes of a circular track.
 *
 * Axis 0 is the pedal: throttle if positive, brake if negative. Between inputs a car moves under constant
 * force and linear drag, which is solved exactly. Two cars in one lane touch: they are pushed apart and
 * exchange momentum. Only the server simulates that contact fully, so a client that predicts only its own car
 * is then corrected. */
#include "base/detmath.h"
#include "game/core/script.h"
#include "game/games/games.h"

typedef struct race_params {
    double acceleration, brake, drag, top_speed, lap, laps, car_length, lane_width, restitution;
} race_params;

typedef struct race_tail {
    int64_t finished;
    double finish_s[]; /* per player; 0: not finished */
} race_tail;

static const ll_param rows[] = {
    {LL_PARAM_ROW("acceleration_mps2", REAL, race_params, acceleration), .min = 0.1, .max = 100,
     .default_value = 6, .unit = "m/s2", .help = "Acceleration at full throttle."},
    {LL_PARAM_ROW("brake_mps2", REAL, race_params, brake), .min = 0.1, .max = 100, .default_value = 9,
     .unit = "m/s2", .help = "Deceleration at full brake."},
    {LL_PARAM_ROW("drag_per_s", REAL, race_params, drag), .min = 0, .max = 10, .default_value = 0.3,
     .unit = "1/s", .help = "Linear drag: fraction of its speed that a coasting car loses per second."},
    {LL_PARAM_ROW("top_speed_mps", REAL, race_params, top_speed), .min = 0.1, .max = 500, .default_value = 16,
     .unit = "m/s", .help = "Speed limit of all cars."},
    {LL_PARAM_ROW("lap_m", REAL, race_params, lap), .min = 10, .max = 100000, .default_value = 100,
     .unit = "m", .help = "Length of a lap; a view shows one lap."},
    {LL_PARAM_ROW("laps", REAL, race_params, laps), .min = 0.01, .max = 10000, .default_value = 6,
     .help = "Laps to the finish line."},
    {LL_PARAM_ROW("car_length_m", REAL, race_params, car_length), .min = 0.1, .max = 100, .default_value = 4,
     .unit = "m", .help = "Length of a car: cars of one lane touch within this distance."},
    {LL_PARAM_ROW("lane_width_m", REAL, race_params, lane_width), .min = 0.1, .max = 100, .default_value = 3,
     .unit = "m", .help = "Distance between lanes."},
    {LL_PARAM_ROW("restitution", REAL, race_params, restitution), .min = 0, .max = 1, .default_value = 0.3,
     .help = "Restitution of contacts between cars."},
};

const ll_param_table ll_race_table = {
    .name = "race", .help = "Parameters of the race.", LL_PARAM_ROWS(rows, race_params)};

static const race_params *params_of(const ll_game_env *env)
{
    return (const race_params *)env->params;
}

static const ll_drag *drag_of(const ll_game_env *env)
{
    return (const ll_drag *)env->derived;
}

static ll_extent extent(const void *params, int players)
{
    (void)params;
    return (ll_extent){players, (int)(sizeof(race_tail) + (size_t)players * sizeof(double))};
}

static void prepare(ll_game_env *env, const void *params)
{
    *(race_params *)env->params = *(const race_params *)params;
    *(ll_drag *)env->derived = ll_drag_over(params_of(env)->drag, env->dt);
}

static void init(ll_world *world, const ll_game_env *env, const int32_t *lanes)
{
    const race_params *p = params_of(env);
    for (int i = 0; i < world->players; i++) {
        int ahead = 0; /* cars in one lane start behind each other */
        for (int j = 0; j < i; j++)
            ahead += lanes[j] == lanes[i];
        world->entity[i].x = -ahead * (p->car_length + 1);
        world->entity[i].y = lanes[i] * p->lane_width;
    }
}

/* `fused` is the machine's, and a constant here: a machine that rounds a product first calls no function. */
static inline __attribute__((always_inline)) void move(ll_entity *car, const ll_game_env *env, double pedal,
                                                       const bool fused)
{
    const race_params *p = params_of(env);
    double a = pedal > 0 ? pedal * p->acceleration : car->vx > 0 ? pedal * p->brake : 0;
    double x = car->x, v = car->vx;
    ll_drag_move_as(fused, drag_of(env), a, &car->x, &car->vx);
    if (car->vx > p->top_speed) {
        car->vx = p->top_speed;
        car->x = x + env->dt * (v + p->top_speed) / 2;
    } else if (car->vx < 0) { /* brakes stop a car, they do not reverse it */
        car->vx = 0;
        car->x = v > 0 ? x + v * v / (2 * -a) : x; /* a model of dead reckoning may go back */
    }
}

static void touch(ll_entity *rear, ll_entity *front, double length, double restitution)
{
    double overlap = length - (front->x - rear->x);
    rear->x -= overlap / 2;
    front->x += overlap / 2;
    double closing = rear->vx - front->vx;
    if (closing > 0) {
        double impulse = (1 + restitution) / 2 * closing; /* equal masses */
        rear->vx -= impulse;
        front->vx += impulse;
    }
}

/* Whether a step moves the car of player `i`; NULL: all. */
static bool moves(const ll_entity_set *set, int i)
{
    return !set || ll_entity_set_has(set, i);
}

/* Lanes are recognised by their centre; quantised snapshots may be slightly off. */
static bool one_lane(const race_params *p, const ll_entity *a, const ll_entity *b)
{
    double apart = b->y - a->y;
    return apart < p->lane_width / 2 && apart > -p->lane_width / 2;
}

static void meet(const race_params *p, ll_entity *a, ll_entity *b)
{
    double gap = b->x - a->x;
    if (gap >= p->car_length || gap <= -p->car_length)
        return;
    if (gap >= 0)
        touch(a, b, p->car_length, p->restitution);
    else
        touch(b, a, p->car_length, p->restitution);
}

static void contacts(ll_world *world, const race_params *p, const ll_entity_set *set)
{
    for (int i = 0; i + 1 < world->players; i++) {
        ll_entity *a = &world->entity[i];
        if (!moves(set, i))
            continue;
        for (int j = i + 1; j < world->players; j++)
            if (one_lane(p, a, &world->entity[j]) && moves(set, j)) /* lanes first: most pairs end here */
                meet(p, a, &world->entity[j]);
    }
}

static void finish(ll_world *world, const race_params *p, const ll_entity_set *set, ll_time now)
{
    const double line = p->lap * p->laps;
    for (int i = 0; i < world->players; i++) {
        ll_entity *car = &world->entity[i];
        if (car->x < line || (car->flags & LL_ENTITY_FINISHED) || !moves(set, i))
            continue;
        race_tail *t = ll_world_tail(world);
        car->flags |= LL_ENTITY_FINISHED;
        t->finished++;
        t->finish_s[i] = ll_to_s(now) - (car->vx > 0 ? (car->x - line) / car->vx : 0);
    }
}

/* `set`: NULL for all. */
static inline __attribute__((always_inline)) void advance(ll_world *world, const ll_game_env *env,
                                                          const ll_action *actions, ll_time now,
                                                          const ll_entity_set *set, const bool fused)
{
    const race_params *p = params_of(env);
    for (int i = 0; i < world->players; i++)
        if (moves(set, i))
            move(&world->entity[i], env, actions[i].axis[0], fused);
    contacts(world, p, set);
    finish(world, p, set, now);
}

static __attribute__((noinline)) void advance_fused(ll_world *world, const ll_game_env *env,
                                                    const ll_action *actions, ll_time now,
                                                    const ll_entity_set *set)
{
    advance(world, env, actions, now, set, true);
}

static void step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const struct ll_past *past)
{
    (void)past;
    if (env->fused)
        advance_fused(world, env, actions, now, NULL);
    else
        advance(world, env, actions, now, NULL, false);
}

static void step_some(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                      const ll_entity_set *set)
{
    if (env->fused)
        advance_fused(world, env, actions, now, set);
    else
        advance(world, env, actions, now, set, false);
}

/* A car may stop and the one behind it go on at top speed; a contact adds at most a car's length. */
static void reach(const ll_world *world, const ll_game_env *env, double horizon_s, ll_entity_set *set)
{
    const race_params *p = params_of(env);
    double far = 2 * p->car_length + p->top_speed * horizon_s;
    for (bool grown = true; grown;) {
        grown = false;
        for (int j = 0; j < world->players; j++)
            for (int i = 0; i < world->players && !ll_entity_set_has(set, j); i++) {
                const ll_entity *a = &world->entity[i], *b = &world->entity[j];
                if (!ll_entity_set_has(set, i) || b->flags & LL_ENTITY_UNKNOWN)
                    continue;
                if (one_lane(p, a, b) && b->x - a->x < far && b->x - a->x > -far) {
                    ll_entity_set_add(set, j);
                    grown = true;
                }
            }
    }
}

static __attribute__((noinline)) void move_fused(ll_entity *car, const ll_game_env *env, double pedal)
{
    move(car, env, pedal, true);
}

static void step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    if (env->fused)
        move_fused(&world->entity[player], env, action->axis[0]);
    else
        move(&world->entity[player], env, action->axis[0], false);
}

/* Full throttle up to top speed: v = a f(t), x = a g(t) with the drag's factors over t. */
static double farthest(const ll_game_env *env, double seconds, bool from_rest)
{
    const race_params *p = params_of(env);
    double a = p->acceleration, c = p->drag, top = p->top_speed, until = seconds;
    if (!from_rest)
        return top * seconds;
    if (c == 0)
        until = top / a;
    else if (top * c < a)
        until = -ll_detmath_log(1 - top * c / a) / c;
    until = until < seconds ? until : seconds;
    return a * ll_drag_over(c, until).g + top * (seconds - until);
}

/* `varied`: one of six pedal positions in slots of 750 +- 500 ms, after the first two seconds, and beyond the
 * finish too. `steady`: full throttle to the finish. */
static ll_action drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                       ll_script script, ll_time t)
{
    static const float pedal[] = {1, 1, 0.8f, 0.6f, 0.3f, -0.4f};
    ll_action a = {0};
    (void)env;
    if (script == LL_SCRIPT_IDLE)
        return a;
    if (script == LL_SCRIPT_STEADY) {
        a.axis[0] = world->entity[player].flags & LL_ENTITY_FINISHED ? -1 : 1;
        return a;
    }
    ll_slot slot = ll_script_slot(seed, player, LL_SCRIPT_SLOTS, t, 750 * LL_MS, 500 * LL_MS);
    a.axis[0] = t < 2 * LL_SECOND ? 1 : pedal[ll_script_draw(seed, player, LL_SCRIPT_OWN, slot.number) % 6];
    return a;
}

static ll_time same_until(const ll_game_env *env, uint64_t seed, int player, ll_script script, ll_time t)
{
    (void)env;
    if (script == LL_SCRIPT_IDLE)
        return LL_NEVER;
    if (script == LL_SCRIPT_STEADY)
        return t; /* it looks whether the car has finished */
    if (t < 2 * LL_SECOND)
        return 2 * LL_SECOND;
    return ll_script_slot_end(seed, player, LL_SCRIPT_SLOTS, t, 750 * LL_MS, 500 * LL_MS);
}

#define VALUES(X)                                                                                            \
    X(number, finish_s, "s", t->finish_s[player],                                                            \
      "virtual time at which the player's car reached the finish; 0: not yet", NULL)                         \
    X(count, place, NULL, place, "place of the player in the race now", NULL)                                \
    X(count, laps, NULL,                                                                                     \
      world->entity[player].x < 0 ? 0 : (double)(int64_t)(world->entity[player].x / p->lap),                 \
      "laps that the player's car has driven", NULL)                                                         \
    X(number, speed_mps, "m/s", world->entity[player].vx, "speed of the player's car", NULL)

const ll_metric_table ll_race_metrics = {LL_GAME_METRICS, .when = "Only in the game race.",
                                         .help = "Values of the game for this player, now.",
                                         LL_METRICS_FROM(VALUES)};

static void describe(const ll_world *world, const ll_game_env *env, int player, double *values)
{
    const race_tail *t = ll_world_tail_const(world);
    const race_params *p = params_of(env);
    int place = 1;
    for (int i = 0; i < world->players; i++) {
        bool earlier =
            t->finish_s[i] > 0 && (t->finish_s[player] == 0 || t->finish_s[i] < t->finish_s[player]);
        bool further =
            t->finish_s[i] == 0 && t->finish_s[player] == 0 && world->entity[i].x > world->entity[player].x;
        place += earlier || further;
    }
    LL_GAME_TELL(values, VALUES);
}

static ll_game_scene scene(const ll_game_env *env, int players)
{
    const race_params *p = params_of(env);
    return (ll_game_scene){.x_min = 0,
                           .x_max = p->lap,
                           .y_min = -p->lane_width,
                           .y_max = p->lane_width * players,
                           .wraps = true,
                           .finish_m = p->lap * p->laps,
                           .entity_length_m = p->car_length};
}

const ll_game ll_game_race = {
    .name = "race",
    .help = "Cars with throttle and brake on a circular track; cars in one lane touch.",
    .params = &ll_race_table,
    .metrics = &ll_race_metrics,
    LL_GAME_FUNCTIONS,
    .own_is_bounded = true,
    .reach = reach,
    .step_some = step_some,
    .farthest = farthest,
    .drive = drive,
    .same_until = same_until,
};
