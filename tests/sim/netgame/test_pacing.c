/* Peers that pace by fractions of a tick: frames that are lengthened in place of frames that are left out,
 * and an input delay that follows the delay of the links. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "sim/netgame/readings.h"
#include "sim/netgame/world_log.h"
#include "support/near.h"

#define TICK (1.0 / 60)

static const char *const ways[] = {"peers.topology=relay", "peers.topology=mesh"};

static const ll_stepping *stepping_of(const scene *s, int player)
{
    return &ll_netgame_client_metrics(s->game, player)->stepping;
}

/* Ticks made, with the part of the next that has passed. */
static double position(const scene *s, int player)
{
    const ll_client *c = ll_netgame_client(s->game, player);
    return (double)peer_of(s, player)->tick +
           (double)(s->game->now - c->ticks.last) / (double)c->ticks.period;
}

/* ---- time sync ---- */

static void equal_clients_keep_their_frames(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const char *const sets[] = {ways[i],
                                    "peers.time_sync=stretch",
                                    "players.0.clock_phase=0.3",
                                    "players.1.clock_phase=0.3",
                                    "server.update_hz=60",
                                    NULL};
        scene s = scene_open("rollback", sets);
        scene_run(&s, 30, NULL);
        for (int p = 0; p < 2; p++) {
            assert_true(ll_netgame_choices(s.game, p)->stretched == 0);
            assert_int_equal(stepping_of(&s, p)->time_sync_frames, 0);
            assert_int_equal(peer_of(&s, p)->tick, (int64_t)(30 * 60));
        }
        scene_close(&s);
    }
}

/* One machine pauses for four frames. The other then leaves out frames, or makes each at most a tenth longer:
 * 40 of them, after the reports of some round trips. What it was ahead is gone in both cases, but for half a
 * tick. */
static void a_lead_is_taken_back_without_a_frame_left_out(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        const bool stretches = i / 2;
        const char *const sets[] = {ways[i % 2],
                                    stretches ? "peers.time_sync=stretch" : "peers.time_sync=wait",
                                    "players.0.clock_phase=0",
                                    "players.1.clock_phase=0",
                                    "players.0.lag_ms=30", /* the prediction window is not used up */
                                    "players.1.lag_ms=30",
                                    "server.update_hz=60",
                                    NULL};
        scene s = scene_open("rollback", sets);
        scene_run(&s, 5, NULL);
        ll_client_ticks *late = &ll_netgame_client(s.game, 1)->ticks;
        const ll_client_ticks *fast = &ll_netgame_client(s.game, 0)->ticks;
        const int64_t held = stepping_of(&s, 0)->time_sync_frames + stepping_of(&s, 0)->stalled_frames;
        late->clock.epoch += 4 * late->period;
        ll_time longest = 0;
        int64_t made = 0, before = peer_of(&s, 0)->tick, left_out = 0;
        for (int k = 1; k <= 6000; k++) {
            scene_run(&s, 5 + k / 1000.0, NULL);
            longest = fast->elapsed > longest ? fast->elapsed : longest;
            if (fast->number != made) {
                left_out += made != 0 && peer_of(&s, 0)->tick == before;
                before = peer_of(&s, 0)->tick;
                made = fast->number;
            }
        }
        double lead = position(&s, 0) - position(&s, 1);
        assert_true(lead > -0.6 && lead < (stretches ? 0.6 : 1.6));
        assert_int_equal(left_out,
                         stepping_of(&s, 0)->time_sync_frames + stepping_of(&s, 0)->stalled_frames - held);
        if (stretches) {
            double stretched = ll_netgame_choices(s.game, 0)->stretched;
            assert_int_equal(left_out, 0);
            assert_true(stretched > 3.4 && stretched < 4.1);
            assert_true(longest > 1.099 * (double)fast->period && longest <= 1.1 * (double)fast->period + 2);
            assert_true(ll_netgame_choices(s.game, 1)->stretched == 0);
        } else {
            assert_true(left_out >= 2);
            assert_true(longest <= fast->period + 2);
        }
        scene_close(&s);
    }
}

/* Frames of one machine are late by up to 3 ms, 9 % on average: the other keeps up with it by longer frames,
 * and neither runs on until it must wait. */
static void a_slower_machine_is_followed(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const char *const sets[] = {ways[i],
                                    "peers.time_sync=stretch",
                                    "server.max_rollback_ticks=8",
                                    "server.update_hz=60",
                                    "players.0.lag_ms=30",
                                    "players.1.lag_ms=30",
                                    "players.1.timer_jitter_ms=3",
                                    NULL};
        scene s = scene_open("race", (const char *const[]){"server.sync=rollback", sets[0], sets[1], sets[2],
                                                           sets[3], sets[4], sets[5], sets[6], NULL});
        double most = 0;
        scene_run(&s, 3, NULL);
        for (int k = 0; k < 60 * 57; k++) {
            scene_run(&s, 3 + k * TICK, NULL);
            double lead = position(&s, 0) - position(&s, 1);
            most = larger(most, lead);
        }
        assert_int_equal(stepping_of(&s, 0)->stalls, 0);
        assert_int_equal(stepping_of(&s, 0)->time_sync_frames, 0);
        assert_true(most < 4);
        assert_true(ll_netgame_choices(s.game, 0)->stretched > 60 * 57 * 0.07);
        scene_close(&s);
    }
}

/* ---- adaptive input delay ---- */

static int64_t delay_of(const scene *s, int player)
{
    return ll_netgame_choices(s->game, player)->delay;
}

/* On clean links the delay is that of the two links in ticks, rounded up, less the budget, 0 to 8; and no
 * rollback resimulates more than the budget, where 8 ticks suffice. */
static void the_delay_follows_from_the_links(void **state)
{
    (void)state;
    static const int lags[] = {0, 1, 20, 40, 50, 63, 79, 90, 120};
    static const int budgets[] = {0, 1, 3, 6};
    for (int i = 0; i < 9 * 4; i++) {
        char a[40], b[40], budget[48];
        snprintf(a, sizeof a, "players.0.lag_ms=%d", lags[i % 9]);
        snprintf(b, sizeof b, "players.1.lag_ms=%d", lags[i % 9]);
        snprintf(budget, sizeof budget, "peers.delay_budget_ticks=%d", budgets[i / 9]);
        const char *const sets[] = {"peers.adaptive_delay=true",
                                    "peers.topology=mesh",
                                    "players.0.clock_phase=0",
                                    "players.1.clock_phase=0",
                                    "server.max_rollback_ticks=16",
                                    "warmup_s=6",
                                    a,
                                    b,
                                    budget,
                                    NULL};
        scene s = scene_open("rollback", sets);
        scene_run(&s, 14, NULL);
        int64_t ticks = (int64_t)ceil(2 * lags[i % 9] / (1000 * TICK) - 1e-9), delay = ticks - budgets[i / 9];
        delay = delay < 0 ? 0 : delay > 8 ? 8 : delay;
        for (int p = 0; p < 2; p++) {
            if (delay_of(&s, p) != delay)
                fail_msg("lag %d, budget %d: %d instead of %d", lags[i % 9], budgets[i / 9],
                         (int)delay_of(&s, p), (int)delay);
            assert_int_equal(ll_netgame_choices(s.game, p)->delay_changes, 0);
            if (ticks == 0) /* an input comes with the tick that needs it, after it */
                continue;
            if (ticks <= 8 + budgets[i / 9])
                assert_int_equal(ll_netgame_choices(s.game, p)->deep, 0);
            assert_true(stepping_of(&s, p)->rollback_ticks_max <= ticks - delay);
        }
        scene_close(&s);
    }
}

/* A delay that begins at 8 falls to that: 120 ms are 8 ticks, rounded up, less 3. A difference of one stays.
 */
static void a_long_delay_falls(void **state)
{
    (void)state;
    {
        const char *const sets[] = {"peers.adaptive_delay=true",
                                    "peers.topology=mesh",
                                    "players.0.input_delay_ticks=8",
                                    "players.1.input_delay_ticks=6",
                                    "players.0.clock_phase=0",
                                    "players.1.clock_phase=0",
                                    "warmup_s=0",
                                    NULL};
        scene s = scene_open("rollback", sets);
        scene_run(&s, 25, NULL);
        assert_int_equal(delay_of(&s, 0), 6);
        assert_int_equal(delay_of(&s, 1), 6);
        assert_int_equal(ll_netgame_choices(s.game, 0)->delay_changes, 1);
        assert_int_equal(ll_netgame_choices(s.game, 1)->delay_changes, 0);
        scene_close(&s);
    }
}

/* With jitter at most one rollback in twenty is deeper than the budget, and the delay does not go to and fro.
 */
static void jitter_deepens_few_rollbacks_and_moves_the_delay_once(void **state)
{
    (void)state;
    for (int i = 0; i < 6; i++) {
        char seed[24];
        snprintf(seed, sizeof seed, "seed=%d", 1 + i);
        const char *const sets[] = {"peers.adaptive_delay=true",
                                    ways[i % 2],
                                    "server.max_rollback_ticks=16",
                                    i % 3 == 2 ? "peers.time_sync=stretch" : "peers.time_sync=wait",
                                    "server.update_hz=60",
                                    "params.laps=10000",
                                    "warmup_s=10",
                                    "players.0.link.up.jitter_ms=25",
                                    "players.1.link.up.jitter_ms=25",
                                    "players.0.lag_ms=30",
                                    "players.1.lag_ms=30",
                                    seed,
                                    NULL};
        scene s = scene_open("rollback", sets);
        int64_t turns[2] = {0}, way[2] = {0}, before[2];
        scene_run(&s, 10, NULL);
        for (int p = 0; p < 2; p++)
            before[p] = delay_of(&s, p);
        for (int k = 1; k <= 4 * 90; k++) {
            scene_run(&s, 10 + k * 0.25, NULL);
            for (int p = 0; p < 2; p++) {
                int64_t by = delay_of(&s, p) - before[p];
                turns[p] += by * way[p] < 0;
                way[p] = by != 0 ? by : way[p];
                before[p] = delay_of(&s, p);
            }
        }
        for (int p = 0; p < 2; p++) {
            const ll_peer_choices *choices = ll_netgame_choices(s.game, p);
            double deep = (double)choices->deep / (double)stepping_of(&s, p)->rollbacks;
            if (!(stepping_of(&s, p)->rollbacks > 20 && deep <= 0.05 && turns[p] == 0 &&
                  choices->delay <= 4 && choices->delay_changes <= 2))
                fail_msg("run %d: %d rollbacks, %g deep, %d turns, %d changes, delay %d", i,
                         (int)stepping_of(&s, p)->rollbacks, deep, (int)turns[p], (int)choices->delay_changes,
                         (int)choices->delay);
        }
        scene_close(&s);
    }
}

/* Scripts act by the world before the longest delay, so the outcome does not depend on the delay in use. */
static void the_outcome_is_that_of_any_links(void **state)
{
    (void)state;
    for (int i = 0; i < 2 * 2; i++) {
        const char *const none[] = {peer_syncs[i % 2],
                                    ways[0],
                                    "peers.adaptive_delay=true",
                                    "server.update_hz=60",
                                    "players.0.lag_ms=0",
                                    "players.1.lag_ms=0",
                                    NULL};
        const char *const bad[] = {peer_syncs[i % 2],
                                   ways[i / 2],
                                   "peers.adaptive_delay=true",
                                   "peers.time_sync=stretch",
                                   "peers.delay_budget_ticks=1",
                                   "players.0.lag_ms=60",
                                   "players.1.lag_ms=30",
                                   "players.0.link.up.jitter_ms=30",
                                   "players.1.link.down.loss_pct=10",
                                   NULL};
        scene a = scene_open("contact", none), b = scene_open("contact", bad);
        world_log x = log_of(&a, 0), y = log_of(&b, 0);
        run(&x, 0, 30);
        run(&y, 0, 30);
        int64_t ticks = x.seen[0] < y.seen[0] ? x.seen[0] : y.seen[0];
        assert_true(ticks > 1400);
        assert_memory_equal(x.hashes[0], y.hashes[0], (size_t)(ticks + 1) * sizeof x.hashes[0][0]);
        assert_true(delay_of(&b, 0) > 0);
        for (int p = 0; p < 2; p++)
            assert_int_equal(ll_netgame_desync(b.game, p)->tick, -1);
        log_free(&x);
        log_free(&y);
        scene_close(&a);
        scene_close(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_clients_keep_their_frames),
        cmocka_unit_test(a_lead_is_taken_back_without_a_frame_left_out),
        cmocka_unit_test(a_slower_machine_is_followed),
        cmocka_unit_test(the_delay_follows_from_the_links),
        cmocka_unit_test(a_long_delay_falls),
        cmocka_unit_test(jitter_deepens_few_rollbacks_and_moves_the_delay_once),
        cmocka_unit_test(the_outcome_is_that_of_any_links),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
