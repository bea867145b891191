/* Piles: columns, pyramids, and light things under heavy ones. */
#include "rigid/scenes/build.h"

#include "rigid/scenes/all.h"

static const double side = 1; /* m, of a box */

/* ---- column ---- */

static void column_limits(const ll_scene_args *a, ll_rigid_limits *l)
{
    ll_build_limits(l, a->size + 1, 8, 0);
}

static ll_status column(ll_rigid *w, const ll_scene_args *a)
{
    ll_builder b = ll_build(w, a->friction);
    ll_build_ground(&b, 100);
    double lift = a->offset != 0 ? 0.1 : 0;
    for (int64_t i = 0; i < a->size; i++) {
        b.material.density = i == a->size - 1 ? a->ratio : 1;
        ll_build_box(&b, side, side, i % 2 == 0 ? a->offset : -a->offset, side * ((double)i + 0.5) + lift, 0);
    }
    return b.status;
}

const ll_scene ll_scene_column = {
    .name = "column",
    .title = "Column",
    .help =
        "size boxes of 1 m, one on the other; the topmost ratio times as heavy. With an offset (m) they are "
        "set to the left and right in turns and dropped from 10 cm (Box2D vertical stack; Rapier's tall "
        "column has 80).",
    .standard = {.size = 20, .ratio = 1, .friction = 0.6},
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
                                   .standard = {.size = 20, .friction = 0.6},
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
    .standard = {.size = 400, .friction = 0.6},
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
    .help = "Boxes of 5 cm, size in the lowest row: contacts' tolerances are a tenth of a box (Box2D).",
    .standard = {.size = 30, .friction = 0.6},
    .limits = pyramid_limits,
    .build = tiny_pyramid};

/* ---- light under heavy ---- */

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
                                        .standard = {.ratio = 400, .offset = 0, .friction = 0.6},
                                        .limits = few_limits,
                                        .build = heavy_on_two};

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
                             size * ((double)i + 0.5) + (top ? 2 : 0), 0);
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
                                      .standard = {.size = 10, .ratio = 100, .friction = 0.6},
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
                                           .standard = {.size = 6, .friction = 0.6},
                                           .limits = few_limits,
                                           .build = inverse_pyramid};
