/* Gambetta: the rule of the live demo "Fast-Paced Multiplayer", for comparison: an input moves its entity by
 * speed x time, and nothing else does. Axis 0 is the direction. There is no velocity and no contact, so
 * replayed inputs are always right. */
#include "game/core/script.h"
#include "game/games/games.h"

typedef struct gambetta_params {
    double speed, width;
} gambetta_params;

static const ll_param rows[] = {
    {LL_PARAM_ROW("speed_mps", REAL, gambetta_params, speed), .min = 0.01, .max = 1000, .default_value = 2,
     .unit = "m/s", .help = "Speed while a key is pressed."},
    {LL_PARAM_ROW("width_m", REAL, gambetta_params, width), .min = 1, .max = 1000, .default_value = 10,
     .unit = "m", .help = "Width of a view."},
};

const ll_param_table ll_gambetta_table = {
    .name = "gambetta", .help = "Parameters of the demo's rule.", LL_PARAM_ROWS(rows, gambetta_params)};

static const gambetta_params *params_of(const ll_game_env *env)
{
    return (const gambetta_params *)env->params;
}

static ll_extent extent(const void *params, int players)
{
    (void)params;
    return (ll_extent){players, 0};
}

static void prepare(ll_game_env *env, const void *params)
{
    *(gambetta_params *)env->params = *(const gambetta_params *)params;
}

static void init(ll_world *world, const ll_game_env *env, const int32_t *lanes)
{
    for (int i = 0; i < world->players; i++) {
        world->entity[i].x = params_of(env)->width * (0.4 + 0.2 * (i % 2)); /* 4 and 6 of 10 */
        world->entity[i].y = lanes[i];
    }
}

static void step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    ll_entity *e = &world->entity[player];
    e->vx = action->axis[0] * params_of(env)->speed;
    e->x = ll_mul_add(env, e->vx, env->dt, e->x);
}

static void step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const struct ll_past *past)
{
    (void)past;
    (void)now;
    for (int i = 0; i < world->players; i++)
        step_own(world, env, i, &actions[i]);
}

static double farthest(const ll_game_env *env, double seconds, bool from_rest)
{
    (void)from_rest;
    return params_of(env)->speed * seconds;
}

enum { OWN_SIDE = LL_SCRIPT_OWN, OWN_OUT, OWN_THERE };

/* `steady`: to and fro. `varied`: out, wait, back, wait, like pressed keys: in slots of 4 +- 0.4 s, to a
 * random side, 1.2 to 1.6 s each way and 0.1 to 0.4 s there. */
static ll_action drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                       ll_script script, ll_time t)
{
    ll_action a = {0};
    (void)world;
    (void)env;
    if (script == LL_SCRIPT_IDLE)
        return a;
    if (script == LL_SCRIPT_STEADY) {
        a.axis[0] = (t + player * 700 * LL_MS) % (4 * LL_SECOND) < 2 * LL_SECOND ? 1 : -1;
        return a;
    }
    ll_slot slot = ll_script_slot(seed, player, LL_SCRIPT_SLOTS, t, 4 * LL_SECOND, 400 * LL_MS);
    float side = ll_script_draw(seed, player, OWN_SIDE, slot.number) & 1 ? 1 : -1;
    ll_time out = 1200 * LL_MS + ll_script_time(seed, player, OWN_OUT, slot.number, 400 * LL_MS);
    ll_time there = 100 * LL_MS + ll_script_time(seed, player, OWN_THERE, slot.number, 300 * LL_MS);
    if (slot.since < out)
        a.axis[0] = side;
    else if (slot.since >= out + there && slot.since < 2 * out + there)
        a.axis[0] = -side;
    return a;
}

#define VALUES(X) X(number, speed_mps, "m/s", world->entity[player].vx, "speed of the player's entity", NULL)

const ll_metric_table ll_gambetta_metrics = {LL_GAME_METRICS, .when = "Only in the game gambetta.",
                                             .help = "Values of the game for this player, now.",
                                             LL_METRICS_FROM(VALUES)};

static void describe(const ll_world *world, const ll_game_env *env, int player, double *values)
{
    (void)env;
    LL_GAME_TELL(values, VALUES);
}

static ll_game_scene scene(const ll_game_env *env, int players)
{
    return (ll_game_scene){
        .x_max = params_of(env)->width, .y_min = -1, .y_max = players, .entity_length_m = 0.5};
}

const ll_game ll_game_gambetta = {
    .name = "gambetta",
    .help = "The live demo's rule: only inputs move an entity.",
    .params = &ll_gambetta_table,
    .metrics = &ll_gambetta_metrics,
    LL_GAME_FUNCTIONS,
    .own_is_bounded = true,
    .farthest = farthest,
    .drive = drive,
};
