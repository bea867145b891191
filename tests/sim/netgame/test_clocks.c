/* Clocks: machines that drift, random phases, different rates; and the waits of an input, to the
 * nanosecond. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "base/rng.h"
#include "support/near.h"
#include "support/scene.h"

#if defined(__SANITIZE_ADDRESS__) || !defined(__OPTIMIZE__)
#define SLOW 1
#else
#define SLOW 0
#endif

static double draw(uint64_t number, int k, double low, double high)
{
    return low + (high - low) * ll_rng_unit(41, (uint64_t)k, number);
}

static scene race(const char *format, ...)
{
    char text[1500];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return scene_make(text, NULL);
}

static ll_summary felt(const scene *s, int player)
{
    return ll_histogram_summary(
        &ll_netgame_client_metrics(s->game, player)->histogram[LL_METRIC_INPUT_LATENCY]);
}

static double acknowledged_ms(const scene *s, int player)
{
    return ll_histogram_summary(&ll_netgame_client_metrics(s->game, player)->histogram[LL_METRIC_ACK_RTT])
        .mean;
}

static int64_t refused(const scene *s, int player)
{
    int64_t sum = 0;
    for (int rule = 1; rule < LL_RULES; rule++)
        sum += ll_netgame_server(s->game)->client_slots[player].counts.refused[rule];
    return sum;
}

/* ---- drift ---- */

/* An hour on machines that are too fast and too slow: inputs stay in time, none is refused, and the
 * prediction is right whenever an input was in time. 100 ppm are a tick in 167 s. */
static void an_hour_of_drift_is_followed(void **state)
{
    (void)state;
    static const double ppm[] = {100, -100, 500, -500};
    for (int i = 0; i < (SLOW ? 1 : 4); i++) {
        scene s = race("{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":3600,\"seed\":%d,"
                       "\"params\":{\"laps\":10000},\"server\":{\"update_hz\":20},\"players\":["
                       "{\"lag_ms\":83,\"drift_ppm\":%g,\"prediction\":true,\"reconciliation\":true},"
                       "{\"lag_ms\":40,\"drift_ppm\":%g,\"interpolation\":true}]}",
                       7 + i, ppm[i], -ppm[i]);
        scene_run(&s, 3600, NULL);
        for (int p = 0; p < 2; p++) {
            const ll_client_metrics *in = ll_netgame_client_metrics(s.game, p);
            double slips = 3600 * 60 * 500e-6 + 1;
            assert_int_equal(refused(&s, p), 0);
            assert_true(in->input_history.slack.min >= -1 && in->input_history.slack.max <= 3);
            assert_true((double)in->input_history.count[LL_INPUT_CAME_LATE] <= slips);
            assert_near(ll_to_ms(ll_netgame_client(s.game, p)->connection.clock.offset +
                                 (ll_time)(3600e9 * (p == 0 ? ppm[i] : -ppm[i]) * 1e-6)),
                        0, 1);
            assert_int_equal(ll_netgame_client(s.game, p)->connection.time_outs, 0);
        }
        scene_close(&s);
    }
}

/* ---- waits of an input ---- */

/* The first time of a grid of `period_ms` from `phase_ms` on that is not before `t`. */
static double next_on(double period_ms, double phase_ms, double t)
{
    return phase_ms + period_ms * ceil((t - phase_ms) / period_ms - 1e-9);
}

/* Made at a tick of the client, applied at the first step after its delay (and the slack), sent with it,
 * back, and drawn at the client's next display. */
static double expected_ms(double lag, double phase, int slack, double tick)
{
    double made = phase * tick;
    double step = larger(tick, next_on(tick, 0, made + lag) + slack * tick); /* the first is at `tick` */
    return next_on(tick, made, step + lag) - made;
}

static void latency_without_prediction_is_the_round_trip_and_the_waits(void **state)
{
    (void)state;
    for (uint64_t n = 0; n < (SLOW ? 10 : 100); n++) {
        static const double rates[] = {20, 30, 50, 60, 100, 125};
        double lag = floor(draw(n, 0, 0, 600)) + 0.25, phase = draw(n, 1, 0.05, 0.95),
               hz = rates[(int)draw(n, 2, 0, 6)];
        int slack = (int)draw(n, 3, 0, 4);
        scene s = race("{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":60,\"seed\":%d,\"tick_hz\":%g,"
                       "\"params\":{\"laps\":10000},\"server\":{\"update_hz\":%g},\"players\":["
                       "{\"lag_ms\":%g,\"clock_phase\":%.9f,\"slack_ticks\":%d}]}",
                       (int)n + 1, hz, hz, lag, phase, slack);
        scene_run(&s, 20, NULL);
        ll_summary got = felt(&s, 0);
        assert_true(got.count > 5);
        double want = expected_ms(lag, phase, slack, 1000 / hz);
        if (!is_near(got.mean, want, 1e-3) || !(got.max - got.mean <= 1e-3))
            fail_msg("lag %g phase %g slack %d at %g Hz: %.6f ms (most %.6f) instead of %.6f", lag, phase,
                     slack, hz, got.mean, got.max, want);
        scene_close(&s);
    }
}

/* ---- a sweep over lag ---- */

#define LAG_MAX 300
#define PHASES (SLOW ? 3 : 24)

static double latency_at(int lag, int seed, const char *phase)
{
    scene s = race("{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":60,\"seed\":%d,"
                   "\"params\":{\"laps\":10000},\"players\":[{\"lag_ms\":%d%s}]}",
                   seed, lag, phase);
    scene_run(&s, 12, NULL);
    double mean = felt(&s, 0).mean;
    scene_close(&s);
    return mean;
}

typedef struct line {
    double slope, offset, worst;
} line;

static line fit(const double *x, const double *y, int n)
{
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (int i = 0; i < n; i++) {
        sx += x[i];
        sy += y[i];
        sxx += x[i] * x[i];
        sxy += x[i] * y[i];
    }
    line l = {.slope = (n * sxy - sx * sy) / (n * sxx - sx * sx)};
    l.offset = (sy - l.slope * sx) / n;
    for (int i = 0; i < n; i++)
        l.worst = larger(l.worst, fabs(y[i] - l.offset - l.slope * x[i]));
    return l;
}

static void latency_is_a_line_over_lag_with_drawn_phases_and_a_staircase_without(void **state)
{
    (void)state;
    double lag[LAG_MAX + 1], drawn[LAG_MAX + 1], aligned[LAG_MAX + 1];
    int n = 0, treads = 0, step = SLOW ? 25 : 1;
    for (int l = 0; l <= LAG_MAX; l += step, n++) {
        lag[n] = l;
        drawn[n] = 0;
        for (int k = 0; k < PHASES; k++)
            drawn[n] += latency_at(l, 1 + l * PHASES + k, "") / PHASES;
        aligned[n] = latency_at(l, 1, ",\"clock_phase\":0");
        treads += n > 0 && fabs(aligned[n] - aligned[n - 1]) < 1e-9;
    }
    line fitted = fit(lag, drawn, n);
    printf("random phases: %.4f ms per ms of lag, %.2f ms at 0, at most %.2f ms off the line\n", fitted.slope,
           fitted.offset, fitted.worst);
    if (!SLOW) {
        assert_near(fitted.slope, 2, 0.01);
        assert_true(fitted.worst < 1000.0 / 60 / 2);
        assert_true(treads > 0.8 * n); /* the same for most steps of a ms */
        printf("phase 0: the same for %d of %d steps of a ms\n", treads, n - 1);
    }
}

/* ---- rates ---- */

/* A player that draws and sends at rates of its own plays the same game: the server's world is bitwise equal
 * when inputs arrive in time, and no view's mean age changes by more than half a period of its displays. */
static void displays_and_sending_change_only_the_views(void **state)
{
    (void)state;
    static const char *const sets[] = {"", ",\"display_hz\":240", ",\"display_hz\":90", ",\"display_hz\":31"};
    double age[4];
    uint64_t world[4];
    for (int k = 0; k < 4; k++) {
        scene s = race("{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":60,\"seed\":5,\"players\":["
                       "{\"lag_ms\":70%s},{\"lag_ms\":33}]}",
                       sets[k]);
        scene_run(&s, 30, NULL);
        const ll_world *w = ll_server_world(ll_netgame_server(s.game));
        world[k] = 0;
        for (int i = 0; i < 2; i++)
            world[k] = world[k] * 31 + (uint64_t)(w->entity[i].x * 1e9);
        age[k] =
            ll_histogram_summary(&ll_netgame_client_metrics(s.game, 0)->histogram[LL_METRIC_VIEW_AGE]).mean;
        scene_close(&s);
        assert_true(world[k] == world[0]);
        static const double hz[] = {60, 240, 90, 31};
        assert_near(age[k], age[0], 1000 / hz[k] / 2 + 1000.0 / 60 / 2);
    }
}

static void slow_senders_are_as_much_later(void **state)
{
    (void)state;
    scene s = race("{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":60,\"seed\":5,\"players\":["
                   "{\"lag_ms\":70,\"send_hz\":20},{\"lag_ms\":70}]}");
    scene_run(&s, 30, NULL);
    for (int p = 0; p < 2; p++) {
        const ll_client_metrics *in = ll_netgame_client_metrics(s.game, p);
        double packets = (double)in->traffic.messages[LL_MESSAGE_INPUT] / 28;
        assert_near(packets, (p == 0 ? 20 : 60), 0.5);
        assert_true(in->input_history.count[LL_INPUT_CAME_LATE] + in->input_history.count[LL_INPUT_WAS_LOST] <
                    12);
    }
    double more =
        acknowledged_ms(&s, 0) - acknowledged_ms(&s, 1); /* of three inputs in a packet the first waits */
    assert_true(more > 2 * 1000.0 / 60 - 17 && more < 2 * 1000.0 / 60 + 17);
    scene_close(&s);
}

/* Devices shift the input latency by their own delay, and change nothing else. */
static void devices_shift_latency_by_their_own(void **state)
{
    (void)state;
    scene a = race(
        "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":200,\"seed\":5,\"params\":{\"laps\":10000},"
        "\"players\":[{\"lag_ms\":70},{\"lag_ms\":20}]}");
    scene b = race(
        "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":200,\"seed\":5,\"params\":{\"laps\":10000},"
        "\"players\":[{\"lag_ms\":70,\"input_device_ms\":12.5,\"input_hz\":125,\"display_device_ms\":31},"
        "{\"lag_ms\":20}]}");
    scene_run(&a, 200, NULL);
    scene_run(&b, 200, NULL);
    double mean = 12.5 + 4 + 31, deviation = 8 / sqrt(12) / sqrt((double)felt(&b, 0).count);
    assert_near(felt(&b, 0).mean - felt(&a, 0).mean, mean, 4 * deviation);
    assert_true(felt(&b, 0).max - felt(&a, 0).max <= 12.5 + 8 + 31 + 1e-6);
    assert_true(felt(&b, 1).mean == felt(&a, 1).mean);
    assert_true(ll_server_world(ll_netgame_server(a.game))->entity[0].x ==
                ll_server_world(ll_netgame_server(b.game))->entity[0].x);
    scene_close(&a);
    scene_close(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_hour_of_drift_is_followed),
        cmocka_unit_test(latency_without_prediction_is_the_round_trip_and_the_waits),
        cmocka_unit_test(latency_is_a_line_over_lag_with_drawn_phases_and_a_staircase_without),
        cmocka_unit_test(displays_and_sending_change_only_the_views),
        cmocka_unit_test(slow_senders_are_as_much_later),
        cmocka_unit_test(devices_shift_latency_by_their_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
