/* Swarm: many bodies that move on circles over a square, and players who drive among them. Nothing touches,
 * so a step costs little and each body has a closed form. For snapshots of many entities. */
#include "base/detmath.h"
#include "game/core/script.h"
#include "game/games/games.h"

typedef struct swarm_params {
    int64_t bodies;
    double side, speed, body_speed, turn;
} swarm_params;

/* Derived for a length of step. */
typedef struct swarm_turn {
    double sin, cos;
} swarm_turn;

static const ll_param rows[] = {
    {LL_PARAM_ROW("bodies", INT, swarm_params, bodies), .max = LL_ENTITIES_MAX - LL_PLAYERS_MAX,
     .default_value = 200, .help = "Number of moving bodies."},
    {LL_PARAM_ROW("field_m", REAL, swarm_params, side), .min = 10, .max = 10000, .default_value = 200,
     .unit = "m",
     .help = "Side of the square in which players and bodies start, and which players do not leave."},
    {LL_PARAM_ROW("speed_mps", REAL, swarm_params, speed), .min = 0.1, .max = 100, .default_value = 8,
     .unit = "m/s", .help = "Speed of a player at full deflection of one axis."},
    {LL_PARAM_ROW("body_speed_mps", REAL, swarm_params, body_speed), .max = 100, .default_value = 4,
     .unit = "m/s", .help = "Highest speed of a body; each has its own, at least half of it."},
    {LL_PARAM_ROW("turn_radps", REAL, swarm_params, turn), .min = 0.01, .max = 10, .default_value = 0.5,
     .unit = "rad/s",
     .help = "Angular velocity of the bodies on their circles; every other one turns the other way."},
};

const ll_param_table ll_swarm_table = {
    .name = "swarm", .help = "Parameters of the swarm.", LL_PARAM_ROWS(rows, swarm_params)};

static const swarm_params *params_of(const ll_game_env *env)
{
    return (const swarm_params *)env->params;
}

static ll_extent extent(const void *params, int players)
{
    return (ll_extent){players + (int)((const swarm_params *)params)->bodies, 0};
}

static void prepare(ll_game_env *env, const void *params)
{
    memcpy(env->params, params, sizeof(swarm_params));
    swarm_turn *turn = (swarm_turn *)env->derived;
    ll_sincos(params_of(env)->turn * env->dt, &turn->sin, &turn->cos);
}

#define PLACE_SEED 0x737761726d /* `swarm`: the same bodies in every session, of any seed */
#define TWO_PI 6.283185307179586

/* Uniform in [0, 1). */
static double draw(int entity, int purpose)
{
    return ll_rng_unit(PLACE_SEED, (uint64_t)purpose, (uint64_t)entity);
}

static void init(ll_world *world, const ll_game_env *env, const int32_t *lanes)
{
    const swarm_params *p = params_of(env);
    (void)lanes;
    for (int i = 0; i < world->entities; i++) {
        ll_entity *e = &world->entity[i];
        e->x = p->side * draw(i, 0);
        e->y = p->side * draw(i, 1);
        if (i < world->players)
            continue;
        double speed = p->body_speed * (0.5 + 0.5 * draw(i, 2)), sin, cos;
        ll_sincos(TWO_PI * draw(i, 3), &sin, &cos);
        e->vx = speed * cos;
        e->vy = speed * sin;
    }
}

/* A player has its speed at once, and stays in the square. */
static void step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    const swarm_params *p = params_of(env);
    ll_entity *e = &world->entity[player];
    e->vx = action->axis[0] * p->speed;
    e->vy = action->axis[1] * p->speed;
    e->x = ll_clamp(ll_mul_add(env, e->vx, env->dt, e->x), 0, p->side);
    e->y = ll_clamp(ll_mul_add(env, e->vy, env->dt, e->y), 0, p->side);
}

/* The velocity turns, and the body stays on its circle, of radius speed / turn: with w its angular velocity,
 * x + vy / w and y - vx / w are its centre, before and after. */
static void turn_body(ll_entity *e, double sin, double cos, double w)
{
    double vx = cos * e->vx - sin * e->vy, vy = sin * e->vx + cos * e->vy;
    e->x += (vy - e->vy) / w;
    e->y -= (vx - e->vx) / w;
    e->vx = vx;
    e->vy = vy;
}

static void step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const struct ll_past *past)
{
    const swarm_turn *turn = (const swarm_turn *)env->derived;
    const double w = params_of(env)->turn;
    (void)past;
    (void)now;
    for (int i = 0; i < world->players; i++)
        step_own(world, env, i, &actions[i]);
    for (int i = world->players; i < world->entities; i++)
        turn_body(&world->entity[i], i & 1 ? -turn->sin : turn->sin, turn->cos, i & 1 ? -w : w);
}

static double farthest(const ll_game_env *env, double seconds, bool from_rest)
{
    (void)from_rest;
    return params_of(env)->speed * seconds * ll_sqrt(2);
}

enum { OWN_COURSE = LL_SCRIPT_OWN };

/* `steady`: to and fro. `varied`: in slots of 2 +- 0.5 s towards a random place of the square. */
static ll_action drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                       ll_script script, ll_time t)
{
    ll_action a = {0};
    if (script == LL_SCRIPT_IDLE)
        return a;
    if (script == LL_SCRIPT_STEADY) {
        a.axis[0] = (t + player * 700 * LL_MS) % (4 * LL_SECOND) < 2 * LL_SECOND ? 1 : -1;
        return a;
    }
    const ll_slot slot = ll_script_slot(seed, player, LL_SCRIPT_SLOTS, t, 2 * LL_SECOND, 500 * LL_MS);
    const ll_entity *own = &world->entity[player];
    const double side = params_of(env)->side;
    double dx = side * ll_script_unit(seed, player, OWN_COURSE, 2 * slot.number) - own->x;
    double dy = side * ll_script_unit(seed, player, OWN_COURSE, 2 * slot.number + 1) - own->y;
    double length = ll_sqrt(dx * dx + dy * dy);
    if (length > 0.5) {
        a.axis[0] = (float)(dx / length);
        a.axis[1] = (float)(dy / length);
    }
    return a;
}

#define VALUES(X)                                                                                            \
    X(number, speed_mps, "m/s",                                                                              \
      ll_sqrt(world->entity[player].vx * world->entity[player].vx +                                          \
              world->entity[player].vy * world->entity[player].vy),                                          \
      "speed of the player's entity", NULL)

const ll_metric_table ll_swarm_metrics = {LL_GAME_METRICS, .when = "Only in the game swarm.",
                                          .help = "Values of the game for this player, now.",
                                          LL_METRICS_FROM(VALUES)};

static void describe(const ll_world *world, const ll_game_env *env, int player, double *values)
{
    (void)env;
    LL_GAME_TELL(values, VALUES);
}

static ll_game_scene scene(const ll_game_env *env, int players)
{
    (void)players;
    const double side = params_of(env)->side;
    return (ll_game_scene){.x_max = side, .y_max = side, .entity_length_m = side / 100};
}

static bool shape(const ll_game_env *env, int players, int index, ll_game_shape *out)
{
    const swarm_params *p = params_of(env);
    if (index >= players + p->bodies)
        return false;
    double size = p->side / (index < players ? 100 : 200);
    *out = (ll_game_shape){
        .kind = index < players ? "player" : "crate", .width = size, .height = size, .round = true};
    return true;
}

const ll_game ll_game_swarm = {
    .name = "swarm",
    .help = "Many bodies on circles, and players who drive among them; nothing touches.",
    .params = &ll_swarm_table,
    .metrics = &ll_swarm_metrics,
    .many = true,
    LL_GAME_FUNCTIONS,
    .own_is_bounded = true,
    .farthest = farthest,
    .drive = drive,
    .shape = shape,
};
