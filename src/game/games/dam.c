/* Dam: a column of water collapses in a tank, and players move paddles through it, seen from the side.
 *
 * Axes 0 and 1 are the direction in which the player wants its paddle to go, along x and y. Paddles pass
 * through everything; water within their circle moves with them. The water is particles (src/fluid, method
 * pbf), one entity each: a step makes a fluid from their positions and velocities and discards it, so that a
 * snapshot holds the whole state. Warm-start data of the solver is not kept.
 *
 * A client that predicts only its own player predicts its paddle; the water comes from snapshots. */
#include <stdio.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "fluid/particle/particle.h"
#include "game/core/script.h"
#include "game/games/games.h"

typedef struct dam_params {
    int64_t across, iterations;
    double side, width, height, radius, speed, acceleration;
} dam_params;

#define ACROSS_MAX 15       /* particles per side of the column */
#define BLOCK_MAX (1 << 20) /* bytes of a step's fluid */
#define WALLS_MAX 3000      /* particles of the tank's walls that fit BLOCK_MAX */

static const ll_param rows[] = {
    {LL_PARAM_ROW("across", INT, dam_params, across), .min = 4, .max = ACROSS_MAX, .default_value = 13,
     .help = "Particles per side of the square column of water."},
    {LL_PARAM_ROW("iterations", INT, dam_params, iterations), .min = 1, .max = 50, .default_value = 12,
     .help = "Iterations of the water's solver (pbf) per substep."},
    {LL_PARAM_ROW("side_m", REAL, dam_params, side), .min = 0.1, .max = 10, .default_value = 1, .unit = "m",
     .help = "Side of the column."},
    {LL_PARAM_ROW("width_m", REAL, dam_params, width), .min = 0.2, .max = 50, .default_value = 3, .unit = "m",
     .help = "Width of the tank."},
    {LL_PARAM_ROW("height_m", REAL, dam_params, height), .min = 0.1, .max = 50, .default_value = 1.4,
     .unit = "m", .help = "Height of the tank."},
    {LL_PARAM_ROW("radius_m", REAL, dam_params, radius), .min = 0.01, .max = 2, .default_value = 0.12,
     .unit = "m", .help = "Radius of a paddle's disc."},
    {LL_PARAM_ROW("speed_mps", REAL, dam_params, speed), .min = 0.1, .max = 5, .default_value = 1.5,
     .unit = "m/s", .help = "Speed of a paddle."},
    {LL_PARAM_ROW("acceleration_mps2", REAL, dam_params, acceleration), .min = 1, .max = 100,
     .default_value = 15, .unit = "m/s2", .help = "Acceleration of a paddle."},
};

static ll_particle_setup setup_of(const dam_params *p)
{
    return (ll_particle_setup){
        .width = p->width,
        .height = p->height,
        .spacing = p->side / (double)p->across,
        .smoothing = 1.25,
        .walls = LL_WALL_LEFT | LL_WALL_RIGHT | LL_WALL_BOTTOM | LL_WALL_TOP,
        .fill_count = 1,
        .fill = {{.width = p->side, .height = p->side}},
    };
}

static ll_particle_params solver_of(const dam_params *p)
{
    ll_particle_params s;
    ll_param_defaults(&ll_particle_table, &s);
    s.method = LL_PARTICLE_PBF;
    s.gravity_x = 0;
    s.gravity_y = -9.81;
    s.density = 1000;
    s.cfl = 1;
    s.iterations = p->iterations;
    s.substeps = 64;
    return s;
}

static ll_status check(const void *object, const char *path)
{
    const dam_params *p = object;
    ll_particle_setup setup = setup_of(p);
    char field[64];
    bool low = p->height < p->side || p->height < 2 * p->radius;
    double least = p->side > 2 * p->radius ? p->side : 2 * p->radius;
    snprintf(field, sizeof field, "%s%s_m", path, low ? "height" : "width");
    if (low || p->width < least)
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s_m: must be at least %g m for a column of %g m and paddles of %g m; got %g",
                              low ? "height" : "width", least, p->side, p->radius,
                              low ? p->height : p->width);
    double walls = 6 * (p->width + p->height) / setup.spacing;
    if (walls > WALLS_MAX)
        return ll_field_error(LL_LIMIT, field,
                              "width_m, height_m: the walls need %.0f particles of %g m; at most %d", walls,
                              setup.spacing, WALLS_MAX);
    return ll_ok();
}

const ll_param_table ll_dam_table = {
    .name = "dam", .help = "Parameters of the dam.", LL_PARAM_ROWS(rows, dam_params), .check = check};

static const dam_params *params_of(const ll_game_env *env)
{
    return (const dam_params *)env->params;
}

static ll_extent extent(const void *params, int players)
{
    const dam_params *p = params;
    return (ll_extent){players + (int)(p->across * p->across), 0};
}

static void prepare(ll_game_env *env, const void *params)
{
    memcpy(env->params, params, sizeof(dam_params));
}

static void init(ll_world *world, const ll_game_env *env, const int32_t *lanes)
{
    const dam_params *p = params_of(env);
    double spacing = p->side / (double)p->across;
    (void)lanes;
    for (int i = 0; i < world->players; i++) { /* next to the column, in a row */
        world->entity[i].x = p->side + (p->width - p->side) * (i + 1) / (world->players + 1);
        world->entity[i].y = p->height / 2;
    }
    for (int64_t k = 0; k < p->across * p->across; k++) {
        ll_entity *e = &world->entity[world->players + k];
        e->x = ((double)(k % p->across) + 0.5) * spacing;
        e->y = ((double)(k / p->across) + 0.5) * spacing;
    }
}

/* ---- a step ---- */

static double towards(double from, double to, double most)
{
    return from + ll_clamp(to - from, -most, most);
}

/* Clamps to the tank; a wall stops it. */
static void keep(double *x, double *v, double low, double high)
{
    double kept = ll_clamp(*x, low, high);
    if (kept != *x)
        *v = 0;
    *x = kept;
}

static void step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    const dam_params *p = params_of(env);
    ll_entity *e = &world->entity[player];
    double most = p->acceleration * env->dt;
    e->vx = towards(e->vx, p->speed * (double)action->axis[0], most);
    e->vy = towards(e->vy, p->speed * (double)action->axis[1], most);
    e->x = ll_mul_add(env, e->vx, env->dt, e->x);
    e->y = ll_mul_add(env, e->vy, env->dt, e->y);
    keep(&e->x, &e->vx, p->radius, p->width - p->radius);
    keep(&e->y, &e->vy, p->radius, p->height - p->radius);
}

/* A paddle at rest has no effect. */
static void draw_along(ll_world *world, const dam_params *p)
{
    for (int i = 0; i < world->players; i++) {
        const ll_entity *e = &world->entity[i];
        if (e->vx == 0 && e->vy == 0)
            continue;
        for (int k = world->players; k < world->entities; k++) {
            ll_entity *w = &world->entity[k];
            double dx = w->x - e->x, dy = w->y - e->y;
            if (dx * dx + dy * dy > p->radius * p->radius)
                continue;
            w->vx = e->vx;
            w->vy = e->vy;
        }
    }
}

/* If the solver fails, the water stays where it is, at rest. */
static void flow(ll_world *world, const ll_game_env *env)
{
    _Alignas(64) char block[BLOCK_MAX];
    const dam_params *p = params_of(env);
    ll_particle_setup setup = setup_of(p);
    ll_particle_params solver = solver_of(p);
    LL_ASSERT(ll_particles_size(&setup) <= sizeof block);
    ll_particles *fluid = ll_particles_init(block, &setup, &solver);
    ll_particle_place places[ACROSS_MAX * ACROSS_MAX];
    ll_entity *water = &world->entity[world->players];
    for (int k = 0; k < world->entities - world->players; k++)
        places[k] = (ll_particle_place){water[k].x, water[k].y, water[k].vx, water[k].vy};
    ll_particles_put(fluid, places);
    ll_status status = ll_particles_step(fluid, env->dt);
    ll_particle_view v = ll_particles_view(fluid);
    for (int32_t i = 0; i < v.count; i++) {
        ll_entity *e = &water[v.id[i]];
        if (ll_failed(&status))
            e->vx = e->vy = 0;
        else
            *e = (ll_entity){.x = v.x[i], .y = v.y[i], .vx = v.u[i], .vy = v.v[i]};
    }
}

static void step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                 const struct ll_past *past)
{
    (void)now;
    (void)past;
    for (int i = 0; i < world->players; i++)
        step_own(world, env, i, &actions[i]);
    draw_along(world, params_of(env));
    flow(world, env);
}

/* ---- scripts ---- */

enum { OWN_X = LL_SCRIPT_OWN, OWN_Y };

/* Moves to a position in the tank. `varied`: random ones, in slots of 1.5 +- 0.8 s; `steady`: to and fro, 1.5
 * s each way. */
static ll_action drive(const ll_world *world, const ll_game_env *env, uint64_t seed, int player,
                       ll_script script, ll_time t)
{
    const dam_params *p = params_of(env);
    const ll_entity *own = &world->entity[player];
    if (script == LL_SCRIPT_IDLE)
        return (ll_action){0};
    double x = 0.1 + 0.8 * (double)((t + player * 400 * LL_MS) / (1500 * LL_MS) % 2), y = 0.15;
    if (script != LL_SCRIPT_STEADY) {
        ll_slot slot = ll_script_slot(seed, player, LL_SCRIPT_SLOTS, t, 1500 * LL_MS, 800 * LL_MS);
        x = ll_script_unit(seed, player, OWN_X, slot.number);
        y = 0.4 * ll_script_unit(seed, player, OWN_Y, slot.number);
    }
    x *= p->width;
    y *= p->height;
    return (ll_action){.axis = {(float)ll_clamp(4 * (x - own->x) / p->speed, -1, 1),
                                (float)ll_clamp(4 * (y - own->y) / p->speed, -1, 1)}};
}

/* ---- reported values ---- */

#define VALUES(X)                                                                                            \
    X(number, front_m, "m", front, "horizontal position of the front of the water", NULL)                    \
    X(number, top_m, "m", top, "height of the highest point of the water", NULL)                             \
    X(number, water_speed_mps, "m/s", ll_sqrt(squares / count), "root mean square speed of the water", NULL) \
    X(number, speed_mps, "m/s", ll_sqrt(own->vx * own->vx + own->vy * own->vy),                              \
      "speed of the player's paddle", NULL)

const ll_metric_table ll_dam_metrics = {LL_GAME_METRICS, .when = "Only in the game dam.",
                                        .help = "Values of the game for this player, now.",
                                        LL_METRICS_FROM(VALUES)};

static void describe(const ll_world *world, const ll_game_env *env, int player, double *values)
{
    const ll_entity *own = &world->entity[player];
    double front = 0, top = 0, squares = 0;
    int count = world->entities - world->players;
    (void)env;
    for (int k = world->players; k < world->entities; k++) {
        const ll_entity *e = &world->entity[k];
        front = e->x > front ? e->x : front;
        top = e->y > top ? e->y : top;
        squares += e->vx * e->vx + e->vy * e->vy;
    }
    LL_GAME_TELL(values, VALUES);
}

static ll_game_scene scene(const ll_game_env *env, int players)
{
    const dam_params *p = params_of(env);
    (void)players;
    return (ll_game_scene){.x_max = p->width, .y_max = p->height, .entity_length_m = 2 * p->radius};
}

static bool shape(const ll_game_env *env, int players, int index, ll_game_shape *shape)
{
    const dam_params *p = params_of(env);
    double spacing = p->side / (double)p->across;
    if (index >= players + p->across * p->across)
        return false;
    *shape = index < players ? (ll_game_shape){"player", 2 * p->radius, 2 * p->radius, true, 0, 0}
                             : (ll_game_shape){"water", spacing, spacing, true, 0, 0};
    return true;
}

const ll_game ll_game_dam = {
    .name = "dam",
    .help = "A column of water collapses in a tank, and players move paddles through it.",
    .params = &ll_dam_table,
    .metrics = &ll_dam_metrics,
    LL_GAME_FUNCTIONS,
    .drive = drive,
    .shape = shape,
};
