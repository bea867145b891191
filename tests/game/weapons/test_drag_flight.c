/* Flights with quadratic drag, against closed forms in one dimension, against integrations in the plane to
 * 1e-13 by another room, and hits against bisection. */
#include <float.h>

#include "base/rng.h"
#include "game/weapons/drag_flight.h"
#include "ode/harness.h"
#include "support/near.h"

static double uniform(uint64_t stream, uint64_t i, double low, double high)
{
    return low + (high - low) * ll_rng_unit(7, stream, i);
}

/* From 1e-6 to 1 per metre, or as given. */
static double spread(uint64_t stream, uint64_t i, double low, double high)
{
    return low * pow(high / low, ll_rng_unit(7, stream, i));
}

/* The header's figure, and rounding. */
#define WITHIN(got, want, drag) assert_true(fabs((got) - (want)) <= 1e-8 / (drag) + 1e-13 * fabs(want))

/* ---- closed forms ---- */

/* x(t) = log(1 + k v0 t) / k, v(t) = v0 / (1 + k v0 t). */
static void without_gravity_it_is_a_logarithm(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 500; i++) {
        double k = spread(1, i, 1e-6, 1), v0 = spread(2, i, 1, 1000), t = spread(3, i, 1e-4, 100),
               angle = uniform(4, i, -3, 3);
        const ll_flight f = {{3, -2}, {v0 * cos(angle), v0 * sin(angle)}, 0, k};
        double way = log1p(k * v0 * t) / k, v = v0 / (1 + k * v0 * t);
        ll_point at = ll_drag_flight_at(&f, t), velocity = ll_drag_flight_velocity(&f, t);
        WITHIN(at.x, 3 + way * cos(angle), k);
        WITHIN(at.y, -2 + way * sin(angle), k);
        assert_near(hypot(velocity.x, velocity.y), v, 1e-6 * v);
    }
}

/* Upwards v = vt tan(atan(v0 / vt) - g t / vt), downwards v = -vt tanh(g t / vt). */
static void upright_it_rises_by_a_tangent_and_falls_to_the_terminal_speed(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 500; i++) {
        double k = spread(1, i, 1e-4, 1), g = spread(2, i, 0.1, 100), v0 = spread(3, i, 1, 300);
        double vt = sqrt(g / k), angle = atan(v0 / vt), apex = angle * vt / g, top = -log(cos(angle)) / k;
        const ll_flight f = {{0, 0}, {0, v0}, g, k};
        for (int n = 1; n <= 6; n++) {
            double t = apex * n / 3, left = t - apex, want;
            if (left < 0)
                want = log(cos(angle - g * t / vt) / cos(angle)) / k;
            else
                want = top - log(cosh(g * left / vt)) / k;
            WITHIN(ll_drag_flight_at(&f, t).y, want, k);
        }
        double v = ll_drag_flight_velocity(&f, apex + 20 * vt / g).y;
        assert_near(v, -vt, 1e-9 * vt);
    }
}

/* With next to no drag it is a parabola. */
static void drag_near_zero_gives_the_parabola(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 200; i++) {
        ll_flight f = {{1, 2}, {uniform(1, i, -90, 90), uniform(2, i, -90, 90)}, 9.81, 1e-14};
        double t = uniform(3, i, 0, 10);
        ll_point a = ll_flight_at(&f, t), u = ll_flight_velocity(&f, t);
        f.drag = 0;
        ll_point b = ll_flight_at(&f, t), v = ll_flight_velocity(&f, t);
        assert_near(a.x, b.x, 1e-8);
        assert_near(a.y, b.y, 1e-8);
        assert_near(u.x, v.x, 1e-8);
        assert_near(u.y, v.y, 1e-8);
    }
}

/* ---- in the plane ---- */

typedef struct forces {
    double g, k;
} forces;

static void braked(const void *p, double t, const double *y, const double *v, double *a)
{
    const forces *of = p;
    double drag = of->k * sqrt(v[0] * v[0] + v[1] * v[1]);
    (void)t, (void)y;
    a[0] = -drag * v[0];
    a[1] = -of->g - drag * v[1];
}

static void agrees_with_an_integration_to_1e_13(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 150; i++) {
        const forces of = {spread(1, i, 0.1, 100), spread(2, i, 1e-5, 1)};
        double v0 = spread(3, i, 1, 1000), angle = uniform(4, i, -1.5, 1.5), t = spread(5, i, 0.01, 10);
        const ll_ode ode = {
            .dim = 4, .acceleration = braked, .velocity_dependent = true, .autonomous = true, .params = &of};
        const double y0[] = {0, 0, v0 * cos(angle), v0 * sin(angle)};
        const ll_flight f = {{0, 0}, {y0[2], y0[3]}, of.g, of.k};
        double y[4];
        solve("dop853", &ode, y0, t, 0, 1e-13, y);
        ll_point at = ll_drag_flight_at(&f, t);
        WITHIN(at.x, y[0], of.k);
        WITHIN(at.y, y[1], of.k);
    }
}

/* drag_2d of the ODE lab: 18 digits by two methods in quadruple precision. */
static void agrees_with_the_published_digits(void **state)
{
    (void)state;
    const ll_flight f = {{0, 0}, {30, 40}, 10, 1.0 / 128};
    ll_point at = ll_drag_flight_at(&f, 4), v = ll_drag_flight_velocity(&f, 4);
    WITHIN(at.x, 77.4765955049512129, f.drag);
    WITHIN(at.y, 39.1562624297932313, f.drag);
    assert_near(v.x, 13.9723273489021700, 1e-6);
    assert_near(v.y, -11.4832542985015648, 1e-6);
}

/* ---- hits ---- */

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

typedef struct meeting {
    ll_flight f;
    double s0, s1;
    ll_point before[2], after[2];
} meeting;

/* A body that passes near the projectile at a random moment of a random part of its flight. */
static meeting random_meeting(uint64_t i)
{
    meeting m = {.f = {{0, 0}, {uniform(1, i, 15, 80), uniform(2, i, 0, 30)}, 9.81, spread(12, i, 1e-3, 0.1)},
                 .s0 = uniform(3, i, 0, 0.5)};
    m.s1 = m.s0 + uniform(4, i, 0.1, 1);
    double hit = uniform(5, i, m.s0, m.s1);
    ll_point at = ll_flight_at(&m.f, hit), v = {uniform(6, i, -8, 8), uniform(7, i, -8, 8)};
    at.x += uniform(8, i, -0.8, 0.8), at.y += uniform(9, i, -0.8, 0.8);
    m.before[1] = (ll_point){at.x - v.x * (hit - m.s0), at.y - v.y * (hit - m.s0)};
    m.after[1] = (ll_point){at.x + v.x * (m.s1 - hit), at.y + v.y * (m.s1 - hit)};
    return m;
}

static double gap(const meeting *m, double s)
{
    double u = (s - m->s0) / (m->s1 - m->s0);
    ll_point p = ll_flight_at(&m->f, s);
    return hypot(p.x - m->before[1].x - u * (m->after[1].x - m->before[1].x),
                 p.y - m->before[1].y - u * (m->after[1].y - m->before[1].y));
}

/* The first time at which the gap is the radius, by steps of 2^-12 and bisection; negative: none. */
static double reference(const meeting *m, double radius)
{
    double low = m->s0, step = (m->s1 - m->s0) / 4096;
    if (gap(m, low) <= radius)
        return low;
    for (int i = 1; i <= 4096; i++) {
        double high = m->s0 + i * step;
        if (gap(m, high) <= radius) {
            for (int k = 0; k < 60; k++) {
                double middle = (low + high) / 2;
                *(gap(m, middle) > radius ? &low : &high) = middle;
            }
            return high;
        }
        low = high;
    }
    return -1;
}

static void meets_a_moving_body(void **state)
{
    (void)state;
    const ll_arena arena = range(0.6);
    int met = 0;
    for (uint64_t i = 0; i < 100; i++) {
        const meeting m = random_meeting(i);
        double want = reference(&m, 0.6);
        ll_flight_hit hit = ll_arena_flight(&arena, 0, &m.f, m.s0, m.s1, m.before, m.after);
        if (want < 0) { /* a touch shorter than the steps of the reference is not decided */
            assert_true(hit.met == LL_MET_NOTHING || fabs(gap(&m, hit.s) - 0.6) < 1e-9);
            continue;
        }
        assert_int_equal(hit.met, LL_MET_BODY);
        assert_int_equal(hit.body, 1);
        assert_near(hit.s, want, 1e-9);
        met++;
    }
    assert_true(met > 40);
}

/* The answer does not depend on how a flight is divided. */
static void parts_of_a_flight_meet_what_the_whole_meets(void **state)
{
    (void)state;
    const ll_arena arena = range(0.6);
    for (uint64_t i = 0; i < 100; i++) {
        const meeting m = random_meeting(i);
        ll_flight_hit whole = ll_arena_flight(&arena, 0, &m.f, m.s0, m.s1, m.before, m.after), part = {0};
        for (double s = m.s0, t; part.met == LL_MET_NOTHING && s < m.s1; s = t) {
            t = smaller(s + uniform(11, i * 100 + (uint64_t)(s * 99), 0.001, 0.05), m.s1);
            double u = (s - m.s0) / (m.s1 - m.s0), w = (t - m.s0) / (m.s1 - m.s0);
            ll_point a = m.before[1], b = m.after[1];
            const ll_point before[] = {{0, 0}, {a.x + u * (b.x - a.x), a.y + u * (b.y - a.y)}},
                           after[] = {{0, 0}, {a.x + w * (b.x - a.x), a.y + w * (b.y - a.y)}};
            part = ll_arena_flight(&arena, 0, &m.f, s, t, before, after);
        }
        assert_int_equal(part.met, whole.met);
        assert_true(part.met == LL_MET_NOTHING || fabs(part.s - whole.s) < 1e-9);
    }
}

/* How far outside of a box, at most. */
static double outside(const ll_box *box, ll_point p)
{
    return larger(larger(box->x_min - p.x, p.x - box->x_max), larger(box->y_min - p.y, p.y - box->y_max));
}

/* Against fine steps along the flight: cover, the sides and the ground. Steps that no flight of at most 100
 * m/s can end within are left out. */
static void ends_at_cover_and_ground(void **state)
{
    (void)state;
    ll_arena arena = range(0.6);
    const ll_point self[] = {{0, 0}};
    int met[LL_MET_BOUNDS + 1] = {0};
    arena.bodies = 1;
    arena.covers = 2;
    arena.bounds = (ll_box){-10, 60, -1, 20};
    for (uint64_t i = 0; i < 200; i++) {
        const ll_flight f = {
            {0, 0}, {uniform(1, i, 5, 80), uniform(2, i, -10, 40)}, 9.81, spread(3, i, 1e-3, 0.1)};
        arena.cover[0] = (ll_box){20, 21, 0, uniform(4, i, 1, 12)};
        arena.cover[1] = (ll_box){30, 40, uniform(5, i, 3, 8), 9};
        ll_flight_hit hit = ll_arena_flight(&arena, 0, &f, 0, 20, self, self);
        ll_met want = LL_MET_NOTHING;
        double s = 0;
        while (want == LL_MET_NOTHING && s < 20) {
            ll_point p = ll_flight_at(&f, s);
            double free = smaller(60 - p.x, p.y + 1);
            if (free < 0)
                want = LL_MET_BOUNDS;
            for (int k = 0; k < 2; k++) {
                double gap = outside(&arena.cover[k], p);
                if (gap < 0 && want == LL_MET_NOTHING)
                    want = LL_MET_COVER;
                free = smaller(free, gap);
            }
            s += larger(1, floor(free / 100 * 4096)) / 4096;
        }
        met[want]++;
        bool clipped = hit.met == LL_MET_COVER && hit.s < s - 3.0 / 4096; /* a corner, between two steps */
        assert_true(clipped || hit.met == want);
        assert_true(clipped || (hit.s <= s && hit.s >= s - 3.0 / 4096));
    }
    assert_true(met[LL_MET_COVER] > 30 && met[LL_MET_BOUNDS] > 30);
}

static void covers_a_distance_at_one_time(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 200; i++) {
        const ll_flight f = {
            {5, 1}, {uniform(1, i, 5, 80), uniform(2, i, -10, 40)}, 9.81, spread(3, i, 1e-3, 0.1)};
        double x = uniform(4, i, 1, 40), s = ll_drag_flight_covers(&f, x, 20);
        if (s < 0)
            assert_true(ll_drag_flight_at(&f, 20).x < 5 + x);
        else
            assert_near(ll_drag_flight_at(&f, s).x - 5, x, 1e-9);
    }
}

/* The hardest values that the shooter allows. */
static void extremes_are_finite(void **state)
{
    (void)state;
    for (int i = 0; i < 16; i++) {
        double v = i & 1 ? 1000 : 1, k = i & 2 ? 1 : 1e-9, g = i & 4 ? 100 : 0.1,
               angle = i & 8 ? 1.5707 : 0.5;
        const ll_flight f = {{0, 0}, {v * cos(angle), v * sin(angle)}, g, k};
        ll_point at = ll_flight_at(&f, 10 * sqrt(1 / (g * k)));
        assert_true(isfinite(at.x) && isfinite(at.y));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_gravity_it_is_a_logarithm),
        cmocka_unit_test(upright_it_rises_by_a_tangent_and_falls_to_the_terminal_speed),
        cmocka_unit_test(drag_near_zero_gives_the_parabola),
        cmocka_unit_test(agrees_with_an_integration_to_1e_13),
        cmocka_unit_test(agrees_with_the_published_digits),
        cmocka_unit_test(meets_a_moving_body),
        cmocka_unit_test(parts_of_a_flight_meet_what_the_whole_meets),
        cmocka_unit_test(ends_at_cover_and_ground),
        cmocka_unit_test(covers_a_distance_at_one_time),
        cmocka_unit_test(extremes_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
