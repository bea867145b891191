/* Detection of cheats: the tests' error rates and mean trials, against Wald's formulas and an exact sum over
 * all courses of a test; the rate, against its definition. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "netcode/server/detect.h"
#include "support/near.h"

static const double honest = 0.001, cheat = 0.1, alpha = 1e-4, beta = 0.01;

/* ---- reactions ---- */

static void numbers_are_those_of_the_ratio(void **state)
{
    (void)state;
    assert_near(LL_SPRT_HIT, log(cheat / honest), 1e-14);
    assert_near(LL_SPRT_MISS, log((1 - cheat) / (1 - honest)), 1e-14);
    assert_near(LL_SPRT_ALARM, log((1 - beta) / alpha), 1e-14);
    assert_near(LL_SPRT_CLEAR, log(beta / (1 - alpha)), 1e-14);
}

typedef struct course {
    double trials, deviation, alarm,
        end; /* means of the trials and of the final sum; probability of an alarm */
} course;

enum { HITS = 400, TRIALS = 4000 };

/* Over all courses: the probability of each number of hits after each number of trials. */
static course exact(double p)
{
    static double now[HITS + 1], next[HITS + 1];
    course c = {0};
    double squares = 0;
    memset(now, 0, sizeof now);
    now[0] = 1;
    for (int n = 1; n <= TRIALS; n++) {
        memset(next, 0, sizeof next);
        for (int h = 0; h < HITS; h++)
            for (int hit = 0; hit < 2 && now[h] > 0; hit++) {
                double w = now[h] * (hit ? p : 1 - p), k = h + hit,
                       sum = k * log(cheat / honest) + (n - k) * log((1 - cheat) / (1 - honest));
                bool alarm = sum >= log((1 - beta) / alpha), clear = sum <= log(beta / (1 - alpha));
                if (!alarm && !clear) {
                    next[h + hit] += w;
                    continue;
                }
                c.trials += n * w, squares += (double)n * n * w, c.end += sum * w, c.alarm += alarm ? w : 0;
            }
        memcpy(now, next, sizeof now);
    }
    c.deviation = sqrt(squares - c.trials * c.trials);
    return c;
}

/* Tests in a row, as the server makes them. */
static course simulated(double p, int tests)
{
    ll_detection d;
    ll_detection_init(&d);
    ll_reaction_watch *w = &d.reaction;
    course c = {0};
    int64_t trials = 0;
    for (int i = 0; i < tests; i++) {
        bool alarm = false;
        int64_t cleared = w->cleared;
        while (!alarm && w->cleared == cleared)
            alarm = ll_reaction_try(w, ll_rng_unit(5, (uint64_t)(p * 1e4), (uint64_t)trials++) < p);
        c.alarm += alarm;
    }
    assert_int_equal(w->shots, trials);
    c.trials = (double)trials / tests, c.alarm /= tests;
    return c;
}

/* Wald: the mean of the final sum is that of the trials times the mean of a step; the sum ends at a bound, or
 * beyond it, since a hit is half of the way to the alarm. Without that excess 46 and 25 trials. */
static void trials_until_a_decision_are_as_computed(void **state)
{
    (void)state;
    const double ps[] = {honest, cheat}, wald[] = {46.2, 24.7};
    const int tests[] = {40000, 40000};
    for (int i = 0; i < 2; i++) {
        double step = ps[i] * LL_SPRT_HIT + (1 - ps[i]) * LL_SPRT_MISS;
        double bound = i == 0 ? (1 - alpha) * LL_SPRT_CLEAR + alpha * LL_SPRT_ALARM
                              : (1 - beta) * LL_SPRT_ALARM + beta * LL_SPRT_CLEAR;
        course want = exact(ps[i]), got = simulated(ps[i], tests[i]);
        assert_near(bound / step, wald[i], 0.05);
        assert_near(want.end, want.trials * step, 1e-9 * want.trials);
        assert_near(got.trials, want.trials, 4 * want.deviation / sqrt(tests[i]));
        double excess = i == 0 ? -LL_SPRT_MISS : LL_SPRT_HIT; /* a sum is at most one step beyond a bound */
        assert_true(want.trials >= wald[i] - 0.05 && want.trials <= wald[i] + excess / fabs(step));
    }
}

static void errors_are_rarer_than_promised(void **state)
{
    (void)state;
    enum { TESTS = 200000 };
    course good = simulated(honest, TESTS), bad = simulated(cheat, TESTS / 10);
    assert_true(exact(honest).alarm <= alpha && 1 - exact(cheat).alarm <= beta);
    assert_true(good.alarm <= alpha + 3 * sqrt(alpha / TESTS));
    assert_true(1 - bad.alarm <= beta + 3 * sqrt(beta / (TESTS / 10.0)));
    assert_near(good.alarm, exact(honest).alarm, 4 * sqrt(alpha / TESTS));
}

/* Two players face each other across the line x = 30, where a wall of 6 m stands; body 1 rises above it. */
typedef struct range {
    ll_arena arena;
    ll_detection detection;
    ll_point bodies[2];
    ll_time now;
} range;

static range new_range(void)
{
    range r = {.arena = {.players = 2,
                         .bodies = 2,
                         .teams = 2,
                         .covers = 1,
                         .player_radius = 0.6,
                         .interval_s = {0.25, 0},
                         .cover = {{29, 31, 0, 6}}},
               .bodies = {{0, 7}, {60, 1}}};
    ll_detection_init(&r.detection);
    return r;
}

/* Inputs at 60 per second until `until_s`, in whose views body 1 is at height y; the last one may be a shot
 * at it. Returns the reaction of that one. */
static ll_time inputs(range *r, double until_s, double y, bool shoots)
{
    ll_time reaction = -1;
    r->bodies[1].y = y;
    while (r->now < (ll_time)(until_s * 1e9) - LL_MS) {
        r->now += LL_SECOND / 60;
        bool last = r->now >= (ll_time)(until_s * 1e9) - LL_MS;
        double dy = y - 7, length = hypot(60, dy);
        const ll_aim at = {r->bodies[0], {60 / length, dy / length}};
        reaction = ll_reaction_see(&r->detection.reaction, &r->arena, 0, r->bodies,
                                   last && shoots ? &at : NULL, r->now);
    }
    return reaction;
}

/* From the input before that on which the body was in sight first. */
static void reactions_count_from_the_first_sight(void **state)
{
    (void)state;
    for (int ticks = 1; ticks <= 60; ticks++) {
        range r = new_range();
        assert_int_equal(inputs(&r, 2, 1, false), -1);
        ll_time got = inputs(&r, 2 + ticks / 60.0, 8, true), want = ticks * (LL_SECOND / 60);
        assert_int_equal(got, want);
        assert_int_equal(inputs(&r, 2 + (ticks + 30) / 60.0, 8, true), -1); /* not a second time */
    }
}

static void what_is_no_reaction_is_no_trial(void **state)
{
    (void)state;
    range late = new_range(), known = new_range(), reload = new_range(), glimpse = new_range(),
          away = new_range();
    inputs(&late, 2, 1, false);
    assert_int_equal(inputs(&late, 3.1, 8, true), -1);   /* more than a second later */
    assert_int_equal(inputs(&known, 0.05, 8, true), -1); /* in sight from the start */
    inputs(&reload, 2, 8, true);                         /* the rifle loads until 2.25 s */
    inputs(&reload, 2.1, 1, false);
    assert_int_equal(inputs(&reload, 2.2, 8, true), -1);
    inputs(&glimpse, 2, 1, false);
    inputs(&glimpse, 4, 8, false);
    inputs(&glimpse, 4.3, 1, false); /* hidden for less than half a second */
    assert_int_equal(inputs(&glimpse, 4.35, 8, true), -1);
    inputs(&away, 2, 1, false);
    assert_int_equal(inputs(&away, 2.1, 1, true), -1); /* at the wall */
}

/* After lost inputs the body may have been drawn since the last one that came. */
static void lost_inputs_make_no_reaction_faster(void **state)
{
    (void)state;
    range r = new_range();
    inputs(&r, 2, 1, false);
    r.now += LL_SECOND / 5;
    assert_true(inputs(&r, 2.2 + 1 / 60.0, 8, true) >= LL_SECOND / 5);
}

/* ---- rate ---- */

typedef struct sender {
    ll_rate_watch *watch;
    uint32_t seq;
    int alarms;
} sender;

static void send(sender *s, int count, double at_s)
{
    s->alarms += ll_rate_take(s->watch, 1, s->seq, count, 60000, (ll_time)(at_s * 1e9));
    s->seq += (uint32_t)count;
}

/* `hz` inputs per second for `duration_s`, after a silence; returns when the first alarm was raised, or a
 * negative time. */
static double alarm_at(double hz, double duration_s, double silence_s)
{
    ll_detection d;
    ll_detection_init(&d);
    sender s = {&d.rate, 1, 0};
    send(&s, 1, 0);
    for (int i = 1; i < duration_s * hz; i++) {
        send(&s, 1, silence_s + i / hz);
        if (s.alarms > 0)
            return i / hz;
    }
    return -1;
}

/* At a rate of (1 + x) hz the sum grows by (x - e) hz per second: 80 after 80 / ((x - e) hz). */
static void the_sum_grows_with_the_excess(void **state)
{
    (void)state;
    const double excess[] = {1, 0.5, 0.2, 0.1, 0.05, 0.01};
    for (int i = 0; i < 6; i++) {
        double want = 80 / (60 * (excess[i] - 1e-3)), got = alarm_at(60 * (1 + excess[i]), 2 * want + 5, 0);
        assert_near(got, want, 0.02 * want + 0.05);
    }
    assert_true(alarm_at(60, 3600, 0) < 0);
    assert_true(alarm_at(60 * 1.0005, 3600, 0) < 0); /* the fastest clock */
}

/* Silence is credit, but not for more than a burst: 80 inputs at 60 Hz. */
static void silence_is_credit_up_to_a_burst(void **state)
{
    (void)state;
    for (int held = 10; held <= 240; held += 10) {
        ll_detection d;
        ll_detection_init(&d);
        sender s = {&d.rate, 1, 0};
        for (int i = 0; i < 600; i++)
            send(&s, 1, i / 60.0);
        for (int k = 0; k < held; k += 10) /* all at once */
            send(&s, 10, (600 + held - 1) / 60.0);
        assert_int_equal(s.alarms, held > 162 ? 1 : 0);
    }
    assert_true(alarm_at(120, 10, 1000) < 2.8); /* a long silence is worth no more */
}

/* Repeated, reordered and lost inputs, and those of a former connection, add nothing. */
static void only_new_inputs_count(void **state)
{
    (void)state;
    ll_detection d;
    ll_detection_init(&d);
    sender s = {&d.rate, 1, 0};
    uint32_t from = 1;
    for (int i = 0; i < 6000;
         i++) { /* a packet of the last four, in pairs that change places, one in ten lost */
        uint32_t newest = (uint32_t)(i ^ 1) + 5;
        from = newest - 3;
        if (i % 10 != 0)
            s.alarms += ll_rate_take(s.watch, 1, from, 4, 60000, (ll_time)(i / 60.0 * 1e9));
    }
    assert_int_equal(s.alarms, 0);
    assert_true(d.rate.most < 5);
    double sum = d.rate.sum;
    assert_false(ll_rate_take(s.watch, 2, 1, 16, 60000, 100 * LL_SECOND));
    assert_true(d.rate.sum == sum);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_those_of_the_ratio),
        cmocka_unit_test(trials_until_a_decision_are_as_computed),
        cmocka_unit_test(errors_are_rarer_than_promised),
        cmocka_unit_test(reactions_count_from_the_first_sight),
        cmocka_unit_test(what_is_no_reaction_is_no_trial),
        cmocka_unit_test(lost_inputs_make_no_reaction_faster),
        cmocka_unit_test(the_sum_grows_with_the_excess),
        cmocka_unit_test(silence_is_credit_up_to_a_burst),
        cmocka_unit_test(only_new_inputs_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
