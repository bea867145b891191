/* Benchmarks of Box2D, other than the pyramids and the grid of joints. */
#include "rigid/scenes/build.h"

#include "base/detmath.h"
#include "rigid/scenes/all.h"

static const double pi = 3.14159265358979323846;

/* ---- smash ---- */

static void smash_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, 3 * a->size * a->size / 2 + 16, 8, 0);
}

static void weightless(const ll_scene_args *a, ll_rigid_params *p)
{
    (void)a;
    p->gravity_x = p->gravity_y = 0;
}

static ll_status smash(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    b.body.velocity = ll_vec(a->speed, 0);
    b.material.density = 8;
    ll_build_box(&b, 8, 8, -20, 0, 0);
    b.body.velocity = ll_vec(0, 0);
    b.material.density = 1;
    double side = 0.4;
    int64_t columns = 3 * a->size / 2, rows = a->size;
    for (int64_t i = 0; i < columns; i++)
        for (int64_t k = 0; k < rows; k++)
            ll_build_box(&b, side, side, 30 + side * (double)i, side * ((double)k - 0.5 * (double)rows), 0);
    return b.status;
}

const ll_scene ll_scene_smash = {
    .name = "smash",
    .title = "Smash",
    .help = "A block of 8 m hits 1.5 size x size boxes of 40 cm at `speed` m/s, without gravity (Box2D).",
    .default_value = {.size = 80, .speed = 40, .friction = 0.6},
    .limits = smash_limits,
    .params = weightless,
    .build = smash};

/* ---- drums ---- */

static void drum_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size * a->size + 512, 10, 4);
}

static ll_status tumbler(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_body_id drum = ll_build_body(&b, LL_BODY_DYNAMIC, 0, 10, 0);
    b.material.density = 50;
    ll_build_box_on(&b, drum, 1, 20, 10, 0, 0);
    ll_build_box_on(&b, drum, 1, 20, -10, 0, 0);
    ll_build_box_on(&b, drum, 20, 1, 0, 10, 0);
    ll_build_box_on(&b, drum, 20, 1, 0, -10, 0);
    b.material.density = 1;
    ll_joint_def motor = ll_joint_defaults(w, LL_JOINT_REVOLUTE, ground, drum, ll_vec(0, 10));
    motor.motored = 1;
    motor.motor_speed = a->speed;
    motor.max_torque = 1e8;
    ll_build_joint(&b, &motor);
    double pitch = 0.4;
    for (int64_t i = 0; i < a->size; i++)
        for (int64_t k = 0; k < a->size; k++)
            ll_build_box(&b, 0.25, 0.25, pitch * ((double)k - 0.5 * (double)a->size),
                         10 + pitch * ((double)i - 0.5 * (double)a->size), 0);
    return b.status;
}

const ll_scene ll_scene_tumbler = {
    .name = "tumbler",
    .title = "Tumbler",
    .help = "size x size boxes in a square drum that a motor rotates at `speed` rad/s (Box2D: 45).",
    .default_value = {.size = 45, .speed = 0.436, .friction = 0.6},
    .limits = drum_limits,
    .build = tumbler};

static void ring_piece(ll_builder *b, ll_body_id body, double inner, double outer, double t0, double t1)
{
    const ll_vec2 corners[4] = {{inner * ll_cos(t0), inner * ll_sin(t0)},
                                {outer * ll_cos(t0), outer * ll_sin(t0)},
                                {outer * ll_cos(t1), outer * ll_sin(t1)},
                                {inner * ll_cos(t1), inner * ll_sin(t1)}};
    ll_build_polygon_on(b, body, corners, 4);
}

static ll_status washer(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    b.body.angular_velocity = a->speed;
    ll_body_id drum = ll_build_body(&b, LL_BODY_KINEMATIC, 0, 10, 0);
    b.body.angular_velocity = 0;
    const int walls = 36;
    double lap = pi / 180; /* overlap of the walls */
    for (int i = 0; i < walls; i++) {
        double t0 = 2 * pi * i / walls, t1 = 2 * pi * (i + 1) / walls;
        ring_piece(&b, drum, 16, 18, t0 - lap, t1 + lap);
        if (i % 9 == 0)
            ring_piece(&b, drum, 14, 16, t0, t1);
    }
    double pitch = 18.9 / (double)a->size, side = pitch / 1.05, corner = 0.55 * side * (double)a->size;
    for (int64_t i = 0; i < a->size; i++)
        for (int64_t k = 0; k < a->size; k++)
            ll_build_box(&b, side, side, pitch * (double)k - corner, 10 + pitch * (double)i - corner, 0);
    return b.status;
}

const ll_scene ll_scene_washer = {
    .name = "washer",
    .title = "Washer",
    .help = "size x size boxes in a round drum with blades that rotates at `speed` rad/s (Box2D: 90).",
    .default_value = {.size = 90, .speed = 0.436, .friction = 0.6},
    .limits = drum_limits,
    .build = washer};

/* ---- spinner ---- */

static ll_status spinner(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, 0.1);
    const int links = 360;
    ll_vec2 ring[360];
    for (int i = 0; i < links; i++) { /* clockwise: solid from inside */
        double t = -2 * pi * i / links;
        ring[i] = ll_vec(40 * ll_cos(t), 32 + 40 * ll_sin(t));
    }
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_build_chain_on(&b, ground, ring, links, true);
    b.material.friction = 0;
    ll_body_id rod = ll_build_body(&b, LL_BODY_DYNAMIC, 0, 12, 0);
    ll_build_box_on(&b, rod, 1.2, 40.4, 0, 0, 0);
    ll_joint_def motor = ll_joint_defaults(w, LL_JOINT_REVOLUTE, ground, rod, ll_vec(0, 12));
    motor.motored = 1;
    motor.motor_speed = a->speed;
    motor.max_torque = 1e15;
    ll_build_joint(&b, &motor);
    b.material = ll_material_defaults();
    b.material.density = 0.25;
    b.material.friction = 0.1;
    b.material.restitution = 0.1;
    double x = -23, y = 2;
    for (int64_t i = 0; i < a->size; i++) {
        if (i % 3 == 0)
            ll_build_capsule(&b, x - 0.25, y, x + 0.25, y, 0.25);
        else if (i % 3 == 1)
            ll_build_circle(&b, 0.35, x, y);
        else
            ll_build_box(&b, 0.7, 0.7, x, y, 0);
        x += 0.5;
        if (x >= 23) {
            x = -23;
            y += 0.5;
        }
    }
    return b.status;
}

static void swept(const ll_scene_args *a, ll_rigid_params *p)
{
    (void)a;
    p->continuous = LL_CONTINUOUS_SWEPT;
}

static void spinner_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size + 512, 12, 4);
}

const ll_scene ll_scene_spinner = {.name = "spinner",
                                   .title = "Spinner",
                                   .help = "size capsules, balls and boxes in a ring, initially overlapping, "
                                           "stirred by a rod of 40 m (Box2D: 6,076).",
                                   .default_value = {.size = 6076, .speed = 5, .friction = 0.1},
                                   .limits = spinner_limits,
                                   .params = swept,
                                   .build = spinner};

/* ---- junkyard and compounds ---- */

static ll_status junkyard(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    double half = 0.45 * (double)a->size;
    ll_body_id ground = ll_build_ground(&b, half + 10);
    ll_build_box_on(&b, ground, 2, 60, -half - 2, 30, 0);
    ll_build_box_on(&b, ground, 2, 60, half + 2, 30, 0);
    ll_vec2 five[5];
    for (int i = 0; i < 5; i++)
        five[i] = ll_vec(0.4 * ll_cos(2 * pi * i / 5), 0.4 * ll_sin(2 * pi * i / 5));
    for (int64_t k = 0; k < a->size; k++)
        for (int64_t i = 0; i < a->size; i++) {
            ll_body_id body =
                ll_build_body(&b, LL_BODY_DYNAMIC, -half + 0.9 * (double)i, 0.5 + 0.9 * (double)k, 0.1);
            ll_build_polygon_on(&b, body, five, 5);
        }
    b.body.velocity = ll_vec(a->speed, 0);
    ll_body_id pusher = ll_build_body(&b, LL_BODY_KINEMATIC, -half, 3, 0);
    ll_build_box_on(&b, pusher, 1, 6, 0, 0, 0);
    return b.status;
}

/* Moves the pusher to and fro. */
static ll_status junkyard_drive(ll_rigid *w, const ll_scene_args *a, int64_t step)
{
    double half = 0.45 * (double)a->size;
    int64_t way = (int64_t)fmax(1, fmin(60 * 2 * half / a->speed, 1e15)); /* steps; any speed is valid */
    if (step == 0 || step % way != 0)
        return ll_ok();
    ll_body_id pusher = ll_rigid_body_at(w, ll_rigid_body_end(w) - 1);
    return ll_rigid_set_velocity(w, pusher, ll_vec(step / way % 2 == 0 ? a->speed : -a->speed, 0), 0);
}

const ll_scene ll_scene_junkyard = {
    .name = "junkyard",
    .title = "Junkyard",
    .help = "size x size pentagons and a pusher of `speed` m/s (Box2D: 8,000 pentagons).",
    .default_value = {.size = 89, .speed = 5, .friction = 0.6},
    .limits = drum_limits,
    .build = junkyard,
    .drive = junkyard_drive};

static void compound_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    int64_t n = a->size * a->size;
    ll_build_limits(l, 2 * n + 16, 8, 0);
}

static ll_status compounds(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 2 * (double)a->size);
    const ll_vec2 left[3] = {{-1, 0}, {0.5, 1}, {0, 2}}, right[3] = {{1, 0}, {-0.5, 1}, {0, 2}};
    for (int64_t k = 0; k < a->size; k++)
        for (int64_t i = 0; i < a->size; i++) {
            ll_body_id body = ll_build_body(&b, LL_BODY_DYNAMIC, 2.2 * ((double)i - 0.5 * (double)a->size),
                                            0.2 + 2.2 * (double)k, 0);
            ll_build_polygon_on(&b, body, left, 3);
            ll_build_polygon_on(&b, body, right, 3);
        }
    return b.status;
}

const ll_scene ll_scene_compounds = {.name = "compounds",
                                     .title = "Compounds",
                                     .help = "size x size bodies of two triangles each (Box2D: 3,000).",
                                     .default_value = {.size = 55, .friction = 0.6},
                                     .limits = compound_limits,
                                     .build = compounds};

/* ---- rain of ragdolls ---- */

enum { doll_parts = 11, steps_between = 8, floor_boxes = 501, storey = 45 };

static ll_body_id limb(ll_builder *b, ll_body_id to, double x0, double y0, double x1, double y1, double r,
                       double lower, double upper)
{
    ll_body_id part = ll_build_capsule(b, x0, y0, x1, y1, r);
    if (to.index == 0)
        return part;
    ll_joint_def def = ll_joint_defaults(b->world, LL_JOINT_REVOLUTE, to, part, ll_vec(x0, y0));
    def.limited = 1;
    def.lower = lower;
    def.upper = upper;
    def.motored = 1; /* friction of the joint */
    def.max_torque = 0.03;
    ll_build_joint(b, &def);
    return part;
}

/* 11 bodies, 10 revolute joints, 1.8 m high; its parts do not collide with each other. */
static void ragdoll(ll_builder *b, double x, double y, int32_t group)
{
    b->material.group = group;
    ll_body_id none = {0, 0};
    ll_body_id hip = limb(b, none, x, y + 0.95, x, y + 1.0, 0.1, 0, 0);
    ll_body_id torso = limb(b, hip, x, y + 1.1, x, y + 1.35, 0.1, -0.8, 0.2);
    limb(b, torso, x, y + 1.5, x, y + 1.6, 0.09, -0.9, 0.3);
    for (int k = -1; k <= 1; k += 2) {
        double side = 0.02 * k;
        ll_body_id thigh = limb(b, hip, x + side, y + 0.9, x + side, y + 0.6, 0.06, -0.15, 1.25);
        limb(b, thigh, x + side, y + 0.5, x + side, y + 0.15, 0.05, -1.5, 0);
        ll_body_id upper = limb(b, torso, x + side, y + 1.35, x + side, y + 1.12, 0.035, -0.3, 2.5);
        limb(b, upper, x + side, y + 1.1, x + side, y + 0.9, 0.03, 0, 1.5);
    }
}

/* Ragdolls are added in groups, one above each floor, column after column. */
typedef struct rainfall {
    int columns, floors, group;
    int pad;
    double pitch, fall; /* m: between columns, above a floor */
} rainfall;

static rainfall rainfall_of(const ll_scene_args *a)
{
    static const rainfall few = {11, 1, 1, 0, 8, 14}, many = {40, 5, 5, 0, 6.25, 40};
    return a->size < 1000 ? few : many;
}

static void rain_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, doll_parts * a->size + 64, 8, doll_parts * a->size);
    if (rainfall_of(a).floors > 1)
        l->shapes = l->hulls = l->shapes + floor_boxes * rainfall_of(a).floors;
}

static ll_status rain(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    rainfall r = rainfall_of(a);
    if (r.floors == 1) {
        ll_body_id ground = ll_build_ground(&b, 60);
        ll_build_box_on(&b, ground, 1, 20, -50, 10, 0);
        ll_build_box_on(&b, ground, 1, 20, 50, 10, 0);
        return b.status;
    }
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    for (int k = 0; k < r.floors; k++)
        for (int i = 0; i < floor_boxes; i++)
            ll_build_box_on(&b, ground, 0.5, 0.5, 0.5 * i - 125, storey * k, 0);
    return b.status;
}

static void shower(ll_builder *b, const rainfall *r, int64_t number)
{
    int column = (int)(number % r->columns);
    for (int k = 0; k < r->floors; k++)
        for (int i = 0; i < r->group; i++) {
            int64_t doll = (number * r->floors + k) * r->group + i;
            double x = r->floors == 1 ? -40 : r->pitch * (0.5 - 0.5 * r->columns);
            double y = r->floors == 1 ? 2 * (double)(number % 3) : storey * k;
            ragdoll(b, x + r->pitch * column + 0.5 * i, r->fall + y, (int32_t)(doll + 1));
        }
}

/* Adds a group every few steps and removes the oldest when all are there. Bodies are added and removed by
 * whole ragdolls, so that the parts of one are neighbours in memory. */
static ll_status rain_drive(ll_rigid *w, const ll_scene_args *a, int64_t step)
{
    if (step % steps_between != 0)
        return ll_ok();
    rainfall r = rainfall_of(a);
    int64_t number = step / steps_between, dolls = r.floors * r.group, showers = a->size / dolls;
    int32_t parts = (int32_t)dolls * doll_parts, first = 1 + (int32_t)(number % showers) * parts;
    if (number >= showers)
        for (int32_t i = parts; i-- > 0;) { /* backwards: the slot freed last is used first */
            LL_TRY(ll_rigid_remove_body(w, ll_rigid_body_at(w, first + i)));
        }
    ll_builder b = ll_build(w, a->friction);
    shower(&b, &r, number);
    return b.status;
}

const ll_scene ll_scene_rain = {
    .name = "rain",
    .title = "Rain of ragdolls",
    .help = "A ragdoll of 11 bodies every 8 steps; beyond size of them, the oldest is removed. From 1,000 "
            "on, 25 at a time, onto five floors of boxes (Box2D: 1,000).",
    .default_value = {.size = 200, .friction = 0.6},
    .limits = rain_limits,
    .build = rain,
    .drive = rain_drive};
