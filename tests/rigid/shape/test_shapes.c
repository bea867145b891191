/* Areas, moments of inertia and boxes of shapes against closed forms; rejected shapes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "base/mix.h"
#include "rigid/shape/bound.h"
#include "rigid/shape/distance.h"
#include "support/near.h"

static const double pi = 3.14159265358979323846;
static const ll_pose home = {{0, 0}, {1, 0}};

static void masses_are_the_textbooks(void **state)
{
    (void)state;
    ll_geometry g;
    assert_int_equal(ll_shape_circle(ll_vec(3, 4), 0.5, &g).code, LL_OK);
    ll_mass m = ll_shape_mass(&g, 2);
    assert_near(m.mass, 2 * pi * 0.25, 1e-14);
    assert_near(m.inertia, 0.5 * m.mass * 0.25, 1e-14);

    assert_int_equal(ll_shape_box(2, 1, ll_vec(1e4, -1e4), 0.7, &g).code, LL_OK);
    m = ll_shape_mass(&g, 3);
    assert_near(m.mass, 6, 1e-10);
    assert_near(m.inertia, 6 * (4 + 1) / 12.0, 1e-10);
    assert_near(m.centre.x, 1e4, 1e-9);

    /* The moment of an equilateral triangle of side s about its centre is m s^2 / 12. */
    ll_vec2 triangle[3] = {{0, 0}, {2, 0}, {1, sqrt(3)}};
    assert_int_equal(ll_shape_polygon(triangle, 3, &g).code, LL_OK);
    m = ll_shape_mass(&g, 1);
    assert_near(m.mass, sqrt(3), 1e-14);
    assert_near(m.inertia, m.mass * 4 / 12, 1e-14);
    assert_near(m.centre.y, sqrt(3) / 3, 1e-15);

    /* A capsule against a sum over thin slices. */
    assert_int_equal(ll_shape_capsule(ll_vec(-1, 0), ll_vec(1, 0), 0.5, &g).code, LL_OK);
    double area = 0, second = 0, step = 1e-5;
    for (double x = -1.5 + step / 2; x < 1.5; x += step) {
        double d = fabs(x) - 1, half = d > 0 ? sqrt(0.25 - d * d) : 0.5;
        area += 2 * half * step;
        second += step * (2 * half * x * x + 2 * half * half * half / 3);
    }
    m = ll_shape_mass(&g, 1);
    assert_near(m.mass, area, 1e-7);
    assert_near(m.inertia, second, 1e-7);
}

static void either_direction_is_one_polygon(void **state)
{
    (void)state;
    ll_vec2 left[4] = {{0, 0}, {2, 0}, {2, 1}, {0, 1}}, right[4] = {{0, 1}, {2, 1}, {2, 0}, {0, 0}};
    ll_geometry a, b;
    assert_int_equal(ll_shape_polygon(left, 4, &a).code, LL_OK);
    assert_int_equal(ll_shape_polygon(right, 4, &b).code, LL_OK);
    assert_memory_equal(&a, &b, sizeof a);
}

static void refused(ll_status status, const char *word)
{
    assert_int_equal(status.code, LL_BAD_INPUT);
    if (strstr(status.text, word) == NULL)
        fail_msg("`%s` does not say `%s`", status.text, word);
}

static void bad_shapes_are_told(void **state)
{
    (void)state;
    ll_geometry g;
    ll_vec2 arrow[4] = {{0, 0}, {2, 0}, {0.5, 0.5}, {0, 2}}, flat[3] = {{0, 0}, {1, 0}, {2, 0}};
    ll_vec2 star[5], twice[4] = {{0, 0}, {1, 0}, {1, 0}, {0, 1}}, many[9] = {{0, 0}};
    for (int i = 0; i < 5; i++)
        star[i] = ll_vec(cos(4 * pi * i / 5), sin(4 * pi * i / 5));
    refused(ll_shape_polygon(arrow, 4, &g), "convex");
    refused(ll_shape_polygon(flat, 3, &g), "degenerate");
    refused(ll_shape_polygon(star, 5, &g), "convex");
    refused(ll_shape_polygon(twice, 4, &g), "closer");
    refused(ll_shape_polygon(many, 9, &g), "3 to 8");
    refused(ll_shape_polygon(many, 2, &g), "3 to 8");
    flat[1].y = NAN;
    refused(ll_shape_polygon(flat, 3, &g), "finite");
    refused(ll_shape_circle(ll_vec(0, INFINITY), 1, &g), "finite");
    refused(ll_shape_circle(ll_vec(0, 0), 0, &g), "radius");
    refused(ll_shape_circle(ll_vec(0, 0), NAN, &g), "radius");
    refused(ll_shape_segment(ll_vec(1, 1), ll_vec(1, 1), &g), "apart");
    refused(ll_shape_box(1, 0, ll_vec(0, 0), 0, &g), "sides");
    refused(ll_shape_box(1, -1, ll_vec(0, 0), 0, &g), "sides");
    refused(ll_shape_box(1, 1, ll_vec(0, 0), NAN, &g), "angle");
}

/* Overestimates of a 3 x 1 rectangle rotated by 30 degrees (the paper's Figure 5). */
static void volumes_overestimate_as_they_must(void **state)
{
    (void)state;
    ll_geometry g;
    assert_int_equal(ll_shape_box(3, 1, ll_vec(0, 0), 0, &g).code, LL_OK);
    double c = cos(pi / 6), s = sin(pi / 6);
    ll_rot q = {c, s};
    assert_near(ll_bound_area(LL_VOLUME_EXACT, &g, q), 3, 1e-14);
    assert_near(ll_bound_area(LL_VOLUME_OBB, &g, q), 3, 1e-14);
    assert_near(ll_bound_area(LL_VOLUME_AABB, &g, q), (3 * c + s) * (3 * s + c), 1e-13);
    assert_near(ll_bound_area(LL_VOLUME_SPHERE, &g, q), pi * 2.5, 1e-13);

    /* The smallest circle of an obtuse triangle is over its longest side; that of an acute one is the
     * circumcircle. */
    ll_vec2 obtuse[3] = {{0, 0}, {4, 0}, {2, 0.5}}, acute[3] = {{0, 0}, {2, 0}, {1, sqrt(3)}};
    assert_int_equal(ll_shape_polygon(obtuse, 3, &g).code, LL_OK);
    assert_near(ll_bound_area(LL_VOLUME_SPHERE, &g, q), 4 * pi, 1e-12);
    assert_int_equal(ll_shape_polygon(acute, 3, &g).code, LL_OK);
    assert_near(ll_bound_area(LL_VOLUME_SPHERE, &g, q), pi * 4 / 3, 1e-12);
    assert_near(ll_bound_area(LL_VOLUME_OBB, &g, q), 2 * sqrt(3), 1e-12);
}

static bool meet(ll_volume volume, const ll_geometry *a, ll_pose pose_a, const ll_geometry *b, ll_pose pose_b)
{
    ll_bound made_a = ll_bound_make(volume, a), made_b = ll_bound_make(volume, b);
    ll_placed_bound at_a, at_b;
    ll_bound_place(volume, &made_a, pose_a, &at_a);
    ll_bound_place(volume, &made_b, pose_b, &at_b);
    return ll_bounds_meet(volume, &at_a, &at_b);
}

/* Over a grid of positions: no bounding volume misses a hit, and each has the false hits of its shape. */
static void volumes_miss_nothing(void **state)
{
    (void)state;
    ll_geometry a, b;
    ll_vec2 triangle[3] = {{-1, -0.5}, {1, -0.5}, {0.3, 0.8}};
    assert_int_equal(ll_shape_box(2, 0.4, ll_vec(0, 0), 0, &a).code, LL_OK);
    assert_int_equal(ll_shape_polygon(triangle, 3, &b).code, LL_OK);
    int hits[LL_VOLUMES] = {0};
    for (int i = 0; i < 2000; i++) {
        double angle = 0.37 * i, x = -2.5 + 5 * fmod(i * 0.6180339887, 1), y = -2.5 + 5 * (i + 0.5) / 2000;
        ll_pose pa = {{0, 0}, {cos(angle), sin(angle)}}, pb = {{x, y}, {cos(2 * angle), sin(2 * angle)}};
        bool exact = meet(LL_VOLUME_EXACT, &a, pa, &b, pb);
        for (int v = 0; v < LL_VOLUMES; v++) {
            bool hit = meet((ll_volume)v, &a, pa, &b, pb);
            hits[v] += hit;
            assert_true(hit || !exact);
        }
    }
    assert_true(hits[LL_VOLUME_EXACT] > 200);
    assert_true(hits[LL_VOLUME_OBB] > hits[LL_VOLUME_EXACT]);
    assert_true(hits[LL_VOLUME_AABB] > hits[LL_VOLUME_OBB]);
    assert_true(hits[LL_VOLUME_SPHERE] > hits[LL_VOLUME_OBB]);
}

static void boxes_enclose_and_extents_reach(void **state)
{
    (void)state;
    ll_geometry g;
    assert_int_equal(ll_shape_capsule(ll_vec(-1, 0), ll_vec(1, 0), 0.25, &g).code, LL_OK);
    ll_aabb box = ll_shape_aabb(&g, (ll_pose){{5, 6}, {0, 1}});
    assert_near(box.lower.x, 4.75, 1e-15);
    assert_near(box.upper.y, 7.25, 1e-15);
    assert_near(ll_shape_extent(&g), 1.25, 0);
    assert_near(ll_shape_core(&g), 0.25, 0);
    assert_int_equal(ll_shape_box(2, 4, ll_vec(0, 0), 0, &g).code, LL_OK);
    assert_near(ll_shape_core(&g), 1, 0);
    assert_near(ll_shape_extent(&g), sqrt(5), 1e-15);
}

/* Any pose of two boxes: the distance is that of the nearest corner to an edge, by brute force. */
static double corner_to_edges(const ll_geometry *a, ll_pose pa, const ll_geometry *b, ll_pose pb)
{
    double least = INFINITY;
    for (int i = 0; i < a->count; i++)
        for (int k = 0; k < b->count; k++) {
            ll_vec2 p = ll_to_world(pa, a->vertex[i]);
            ll_vec2 v = ll_to_world(pb, b->vertex[k]), w = ll_to_world(pb, b->vertex[(k + 1) % b->count]);
            ll_vec2 e = ll_sub(w, v);
            double t = smaller(1, larger(0, ll_dot(ll_sub(p, v), e) / ll_dot(e, e)));
            least = smaller(least, ll_length(ll_sub(p, ll_madd(v, t, e))));
        }
    return least;
}

static void gjk_agrees_with_brute_force(void **state)
{
    (void)state;
    ll_geometry a, b;
    ll_vec2 points[5] = {{-0.6, -0.4}, {0.5, -0.6}, {0.9, 0.1}, {0.2, 0.7}, {-0.7, 0.5}};
    assert_int_equal(ll_shape_box(1, 0.5, ll_vec(0.1, 0), 0, &a).code, LL_OK);
    assert_int_equal(ll_shape_polygon(points, 5, &b).code, LL_OK);
    int apart = 0;
    for (int i = 0; i < 5000; i++) {
        double angle = 0.73 * i, r = 0.2 + 2.5 * fmod(i * 0.6180339887, 1);
        ll_pose pa = {{100, -50}, {cos(angle), sin(angle)}};
        ll_pose pb = {{100 + r * cos(1.7 * i), -50 + r * sin(1.7 * i)}, {cos(3 * angle), sin(3 * angle)}};
        ll_distance_result d = ll_distance(&a, pa, &b, pb);
        assert_true(d.iterations < 12);
        if (d.distance == 0)
            continue;
        apart++;
        assert_near(d.distance, smaller(corner_to_edges(&a, pa, &b, pb), corner_to_edges(&b, pb, &a, pa)),
                    1e-12);
        assert_near(ll_length(ll_sub(d.point_b, d.point_a)), d.distance, 1e-12);
        assert_near(ll_dot(d.normal, ll_sub(d.point_b, d.point_a)), d.distance, 1e-12);
    }
    assert_in_range(apart, 3000, 4900);
}

static void first_touch_is_the_closed_forms(void **state)
{
    (void)state;
    ll_geometry ball, wall, rod;
    assert_int_equal(ll_shape_circle(ll_vec(0, 0), 0.05, &ball).code, LL_OK);
    assert_int_equal(ll_shape_box(0.05, 4, ll_vec(0, 0), 0, &wall).code, LL_OK);
    ll_sweep still = {home, {0, 0}, 0}, fast = {{{-10, 0.3}, {1, 0}}, {100, 0}, 0};
    ll_toi_result touch = ll_time_of_impact(&wall, &still, &ball, &fast, 0.001);
    assert_true(touch.hit);
    assert_near(touch.t, (10 - 0.025 - 0.05 - 0.001) / 100, 0.0001 / 100);

    ll_sweep beside = {{{-10, 3}, {1, 0}}, {100, 0}, 0};
    assert_false(ll_time_of_impact(&wall, &still, &ball, &beside, 0.001).hit);

    /* A wall that approaches. */
    ll_sweep coming = {{{50, 0}, {1, 0}}, {-100, 0}, 0};
    touch = ll_time_of_impact(&wall, &coming, &ball, &fast, 0.001);
    assert_near(touch.t, (60 - 0.025 - 0.05 - 0.001) / 200, 0.0001 / 200);

    /* A rotating rod of half length 1 whose tip hits a segment 0.5 below: at the angle asin 0.5. */
    ll_geometry floor;
    assert_int_equal(ll_shape_segment(ll_vec(5, -0.5), ll_vec(-5, -0.5), &floor).code, LL_OK);
    assert_int_equal(ll_shape_segment(ll_vec(-1, 0), ll_vec(1, 0), &rod).code, LL_OK);
    ll_sweep revolute_limits = {home, {0, 0}, -pi / 2};
    touch = ll_time_of_impact(&floor, &still, &rod, &revolute_limits, 1e-6);
    assert_true(touch.hit);
    assert_near(touch.t, 1.0 / 3, 1e-5);
}

/* The k-th number of draw i, in [0, 1). */
static double share(int i, int k)
{
    return (double)(ll_mix((uint64_t)(16 * i + k + 1) * LL_MIX_STEP) >> 11) * 0x1p-53;
}

static ll_sweep some_sweep(int i, int k)
{
    double angle = 6.3 * share(i, k), far = 0.4 + 1.4 * share(i, k + 1), way = 6.3 * share(i, k + 2);
    ll_sweep sweep = {{{far * cos(way), far * sin(way)}, {cos(angle), sin(angle)}},
                      {2 * share(i, k + 3) - 1, 2 * share(i, k + 4) - 1},
                      share(i, k + 5) < 0.3 ? 0 : 3 * share(i, k + 6) - 1.5};
    return sweep;
}

/* What the bound of a support line says of random motions is true at every sampled time, and leaves the time
 * of impact without a hit. */
static void a_support_line_never_errs(void **state)
{
    (void)state;
    ll_geometry shapes[6];
    ll_vec2 points[5] = {{-0.6, -0.4}, {0.5, -0.6}, {0.9, 0.1}, {0.2, 0.7}, {-0.7, 0.5}};
    assert_int_equal(ll_shape_box(1, 0.5, ll_vec(0.1, 0), 0.3, &shapes[0]).code, LL_OK);
    assert_int_equal(ll_shape_polygon(points, 5, &shapes[1]).code, LL_OK);
    assert_int_equal(ll_shape_capsule(ll_vec(-0.8, 0), ll_vec(0.4, 0), 0.1, &shapes[2]).code, LL_OK);
    assert_int_equal(ll_shape_segment(ll_vec(-1, 0.2), ll_vec(1, -0.1), &shapes[3]).code, LL_OK);
    shapes[4] = shapes[3];
    shapes[4].kind = LL_SHAPE_CHAIN_SEGMENT;
    assert_int_equal(ll_shape_circle(ll_vec(0.2, 0.1), 0.3, &shapes[5]).code, LL_OK);
    int apart = 0, unknown = 0, hits = 0;
    for (int i = 0; i < 20000; i++) {
        const ll_geometry *a = &shapes[i % 5], *b = &shapes[i / 5 % 6];
        double target = i % 7 == 0 ? 0 : 0.00125, margin = target + 0.0005;
        ll_sweep sa = some_sweep(i, 0), sb = some_sweep(i, 7);
        if (i % 2 == 0)
            sa = (ll_sweep){.start = sa.start};
        bool hit = ll_time_of_impact(a, &sa, b, &sb, target).hit;
        hits += hit;
        if (!ll_sweeps_stay_apart(a, &sa, b, &sb, margin)) {
            unknown += !hit;
            continue;
        }
        apart++;
        assert_false(hit);
        for (int k = 0; k <= 64; k++) {
            ll_pose at_a = ll_sweep_at(&sa, k / 64.0), at_b = ll_sweep_at(&sb, k / 64.0);
            assert_true(ll_distance(a, at_a, b, at_b).distance > margin);
        }
    }
    assert_in_range(apart, 2000, 20000);
    assert_in_range(hits, 500, 20000);
    assert_in_range(unknown, 1, 20000);
    assert_false(ll_sweeps_stay_apart(&shapes[5], &(ll_sweep){home, {0, 0}, 0}, &shapes[5],
                                      &(ll_sweep){{{9, 9}, {1, 0}}, {0, 0}, 0}, 0.001)); /* without a side */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(masses_are_the_textbooks),    cmocka_unit_test(either_direction_is_one_polygon),
        cmocka_unit_test(bad_shapes_are_told),         cmocka_unit_test(volumes_overestimate_as_they_must),
        cmocka_unit_test(volumes_miss_nothing),        cmocka_unit_test(boxes_enclose_and_extents_reach),
        cmocka_unit_test(gjk_agrees_with_brute_force), cmocka_unit_test(first_touch_is_the_closed_forms),
        cmocka_unit_test(a_support_line_never_errs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
