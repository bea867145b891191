/* Stack: players drive balls into a structure that stands by friction, a scene of src/rigid, seen from the
 * side.
 *
 * Axes 0 and 1 are the direction in which the player wants its ball to go, along x and y; the balls have no
 * weight. The bodies of the scene are entities. Their positions and velocities are the whole state: a step
 * builds the scene, places its bodies, and discards it. It starts without the impulses that hold a stack
 * together, and finds them in its 32 substeps (solver soft_step). Bodies slower than 1 mm/s rest, and if all
 * rest a step costs nothing.
 *
 * A client that predicts only its own player predicts a ball that hits nothing but the ground: every push is
 * mispredicted. In scope `all` it predicts the pushed bodies too. */
#include <stdio.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "game/core/script.h"
#include "game/games/games.h"
#include "rigid/scenes/scene.h"

typedef struct stack_params {
    int64_t size, substeps;
    double friction, radius, mass, speed, acceleration;
    int32_t scene; /* index into scene_names */
    int32_t reserved;
} stack_params;

#define BLOCK_MAX (2 << 20) /* bytes of a step's world */
#define BODIES_MAX (LL_TOUCHING_MAX - LL_PEERS_MAX)
#define REST 1e-3 /* m/s and rad/s */

/* Scenes of src/rigid with boxes and without joints. */
static const char *const scene_names[] = {"pyramid", "column", "card_house", "domino", NULL};

static const ll_param rows[] = {
    {LL_PARAM_ROW("scene", CHOICE, stack_params, scene), .choices = scene_names,
     .help = "Structure: a scene of rigid bodies."},
    {LL_PARAM_ROW("size", INT, stack_params, size), .min = 1, .max = 20, .default_value = 6,
     .help = "Size of the scene: rows, levels or pieces."},
    {LL_PARAM_ROW("substeps", INT, stack_params, substeps), .min = 1, .max = 64, .default_value = 32,
     .help = "Substeps per step: higher stacks need more to stand."},
    {LL_PARAM_ROW("friction", REAL, stack_params, friction), .min = 0.01, .max = 2, .default_value = 0.6,
     .help = "Friction coefficient of all bodies."},
    {LL_PARAM_ROW("radius_m", REAL, stack_params, radius), .min = 0.02, .max = 2, .default_value = 0.4,
     .unit = "m", .help = "Radius of a ball."},
    {LL_PARAM_ROW("mass_kg", REAL, stack_params, mass), .min = 0.001, .max = 1000, .default_value = 3,
     .unit = "kg", .help = "Mass of a ball; a box of the pyramid has 1 kg."},
    {LL_PARAM_ROW("speed_mps", REAL, stack_params, speed), .min = 0.1, .max = 10, .default_value = 4,
     .unit = "m/s", .help = "Speed of a ball."},
    {LL_PARAM_ROW("acceleration_mps2", REAL, stack_params, acceleration), .min = 1, .max = 200,
     .default_value = 25, .unit = "m/s2",
     .help = "Acceleration of a ball; times its mass, the force it pushes with."},
};

/* ---- the scene's world ---- */

static ll_scene_args args_of(const ll_scene *scene, const stack_params *p)
{
    return ll_scene_args_of(scene, &(ll_scene_args){.size = p->size, .friction = p->friction});
}

static ll_rigid_limits limits_of(const stack_params *p, int players)
{
    const ll_scene *scene = ll_scene_named(scene_names[p->scene]);
    ll_scene_args args = args_of(scene, p);
    ll_rigid_limits limits = {0};
    scene->limits(&args, &limits);
    limits.broad = LL_BROAD_SAP;
    limits.bodies += players;
    limits.shapes += players;
    limits.contacts += 16 * players;
    return limits;
}

/* The initial scene, in a block of BLOCK_MAX bytes. */
static ll_status try_to_build(void *block, const stack_params *p, int players, ll_rigid **out)
{
    const ll_scene *scene = ll_scene_named(scene_names[p->scene]);
    ll_scene_args args = args_of(scene, p);
    ll_rigid_limits limits = limits_of(p, players);
    ll_rigid_params params;
    ll_param_defaults(&ll_rigid_table, &params);
    if (scene->params)
        scene->params(&args, &params);
    params.solver = LL_SOLVER_SOFT_STEP;
    params.substeps = p->substeps;
    params.continuous = LL_CONTINUOUS_SPECULATIVE;
    params.sleep = params.recycle = false;
    LL_ASSERT(ll_rigid_size(&limits) <= BLOCK_MAX);
    *out = ll_rigid_init(block, &limits, &params);
    return scene->build(*out, &args);
}

static ll_rigid *build(void *block, const stack_params *p, int players)
{
    ll_rigid *world;
    ll_status status = try_to_build(block, p, players, &world);
    LL_ASSERT(!ll_failed(&status));
    return world;
}

/* The movable bodies, in the order of the entities; returns their count. */
static int bodies_of(const ll_rigid *world, ll_body_id ids[BODIES_MAX])
{
    int count = 0;
    for (int32_t i = 0; i < ll_rigid_body_end(world); i++) {
        ll_body_state s;
        ll_status status = ll_rigid_get_body(world, ll_rigid_body_at(world, i), &s);
        if (ll_failed(&status) || s.type != LL_BODY_DYNAMIC)
            continue;
        if (count < BODIES_MAX)
            ids[count] = ll_rigid_body_at(world, i);
        count++;
    }
    return count;
}

static int count_of(const stack_params *p)
{
    _Alignas(64) char block[BLOCK_MAX];
    ll_body_id ids[BODIES_MAX];
    return bodies_of(build(block, p, 0), ids);
}

static ll_status check(const void *object, const char *path)
{
    const stack_params *p = object;
    char field[64];
    ll_rigid_limits limits = limits_of(p, LL_PEERS_MAX);
    snprintf(field, sizeof field, "%ssize", path);
    if (ll_rigid_size(&limits) > BLOCK_MAX)
        return ll_field_error(LL_LIMIT, field, "scene: %s of size %lld needs %zu kB; at most %d are allowed",
                              scene_names[p->scene], (long long)p->size, ll_rigid_size(&limits) / 1000,
                              BLOCK_MAX / 1000);
    _Alignas(64) char block[BLOCK_MAX];
    ll_body_id ids[BODIES_MAX];
    ll_rigid *world;
    ll_status status = try_to_build(block, p, 0, &world);
    if (ll_failed(&status))
        return ll_field_error(LL_LIMIT, field, "scene: %s of size %lld cannot be built: %s",
                              scene_names[p->scene], (long long)p->size, status.text);
    int count = bodies_of(world, ids);
    if (count > BODIES_MAX)
        return ll_field_error(LL_LIMIT, field, "scene: %s of size %lld has %d bodies; at most %d are allowed",
                              scene_names[p->scene], (long long)p->size, count, BODIES_MAX);
    return ll_ok();
}

const ll_param_table ll_stack_table = {
    .name = "stack", .help = "Parameters of the stack.", LL_PARAM_ROWS(rows, stack_params), .check = check};

static const stack_params *params_of(const ll_game_env *env)
{
    return (const stack_params *)env->params;
}

static ll_extent extent(const void *params, int players)
{
    return (ll_extent){players + count_of(params), 0};
}

/* Initial bounds of the bodies, for the view, with room for the balls next to them. */
static ll_game_scene *room(const ll_game_env *env)
{
    return (ll_game_scene *)env->derived;
}

static void prepare(ll_game_env *env, const void *params)
{
    _Alignas(64) char block[BLOCK_MAX];
    const stack_params *p = params;
    ll_body_id ids[BODIES_MAX];
    _Static_assert(sizeof(ll_game_scene) <= sizeof env->derived, "room for it");
    memcpy(env->params, params, sizeof(stack_params));
    ll_rigid *world = build(block, p, 0);
    int count = bodies_of(world, ids);
    ll_game_scene s = {.entity_length_m = 2 * p->radius};
    for (int k = 0; k < count; k++) {
        ll_body_state b;
        ll_status status = ll_rigid_get_body(world, ids[k], &b);
        LL_ASSERT(!ll_failed(&status));
        s.x_min = k == 0 || b.position.x < s.x_min ? b.position.x : s.x_min;
        s.x_max = k == 0 || b.position.x > s.x_max ? b.position.x : s.x_max;
        s.y_max = b.position.y > s.y_max ? b.position.y : s.y_max;
    }
    s.x_min -= 12 * p->radius;
    s.x_max += 12 * p->radius;
    s.y_max += 4 * p->radius;
    *room(env) = s;
}

static void init(ll_world *world, const ll_game_env *env, const int32_t *lanes)
{
    _Alignas(64) char block[BLOCK_MAX];
    const stack_params *p = params_of(env);
    ll_body_id ids[BODIES_MAX];
    ll_rigid *rigid = build(block, p, world->players);
    int count = bodies_of(rigid, ids);
    (void)lanes;
    for (int i = 0; i < world->players;
         i++) { /* alternately to the left and right of it, one above the other */
        world->entity[i].x = i % 2 == 0 ? room(env)->x_min + 3 * p->radius : room(env)->x_max - 3 * p->radius;
        world->entity[i].y = p->radius * (1.5 + 2.5 * (i / 2));
    }
    for (int k = 0; k < count; k++) {
        ll_body_state b;
        ll_status status = ll_rigid_get_body(rigid, ids[k], &b);
        LL_ASSERT(!ll_failed(&status));
        world->entity[world->players + k] = (ll_entity){.x = b.position.x,
                                                        .y = b.position.y,
                                                        .angle = b.angle,
                                                        .vx = b.velocity.x,
                                                        .vy = b.velocity.y,
                                                        .angular_velocity = b.angular_velocity};
    }
}

/* ---- a step ---- */

static void drive_ball(ll_entity *e, const ll_game_env *env, const ll_action *action)
{
    const stack_params *p = params_of(env);
    double most = p->acceleration * env->dt;
    double x = ll_clamp(p->speed * (double)action->axis[0] - e->vx, -most, most);
    double y = ll_clamp(p->speed * (double)action->axis[1] - e->vy, -most, most);
    e->vx += x;
    e->vy += y;
}

/* Clamps to the view's width and above the ground; stops the velocity in that direction. */
static void keep(ll_entity *e, const ll_game_env *env)
{
    const stack_params *p = params_of(env);
    const ll_game_scene *s = room(env);
    double x = ll_clamp(e->x, s->x_min + p->radius, s->x_max - p->radius);
    double y = ll_clamp(e->y, p->radius, 2 * s->y_max + 10 * p->radius);
    e->vx = x == e->x ? e->vx : 0;
    e->vy = y == e->y ? e->vy : 0;
    e->x = x;
    e->y = y;
}

static void step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    ll_entity *e = &world->entity[player];
    drive_ball(e, env, action);
    e->x = ll_mul_add(env, e->vx, env->dt, e->x);
    e->y = ll_mul_add(env, e->vy, env->dt, e->y);
    keep(e, env);
}

static bool at_rest(const ll_entity *e)
{
    return e->vx == 0 && e->vy == 0 && e->angular_velocity == 0;
}

static ll_status put(ll_rigid *rigid, ll_body_id id, const ll_entity *e)
{
    ll_status status = ll_rigid_set_pose(rigid, id, (ll_vec2){e->x, e->y}, e->angle);
    return ll_failed(&status)
               ? status
               : ll_rigid_set_velocity(rigid, id, (ll_vec2){e->vx, e->vy}, e->angular_velocity);
}

static ll_status add_ball(ll_rigid *rigid, const ll_game_env *env, const ll_entity *e, ll_body_id *id)
{
    const stack_params *p = params_of(env);
    ll_body_def def = ll_body_defaults(LL_BODY_DYNAMIC);
    ll_material material = ll_material_defaults();
    ll_geometry ball;
    def.position = (ll_vec2){e->x, e->y};
    def.velocity = (ll_vec2){e->vx, e->vy};
    def.gravity_scale = 0;
    def.fixed_rotation = 1;
    material.friction = p->friction;
    ll_status status = ll_shape_circle((ll_vec2){0, 0}, p->radius, &ball);
    LL_THEN(status, ll_rigid_add_body(rigid, &def, id));
    LL_THEN(status, ll_rigid_add_shape(rigid, *id, &ball, &material));
    return ll_failed(&status) ? status : ll_rigid_set_mass(rigid, *id, p->mass, 1);
}

static void take(ll_entity *e, const ll_game_env *env, const ll_body_state *s)
{
    bool rests = ll_sqrt(s->velocity.x * s->velocity.x + s->velocity.y * s->velocity.y) < REST &&
                 s->angular_velocity < REST && s->angular_velocity > -REST;
    if (rests) {
        e->vx = e->vy = e->angular_velocity = 0;
        return;
    }
    *e = (ll_entity){.vx = s->velocity.x,
                     .vy = s->velocity.y,
                     .angular_velocity = s->angular_velocity,
                     .x = ll_mul_add(env, (s->position.x - e->x) / env->dt, env->dt, e->x),
                     .y = ll_mul_add(env, (s->position.y - e->y) / env->dt, env->dt, e->y),
                     .angle = s->angle};
}

/* If the rigid step fails (a body was thrown out of the world), bodies stay where they are. */
static void step_bodies(ll_world *world, const ll_game_env *env)
{
    _Alignas(64) char block[BLOCK_MAX];
    ll_body_id ids[LL_TOUCHING_MAX];
    int players = world->players;
    ll_rigid *rigid = build(block, params_of(env), players);
    LL_ASSERT(bodies_of(rigid, ids + players) == world->entities - players);
    ll_status status = ll_ok();
    for (int i = 0; i < world->entities && !ll_failed(&status); i++)
        status = i < players ? add_ball(rigid, env, &world->entity[i], &ids[i])
                             : put(rigid, ids[i], &world->entity[i]);
    LL_THEN(status, ll_rigid_step(rigid, env->dt, NULL));
    for (int i = 0; i < world->entities; i++) {
        ll_body_state s;
        LL_THEN(status, ll_rigid_get_body(rigid, ids[i], &s));
        if (ll_failed(&status))
            return;
        take(&world->entity[i], env, &s);
        if (i < players)
            keep(&world->entity[i], env);
    }
}

static void step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const struct ll_past *past)
{
    bool moves = false;
    (void)now;
    (void)past;
    for (int i = 0; i < world->players; i++)
        drive_ball(&world->entity[i], env, &actions[i]);
    for (int i = 0; i < world->entities; i++)
        moves = moves || !at_rest(&world->entity[i]);
    if (moves)
        step_bodies(world, env);
}

/* ---- scripts ---- */

/* Against the foot of the structure and back, 2.5 s each way; `varied`: at random heights, in slots of 2.5 +-
 * 1 s. */
static ll_action drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                       ll_script script, ll_time t)
{
    const stack_params *p = params_of(env);
    const ll_game_scene *s = room(env);
    const ll_entity *own = &world->entity[player];
    if (script == LL_SCRIPT_IDLE)
        return (ll_action){0};
    int64_t turn = (t + player * 1300 * LL_MS) / (2500 * LL_MS);
    double height = 0.2;
    if (script != LL_SCRIPT_STEADY) {
        turn = ll_script_slot(seed, player, LL_SCRIPT_SLOTS, t, 2500 * LL_MS, LL_SECOND).number;
        height = 0.8 * ll_script_unit(seed, player, LL_SCRIPT_OWN, turn);
    }
    double home = player % 2 == 0 ? s->x_min + 3 * p->radius : s->x_max - 3 * p->radius;
    double x = turn % 2 == 0 ? home : (s->x_min + s->x_max) / 2, y = p->radius + height * s->y_max;
    return (ll_action){.axis = {(float)ll_clamp(2 * (x - own->x) / p->speed, -1, 1),
                                (float)ll_clamp(2 * (y - own->y) / p->speed, -1, 1)}};
}

/* ---- reported values ---- */

#define VALUES(X)                                                                                            \
    X(number, top_m, "m", top, "height of the highest body of the stack", NULL)                              \
    X(number, mean_height_m, "m", sum / (world->entities - world->players),                                  \
      "mean height of the bodies of the stack", NULL)                                                        \
    X(count, moving, NULL, moving, "bodies of the stack that are not at rest", NULL)                         \
    X(number, speed_mps, "m/s", ll_sqrt(own->vx * own->vx + own->vy * own->vy),                              \
      "speed of the player's ball", NULL)

const ll_metric_table ll_stack_metrics = {LL_GAME_METRICS, .when = "Only in the game stack.",
                                          .help = "Values of the game for this player, now.",
                                          LL_METRICS_FROM(VALUES)};

static void describe(const ll_world *world, const ll_game_env *env, int player, double *values)
{
    const ll_entity *own = &world->entity[player];
    double top = 0, moving = 0, sum = 0;
    (void)env;
    for (int k = world->players; k < world->entities; k++) {
        const ll_entity *e = &world->entity[k];
        top = e->y > top ? e->y : top;
        sum += e->y;
        moving += !at_rest(e);
    }
    LL_GAME_TELL(values, VALUES);
}

static ll_game_scene scene(const ll_game_env *env, int players)
{
    (void)players;
    return *room(env);
}

/* Box around the body's shape, in the body frame; in the scenes here it equals the shape. */
static bool shape(const ll_game_env *env, int players, int index, ll_game_shape *shape)
{
    _Alignas(64) char block[BLOCK_MAX];
    const stack_params *p = params_of(env);
    ll_body_id ids[BODIES_MAX];
    ll_rigid *rigid = build(block, p, 0);
    if (index < players) {
        *shape = (ll_game_shape){"player", 2 * p->radius, 2 * p->radius, true, 0, 0};
        return true;
    }
    if (index >= players + bodies_of(rigid, ids))
        return false;
    for (int32_t i = 0; i < ll_rigid_shape_end(rigid); i++) {
        ll_shape_view v;
        if (!ll_rigid_shape_at(rigid, i, &v) || v.body.index != ids[index - players].index)
            continue;
        ll_aabb box = ll_shape_aabb(&v.geometry, (ll_pose){{0, 0}, {1, 0}});
        *shape = (ll_game_shape){"crate", box.upper.x - box.lower.x, box.upper.y - box.lower.y, false, 0, 0};
    }
    return true;
}

const ll_game ll_game_stack = {
    .name = "stack",
    .help = "Players drive balls into a structure that stands by friction, seen from the side.",
    .params = &ll_stack_table,
    .metrics = &ll_stack_metrics,
    LL_GAME_FUNCTIONS,
    .drive = drive,
    .shape = shape,
};
