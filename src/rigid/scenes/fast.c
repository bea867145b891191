/* Fast bodies, thin walls and seams: tests of continuous collision detection and ghost vertices. */
#include "rigid/scenes/build.h"

#include "base/detmath.h"
#include "rigid/scenes/all.h"

static void fast_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, 2 * a->size + 256, 8, 8);
}

static void swept(const ll_scene_args *a, ll_rigid_params *p)
{
    (void)a;
    p->continuous = LL_CONTINUOUS_SWEPT;
}

static void swept_and_weightless(const ll_scene_args *a, ll_rigid_params *p)
{
    swept(a, p);
    p->gravity_x = p->gravity_y = 0;
}

/* Each ball has its own wall, and starts farther away than the last by a step's path over their count. */
static ll_status bullets_at(ll_rigid *w, const ll_scene_args *a, ll_body_type wall_type)
{
    ll_builder b = ll_build(w, a->friction);
    double pitch = 1, way = a->speed / 60;
    for (int64_t i = 0; i < a->size; i++) {
        double y = pitch * (double)i;
        b.body.velocity = ll_vec(wall_type == LL_BODY_KINEMATIC ? -a->offset : 0, 0);
        b.material.density = 1000;
        ll_body_id wall = ll_build_body(&b, wall_type, 0, y, 0);
        ll_build_box_on(&b, wall, 0.05, 0.8 * pitch, 0, 0, 0);
        b.body.velocity = ll_vec(a->speed, 0);
        b.material.density = 1;
        ll_build_circle(&b, 0.05, -way * (2 + ((double)i + 0.5) / (double)a->size), y);
    }
    return b.status;
}

static ll_status bullets(ll_rigid *w, const ll_scene_args *a)
{
    return bullets_at(w, a, LL_BODY_STATIC);
}

static ll_status bullets_moving(ll_rigid *w, const ll_scene_args *a)
{
    return bullets_at(w, a, LL_BODY_KINEMATIC);
}

static ll_status bullets_loose(ll_rigid *w, const ll_scene_args *a)
{
    return bullets_at(w, a, LL_BODY_DYNAMIC);
}

#define BULLETS(row, text, how, builder)                                                                     \
    const ll_scene row = {.name = text,                                                                      \
                          .title = "Bullets " how,                                                           \
                          .help = "size balls of r = 5 cm at speed m/s against walls of 5 cm " how           \
                                  ", each at another phase of a step.",                                      \
                          .default_value = {.size = 200, .speed = 100, .offset = 5, .friction = 0},          \
                          .limits = fast_limits,                                                             \
                          .params = swept_and_weightless,                                                    \
                          .build = builder}
BULLETS(ll_scene_bullets, "bullets", "at rest", bullets);
BULLETS(ll_scene_bullets_moving, "bullets_moving", "that approach at offset m/s", bullets_moving);
BULLETS(ll_scene_bullets_loose, "bullets_loose", "that are free to move", bullets_loose);

static ll_status skinny_box(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_build_segment_on(&b, ground, 20, 0, -20, 0);
    ll_build_box_on(&b, ground, 0.2, 2, 0, 1, 0);
    for (int64_t i = 0; i < a->size; i++) {
        b.body.velocity = ll_vec(0, -a->speed);
        b.body.angular_velocity = i % 2 == 0 ? 50 : -50;
        ll_build_box(&b, 4, 0.01, 3 * ((double)i - 0.5 * (double)a->size), 8, 0.3 * (double)i);
    }
    return b.status;
}

const ll_scene ll_scene_skinny_box = {
    .name = "skinny_box",
    .title = "Skinny box",
    .help = "size boxes of 1 cm that rotate at 50 rad/s and fall at speed m/s (Box2D).",
    .default_value = {.size = 4, .speed = 100, .friction = 0.6},
    .limits = fast_limits,
    .params = swept,
    .build = skinny_box};

static ll_status drop(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_build_segment_on(&b, ground, 100, 0, -100, 0);
    b.body.velocity = ll_vec(0, -a->speed);
    for (int64_t i = 0; i < a->size; i++) {
        double x = 2 * ((double)i - 0.5 * (double)a->size), y = 10 + 0.37 * (double)i;
        if (i % 3 == 0)
            ll_build_circle(&b, 0.1, x, y);
        else if (i % 3 == 1)
            ll_build_box(&b, 0.2, 0.2, x, y, 0.1 * (double)i);
        else
            ll_build_capsule(&b, x - 0.2, y, x + 0.2, y, 0.05);
    }
    return b.status;
}

const ll_scene ll_scene_drop = {
    .name = "drop",
    .title = "Drop",
    .help = "size small bodies that fall at speed m/s onto a floor without thickness (Box2D).",
    .default_value = {.size = 30, .speed = 200, .friction = 0.6},
    .limits = fast_limits,
    .params = swept,
    .build = drop};

static ll_status pinball(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    const ll_vec2 table[5] = {{8, 20}, {-8, 20}, {-8, 0}, {0, -2}, {8, 0}};
    b.material.restitution = 1;
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_vec2 inward[5]; /* clockwise: solid from inside */
    for (int i = 0; i < 5; i++)
        inward[i] = table[4 - i];
    ll_build_chain_on(&b, ground, inward, 5, true);
    for (int i = 0; i < 3; i++)
        ll_build_circle_on(&b, ground, 1, -4 + 4.0 * i, 8 + 4.0 * (i % 2));
    b.body.velocity = ll_vec(a->speed, 0.3 * a->speed);
    for (int64_t i = 0; i < a->size; i++)
        ll_build_circle(&b, 0.2, -3 + 0.5 * (double)i, 16);
    return b.status;
}

const ll_scene ll_scene_pinball = {.name = "pinball",
                                   .title = "Pinball",
                                   .help =
                                       "size balls at speed m/s between bumpers of restitution 1 (Box2D).",
                                   .default_value = {.size = 4, .speed = 60, .friction = 0},
                                   .limits = fast_limits,
                                   .params = swept,
                                   .build = pinball};

/* A floor of chain segments, or of adjacent boxes: a body that slides over the seams should not notice
 * them. */
static ll_status ghost_bumps(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, 0);
    ll_vec2 points[64];
    for (int i = 0; i < 64; i++)
        points[i] = ll_vec(32 - i, 0);
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_build_chain_on(&b, ground, points, 64, false);
    b.body.velocity = ll_vec(a->speed, 0);
    ll_build_box(&b, 1, 1, -24, 0.5, 0);
    ll_build_circle(&b, 0.5, -26, 0.5);
    ll_build_capsule(&b, -28.5, 0.25, -28, 0.25, 0.25);
    return b.status;
}

const ll_scene ll_scene_ghost_bumps = {
    .name = "ghost_bumps",
    .title = "Ghost bumps",
    .help = "A box, a ball and a capsule that slide at speed m/s over the seams of a chain "
            "(Box2D chain slide, ghost bumps).",
    .default_value = {.size = 1, .speed = 10, .friction = 0},
    .limits = fast_limits,
    .build = ghost_bumps};

static ll_status wedge(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_build_segment_on(&b, ground, -4, 8, 0, 0);
    ll_build_segment_on(&b, ground, 0, 0, 0, 8);
    b.body.velocity = ll_vec(0, -a->speed);
    b.body.bullet = 1;
    for (int64_t i = 0; i < a->size; i++)
        ll_build_circle(&b, 0.3, -0.6, 6 + 0.7 * (double)i);
    return b.status;
}

const ll_scene ll_scene_wedge = {.name = "wedge",
                                 .title = "Wedge",
                                 .help =
                                     "size bullets driven at speed m/s into a corner that narrows (Box2D).",
                                 .default_value = {.size = 2, .speed = 200, .friction = 0.2},
                                 .limits = fast_limits,
                                 .params = swept,
                                 .build = wedge};

static ll_status pixel_imperfect(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, 0);
    double pixel = 1.0 / 30;
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_build_box_on(&b, ground, 20, 8, 0, -4, 0);
    ll_build_box_on(&b, ground, 1, 4, -5, 2, 0);
    ll_build_box_on(&b, ground, 1, 4, -5 + 1 + 2 * (0.5 + pixel), 2, 0); /* a shaft with two pixels of play */
    b.body.velocity = ll_vec(0, -a->speed);
    b.body.fixed_rotation = 1;
    ll_build_box(&b, 1, 1, -5 + 0.5 + 0.5 + pixel, 6, 0);
    return b.status;
}

const ll_scene ll_scene_pixel_imperfect = {
    .name = "pixel_imperfect",
    .title = "Pixel imperfect",
    .help = "A box that falls at speed m/s into a shaft with a pixel of play (Box2D).",
    .default_value = {.size = 1, .speed = 10, .friction = 0},
    .limits = fast_limits,
    .params = swept,
    .build = pixel_imperfect};

static ll_status sliver(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 20);
    const ll_vec2 thin[3] = {{-1, 0}, {1, 0.02}, {-1, 0.02}};
    for (int64_t i = 0; i < a->size; i++) {
        ll_body_id body =
            ll_build_body(&b, LL_BODY_DYNAMIC, 0.5 * (double)(i % 3), 1 + 0.3 * (double)i, 0.4 * (double)i);
        ll_build_polygon_on(&b, body, thin, 3);
    }
    return b.status;
}

const ll_scene ll_scene_sliver = {.name = "sliver",
                                  .title = "Slivers",
                                  .help = "size triangles of 2 m and 2 cm that fall on each other (Box2D).",
                                  .default_value = {.size = 12, .friction = 0.6},
                                  .limits = fast_limits,
                                  .params = swept,
                                  .build = sliver};
