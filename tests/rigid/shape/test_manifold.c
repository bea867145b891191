/* Manifolds of every pair of shapes against drawn ones. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>

#include "rigid/shape/distance.h"
#include "rigid/shape/manifold.h"
#include "support/near.h"

static const double margin = 0.02;

static ll_pose at(double x, double y, double angle)
{
    return (ll_pose){{x, y}, {cos(angle), sin(angle)}};
}

static ll_geometry box(double w, double h)
{
    ll_geometry g;
    assert_int_equal(ll_shape_box(w, h, ll_vec(0, 0), 0, &g).code, LL_OK);
    return g;
}

static ll_geometry circle(double r)
{
    ll_geometry g;
    assert_int_equal(ll_shape_circle(ll_vec(0, 0), r, &g).code, LL_OK);
    return g;
}

static ll_geometry capsule(double half, double r)
{
    ll_geometry g;
    assert_int_equal(ll_shape_capsule(ll_vec(-half, 0), ll_vec(half, 0), r, &g).code, LL_OK);
    return g;
}

static void circles(void **state)
{
    (void)state;
    ll_geometry a = circle(1), b = circle(0.5);
    ll_manifold m = ll_collide(&a, &b, at(0.6, 0.8, 2), margin);
    assert_int_equal(m.count, 1);
    assert_near(m.at[0].separation, -0.5, 1e-15);
    assert_near(m.normal.x, 0.6, 1e-15);
    assert_near(m.at[0].point.y, 0.75 * 0.8, 1e-15);
    assert_int_equal(ll_collide(&a, &b, at(1.521, 0, 0), margin).count, 0);
    assert_near(ll_collide(&a, &b, at(1.51, 0, 0), margin).at[0].separation, 0.01, 1e-15);
}

static void a_box_on_a_box_stands_on_two_points(void **state)
{
    (void)state;
    ll_geometry a = box(1, 1), b = box(1, 1);
    ll_manifold m = ll_collide(&a, &b, at(0.3, 0.99, 0), margin);
    assert_int_equal(m.count, 2);
    assert_near(m.normal.y, 1, 0);
    for (int i = 0; i < 2; i++) {
        assert_near(m.at[i].separation, -0.01, 1e-15);
        assert_near(m.at[i].point.y, 0.495, 1e-15);
    }
    assert_near(smaller(m.at[0].point.x, m.at[1].point.x), -0.2, 1e-15);
    assert_near(larger(m.at[0].point.x, m.at[1].point.x), 0.5, 1e-15);
    assert_int_not_equal(m.at[0].id, m.at[1].id);

    m = ll_collide(&a, &b, at(0, -0.99, 3.14159265358979), margin);
    assert_near(m.normal.y, -1, 1e-12);
    assert_int_equal(m.count, 2);
}

static void a_corner_on_a_box_is_one_point(void **state)
{
    (void)state;
    ll_geometry a = box(4, 1), b = box(1, 1);
    double h = sqrt(0.5);
    ll_manifold m = ll_collide(&a, &b, at(0.4, 0.5 + h - 0.01, 0.78539816339744831), margin);
    assert_int_equal(m.count, 1);
    assert_near(m.at[0].separation, -0.01, 1e-12);
    assert_near(m.at[0].point.x, 0.4, 1e-9);
}

static void a_capsule_stands_on_its_end(void **state)
{
    (void)state;
    ll_geometry a = box(4, 1), b = capsule(0.5, 0.1);
    for (int k = -1; k <= 1; k += 2) {
        ll_manifold m = ll_collide(&a, &b, (ll_pose){{0.3, 1.09}, {0, k}}, margin);
        assert_int_equal(m.count, 1);
        assert_near(m.at[0].separation, -0.01, 1e-12);
        assert_near(m.normal.y, 1, 0);
        assert_near(m.at[0].point.x, 0.3, 1e-12);
        m = ll_collide(&a, &b, (ll_pose){{0.3, 0.8}, {0, k}}, margin); /* deep */
        assert_near(smaller(m.at[0].separation, m.at[m.count - 1].separation), -0.3, 1e-12);
    }
}

static void corners_push_along_the_line_between_them(void **state)
{
    (void)state;
    ll_geometry a = box(1, 1), b = capsule(0.5, 0.1);
    /* The capsule's left end is over the corner at 45 degrees. */
    double d = 0.11 * sqrt(0.5);
    ll_manifold m = ll_collide(&a, &b, at(0.5 + d + 0.5, 0.5 + d, 0), margin);
    assert_int_equal(m.count, 1);
    assert_near(m.at[0].separation, 0.01, 1e-12);
    assert_near(m.normal.x, sqrt(0.5), 1e-12);
}

/* For all shapes: the deepest point of a manifold has the separation that GJK gives, if they are apart. */
static void separations_are_distances(void **state)
{
    (void)state;
    ll_geometry shapes[4] = {box(1, 0.6), capsule(0.4, 0.2), circle(0.3), {0}};
    ll_vec2 points[5] = {{-0.6, -0.4}, {0.5, -0.6}, {0.9, 0.1}, {0.2, 0.7}, {-0.7, 0.5}};
    assert_int_equal(ll_shape_polygon(points, 5, &shapes[3]).code, LL_OK);
    int seen = 0;
    for (int i = 0; i < 40000; i++) {
        const ll_geometry *a = &shapes[i % 4], *b = &shapes[(i / 4) % 4];
        double r = 0.4 + 1.2 * fmod(i * 0.6180339887, 1);
        ll_pose home = at(0, 0, 0), rel = at(r * cos(1.7 * i), r * sin(1.7 * i), 0.73 * i);
        ll_distance_result d = ll_distance(a, home, b, rel);
        ll_manifold m = ll_collide(a, b, rel, 0.05);
        if (d.distance == 0 || d.distance > 0.049) {
            if (d.distance > 0.051)
                assert_int_equal(m.count, 0);
            continue;
        }
        seen++;
        assert_in_range(m.count, 1, 2);
        double least = smaller(m.at[0].separation, m.at[m.count - 1].separation);
        assert_near(least, d.distance, 0.001); /* axes within a tenth of the slop count as equal */
        /* The reverse direction gives the same contact. */
        ll_manifold back = ll_collide(b, a, ll_pose_between(rel, home), 0.05);
        assert_int_equal(back.count > 0, 1);
        ll_vec2 normal = ll_rotate(rel.q, back.normal);
        assert_near(smaller(back.at[0].separation, back.at[back.count - 1].separation), least, 0.001);
        if (d.distance > 0.002 && least < 0.045)
            assert_true(ll_dot(normal, m.normal) < -0.9);
    }
    assert_in_range(seen, 1000, 10000);
}

/* A chain of five segments with a concave and a convex vertex: a box or a ball over an inner vertex gets no
 * sideways normal on the flat part, and is pushed out only within the range of the ridge. */
static void links_have_no_inner_corners(void **state)
{
    (void)state;
    ll_vec2 v[6] = {{4, 0}, {2, 0}, {0, 0}, {-2, 0}, {-3, 1}, {-5, 1}}; /* right to left: solid from above */
    ll_geometry links[3], ball = circle(0.5), crate = box(1, 1);
    for (int i = 0; i < 3; i++)
        assert_int_equal(ll_shape_chain_segment(v[i], v[i + 1], v[i + 2], v[i + 3], &links[i]).code, LL_OK);
    for (int i = 0; i <= 400; i++) {
        double x = -0.5 + i * 0.01 * 0.75;
        for (int k = 0; k < 2; k++) {
            ll_manifold on_ball = ll_collide(&links[k], &ball, at(x, 0.48, 0), margin);
            ll_manifold on_crate = ll_collide(&links[k], &crate, at(x, 0.48, 0), margin);
            if (on_ball.count > 0)
                assert_near(on_ball.normal.x, 0, 1e-6);
            if (on_crate.count > 0)
                assert_near(on_crate.normal.x, 0, 1e-6);
        }
    }
    /* Nothing is stopped from below. */
    assert_int_equal(ll_collide(&links[0], &ball, at(1, -0.3, 0), margin).count, 0);
    assert_int_equal(ll_collide(&links[0], &crate, at(1, -0.3, 0), margin).count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(circles),
        cmocka_unit_test(a_box_on_a_box_stands_on_two_points),
        cmocka_unit_test(a_corner_on_a_box_is_one_point),
        cmocka_unit_test(a_capsule_stands_on_its_end),
        cmocka_unit_test(corners_push_along_the_line_between_them),
        cmocka_unit_test(separations_are_distances),
        cmocka_unit_test(links_have_no_inner_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
