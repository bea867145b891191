/* Hits of shots, against closed forms and against bisection in long double. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/rng.h"
#include "game/core/arena.h"
#include "support/near.h"

static double uniform(uint64_t stream, uint64_t i, double low, double high)
{
    return low + (high - low) * ll_rng_unit(1, stream, i);
}

/* One player at the origin that shoots at one target of radius `radius`. */
static ll_arena range(double radius)
{
    return (ll_arena){.players = 1,
                      .bodies = 2,
                      .teams = 2,
                      .player_radius = 0.5,
                      .target_radius = radius,
                      .gravity = 9.81,
                      .bounds = {-1e6, 1e6, -1e6, 1e6}};
}

/* ---- rays ---- */

static void ray_meets_circle(void **state)
{
    (void)state;
    for (int i = -25; i <= 25; i++) { /* along x, at height i / 10, a circle of radius 2 about (10, 0) */
        double h = i / 10.0, got = ll_ray_circle((ll_point){0, h}, (ll_point){1, 0}, (ll_point){10, 0}, 2);
        if (fabs(h) > 2)
            assert_true(got < 0);
        else
            assert_near(got, 10 - sqrt(4 - h * h), 1e-13);
    }
    for (uint64_t i = 0; i < 1000;
         i++) { /* aimed at a point of the disc: the distance by the law of cosines */
        double angle = uniform(1, i, -3, 3), d = uniform(2, i, 3, 50), off = uniform(3, i, -1, 1), r = 1.5;
        ll_point c = {d * cos(angle), d * sin(angle)};
        double turn = asin(off * r / d);
        ll_point way = {cos(angle + turn), sin(angle + turn)};
        double want = d * cos(turn) - sqrt(r * r * (1 - off * off));
        assert_near(ll_ray_circle((ll_point){0, 0}, way, c, r), want, 1e-11);
    }
    assert_true(ll_ray_circle((ll_point){9, 0}, (ll_point){1, 0}, (ll_point){10, 0}, 2) == 0); /* within */
    assert_true(ll_ray_circle((ll_point){13, 0}, (ll_point){1, 0}, (ll_point){10, 0}, 2) < 0); /* behind */
}

static void ray_meets_box(void **state)
{
    (void)state;
    const ll_box box = {4, 6, -1, 3};
    const ll_point o = {0, 0};
    assert_true(ll_ray_box(o, (ll_point){1, 0}, &box) == 4);
    assert_near(ll_ray_box(o, (ll_point){0.8, 0.6}, &box), 5, 1e-14); /* (4, 3): the corner */
    assert_true(ll_ray_box(o, (ll_point){0.6, 0.8}, &box) < 0);
    assert_true(ll_ray_box(o, (ll_point){-1, 0}, &box) < 0);
    assert_true(ll_ray_box((ll_point){5, 10}, (ll_point){0, -1}, &box) == 7); /* upright, along a slab */
    assert_true(ll_ray_box((ll_point){7, 10}, (ll_point){0, -1}, &box) < 0);
    assert_true(ll_ray_box((ll_point){5, 0}, (ll_point){0, 1}, &box) == 0);
}

static void the_nearest_enemy_before_cover_is_hit(void **state)
{
    (void)state;
    ll_arena a = range(1);
    a.players = 3, a.bodies = 5;
    const ll_point along = {1, 0};
    ll_point bodies[] = {{0, 0}, {30, 0}, {10, 0}, {20, 0}, {25, 0}}; /* 2 is of the shooter's team */
    assert_int_equal(ll_arena_ray(&a, 0, bodies[0], along, bodies), 3);
    bodies[3].y = 1.01;
    assert_int_equal(ll_arena_ray(&a, 0, bodies[0], along, bodies), 4);
    bodies[4].y = -1.01;
    assert_int_equal(ll_arena_ray(&a, 0, bodies[0], along, bodies), 1); /* the player, of radius 0.5 */
    assert_int_equal(ll_arena_ray(&a, 0, (ll_point){0, 0.51}, along, bodies), 3);
    a.covers = 1;
    a.cover[0] = (ll_box){28, 29, -5, 5};
    assert_int_equal(ll_arena_ray(&a, 0, bodies[0], along, bodies), LL_NOBODY);
    assert_false(ll_arena_sees(&a, bodies[0], bodies[1]));
    assert_true(ll_arena_sees(&a, bodies[0], bodies[4]));
    a.cover[0].x_min = 31, a.cover[0].x_max = 32;
    assert_int_equal(ll_arena_ray(&a, 0, bodies[0], along, bodies), 1);
    assert_true(ll_arena_sees(&a, bodies[0], bodies[1]));
}

/* ---- flights ---- */

static void flight_is_a_parabola(void **state)
{
    (void)state;
    const ll_flight f = {{1, 2}, {30, 20}, 9.81, 0};
    double apex = 20 / 9.81;
    assert_near(ll_flight_at(&f, apex).y, 2 + 20.0 * 20 / (2 * 9.81), 1e-12);
    assert_near(ll_flight_at(&f, 2 * apex).y, 2, 1e-12);
    assert_near(ll_flight_at(&f, 2 * apex).x, 1 + 2 * 30 * 20 / 9.81, 1e-12);
}

static void chord_is_off_by_an_eighth_of_g_t_squared(void **state)
{
    (void)state;
    const ll_flight f = {{1, 2}, {30, 20}, 9.81, 0};
    for (int i = 1; i <= 20; i++) {
        double s0 = 0.3, t = 0.05 * i, s1 = s0 + t, most = 0;
        ll_flight chord = ll_flight_chord(&f, s0, s1);
        for (int k = 0; k <= 100; k++) {
            double s = t * k / 100;
            ll_point a = ll_flight_at(&chord, s), b = ll_flight_at(&f, s0 + s);
            assert_near(a.x, b.x, 1e-12);
            assert_near(b.y - a.y, 9.81 / 2 * s * (t - s), 1e-12);
            most = larger(most, b.y - a.y);
        }
        assert_near(most, 9.81 * t * t / 8, 1e-12);
    }
}

/* The first time that |flight - body| is the radius, by steps of 1e-4 s and bisection. */
static double reference(const ll_flight *f, double s0, double s1, ll_point a, ll_point b, double radius)
{
    long double low = s0;
#define GAP(s)                                                                                               \
    (hypotl(f->from.x + f->velocity.x * (s) - (a.x + (b.x - a.x) * ((s)-s0) / (s1 - s0)),                    \
            f->from.y + (f->velocity.y - f->gravity / 2 * (s)) * (s) -                                       \
                (a.y + (b.y - a.y) * ((s)-s0) / (s1 - s0))) -                                                \
     radius)
    for (long double s = s0; s < s1; s += 1e-4L) {
        long double high = s + 1e-4L < s1 ? s + 1e-4L : s1;
        if (GAP(high) <= 0) {
            for (int i = 0; i < 80; i++) {
                long double middle = (low + high) / 2;
                if (GAP(middle) > 0)
                    low = middle;
                else
                    high = middle;
            }
            return (double)high;
        }
        low = high;
    }
    return -1;
}

static void flight_meets_a_moving_body(void **state)
{
    (void)state;
    const ll_arena arena = range(0.6);
    int met = 0;
    for (uint64_t i = 0; i < 400; i++) {
        ll_flight f = {{0, 0}, {uniform(1, i, 15, 40), uniform(2, i, 0, 20)}, 9.81, 0};
        double s0 = uniform(3, i, 0, 0.5), s1 = s0 + uniform(4, i, 0.1, 1), hit = uniform(5, i, s0, s1);
        ll_point at = ll_flight_at(&f, hit), v = {uniform(6, i, -8, 8), uniform(7, i, -8, 8)};
        at.x += uniform(8, i, -0.8, 0.8), at.y += uniform(9, i, -0.8, 0.8); /* near there, at that time */
        ll_point before[] = {{0, 0}, {at.x - v.x * (hit - s0), at.y - v.y * (hit - s0)}};
        ll_point after[] = {{0, 0}, {at.x + v.x * (s1 - hit), at.y + v.y * (s1 - hit)}};
        double want = reference(&f, s0, s1, before[1], after[1], 0.6);
        ll_flight_hit m = ll_arena_flight(&arena, 0, &f, s0, s1, before, after);
        if (want < 0) { /* a touch shorter than the steps of the reference is not decided */
            ll_point p = ll_flight_at(&f, m.s);
            double u = (m.s - s0) / (s1 - s0);
            ll_point q = {before[1].x + u * (after[1].x - before[1].x),
                          before[1].y + u * (after[1].y - before[1].y)};
            assert_true(m.met == LL_MET_NOTHING || is_near(hypot(p.x - q.x, p.y - q.y), 0.6, 1e-9));
            continue;
        }
        assert_int_equal(m.met, LL_MET_BODY);
        assert_int_equal(m.body, 1);
        assert_near(m.s, want, 1e-10);
        met++;
    }
    assert_true(met > 150);
}

/* The answer does not depend on how a flight is cut. */
static void cuts_change_nothing(void **state)
{
    (void)state;
    const ll_arena arena = range(0.6);
    for (uint64_t i = 0; i < 200; i++) {
        ll_flight f = {{0, 0}, {uniform(1, i, 15, 40), uniform(2, i, 0, 20)}, 9.81, 0};
        double hit = uniform(5, i, 0.3, 0.9);
        ll_point at = ll_flight_at(&f, hit), v = {uniform(6, i, -8, 8), uniform(7, i, -8, 8)};
        ll_point ends[2][2] = {{{0, 0}, {at.x - v.x * hit, at.y - v.y * hit}},
                               {{0, 0}, {at.x + v.x * (1 - hit), at.y + v.y * (1 - hit)}}};
        ll_flight_hit whole = ll_arena_flight(&arena, 0, &f, 0, 1, ends[0], ends[1]), cut = {0};
        assert_int_equal(whole.met, LL_MET_BODY);
        for (double s = 0, t; cut.met == LL_MET_NOTHING; s = t) {
            t = smaller(s + uniform(11, i * 100 + (uint64_t)(s * 99), 0.001, 0.05), 1);
            assert_true(s < 1);
            ll_point a[] = {{0, 0}, {ends[0][1].x + v.x * s, ends[0][1].y + v.y * s}};
            ll_point b[] = {{0, 0}, {ends[0][1].x + v.x * t, ends[0][1].y + v.y * t}};
            cut = ll_arena_flight(&arena, 0, &f, s, t, a, b);
        }
        assert_near(cut.s, whole.s, 1e-11);
    }
}

static void flight_ends_at_cover_and_ground(void **state)
{
    (void)state;
    ll_arena arena = range(0.6);
    arena.bodies = 1;
    arena.bounds = (ll_box){-10, 200, 0, 20};
    const ll_point self[] = {{0, 0}};
    double v = 30 * sqrt(0.5), fall = 2 * v / 9.81;
    ll_flight f = {{0, 0}, {v, v}, 9.81, 0};
    ll_flight_hit m = ll_arena_flight(&arena, 0, &f, 0, 10, self, self);
    assert_int_equal(m.met, LL_MET_BOUNDS);
    assert_near(m.s, fall, 1e-12); /* it rises above the upper edge and comes back */
    assert_near(ll_flight_at(&f, m.s).x, 30 * 30 / 9.81, 1e-10);
    arena.covers = 1;
    arena.cover[0] = (ll_box){60, 62, 0, 100}; /* a wall: met at its side */
    m = ll_arena_flight(&arena, 0, &f, 0, 10, self, self);
    assert_int_equal(m.met, LL_MET_COVER);
    assert_near(m.s, 60 / v, 1e-12);
    arena.cover[0] = (ll_box){50, 90, 0, 5}; /* a roof at 5 m: met from above */
    m = ll_arena_flight(&arena, 0, &f, 0, 10, self, self);
    assert_int_equal(m.met, LL_MET_COVER);
    assert_near(m.s, (v + sqrt(v * v - 2 * 9.81 * 5)) / 9.81, 1e-12);
    arena.cover[0] = (ll_box){0, 200, 10, 11}; /* a ceiling: from below */
    m = ll_arena_flight(&arena, 0, &f, 0, 10, self, self);
    assert_near(m.s, (v - sqrt(v * v - 2 * 9.81 * 10)) / 9.81, 1e-12);
    arena.cover[0] = (ll_box){60, 62, 0, 1}; /* too low */
    m = ll_arena_flight(&arena, 0, &f, 0, 10, self, self);
    assert_int_equal(m.met, LL_MET_BOUNDS);
    arena.bounds.x_max = 40;
    m = ll_arena_flight(&arena, 0, &f, 0, 10, self, self);
    assert_true(m.met == LL_MET_BOUNDS);
    assert_near(m.s, 40 / v, 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ray_meets_circle),
        cmocka_unit_test(ray_meets_box),
        cmocka_unit_test(the_nearest_enemy_before_cover_is_hit),
        cmocka_unit_test(flight_is_a_parabola),
        cmocka_unit_test(chord_is_off_by_an_eighth_of_g_t_squared),
        cmocka_unit_test(flight_meets_a_moving_body),
        cmocka_unit_test(cuts_change_nothing),
        cmocka_unit_test(flight_ends_at_cover_and_ground),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
