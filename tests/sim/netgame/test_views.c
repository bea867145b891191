/* The scenarios of rendered views: each technique has an effect, and the intended one. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/near.h"
#include "support/scene.h"

static const ll_client_metrics *of(const scene *s, int player)
{
    return ll_netgame_client_metrics(s->game, player);
}

static ll_summary summary(const scene *s, int player, ll_metric metric)
{
    return ll_histogram_summary(&of(s, player)->histogram[metric]);
}

static double mean(const ll_running_stats *g)
{
    return g->sum / (double)g->count;
}

static scene run_whole(const char *id, const char *const *sets)
{
    scene s = scene_open(id, sets);
    scene_run_whole(&s);
    return s;
}

/* Jitter J needs a delay of an interval + 2 J relative to the fastest snapshot: 190 ms of the 210 that A
 * has. */
static void two_intervals_ride_out_jitter(void **state)
{
    (void)state;
    scene s = run_whole("interpolation_jitter", NULL);
    assert_true(of(&s, 0)->buffer.underruns == 0 && of(&s, 0)->buffer.held_frames == 0);
    assert_true(of(&s, 0)->track[1].smooth.frozen == 0);
    assert_true(of(&s, 1)->buffer.underruns > 100);
    scene_close(&s);
}

/* The same path and delay: the chord is off by at most a dt^2 / 8, a being 6 m/s2, the brake's 9, and drag;
 * the cubic only where the pedal changes in between. */
static void cubics_are_nearer_than_chords(void **state)
{
    (void)state;
    scene s = run_whole("hermite", NULL);
    ll_summary chord = summary(&s, 0, LL_METRIC_TIMELINE_ERROR),
               cubic = summary(&s, 1, LL_METRIC_TIMELINE_ERROR);
    assert_true(chord.max < (9 + 0.3 * 16) / 16 / 8);
    assert_true(cubic.rms < chord.rms / 10);
    scene_close(&s);
}

/* 30 snapshots per second, ratio 2 and 10 ms of margin: at the end of each interval the newest snapshot is at
 * least 43 ms ahead. So silences of 0.2 and 0.5 s leave nothing to draw for 157 to 190 and 457 to 490 ms, and
 * A bridges 400. */
static void silences_are_bridged_up_to_the_cap(void **state)
{
    (void)state;
    scene s = run_whole("extrapolation_silence", NULL);
    const ll_client_metrics *a = of(&s, 0), *b = of(&s, 1);
    double bridged = (double)a->buffer.extrapolated_frames / 60, waited = (double)a->buffer.held_frames / 60,
           alone = (double)b->buffer.held_frames / 60;
    /* A's wait at the limit counts as extrapolated too: it stands where extrapolation has put it. */
    assert_near(bridged, alone, 3 * 0.05);
    assert_near(bridged - waited, (0.175 + 0.4 + 0.4), 0.06);
    assert_true(a->buffer.underruns == 3 && b->buffer.underruns == 3);
    /* More than 250 ms behind: also after 0.5 s, where nothing was bridged. */
    assert_true(a->buffer.overruns == 1 && b->buffer.overruns == 2);
    assert_true(summary(&s, 0, LL_METRIC_POP).max > 0.01 && summary(&s, 1, LL_METRIC_POP).max == 0);
    scene_close(&s);
}

/* Extrapolated to the present: nearer to the present truth by the time that it is less late; worse on its own
 * timeline. By the measured clock it is not late at all on a symmetric link, by arrival one delay. */
static void dead_reckoning_trades_lateness_for_error(void **state)
{
    (void)state;
    const char *const arrival[] = {"players.1.extrapolation_clock=arrival", NULL};
    scene s = run_whole("dead_reckoning", arrival);
    assert_near(summary(&s, 1, LL_METRIC_VIEW_AGE).mean, 80, 0.1);
    assert_true(summary(&s, 1, LL_METRIC_REMOTE_ERROR).rms < summary(&s, 0, LL_METRIC_REMOTE_ERROR).rms / 3);
    scene_close(&s);
    s = run_whole("dead_reckoning", NULL);
    assert_true(summary(&s, 1, LL_METRIC_VIEW_AGE).max < 0.001);
    assert_true(summary(&s, 1, LL_METRIC_REMOTE_ERROR).rms < summary(&s, 0, LL_METRIC_REMOTE_ERROR).rms / 3);
    assert_true(summary(&s, 1, LL_METRIC_TIMELINE_ERROR).rms >
                3 * summary(&s, 0, LL_METRIC_TIMELINE_ERROR).rms);
    assert_true(of(&s, 1)->server.sum < of(&s, 0)->server.sum);
    scene_close(&s);
}

/* On the even link it is one interval and the margin. While the link was bad it had a third of the under-runs
 * of two fixed intervals; on the whole it is less late. */
static void adaptive_delays_match_the_link(void **state)
{
    (void)state;
    int64_t adaptive = 0, fixed = 0;
    for (int tenths = 0; tenths < 10;
         tenths++) { /* of the clocks' phase: it determines how often a display narrowly misses a snapshot */
        char a[48], b[48];
        snprintf(a, sizeof a, "players.0.clock_phase=0.%d", tenths);
        snprintf(b, sizeof b, "players.1.clock_phase=0.%d", tenths);
        const char *const sets[] = {a, b, NULL};
        scene s = run_whole("adaptive_delay", sets);
        assert_near(ll_to_ms(ll_netgame_client(s.game, 0)->view.delay), (1000.0 / 30 + 10), 0.001);
        assert_true(of(&s, 0)->buffer.underruns < of(&s, 1)->buffer.underruns);
        assert_true(tenths > 0 || of(&s, 0)->buffer.underruns < of(&s, 1)->buffer.underruns / 3);
        assert_true(mean(&of(&s, 0)->buffer.delay_ms) < mean(&of(&s, 1)->buffer.delay_ms));
        adaptive += of(&s, 0)->buffer.underruns;
        fixed += of(&s, 1)->buffer.underruns;
        scene_close(&s);
    }
    assert_true(adaptive < fixed / 3);
}

/* 60 ms more lag leave 17 ms too few in a buffer of 77: A, which follows its target exactly, has an under-run
 * at every snapshot; B, which tolerates 33 ms behind, one or two. */
static void catching_up_calmly_leaves_something_in_stock(void **state)
{
    (void)state;
    scene s = run_whole("time_scale", NULL);
    assert_near(of(&s, 0)->buffer.time_scale.max, 1.1, 1e-6);
    assert_near(of(&s, 1)->buffer.time_scale.max, 1.02, 1e-6);
    assert_true(of(&s, 0)->buffer.underruns > 60 && of(&s, 1)->buffer.underruns <= 2);
    assert_true(of(&s, 1)->track[0].smooth.acceleration < of(&s, 0)->track[1].smooth.acceleration);
    scene_close(&s);
}

/* Smoothing affects the view alone: the server's world and the clients' predictions are bitwise the same. */
static void smoothing_leaves_the_state_alone(void **state)
{
    (void)state;
    /* a seed with hard impacts between the cars: after a small correction a drawn car moves more by its own
     * speed */
    const char *const smooth[] = {"seed=2", NULL}, *const snap[] = {"seed=2", "players.1.correction=snap",
                                                                    NULL};
    scene a = run_whole("smoothing", smooth), b = run_whole("smoothing", snap);
    ll_world *wa = ll_server_world(ll_netgame_server(a.game)),
             *wb = ll_server_world(ll_netgame_server(b.game));
    assert_memory_equal(wa, wb, ll_world_size(wa));
    for (int p = 0; p < 2; p++)
        assert_memory_equal(ll_client_predicted(ll_netgame_client(a.game, p)),
                            ll_client_predicted(ll_netgame_client(b.game, p)), ll_world_size(wa));
    assert_true(of(&a, 1)->corrections.count == of(&b, 1)->corrections.count &&
                of(&a, 1)->corrections.count > 50);
    /* A frame shows 1 - 2^(-(16.7 / 100)) = 0.109 of the present error, to which several snapshots'
     * corrections add. */
    assert_true(summary(&a, 1, LL_METRIC_POP).max < summary(&b, 1, LL_METRIC_POP).max / 5);
    scene_close(&a);
    scene_close(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_intervals_ride_out_jitter),
        cmocka_unit_test(cubics_are_nearer_than_chords),
        cmocka_unit_test(silences_are_bridged_up_to_the_cap),
        cmocka_unit_test(dead_reckoning_trades_lateness_for_error),
        cmocka_unit_test(adaptive_delays_match_the_link),
        cmocka_unit_test(catching_up_calmly_leaves_something_in_stock),
        cmocka_unit_test(smoothing_leaves_the_state_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
