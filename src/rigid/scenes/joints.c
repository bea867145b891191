/* Joints under load: chains, bridges, grids. */
#include "rigid/scenes/build.h"

#include "rigid/scenes/all.h"

static void chain_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, 6 * a->size + 32, 8, 12 * a->size + 32);
}

/* Links of 1 m to the right of the origin, jointed to it and to each other; `stretch`: factor of their
 * distance. */
static ll_body_id hang_chain(ll_builder *b, int64_t links, double stretch)
{
    ll_body_id before = ll_build_body(b, LL_BODY_STATIC, 0, 0, 0);
    for (int64_t i = 0; i < links; i++) {
        double x = stretch * (double)i;
        ll_body_id link = ll_build_capsule(b, x, 0, x + 1, 0, 0.125);
        ll_joint_def def = ll_joint_defaults(b->world, LL_JOINT_REVOLUTE, before, link, ll_vec(x, 0));
        def.anchor_a = i == 0 ? ll_vec(0, 0) : ll_vec(0.5, 0);
        ll_build_joint(b, &def);
        before = link;
    }
    return before;
}

static ll_status ball_chain(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    b.material.mask = 0;
    b.material.density = 20; /* 6 kg */
    ll_body_id last = hang_chain(&b, a->size, 1);
    double radius = 4, link = 20 * (0.25 + 3.14159265358979 * 0.125 * 0.125);
    b.material.density = a->ratio * link / (3.14159265358979 * radius * radius);
    ll_body_id ball = ll_build_circle(&b, radius, (double)a->size + radius, 0);
    ll_build_revolute(&b, last, ball, (double)a->size, 0);
    return b.status;
}

const ll_scene ll_scene_ball_chain = {
    .name = "ball_chain",
    .title = "Ball and chain",
    .help = "A ball of ratio times a link's mass on a chain of size links (solver2d, Box2D).",
    .default_value = {.size = 40, .ratio = 670, .friction = 0.6},
    .limits = chain_limits,
    .build = ball_chain};

static ll_status stretched_chain(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    b.material.mask = 0;
    hang_chain(&b, a->size, a->ratio);
    return b.status;
}

const ll_scene ll_scene_stretched_chain = {
    .name = "stretched_chain",
    .title = "Stretched chain",
    .help = "size links placed ratio times as far apart as their joints allow (solver2d).",
    .default_value = {.size = 40, .ratio = 2, .friction = 0.6},
    .limits = chain_limits,
    .build = stretched_chain};

static void grid_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size * a->size + 4, 4, 2 * a->size * a->size);
    l->hulls = 0;
}

/* A cloth of balls, held at the middle of its upper row. */
static ll_status joint_grid(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    b.material.category = 2;
    b.material.mask = ~UINT32_C(2);
    int64_t n = a->size;
    int32_t first = ll_rigid_body_end(w);
    for (int64_t k = 0; k < n; k++)
        for (int64_t i = 0; i < n; i++) {
            bool held = i == 0 && k >= n / 2 - 3 && k <= n / 2 + 3;
            ll_body_id body =
                ll_build_body(&b, held ? LL_BODY_STATIC : LL_BODY_DYNAMIC, (double)k, -(double)i, 0);
            ll_build_circle_on(&b, body, 0.4, 0, 0);
            if (ll_failed(&b.status))
                return b.status;
            int32_t self = first + (int32_t)(k * n + i);
            if (i > 0)
                ll_build_revolute(&b, ll_rigid_body_at(w, self - 1), body, (double)k, -(double)i + 0.5);
            if (k > 0)
                ll_build_revolute(&b, ll_rigid_body_at(w, self - (int32_t)n), body, (double)k - 0.5,
                                  -(double)i);
        }
    return b.status;
}

const ll_scene ll_scene_joint_grid = {
    .name = "joint_grid",
    .title = "Grid of joints",
    .help = "size x size balls, jointed to their neighbours (Box2D joint_grid: 100).",
    .default_value = {.size = 100, .friction = 0.6},
    .limits = grid_limits,
    .build = joint_grid};

static ll_status bridge(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    b.material.density = 20;
    double left = -0.5 * (double)a->size;
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0), before = ground;
    for (int64_t i = 0; i < a->size; i++) {
        double x = left + (double)i;
        ll_body_id plank = ll_build_box(&b, 1, 0.25, x + 0.5, 0, 0);
        ll_build_revolute(&b, before, plank, x, 0);
        before = plank;
    }
    ll_build_revolute(&b, before, ground, -left, 0);
    for (int i = 0; i < 3; i++)
        ll_build_box(&b, 1, 1, -8 + 8.0 * i, 3, 0.2 * i);
    return b.status;
}

const ll_scene ll_scene_bridge = {
    .name = "bridge",
    .title = "Bridge",
    .help = "size planks jointed into a suspension bridge, and three boxes on it (Box2D: 160).",
    .default_value = {.size = 160, .friction = 0.6},
    .limits = chain_limits,
    .build = bridge};

static ll_status cantilever(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_body_id before = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    b.material.density = 20;
    b.material.mask = 0;
    for (int64_t i = 0; i < a->size; i++) {
        ll_body_id part = ll_build_capsule(&b, (double)i, 0, (double)i + 1, 0, 0.125);
        ll_joint_def def = ll_joint_defaults(w, LL_JOINT_WELD, before, part, ll_vec((double)i, 0));
        ll_build_joint(&b, &def);
        before = part;
    }
    return b.status;
}

const ll_scene ll_scene_cantilever = {.name = "cantilever",
                                      .title = "Cantilever",
                                      .help =
                                          "size parts welded into a beam that is fixed at one end (Box2D).",
                                      .default_value = {.size = 8, .friction = 0.6},
                                      .limits = chain_limits,
                                      .build = cantilever};

/* Crossed bars with revolute joints at their middles and ends; the lower ones stand on a revolute and a
 * prismatic joint. */
static ll_status scissor_lift(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_body_id base = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0), left = base, right = base;
    b.material.mask = 0;
    double rise = 1;
    for (int64_t i = 0; i < a->size; i++) {
        double y = rise * (double)i;
        ll_body_id up = ll_build_capsule(&b, -2.5, y, 2.5, y + rise, 0.15);
        ll_body_id down = ll_build_capsule(&b, 2.5, y, -2.5, y + rise, 0.15);
        ll_build_revolute(&b, up, down, 0, y + 0.5 * rise);
        if (i == 0) {
            ll_build_revolute(&b, base, up, -2.5, 0);
            ll_joint_def slide = ll_joint_defaults(w, LL_JOINT_DISTANCE, base, down, ll_vec(2.5, 0));
            slide.anchor_a = ll_vec(2.5, -50); /* a long rod: almost level */
            slide.length = 50;
            ll_build_joint(&b, &slide);
            ll_joint_def rod = ll_joint_defaults(w, LL_JOINT_DISTANCE, up, down, ll_vec(0, 0));
            rod.anchor_a = ll_vec(-2.5, -0.5 * rise);
            rod.anchor_b = ll_vec(2.5, -0.5 * rise);
            rod.length = 5;
            ll_build_joint(&b, &rod);
        } else {
            ll_build_revolute(&b, left, up, -2.5, y);
            ll_build_revolute(&b, right, down, 2.5, y);
        }
        left = down;
        right = up;
    }
    return b.status;
}

const ll_scene ll_scene_scissor_lift = {.name = "scissor_lift",
                                        .title = "Scissor lift",
                                        .help = "size pairs of crossed bars: closed loops of joints (Box2D).",
                                        .default_value = {.size = 3, .friction = 0.6},
                                        .limits = chain_limits,
                                        .build = scissor_lift};

static void ccd_mass_ratio(const ll_scene_args *a, ll_rigid_params *p)
{
    (void)a;
    p->gravity_y = -22;
}

static ll_status cart(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    b.material.density = a->ratio;
    ll_body_id top = ll_build_box(&b, 4, 2, 0, 2.2, 0);
    b.material.density = 1;
    for (int k = -1; k <= 1; k += 2) {
        ll_body_id wheel = ll_build_circle(&b, 0.6, 1.5 * k, 0.6);
        ll_joint_def def = ll_joint_defaults(w, LL_JOINT_REVOLUTE, top, wheel, ll_vec(1.5 * k, 0.6));
        def.motored = 1;
        def.motor_speed = -a->speed;
        def.max_torque = 1e4;
        ll_build_joint(&b, &def);
    }
    return b.status;
}

const ll_scene ll_scene_cart = {
    .name = "cart",
    .title = "Cart",
    .help = "A load of ratio times the density of its two driven wheels, at 2.2 g (Box2D).",
    .default_value = {.size = 1, .ratio = 20, .speed = 2, .friction = 0.9},
    .limits = chain_limits,
    .params = ccd_mass_ratio,
    .build = cart};

/* Two opposed prismatic joints on one bar, driven against each other. */
static ll_status unstable_prismatic(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_body_id centre = ll_build_circle(&b, 0.5, 0, 2);
    ll_build_revolute(&b, ground, centre, 0, 2);
    for (int k = -1; k <= 1; k += 2) {
        ll_body_id arm = ll_build_box(&b, 4, 0.4, 3.0 * k, 2, 0);
        ll_joint_def def = ll_joint_defaults(w, LL_JOINT_PRISMATIC, centre, arm, ll_vec(0.6 * k, 2));
        def.axis = ll_vec(k, 0);
        def.limited = 1;
        def.lower = -0.2;
        def.upper = 1;
        ll_build_joint(&b, &def);
    }
    return b.status;
}

const ll_scene ll_scene_unstable_prismatic = {
    .name = "unstable_prismatic",
    .title = "Unstable prismatic",
    .help = "Two prismatic joints on one revolute joint with limits: an open issue of Box2D.",
    .default_value = {.size = 1, .friction = 0.6},
    .limits = chain_limits,
    .build = unstable_prismatic};

static ll_status windmill(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_body_id ground = ll_build_ground(&b, 50);
    ll_body_id cross = ll_build_body(&b, LL_BODY_DYNAMIC, 0, 8, 0);
    ll_build_box_on(&b, cross, 12, 0.4, 0, 0, 0);
    ll_build_box_on(&b, cross, 0.4, 12, 0, 0, 0);
    ll_joint_def def = ll_joint_defaults(w, LL_JOINT_REVOLUTE, ground, cross, ll_vec(0, 8));
    def.motored = 1;
    def.motor_speed = a->speed;
    def.max_torque = 1e6;
    ll_build_joint(&b, &def);
    for (int i = 0; i < 20; i++)
        ll_build_box(&b, 0.6, 0.6, -3 + 0.7 * (i % 8), 15 + 0.8 * (i / 8), 0);
    return b.status;
}

const ll_scene ll_scene_windmill = {
    .name = "windmill",
    .title = "Windmill",
    .help = "A motor of speed rad/s and unlimited torque, and boxes in its way (Box2D).",
    .default_value = {.size = 1, .speed = 2, .friction = 0.6},
    .limits = chain_limits,
    .build = windmill};
