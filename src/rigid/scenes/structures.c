/* Structures that stand by friction: cards, an arch, dominoes, ramps. */
#include "rigid/scenes/build.h"

#include "base/detmath.h"
#include "rigid/scenes/all.h"

static const double degree = 3.14159265358979323846 / 180;

static void some_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, 8 * a->size + 128, 8, 0);
}

static ll_status card_house(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 40);
    const double length = 0.4, thick = 0.002, lean = 25 * degree;
    double half = 0.5 * length * ll_cos(lean), foot = 0.5 * length * ll_sin(lean);
    double y = 0;
    for (int64_t level = 0; level < a->size; level++) {
        int64_t pairs = a->size - level;
        double x0 = -2 * foot * (double)(pairs - 1);
        for (int64_t k = 0; k < pairs; k++) { /* the feet are 4 * foot apart */
            double x = x0 + 4 * foot * (double)k;
            double rise = half + 0.5 * thick * ll_sin(lean);
            ll_build_box(&b, thick, length, x - foot - 0.5 * thick * ll_cos(lean), y + rise, -lean);
            ll_build_box(&b, thick, length, x + foot + 0.5 * thick * ll_cos(lean), y + rise, lean);
        }
        y += 2 * half + thick * ll_sin(lean);
        for (int64_t k = 0; k + 1 < pairs; k++)
            ll_build_box(&b, length, thick, x0 + 4 * foot * ((double)k + 0.5), y + 0.5 * thick, 0);
        y += thick;
    }
    return b.status;
}

const ll_scene ll_scene_card_house = {
    .name = "card_house",
    .title = "House of cards",
    .help = "size levels of cards of 40 cm and 2 mm that lean by 25 degrees (Box2D, Rapier).",
    .default_value = {.size = 5, .friction = 0.7},
    .limits = some_limits,
    .build = card_house};

/* Stones between an inner and an outer half ellipse, cut by rays; four blocks lie on top. */
static ll_status arch(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    const int stones = 17;
    ll_vec2 inner[18], outer[18];
    for (int i = 0; i <= stones; i++) {
        double angle = 180 * degree * i / stones;
        inner[i] = ll_vec(12 * ll_cos(angle), 18 * ll_sin(angle));
        outer[i] = ll_vec(16 * ll_cos(angle), 22.5 * ll_sin(angle));
    }
    inner[0].y = outer[0].y = inner[stones].y = outer[stones].y = 0;
    for (int i = 0; i < stones; i++) {
        ll_vec2 stone[4] = {inner[i], outer[i], outer[i + 1], inner[i + 1]};
        ll_body_id body = ll_build_body(&b, LL_BODY_DYNAMIC, 0, 0, 0);
        ll_build_polygon_on(&b, body, stone, 4);
    }
    double top = outer[stones / 2].y;
    for (int i = 0; i < 4; i++)
        ll_build_box(&b, 4, 1, 0, top + 0.5 + i, 0);
    return b.status;
}

const ll_scene ll_scene_arch = {.name = "arch",
                                .title = "Arch",
                                .help = "17 stones without mortar and four blocks on the keystone (Box2D).",
                                .default_value = {.size = 1, .friction = 0.6},
                                .limits = some_limits,
                                .build = arch};

static ll_status domino(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    ll_body_id first = {0, 0};
    for (int64_t i = 0; i < a->size; i++) {
        ll_body_id body = ll_build_box(&b, 0.25, 1, (double)i - 0.5 * (double)a->size, 0.5, 0);
        if (i == 0)
            first = body;
    }
    if (!ll_failed(&b.status))
        b.status = ll_rigid_apply_impulse(w, first, ll_vec(0.2, 0), ll_vec(-0.5 * (double)a->size, 1));
    return b.status;
}

const ll_scene ll_scene_domino = {.name = "domino",
                                  .title = "Dominoes",
                                  .help = "size dominoes 1 m apart, and a push (Box2D double domino).",
                                  .default_value = {.size = 15, .friction = 0.6},
                                  .limits = some_limits,
                                  .build = domino};

static ll_status ramps(ll_rigid *w, const ll_scene_args *a)
{
    (void)a;
    ll_builder b = ll_build(w, 0.2);
    ll_build_ground(&b, 60);
    ll_body_id steep = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_build_segment_on(&b, steep, -24, 26, 2, 19.5); /* 14 degrees */
    ll_build_segment_on(&b, steep, 17.5, 14, -8.5, 7.5);
    const double friction[5] = {0.75, 0.5, 0.35, 0.1, 0};
    for (int i = 0; i < 5; i++) {
        b.material.friction = friction[i];
        ll_build_box(&b, 1, 1, -20 + 3.0 * i, 27, -0.25);
    }
    return b.status;
}

const ll_scene ll_scene_ramps = {.name = "ramps",
                                 .title = "Friction ramps",
                                 .help = "Boxes of friction 0.75, 0.5, 0.35, 0.1 and 0 on ramps (Box2D).",
                                 .default_value = {.size = 1, .friction = 0.2},
                                 .limits = some_limits,
                                 .build = ramps};

/* ---- the paper ---- */

/* Profile of a rugged wall: teeth of repeatable random size. */
static double rough(int64_t i)
{
    uint64_t h = (uint64_t)(i + 1) * UINT64_C(0x9e3779b97f4a7c15);
    return (double)(h >> 40) / (double)(1 << 24);
}

static ll_status rugged_wall(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_vec2 points[64];
    ll_build_ground(&b, 60);
    int count = (int)(a->size < 60 ? a->size : 60);
    for (int i = 0; i < count; i++) /* upwards: solid on the right, from outside */
        points[i] = ll_vec(4 - 2 * rough(i), 0.5 * i - 0.5);
    ll_body_id wall = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    for (int i = 0; i + 1 < count; i++) { /* each tooth is solid up to the wall's back */
        ll_vec2 piece[4] = {points[i], {6, points[i].y}, {6, points[i + 1].y}, points[i + 1]};
        ll_build_polygon_on(&b, wall, piece, 4);
    }
    b.material.restitution = 0.3;
    for (int i = 0; i < 12; i++) {
        b.body.velocity = ll_vec(a->speed, 0);
        b.body.angular_velocity = i % 2 == 0 ? 3 : -3;
        if (i % 3 == 0)
            ll_build_circle(&b, 0.25, -4 - 0.5 * i, 1 + 0.9 * i);
        else
            ll_build_box(&b, 0.8, 0.3, -4 - 0.5 * i, 1 + 0.9 * i, 0.3 * i);
    }
    return b.status;
}

const ll_scene ll_scene_rugged_wall = {
    .name = "rugged_wall",
    .title = "Rugged wall",
    .help = "The paper's rugged wall of size teeth, and bodies thrown at it with speed m/s: exact, or with "
            "bounding volumes (parameter bounding_volume).",
    .default_value = {.size = 30, .speed = 15, .friction = 0.4},
    .limits = some_limits,
    .build = rugged_wall};

static void beginner(const ll_scene_args *a, ll_rigid_params *p)
{
    (void)a;
    p->solver = LL_SOLVER_IMPULSE;
}

static ll_status collapsing_stack(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    for (int64_t i = 0; i < a->size; i++)
        ll_build_box(&b, 1, 1, 0, (double)i + 0.5, 0);
    return b.status;
}

const ll_scene ll_scene_collapsing_stack = {
    .name = "collapsing_stack",
    .title = "Collapsing stack",
    .help = "The paper's stack of size blocks. With the solver impulse its own contacts make it collapse; "
            "with the others it stands.",
    .default_value = {.size = 10, .friction = 0.6},
    .limits = some_limits,
    .params = beginner,
    .build = collapsing_stack};

static ll_status figure_5(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    b.body.angular_velocity = a->speed;
    ll_build_box(&b, 3, 1, -2.5, 0, 30 * degree);
    b.body.angular_velocity = -a->speed;
    ll_build_box(&b, 3, 1, 2.5, 0, -50 * degree);
    return b.status;
}

static void weightless(const ll_scene_args *a, ll_rigid_params *p)
{
    (void)a;
    p->gravity_x = p->gravity_y = 0;
}

const ll_scene ll_scene_figure_5 = {
    .name = "figure_5",
    .title = "Figure 5: bounding volumes",
    .help = "Two rectangles that rotate at speed rad/s, and the AABB, sphere and OBB around them.",
    .default_value = {.size = 1, .speed = 0.5, .friction = 0.6},
    .limits = some_limits,
    .params = weightless,
    .build = figure_5};
