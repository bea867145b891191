/* Shooter: two towers face each other over a yard in which targets fly; seen from the side.
 *
 * The side view shows the plane of gravity, so a projectile's flight is complete without a third dimension.
 * A player rides a lift on its tower, across the line of fire: axis 0 is the speed of the lift. Axis 1 is the
 * aim: -1 straight down, 0 level, 1 straight up. LL_BUTTON_FIRE fires the rifle (hitscan), LL_BUTTON_CANNON a
 * projectile. Players with even numbers have the left tower, those with odd numbers the right one; the
 * players of a tower are a team and do not hit each other.
 *
 * Walls and a roof in the yard are cover: they block lines of sight and shots. Targets move to and fro,
 * vertically or horizontally, and turn at their ends and at random. Hits are counted; the victim goes on. A
 * shot of a step starts at the player's position before the step, which is what its client drew at the press.
 * A player's motion depends only on its own inputs, so its prediction is exact. */
#include "game/games/shooter.h"

#include "base/detmath.h"
#include "base/rng.h"

typedef struct shooter_tail {
    ll_time time; /* of the world, by the server's clock */
    ll_weapon_state arms[];
} shooter_tail;

static const char *const weapons_names[] = {"both", "rifle", "cannon", NULL};

static const ll_param rows[] = {
    {LL_PARAM_ROW("strafe_mps", REAL, ll_shooter_params, strafe), .max = 100, .default_value = 5,
     .unit = "m/s", .help = "Speed of a player's lift."},
    {LL_PARAM_ROW("player_radius_m", REAL, ll_shooter_params, player_radius), .min = 0.05, .max = 2,
     .default_value = 0.6, .unit = "m", .help = "Radius of a player's circle."},
    {LL_PARAM_ROW("targets", INT, ll_shooter_params, targets), .max = 16, .default_value = 6,
     .help = "Number of targets in the yard."},
    {LL_PARAM_ROW("target_speed_mps", REAL, ll_shooter_params, target_speed), .max = 100, .default_value = 6,
     .unit = "m/s", .help = "Speed of the targets."},
    {LL_PARAM_ROW("target_radius_m", REAL, ll_shooter_params, target_radius), .min = 0.05, .max = 2,
     .default_value = 0.6, .unit = "m", .help = "Radius of a target's circle."},
    {LL_PARAM_ROW("target_turn_s", REAL, ll_shooter_params, turn), .min = 0.2, .max = 3600,
     .default_value = 1.5, .unit = "s",
     .help = "Mean time between random turns of a target, besides those at its ends."},
    {LL_PARAM_ROW("weapons", CHOICE, ll_shooter_params, weapons), .choices = weapons_names,
     .help = "Weapons of the players."},
    {LL_PARAM_ROW("hitscan_interval_s", REAL, ll_shooter_params, rifle_interval), .min = 0.1, .max = 60,
     .default_value = 0.25, .unit = "s", .help = "Time between two shots of a rifle."},
    {LL_PARAM_ROW("cannon_interval_s", REAL, ll_shooter_params, cannon_interval), .min = 0.5, .max = 60,
     .default_value = 1.5, .unit = "s", .help = "Time between two shots of a cannon."},
    {LL_PARAM_ROW("projectile_speed_mps", REAL, ll_shooter_params, shell_speed), .min = 1, .max = 1000,
     .default_value = 35, .unit = "m/s", .help = "Muzzle speed of a projectile."},
    {LL_PARAM_ROW("gravity_mps2", REAL, ll_shooter_params, gravity), .min = 0.1, .max = 100,
     .default_value = 9.81, .unit = "m/s2", .help = "Gravity on projectiles, downwards."},
    {LL_PARAM_ROW("drag_per_m", REAL, ll_shooter_params, drag), .max = 1, .unit = "1/m",
     .help = "Quadratic drag of projectiles: deceleration over speed squared; 0: they fly parabolas."},
    {LL_PARAM_ROW("spread", REAL, ll_shooter_params, spread), .max = 10, .default_value = 1.5,
     .help = "Largest random aiming error of scripts, in radii of the target; `steady` aims at the centre."},
};

const ll_param_table ll_shooter_table = {
    .name = "shooter", .help = "Parameters of the shooter.", LL_PARAM_ROWS(rows, ll_shooter_params)};

static ll_extent extent(const void *params, int players)
{
    const ll_shooter_params *p = params;
    return (ll_extent){players + (int)p->targets,
                       (int)(sizeof(shooter_tail) + (size_t)players * sizeof(ll_weapon_state))};
}

static void prepare(ll_game_env *env, const void *params)
{
    *(ll_shooter_params *)env->params = *(const ll_shooter_params *)params;
}

/* ---- targets ---- */

/* Even targets move vertically on either side of the roof, odd ones horizontally above it. */
static bool upright(int target)
{
    return target % 2 == 0;
}

static void place_target(ll_entity *e, int target, double speed)
{
    int rank = target / 2;
    double way = rank % 2 == 0 ? speed : -speed;
    if (upright(target)) {
        double x = 18 + 2.5 * (double)(rank / 2);
        *e = (ll_entity){.x = rank % 2 == 0 ? x : LL_SHOOTER_WIDTH - x, .y = 5 + rank, .vy = way};
    } else {
        *e = (ll_entity){.x = 22 + 5 * (double)(rank % 4), .y = 12 + 0.8 * (double)rank, .vx = way};
    }
}

#define TURN_SLOT (LL_SECOND / 5)

static bool turns(const ll_shooter_params *p, int target, ll_time before, ll_time now)
{
    int64_t slot = now / TURN_SLOT;
    return slot != before / TURN_SLOT &&
           ll_rng_unit(0x7475726e, (uint64_t)target, (uint64_t)slot) * p->turn < ll_to_s(TURN_SLOT);
}

/* A target turns before it moves, so that its path within a step is straight. */
static void move_target(ll_entity *e, const ll_game_env *env, int target, ll_time before, ll_time now)
{
    const ll_shooter_params *p = ll_shooter_params_of(env);
    double *at = upright(target) ? &e->y : &e->x, *v = upright(target) ? &e->vy : &e->vx;
    double low = upright(target) ? 1.5 : 17, high = upright(target) ? 17.5 : LL_SHOOTER_WIDTH - 17;
    if (turns(p, target, before, now))
        *v = -*v;
    double next = ll_mul_add(env, *v, env->dt, *at);
    if ((next < low && *v < 0) || (next > high && *v > 0))
        *v = -*v;
    *at = ll_mul_add(env, *v, env->dt, *at);
}

/* ---- players ---- */

static void init(ll_world *world, const ll_game_env *env, const int32_t *lanes)
{
    (void)lanes;
    for (int i = 0; i < world->players; i++) {
        double x = 4 + 1.2 * (double)(i / 2);
        world->entity[i] = (ll_entity){.x = i % 2 == 0 ? x : LL_SHOOTER_WIDTH - x,
                                       .y = 7.5 + (double)(i / 2),
                                       .angle = i % 2 == 0 ? 0 : 2 * LL_SHOOTER_QUARTER};
    }
    for (int i = world->players; i < world->entities; i++)
        place_target(&world->entity[i], i - world->players, ll_shooter_params_of(env)->target_speed);
    shooter_tail *t = ll_world_tail(world);
    for (int i = 0; i < world->players; i++)
        t->arms[i] = (ll_weapon_state){0};
}

static void step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    ll_entity *e = &world->entity[player];
    double elevation = (double)action->axis[1] * LL_SHOOTER_QUARTER;
    double speed = (double)action->axis[0] * ll_shooter_params_of(env)->strafe;
    double y = ll_mul_add(env, speed, env->dt, e->y);
    y = ll_clamp(y, LL_SHOOTER_LIFT_LOW, LL_SHOOTER_LIFT_HIGH);
    e->vy = (y - e->y) / env->dt;
    e->y = y;
    e->angle = player % 2 == 0 ? elevation : 2 * LL_SHOOTER_QUARTER - elevation;
}

static ll_aim aim(const ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    (void)env;
    const ll_entity *e = &world->entity[player];
    double elevation = (double)action->axis[1] * LL_SHOOTER_QUARTER;
    return (ll_aim){{e->x, e->y}, {ll_shooter_facing(player) * ll_cos(elevation), ll_sin(elevation)}};
}

static void step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const ll_past *past)
{
    ll_arena arena;
    ll_point before[LL_BODIES_MAX], after[LL_BODIES_MAX];
    shooter_tail *t = ll_world_tail(world);
    ll_shooter_arena(env, world->players, &arena);
    ll_bodies_now(&arena, world, before);
    const ll_field field = {&arena, before, past, actions};
    for (int i = 0; i < world->players; i++)
        ll_weapons_fire(&t->arms[i], &field, i, &actions[i], aim(world, env, i, &actions[i]), t->time, now);
    for (int i = 0; i < world->players; i++)
        step_own(world, env, i, &actions[i]);
    for (int i = world->players; i < world->entities; i++)
        move_target(&world->entity[i], env, i - world->players, t->time, now);
    ll_bodies_now(&arena, world, after);
    for (int i = 0; i < world->players; i++)
        ll_weapons_fly(&t->arms[i], &field, i, after, t->time, now);
    t->time = now;
}

static const ll_weapon_state *arms(const ll_world *world, int player)
{
    const shooter_tail *t = ll_world_tail_const(world);
    return &t->arms[player];
}

#define VALUES(X)                                                                                            \
    X(count, rifle_shots, NULL, a->shots[LL_HITSCAN], "rifle shots (hitscan) of the player so far", NULL)    \
    X(events, rifle_hits, NULL, a->hits[LL_HITSCAN], "hits by the player's rifle (hitscan) so far", NULL)    \
    X(count, shell_shots, NULL, a->shots[LL_PROJECTILE],                                                     \
      "shells (projectiles) that the player fired so far", NULL)                                             \
    X(events, shell_hits, NULL, a->hits[LL_PROJECTILE], "hits by the player's shells (projectiles) so far",  \
      NULL)

const ll_metric_table ll_shooter_metrics = {LL_GAME_METRICS, .when = "Only in the game shooter.",
                                            .help = "Values of the game for this player, now.",
                                            LL_METRICS_FROM(VALUES)};

static void describe(const ll_world *world, const ll_game_env *env, int player, double *values)
{
    const ll_weapon_state *a = arms(world, player);
    (void)env;
    LL_GAME_TELL(values, VALUES);
}

static ll_game_scene scene(const ll_game_env *env, int players)
{
    (void)players;
    return (ll_game_scene){.x_max = LL_SHOOTER_WIDTH,
                           .y_max = LL_SHOOTER_HEIGHT,
                           .entity_length_m = 2 * ll_shooter_params_of(env)->player_radius};
}

static bool shape(const ll_game_env *env, int players, int index, ll_game_shape *s)
{
    const ll_shooter_params *p = ll_shooter_params_of(env);
    int cover = index - players - (int)p->targets;
    double radius = index < players ? p->player_radius : p->target_radius;
    *s = (ll_game_shape){index < players ? "player" : "target", 2 * radius, 2 * radius, true, 0, 0};
    if (cover < 0)
        return true;
    if (cover >= ll_shooter_cover_count)
        return false;
    const ll_box *b = &ll_shooter_covers[cover];
    *s = (ll_game_shape){"cover", b->x_max - b->x_min,       b->y_max - b->y_min,
                         false,   (b->x_min + b->x_max) / 2, (b->y_min + b->y_max) / 2};
    return true;
}

static const ll_weapons weapons = {.arena = ll_shooter_arena, .aim = aim, .arms = arms};

const ll_game ll_game_shooter = {
    .name = "shooter",
    .help = "Players on two towers shoot at flying targets and at each other, by rifle and by cannon.",
    .params = &ll_shooter_table,
    .metrics = &ll_shooter_metrics,
    LL_GAME_FUNCTIONS,
    .drive = ll_shooter_drive,
    .shape = shape,
    .weapons = &weapons,
};
