/* Crates: players push boxes in an arena, seen from above.
 *
 * Axes 0 and 1 are the direction in which the player wants to go, along x and y; the floor's grip limits the
 * change of its velocity. A player is a disc, a crate a square; a rigid world computes contacts
 * (game/games/floor.h). A released crate slides, rotates and comes to rest.
 *
 * A client that predicts only its own player treats all others as obstacles at their positions in the last
 * snapshot: a crate that moves on the server stops the predicted player. */
#include <stdio.h>

#include "base/detmath.h"
#include "base/rng.h"
#include "game/core/script.h"
#include "game/games/floor.h"
#include "game/games/games.h"

typedef struct crates_params {
    int64_t count;
    double size, mass, friction, width, depth, radius, player_mass, speed, acceleration;
} crates_params;

typedef struct crates_tail {
    struct {
        double pushed; /* m: distance that crates moved while this player pressed them */
        int64_t pressing;
    } score[1]; /* per player */
} crates_tail;

#define GRAVITY 9.81
#define TOP_SPEED 1.5 /* relative to the players' speed */

static const ll_param rows[] = {
    {LL_PARAM_ROW("count", INT, crates_params, count), .min = 1, .max = LL_TOUCHING_MAX - LL_PEERS_MAX,
     .default_value = 40, .help = "Number of crates."},
    {LL_PARAM_ROW("size_m", REAL, crates_params, size), .min = 0.2, .max = 5, .default_value = 0.8,
     .unit = "m", .help = "Side of a crate."},
    {LL_PARAM_ROW("mass_kg", REAL, crates_params, mass), .min = 1, .max = 1000, .default_value = 20,
     .unit = "kg", .help = "Mass of a crate."},
    {LL_PARAM_ROW("friction", REAL, crates_params, friction), .min = 0.01, .max = 2, .default_value = 0.4,
     .help = "Coulomb friction of a crate on the floor."},
    {LL_PARAM_ROW("arena_width_m", REAL, crates_params, width), .min = 5, .max = 200, .default_value = 48,
     .unit = "m", .help = "Width of the arena; players start along its left and right walls."},
    {LL_PARAM_ROW("arena_depth_m", REAL, crates_params, depth), .min = 2, .max = 200, .default_value = 8,
     .unit = "m", .help = "Depth of the arena."},
    {LL_PARAM_ROW("radius_m", REAL, crates_params, radius), .min = 0.1, .max = 2, .default_value = 0.4,
     .unit = "m", .help = "Radius of a player's disc."},
    {LL_PARAM_ROW("player_mass_kg", REAL, crates_params, player_mass), .min = 1, .max = 1000,
     .default_value = 80, .unit = "kg", .help = "Mass of a player."},
    {LL_PARAM_ROW("speed_mps", REAL, crates_params, speed), .min = 0.5, .max = 20, .default_value = 4,
     .unit = "m/s", .help = "Speed of a player; the limit of all speeds is 1.5 times this."},
    {LL_PARAM_ROW("acceleration_mps2", REAL, crates_params, acceleration), .min = 1, .max = 100,
     .default_value = 12, .unit = "m/s2",
     .help = "Acceleration of a player; times its mass, the force it pushes with."},
};

#define BORDER 4.0 /* initial distance of crates from the side walls, in players' radii */
#define SPACE 1.2  /* least initial distance of crates, in diagonals */

static double diagonal(const crates_params *p)
{
    return 1.4142135623730951 * p->size;
}

/* Width between the players' borders. */
static double inner_width(const crates_params *p)
{
    return p->width - 2 * BORDER * p->radius;
}

/* Crates start on a lattice: the number of lines that gives each the most room. */
static int64_t lines_of(const crates_params *p)
{
    int64_t best = 1;
    double most = 0;
    for (int64_t n = 1; n <= p->count; n++) {
        double across = inner_width(p) / (double)((p->count + n - 1) / n), down = p->depth / (double)n;
        double room = across < down ? across : down;
        best = room > most ? n : best;
        most = room > most ? room : most;
    }
    return best;
}

static ll_status check(const void *object, const char *path)
{
    const crates_params *p = object;
    char field[64];
    double pitch = SPACE * diagonal(p), depth = pitch > 20 * p->radius ? pitch : 20 * p->radius;
    int64_t most = (int64_t)(p->depth / pitch), lines = most < p->count ? most : p->count;
    bool shallow = p->depth < depth;
    snprintf(field, sizeof field, "%sarena_%s_m", path, shallow ? "depth" : "width");
    if (shallow)
        return ll_field_error(
            LL_BAD_INPUT, field,
            "arena_depth_m: must be at least %g m for crates of %g m and players of radius %g m; got %g",
            depth, p->size, p->radius, p->depth);
    double width = 2 * BORDER * p->radius + (double)((p->count + lines - 1) / lines) * pitch;
    if (p->width < width)
        return ll_field_error(
            LL_BAD_INPUT, field,
            "arena_width_m: must be at least %g m for %d crates of %g m in a depth of %g m; got %g", width,
            (int)p->count, p->size, p->depth, p->width);
    return ll_ok();
}

const ll_param_table ll_crates_table = {.name = "crates",
                                        .help = "Parameters of the crates.",
                                        LL_PARAM_ROWS(rows, crates_params),
                                        .check = check};

static const crates_params *params_of(const ll_game_env *env)
{
    return (const crates_params *)env->params;
}

static const ll_floor *floor_of(const ll_game_env *env)
{
    return (const ll_floor *)env->derived;
}

static ll_extent extent(const void *params, int players)
{
    const crates_params *p = params;
    const crates_tail *t = NULL;
    return (ll_extent){players + (int)p->count, players * (int)sizeof t->score[0]};
}

static void prepare(ll_game_env *env, const void *params)
{
    crates_params *p = (crates_params *)env->params;
    *p = *(const crates_params *)params;
    double half = p->size / 2, low = half < p->radius ? half : p->radius, top = TOP_SPEED * p->speed;
    *(ll_floor *)env->derived = (ll_floor){.width = p->width,
                                           .depth = p->depth,
                                           .top_speed = top,
                                           .half_max = half > p->radius ? half : p->radius,
                                           .substeps = ll_floor_substeps(env->dt, top, low)};
}

/* Places players alternately along the walls at x = 0 and at the largest x. */
static void place_players(ll_world *world, const crates_params *p)
{
    for (int i = 0; i < world->players; i++) {
        int beside = (world->players + 1 - i % 2) / 2;
        double x = BORDER / 2 * p->radius;
        world->entity[i].x = i % 2 == 0 ? x : p->width - x;
        world->entity[i].y = p->depth * (i / 2 + 1) / (beside + 1);
    }
}

/* Places a crate at random in its cell of the lattice, at a random angle, apart from its neighbours. */
static void place_crate(ll_entity *e, const crates_params *p, int64_t lines, int64_t columns, int64_t k)
{
    const uint64_t stream = 0x63726174, draw = (uint64_t)k * 3;
    double width = inner_width(p) / (double)columns, depth = p->depth / (double)lines;
    double spare_x = (width - diagonal(p)) * 0.9, spare_y = (depth - diagonal(p)) * 0.9;
    e->x = BORDER * p->radius + width * ((double)(k % columns) + 0.5);
    e->y = depth * ((double)(k / columns) + 0.5);
    e->x += spare_x * (ll_rng_unit(stream, 0, draw) - 0.5);
    e->y += spare_y * (ll_rng_unit(stream, 0, draw + 1) - 0.5);
    e->angle = 1.5 * (ll_rng_unit(stream, 0, draw + 2) - 0.5);
}

static void init(ll_world *world, const ll_game_env *env, const int32_t *lanes)
{
    const crates_params *p = params_of(env);
    int64_t lines = lines_of(p), columns = (p->count + lines - 1) / lines;
    (void)lanes;
    place_players(world, p);
    for (int64_t k = 0; k < p->count; k++)
        place_crate(&world->entity[world->players + k], p, lines, columns, k);
}

/* ---- worlds and bodies ---- */

static ll_floor_body body_of(const ll_world *world, const crates_params *p, int i, const ll_action *action)
{
    const ll_entity *e = &world->entity[i];
    ll_floor_body b = {.x = e->x,
                       .y = e->y,
                       .angle = e->angle,
                       .vx = e->vx,
                       .vy = e->vy,
                       .angular_velocity = e->angular_velocity,
                       .absent = (e->flags & LL_ENTITY_UNKNOWN) != 0,
                       .unsettled = (e->flags & LL_ENTITY_UNSETTLED) != 0};
    if (i < world->players) {
        b.round = true;
        b.half = p->radius;
        b.inverse_mass = 1 / p->player_mass;
        b.grip = p->acceleration;
        if (action) {
            b.wanted_vx = (double)action->axis[0] * p->speed;
            b.wanted_vy = (double)action->axis[1] * p->speed;
            double size2 = b.wanted_vx * b.wanted_vx + b.wanted_vy * b.wanted_vy;
            if (size2 > p->speed * p->speed) { /* no faster along a diagonal */
                b.wanted_vx *= p->speed / ll_sqrt(size2);
                b.wanted_vy *= p->speed / ll_sqrt(size2);
            }
        }
    } else {
        b.half = p->size / 2;
        b.inverse_mass = 1 / p->mass;
        b.inverse_inertia = 6 / (p->mass * p->size * p->size);
        b.grip = p->friction * GRAVITY;
        /* A square that rotates under friction: torque mu m g r, with r the mean distance 0.38260 a from its
         * centre, over m a^2 / 6. */
        b.grip_spin = b.grip * 0.38259785823210635 * 6 / p->size;
    }
    return b;
}

static void to_entity(const ll_floor_body *b, ll_entity *e)
{
    if (b->absent)
        return;
    e->x = b->x;
    e->y = b->y;
    e->angle = b->angle;
    e->vx = b->vx;
    e->vy = b->vy;
    e->angular_velocity = b->angular_velocity;
    e->flags = b->unsettled ? LL_ENTITY_UNSETTLED : 0;
}

static bool at_rest(const ll_entity *e)
{
    return e->vx == 0 && e->vy == 0 && e->angular_velocity == 0 && !(e->flags & LL_ENTITY_UNSETTLED);
}

static void score(ll_world *world, const ll_floor_body *bodies)
{
    crates_tail *t = ll_world_tail(world);
    for (int p = 0; p < world->players; p++)
        t->score[p].pressing = 0;
    for (int i = world->players; i < world->entities; i++) {
        double dx = bodies[i].x - world->entity[i].x, dy = bodies[i].y - world->entity[i].y;
        for (int p = 0; p < world->players; p++) {
            bool pressed = bodies[i].pressed_by >> p & 1;
            t->score[p].pressing += pressed;
            t->score[p].pushed += pressed ? ll_sqrt(dx * dx + dy * dy) : 0;
        }
    }
}

static void step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const struct ll_past *past)
{
    ll_floor_body bodies[LL_TOUCHING_MAX];
    (void)now;
    (void)past;
    for (int i = 0; i < world->entities; i++)
        bodies[i] = body_of(world, params_of(env), i, i < world->players ? &actions[i] : NULL);
    ll_floor_step(env, floor_of(env), bodies, world->entities);
    score(world, bodies);
    for (int i = 0; i < world->entities; i++)
        to_entity(&bodies[i], &world->entity[i]);
}

static void step_some(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                      const ll_entity_set *set)
{
    ll_floor_body bodies[LL_TOUCHING_MAX];
    int entity[LL_TOUCHING_MAX], count = 0;
    (void)now;
    for (int i = 0; i < world->entities; i++) {
        if (!ll_entity_set_has(set, i))
            continue;
        bodies[count] = body_of(world, params_of(env), i, i < world->players ? &actions[i] : NULL);
        entity[count++] = i;
    }
    ll_floor_step(env, floor_of(env), bodies, count);
    for (int k = 0; k < count; k++)
        to_entity(&bodies[k], &world->entity[entity[k]]);
}

/* Entities within a step's reach are obstacles. */
static void step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    ll_floor_body bodies[LL_TOUCHING_MAX];
    const ll_floor *floor = floor_of(env);
    const ll_entity *own = &world->entity[player];
    double near = 4 * floor->half_max + floor->top_speed * env->dt;
    int count = 0;
    bodies[count++] = body_of(world, params_of(env), player, action);
    for (int i = 0; i < world->entities; i++) {
        const ll_entity *e = &world->entity[i];
        double dx = e->x - own->x, dy = e->y - own->y;
        if (i == player || e->flags & LL_ENTITY_UNKNOWN || dx * dx + dy * dy > near * near)
            continue;
        ll_floor_body *b = &bodies[count++];
        *b = body_of(world, params_of(env), i, NULL);
        b->inverse_mass = b->inverse_inertia = b->vx = b->vy = b->angular_velocity = 0;
    }
    ll_floor_step(env, floor, bodies, count);
    to_entity(&bodies[0], &world->entity[player]);
}

/* ---- possible contacts ---- */

/* Entities as circles that grow at top speed from their earliest motion. */
typedef struct wave {
    int count;
    double top;
    double x[LL_TOUCHING_MAX], y[LL_TOUCHING_MAX];
    double radius[LL_TOUCHING_MAX]; /* plus half of the distance within which the floor makes a pair */
    double start[LL_TOUCHING_MAX];  /* s */
} wave;

/* Whether circles i and j are at most `far` apart. */
static bool within(const wave *w, int i, int j, double far)
{
    double dx = w->x[i] - w->x[j], dy = w->y[i] - w->y[j], reach = w->radius[i] + w->radius[j] + far;
    return dx * dx + dy * dy <= reach * reach;
}

/* Earliest motion of each: players and sliding bodies at once, a resting body when a moving one may have
 * reached it, or never in time. Sorted by these times. */
static void start(wave *w, double horizon_s)
{
    bool done[LL_TOUCHING_MAX] = {false};
    for (;;) {
        int first = -1;
        for (int i = 0; i < w->count; i++)
            if (!done[i] && w->start[i] < horizon_s && (first < 0 || w->start[i] < w->start[first]))
                first = i;
        if (first < 0)
            return;
        done[first] = true;
        for (int j = 0; j < w->count; j++) {
            double dx = w->x[first] - w->x[j], dy = w->y[first] - w->y[j];
            if (done[j] || !within(w, first, j, w->top * (w->start[j] - w->start[first])))
                continue;
            double apart = ll_sqrt(dx * dx + dy * dy) - w->radius[first] - w->radius[j];
            w->start[j] = w->start[first] + (apart > 0 ? apart / w->top : 0);
        }
    }
}

/* Two touch if, at top speed from their earliest motion on, they can meet in time. */
static void reach(const ll_world *world, const ll_game_env *env, double horizon_s, ll_entity_set *set)
{
    const crates_params *p = params_of(env);
    wave w = {.count = world->entities, .top = floor_of(env)->top_speed};
    int queue[LL_TOUCHING_MAX], count = 0;
    double margin = ll_floor_margin(env, floor_of(env)) / 2;
    for (int i = 0; i < w.count; i++) {
        const ll_entity *e = &world->entity[i];
        bool player = i < world->players;
        w.x[i] = e->x;
        w.y[i] = e->y;
        w.radius[i] = (player ? p->radius : diagonal(p) / 2) + margin;
        w.start[i] = player || !at_rest(e) ? 0 : horizon_s;
        if (ll_entity_set_has(set, i))
            queue[count++] = i;
    }
    start(&w, horizon_s);
    for (int k = 0; k < count; k++)
        for (int j = 0; j < w.count; j++) {
            double time = 2 * horizon_s - w.start[queue[k]] - w.start[j];
            if (ll_entity_set_has(set, j) || world->entity[j].flags & LL_ENTITY_UNKNOWN || time <= 0 ||
                !within(&w, queue[k], j, w.top * time))
                continue;
            ll_entity_set_add(set, j);
            queue[count++] = j;
        }
}

/* ---- scripts ---- */

static ll_action towards(const ll_entity *own, double x, double y)
{
    double dx = x - own->x, dy = y - own->y, far = ll_sqrt(dx * dx + dy * dy);
    return far > 0 ? (ll_action){.axis = {(float)(dx / far), (float)(dy / far)}} : (ll_action){0};
}

enum { OWN_CRATE = LL_SCRIPT_OWN, OWN_GOAL_X, OWN_GOAL_Y };

/* For a slot of 4 +- 2 s pushes one crate towards one position, after moving behind it. */
static ll_action push_about(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                            ll_time t)
{
    const crates_params *p = params_of(env);
    int64_t slot = ll_script_slot(seed, player, LL_SCRIPT_SLOTS, t, 4 * LL_SECOND, 2 * LL_SECOND).number;
    uint64_t crates = (uint64_t)(world->entities - world->players);
    int chosen = world->players + (int)(ll_script_draw(seed, player, OWN_CRATE, slot) % crates);
    const ll_entity *own = &world->entity[player], *crate = &world->entity[chosen];
    double goal_x = p->width * (0.2 + 0.6 * ll_script_unit(seed, player, OWN_GOAL_X, slot)),
           goal_y = p->depth * (0.2 + 0.6 * ll_script_unit(seed, player, OWN_GOAL_Y, slot));
    double dx = goal_x - crate->x, dy = goal_y - crate->y, far = ll_sqrt(dx * dx + dy * dy) + 1e-9;
    double stand = p->radius + p->size, x = crate->x - dx / far * stand, y = crate->y - dy / far * stand;
    double ox = crate->x - own->x, oy = crate->y - own->y, near = ll_sqrt(ox * ox + oy * oy) + 1e-9;
    bool behind = (ox * dx + oy * dy) / (near * far) > 0.8 && near < 2 * stand;
    return behind ? towards(own, crate->x, crate->y) : towards(own, x, y);
}

/* `steady`: in circles, through any crates. */
static ll_action drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                       ll_script script, ll_time t)
{
    const crates_params *p = params_of(env);
    if (script == LL_SCRIPT_IDLE)
        return (ll_action){0};
    if (script != LL_SCRIPT_STEADY)
        return push_about(world, env, seed, player, t);
    double angle = 0.4 * ll_to_s(t) + 3.141592653589793 * player;
    return towards(&world->entity[player], p->width * (0.5 - 0.3 * ll_cos(angle)),
                   p->depth * (0.5 + 0.3 * ll_sin(angle)));
}

/* ---- reported values ---- */

#define VALUES(X)                                                                                            \
    X(number, pushed_m, "m", t->score[player].pushed,                                                        \
      "distance that crates moved while the player pressed them", NULL)                                      \
    X(count, pressing, NULL, t->score[player].pressing, "crates that the player presses now", NULL)          \
    X(number, speed_mps, "m/s", ll_sqrt(own->vx * own->vx + own->vy * own->vy),                              \
      "speed of the player's entity", NULL)                                                                  \
    X(count, moving, NULL, moving, "crates of the world that are not at rest", NULL)

const ll_metric_table ll_crates_metrics = {LL_GAME_METRICS, .when = "Only in the game crates.",
                                           .help = "Values of the game for this player, now.",
                                           LL_METRICS_FROM(VALUES)};

static void describe(const ll_world *world, const ll_game_env *env, int player, double *values)
{
    const crates_tail *t = ll_world_tail_const(world);
    const ll_entity *own = &world->entity[player];
    int moving = 0;
    (void)env;
    for (int i = world->players; i < world->entities; i++)
        moving += !at_rest(&world->entity[i]);
    LL_GAME_TELL(values, VALUES);
}

static ll_game_scene scene(const ll_game_env *env, int players)
{
    const crates_params *p = params_of(env);
    (void)players;
    return (ll_game_scene){.x_max = p->width, .y_max = p->depth, .entity_length_m = 2 * p->radius};
}

static bool shape(const ll_game_env *env, int players, int index, ll_game_shape *shape)
{
    const crates_params *p = params_of(env);
    if (index >= players + p->count)
        return false;
    *shape = index < players ? (ll_game_shape){"player", 2 * p->radius, 2 * p->radius, true, 0, 0}
                             : (ll_game_shape){"crate", p->size, p->size, false, 0, 0};
    return true;
}

const ll_game ll_game_crates = {
    .name = "crates",
    .help = "Players push boxes, seen from above.",
    .params = &ll_crates_table,
    .metrics = &ll_crates_metrics,
    LL_GAME_FUNCTIONS,
    .own_reads_world = true,
    .reach = reach,
    .step_some = step_some,
    .drive = drive,
    .shape = shape,
};
