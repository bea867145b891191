/* Piles: columns, pyramids, and light bodies under heavy ones. */
#include "rigid/scenes/build.h"

#include "rigid/scenes/all.h"

static const double side = 1; /* m, of a box */

/* ---- column ---- */

static void column_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size + 1, 8, 0);
}

static double column_fall(const ll_scene_args *a)
{
    return a->offset != 0 ? 0.1 : 0;
}

static ll_status column(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    double lift = column_fall(a);
    for (int64_t i = 0; i < a->size; i++) {
        b.material.density = i == a->size - 1 ? a->ratio : 1;
        ll_build_box(&b, side, side, i % 2 == 0 ? a->offset : -a->offset, side * ((double)i + 0.5) + lift, 0);
    }
    return b.status;
}

const ll_scene ll_scene_column = {
    .name = "column",
    .title = "Column",
    .help = "size boxes of 1 m, one on the other; the topmost ratio times as heavy. With an offset (m) they "
            "are set alternately to the left and right and dropped from 10 cm (Box2D vertical stack; "
            "Rapier's tall column has 80).",
    .default_value = {.size = 20, .ratio = 1, .friction = 0.6},
    .fall = column_fall,
    .limits = column_limits,
    .build = column};

/* ---- pyramid ---- */

static void pyramid_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size * (a->size + 1) / 2 + 1, 4, 0);
}

static void pyramid_at(ll_builder *b, int64_t base, double x, double size)
{
    for (int64_t i = 0; i < base; i++)
        for (int64_t k = i; k < base; k++)
            ll_build_box(b, size, size, x + size * ((double)k - 0.5 * (double)(i + base - 1)) * 1.0,
                         size * ((double)i + 0.5), 0);
}

static ll_status pyramid(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 2 * (double)a->size + 100);
    pyramid_at(&b, a->size, 0, side);
    return b.status;
}

const ll_scene ll_scene_pyramid = {.name = "pyramid",
                                   .title = "Pyramid",
                                   .help = "Boxes of 1 m, size of them in the lowest row: 20, 40 and 100 "
                                           "make 210, 820 and 5,050 (Box2D large_pyramid).",
                                   .default_value = {.size = 20, .friction = 0.6},
                                   .limits = pyramid_limits,
                                   .build = pyramid};

static void many_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size * 55 + 1, 4, 0);
}

static ll_status many_pyramids(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    double pitch = 12;
    ll_build_ground(&b, pitch * (double)a->size);
    for (int64_t i = 0; i < a->size; i++)
        pyramid_at(&b, 10, pitch * ((double)i - 0.5 * (double)(a->size - 1)), side);
    return b.status;
}

const ll_scene ll_scene_many_pyramids = {
    .name = "many_pyramids",
    .title = "Many pyramids",
    .help = "size pyramids of 55 boxes; 400 make 22,000 (Box2D many_pyramids).",
    .default_value = {.size = 400, .friction = 0.6},
    .limits = many_limits,
    .build = many_pyramids};

static ll_status tiny_pyramid(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 10);
    pyramid_at(&b, a->size, 0, 0.05);
    return b.status;
}

const ll_scene ll_scene_tiny_pyramid = {
    .name = "tiny_pyramid",
    .title = "Tiny pyramid",
    .help = "Boxes of 5 cm, size in the lowest row: the contact margin is a tenth of a box (Box2D).",
    .default_value = {.size = 30, .friction = 0.6},
    .limits = pyramid_limits,
    .build = tiny_pyramid};

/* ---- light under heavy ---- */

/* Only the heavy body falls; those below it sag less than it does. */
static double heavy_fall(const ll_scene_args *a)
{
    return a->offset;
}

static void few_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size + 64, 8, 0);
}

static ll_status heavy_on_two(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    double big = sqrt(a->ratio) * side;
    ll_build_box(&b, side, side, -0.45 * big, 0.5 * side, 0);
    ll_build_box(&b, side, side, 0.45 * big, 0.5 * side, 0);
    ll_build_box(&b, big, big, 0, side + 0.5 * big + a->offset, 0);
    return b.status;
}

const ll_scene ll_scene_heavy_on_two = {.name = "heavy_on_two",
                                        .title = "Heavy on two",
                                        .help = "A box of ratio times the mass on two boxes of 1 m, dropped "
                                                "from offset (m) above (Box2D high mass ratio 2).",
                                        .default_value = {.ratio = 400, .offset = 0, .friction = 0.6},
                                        .fall = heavy_fall,
                                        .limits = few_limits,
                                        .build = heavy_on_two};

static double tops_fall(const ll_scene_args *a)
{
    (void)a;
    return 2;
}

static ll_status heavy_tops(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    double size = 2;
    for (int p = 0; p < 3; p++)
        for (int64_t i = 0; i < a->size; i++)
            for (int64_t k = i; k < a->size; k++) {
                bool top = i == a->size - 1;
                b.material.density = top ? (p + 1) * a->ratio : 1;
                ll_build_box(&b, size, size,
                             (p - 1) * 30.0 + size * ((double)k - 0.5 * (double)(i + a->size - 1)),
                             size * ((double)i + 0.5) + (top ? tops_fall(a) : 0), 0);
            }
    return b.status;
}

static void heavy_tops_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, 3 * a->size * (a->size + 1) / 2 + 1, 6, 0);
}

const ll_scene ll_scene_heavy_tops = {.name = "heavy_tops",
                                      .title = "Heavy tops",
                                      .help = "Three pyramids of 2 m boxes, size in the lowest row; tops of "
                                              "1, 2 and 3 times ratio in density fall 2 m "
                                              "(Box2D high mass ratio 1).",
                                      .default_value = {.size = 10, .ratio = 100, .friction = 0.6},
                                      .fall = tops_fall,
                                      .limits = heavy_tops_limits,
                                      .build = heavy_tops};

static ll_status inverse_pyramid(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 200);
    double y = 0, size = 0.5;
    for (int64_t i = 0; i < a->size; i++, size *= 2) {
        ll_build_box(&b, size, size, 0, y + 0.5 * size, 0);
        y += size;
    }
    return b.status;
}

const ll_scene ll_scene_inverse_pyramid = {.name = "inverse_pyramid",
                                           .title = "Inverse pyramid",
                                           .help = "size boxes, each twice as wide as the one below: six "
                                                   "make a mass ratio of 1,024 (Rapier inv_pyramid2).",
                                           .default_value = {.size = 6, .friction = 0.6},
                                           .limits = few_limits,
                                           .build = inverse_pyramid};

static ll_status heavy_on_triangles(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    const ll_vec2 triangle[3] = {{-0.5 * side, 0}, {0.5 * side, 0}, {0, side}};
    double big = sqrt(a->ratio) * side;
    for (int k = -1; k <= 1; k += 2) {
        ll_body_id body = ll_build_body(&b, LL_BODY_DYNAMIC, k * 0.45 * big, 0, 0);
        ll_build_polygon_on(&b, body, triangle, 3);
    }
    ll_build_box(&b, big, big, 0, side + 0.5 * big + a->offset, 0);
    return b.status;
}

const ll_scene ll_scene_heavy_on_triangles = {
    .name = "heavy_on_triangles",
    .title = "Heavy on triangles",
    .help = "A box of ratio times the mass on the tips of two triangles (Box2D high mass ratio 3).",
    .default_value = {.ratio = 400, .friction = 0.6},
    .fall = heavy_fall,
    .limits = few_limits,
    .build = heavy_on_triangles};

/* ---- leaning, overlapping, crowded ---- */

static void square_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size * a->size + 16, 10, 0);
}

static ll_status tilted_stack(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    for (int64_t column_index = 0; column_index < a->size; column_index++)
        for (int64_t row = 0; row < a->size; row++)
            ll_build_box(&b, 0.9, 0.9, 5 * (double)(column_index - a->size / 2) + a->offset * (double)row,
                         0.45 + 0.9 * (double)row, 0);
    return b.status;
}

const ll_scene ll_scene_tilted_stack = {
    .name = "tilted_stack",
    .title = "Tilted stack",
    .help = "size columns of size boxes, each row offset (m) to the right (Box2D).",
    .default_value = {.size = 10, .offset = 0.2, .friction = 0.3},
    .limits = square_limits,
    .build = tilted_stack};

static ll_status overlap(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    double pitch = side * (1 - a->ratio);
    for (int64_t i = 0; i < a->size; i++)
        for (int64_t k = i; k < a->size; k++)
            ll_build_box(&b, side, side, pitch * ((double)k - 0.5 * (double)(i + a->size - 1)),
                         0.5 * side + pitch * (double)i, 0);
    return b.status;
}

const ll_scene ll_scene_overlap = {
    .name = "overlap",
    .title = "Overlap recovery",
    .help = "A pyramid of size rows whose boxes initially overlap by the fraction ratio (Box2D, Rapier).",
    .default_value = {.size = 4, .ratio = 0.25, .friction = 0.6},
    .limits = square_limits,
    .build = overlap};

static void total_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size + 1, a->size, 0);
}

static ll_status total_overlap(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    for (int64_t i = 0; i < a->size; i++)
        ll_build_box(&b, side, side, 0, 2, 0);
    return b.status;
}

const ll_scene ll_scene_total_overlap = {.name = "total_overlap",
                                         .title = "Total overlap",
                                         .help = "size boxes at one position (Rapier debug_total_overlap2).",
                                         .default_value = {.size = 16, .friction = 0.6},
                                         .limits = total_limits,
                                         .build = total_overlap};

static void weightless(const ll_scene_args *a, ll_rigid_params *p)
{
    (void)a;
    p->gravity_x = p->gravity_y = 0;
}

static ll_status confined(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    double half = 0.5 * 0.8 * (double)a->size;
    ll_body_id walls = ll_build_body(&b, LL_BODY_STATIC, 0, 0, 0);
    ll_build_capsule_on(&b, walls, -half - 0.5, -half - 0.5, half + 0.5, -half - 0.5, 0.5);
    ll_build_capsule_on(&b, walls, -half - 0.5, -half - 0.5, -half - 0.5, half + 0.5, 0.5);
    ll_build_capsule_on(&b, walls, half + 0.5, -half - 0.5, half + 0.5, half + 0.5, 0.5);
    ll_build_capsule_on(&b, walls, -half - 0.5, half + 0.5, half + 0.5, half + 0.5, 0.5);
    double pitch = (2 * half - 1) / (double)(a->size - 1);
    for (int64_t i = 0; i < a->size; i++)
        for (int64_t k = 0; k < a->size; k++)
            ll_build_circle(&b, 0.5, -half + 0.5 + pitch * (double)i, -half + 0.5 + pitch * (double)k);
    return b.status;
}

const ll_scene ll_scene_confined = {
    .name = "confined",
    .title = "Confined",
    .help =
        "size x size balls of 1 m in a box that fits four fifths as many per side, without gravity (Box2D).",
    .default_value = {.size = 25, .friction = 0.1},
    .limits = square_limits,
    .params = weightless,
    .build = confined};

/* ---- balls ---- */

static ll_status circle_stack(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    b.material.restitution = 0.8;
    ll_build_ground(&b, 20);
    for (int64_t i = 0; i < a->size; i++) {
        b.material.density = 1 + 4 * (double)i;
        ll_build_circle(&b, 0.25, 0, 0.75 + 0.6 * (double)i);
    }
    return b.status;
}

const ll_scene ll_scene_circle_stack = {
    .name = "circle_stack",
    .title = "Stack of balls",
    .help = "size bouncing balls in a column, each heavier than the one below (Box2D).",
    .default_value = {.size = 10, .friction = 0.6},
    .limits = few_limits,
    .build = circle_stack};

static ll_status warm_start(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 20);
    for (int i = 0; i < 3; i++) {
        b.material.density = i == 2 ? a->ratio : 1;
        ll_build_circle(&b, 0.5, 0, 0.5 + i);
    }
    return b.status;
}

static ll_status warm_start_drive(ll_rigid *w, const ll_scene_args *a, int64_t step)
{
    (void)a;
    return step == 120 ? ll_rigid_remove_body(w, ll_rigid_body_at(w, 3)) : ll_ok();
}

const ll_scene ll_scene_warm_start = {
    .name = "warm_start",
    .title = "Stored energy",
    .help = "Three balls; the topmost, ratio times as dense, is removed after 2 s. How high the others jump "
            "shows the energy that the contacts stored (solver2d warm-start energy).",
    .default_value = {.ratio = 100, .friction = 0.6},
    .limits = few_limits,
    .build = warm_start,
    .drive = warm_start_drive};

static ll_status rush(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    int64_t count = a->size * a->size;
    for (int64_t i = 0; i < count; i++) { /* in a spiral, rotated by the golden angle */
        double r = 10 + 0.6 * sqrt((double)i), c = -0.7373688780783197, s = 0.6754902942615238;
        static const ll_rot one = {1, 0};
        ll_rot q = one;
        for (int64_t k = 0; k < i % 377; k++)
            q = ll_rot_mul(q, (ll_rot){c, s});
        ll_build_circle(&b, 0.5, r * q.c, r * q.s);
    }
    return b.status;
}

/* All are attracted to the centre, proportionally to the distance. */
static ll_status rush_drive(ll_rigid *w, const ll_scene_args *a, int64_t step)
{
    (void)step;
    for (int32_t i = 0; i < ll_rigid_body_end(w); i++) {
        ll_body_state s;
        ll_body_id id = ll_rigid_body_at(w, i);
        ll_status status = ll_rigid_get_body(w, id, &s);
        if (!ll_failed(&status) && s.type == LL_BODY_DYNAMIC)
            status = ll_rigid_apply_force(w, id, ll_scale(-a->speed * s.mass, ll_normalised(s.position)), 0);
        if (ll_failed(&status))
            return status;
    }
    return ll_ok();
}

const ll_scene ll_scene_rush = {.name = "rush",
                                .title = "Rush",
                                .help = "size x size balls attracted to one point by speed m/s^2 (solver2d).",
                                .default_value = {.size = 20, .speed = 20, .friction = 0.1},
                                .limits = square_limits,
                                .params = weightless,
                                .build = rush,
                                .drive = rush_drive};

/* ---- far from the origin ---- */

static ll_status far_pyramid(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    double x = a->offset, y = -0.8 * a->offset;
    ll_body_id ground = ll_build_body(&b, LL_BODY_STATIC, x, y - 1, 0);
    ll_build_box_on(&b, ground, 200, 2, 0, 0, 0);
    for (int64_t i = 0; i < a->size; i++)
        for (int64_t k = i; k < a->size; k++)
            ll_build_box(&b, side, side, x + side * ((double)k - 0.5 * (double)(i + a->size - 1)),
                         y + side * ((double)i + 0.5), 0);
    return b.status;
}

const ll_scene ll_scene_far_pyramid = {.name = "far_pyramid",
                                       .title = "Far pyramid",
                                       .help = "A pyramid of size rows at (offset, -0.8 offset) m: shows the "
                                               "loss of digits there (solver2d, Box2D).",
                                       .default_value = {.size = 10, .offset = 1e5, .friction = 0.6},
                                       .limits = square_limits,
                                       .build = far_pyramid};
