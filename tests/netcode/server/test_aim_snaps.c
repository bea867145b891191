/* Aims that snap: which turns are trials and which are snaps, and the error rates of the test. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/rng.h"
#include "netcode/server/aim_snaps.h"
#include "support/near.h"

static void numbers_are_those_of_the_ratio(void **state)
{
    (void)state;
    assert_near(LL_AIM_SNAP, log(0.3 / 0.01), 1e-14);
    assert_near(LL_AIM_TURN, log(0.7 / 0.99), 1e-14);
}

/* Tests in a row at a share `p` of snaps; returns the share of alarms. */
static double alarms_of(double p, int tests, double *trials)
{
    ll_aim_watch w;
    ll_aim_watch_init(&w);
    int64_t alarms = 0;
    while (alarms + w.cleared < tests)
        alarms += ll_aim_try(&w, ll_rng_unit(6, (uint64_t)(p * 1e4), (uint64_t)w.shots) < p);
    *trials = (double)w.shots / tests;
    return (double)alarms / tests;
}

/* Wald's bounds hold, and the mean of the trials is that of his formula, but for what the sum goes beyond. */
static void errors_are_rarer_than_promised(void **state)
{
    (void)state;
    enum { TESTS = 100000 };
    double honest, bot;
    double mistaken = alarms_of(0.01, TESTS, &honest), missed = 1 - alarms_of(0.3, TESTS / 10, &bot);
    assert_true(mistaken <= 1e-4 + 3 * sqrt(1e-4 / TESTS));
    assert_true(missed <= 0.01 + 3 * sqrt(0.01 / (TESTS / 10.0)));
    double step = 0.01 * LL_AIM_SNAP + 0.99 * LL_AIM_TURN, wald = LL_SPRT_CLEAR / step;
    double steps = 0.3 * LL_AIM_SNAP + 0.7 * LL_AIM_TURN, walds = 0.99 * LL_SPRT_ALARM / steps;
    assert_true(honest >= wald - 0.5 && honest <= wald + 2);
    assert_true(bot >= walds - 0.5 && bot <= walds + LL_AIM_SNAP / steps);
}

/* Body 1, of 0.6 m, is 50 m in front of player 0. A wall at half the way may cover it. */
typedef struct range {
    ll_arena arena;
    ll_aim_watch watch;
    ll_point bodies[2];
    ll_time now;
} range;

static range new_range(void)
{
    range r = {
        .arena = {.players = 2, .bodies = 2, .teams = 2, .player_radius = 0.6, .cover = {{24, 26, -5, 5}}},
        .bodies = {{0, 0}, {50, 0}}};
    ll_aim_watch_init(&r.watch);
    return r;
}

/* An input `ms` after the last, whose aim passes the body's middle by `off` radii; returns the rate of a
 * trial. */
static double input(range *r, double ms, double off, bool shoots)
{
    double angle = asin(off * 0.6 / 50);
    r->now += (ll_time)(ms * 1e6);
    const ll_aim aim = {r->bodies[0], {cos(angle), sin(angle)}};
    return ll_aim_see(&r->watch, &r->arena, 0, r->bodies, &aim, shoots, r->now);
}

/* The rate is the way to the body's edge over the time, however far the aim goes on into it. */
static void a_jump_counts_by_its_way_and_time(void **state)
{
    (void)state;
    static const double offs[] = {1.2, 1.6, 1.8, 4, 40}, ms[] = {7.8125, 1000.0 / 60, 50};
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 3; k++) {
            range r = new_range();
            input(&r, ms[k], offs[i], false);
            double rate = input(&r, ms[k], 0.3, true), want = (offs[i] - 1) / (ms[k] / 1e3);
            assert_near(rate, want, 1e-3 * want + 1e-3);
            assert_true(input(&r, ms[k], 0.2, true) < 0); /* once only */
        }
}

/* What remains of a person's turn falls by the same share in the same time: from any distance, at any rate of
 * inputs, it is slow where it arrives. */
static void a_turn_that_slows_down_is_no_snap(void **state)
{
    (void)state;
    static const double hz[] = {20, 30, 60, 128};
    for (int i = 0; i < 4; i++)
        for (double from = 1.05; from < 200; from *= 1.07) {
            range r = new_range();
            double off = from, rate = -1;
            input(&r, 1000 / hz[i], off, false);
            while (rate < 0) {
                off *= exp(-1 / hz[i] / 0.06);
                rate = input(&r, 1000 / hz[i], off, off < 1);
            }
            assert_true(rate < LL_AIM_FAST);
        }
}

static void what_is_no_turn_is_no_trial(void **state)
{
    (void)state;
    range on = new_range(), corner = new_range(), lost = new_range(), late = new_range(), first = new_range(),
          miss = new_range();
    assert_true(input(&first, 16, 0, true) < 0); /* nothing is known of before */
    for (int k = 0; k < 100; k++) {              /* follows a body that moves */
        on.bodies[1].y += 0.2;
        on.bodies[0].y += 0.2;
        assert_true(input(&on, 16, 0.5 * sin(k), k > 0) < 0);
    }
    corner.arena.covers = 1; /* the aim is where the body comes out */
    assert_true(input(&corner, 16, 0.1, true) < 0);
    corner.arena.covers = 0;
    assert_true(input(&corner, 16, 0.1, true) < 0);
    input(&lost, 16, 9, false);
    assert_true(input(&lost, 51, 0, true) < 0);
    input(&late, 16, 9, false);
    input(&late, 16, 0, false);
    for (int k = 0; k < 64; k++)
        input(&late, 16, 0, false);
    assert_true(input(&late, 16, 0, true) < 0); /* more than a second later */
    input(&miss, 16, 9, false);
    assert_true(input(&miss, 16, 1.1, true) < 0); /* past it */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_those_of_the_ratio),
        cmocka_unit_test(errors_are_rarer_than_promised),
        cmocka_unit_test(a_jump_counts_by_its_way_and_time),
        cmocka_unit_test(a_turn_that_slows_down_is_no_snap),
        cmocka_unit_test(what_is_no_turn_is_no_trial),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
