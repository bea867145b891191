/* Deterministic lockstep and rollback over links with delays and outages: rates, waits and stalls. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sim/netgame/world_log.h"

static void run_to_tick(world_log *d, int64_t tick)
{
    ll_recorder r = {.record = on_event, .context = d};
    for (int k = 1; d->seen[0] < tick; k++) {
        assert_true(k < 3600);
        scene_run(d->s, k, &r);
    }
}

static void lag_does_not_change_the_result(void **state)
{
    (void)state;
    static const char *const games[] = {"contact", "cannon", "gambetta_default", "eight", "rollback_shooter"};
    for (int i = 0; i < 5 * 2; i++) {
        const char *const without[] = {
            peer_syncs[i % 2],       "server.update_hz=120", "players.0.input_delay_ticks=3",
            "players.0.script=hold", /* a shooter: aims at the other player */
            "players.0.lag_ms=0",    "players.1.lag_ms=0",   NULL};
        const char *const with[] = {peer_syncs[i % 2],
                                    "server.update_hz=120",
                                    "players.0.input_delay_ticks=3",
                                    "players.0.script=hold",
                                    "players.0.lag_ms=40",
                                    "players.1.lag_ms=90",
                                    "players.0.link.up.jitter_ms=30",
                                    "players.1.link.down.jitter_ms=30",
                                    "players.0.link.down.loss_pct=10",
                                    "players.1.link.up.loss_pct=10",
                                    NULL};
        scene a = scene_open(games[i / 2], without), b = scene_open(games[i / 2], with);
        world_log x = log_of(&a, 0), y = log_of(&b, 0);
        run_to_tick(&x, 1200);
        run_to_tick(&y, 1200);
        assert_memory_equal(x.hashes[0], y.hashes[0], 1201 * sizeof x.hashes[0][0]);
        log_free(&x);
        log_free(&y);
        int64_t rollbacks = ll_netgame_client_metrics(b.game, 0)->stepping.rollbacks +
                            ll_netgame_client_metrics(b.game, 1)->stepping.rollbacks;
        assert_true((rollbacks > 4) == (i % 2 == 1));
        scene_close(&a);
        scene_close(&b);
    }
}

/* A client that plays alone waits for no other, and is ahead of the server by the ticks of its lag: more than
 * it keeps worlds of. Those are compared with nothing, and the others equal the server's. */
static void a_client_far_ahead_alone_stays_in_step(void **state)
{
    (void)state;
    static const char *const players[] = {"players=[{\"lag_ms\":870,\"input_delay_ticks\":5}]",
                                          "players=[{\"lag_ms\":30,\"link\":{\"up\":{\"jitter_ms\":200,"
                                          "\"blackout_at_ms\":3100,\"blackout_length_ms\":1200}}}]"};
    for (int i = 0; i < 4; i++) {
        const char *const sets[] = {players[i / 2], peer_syncs[i % 2], "tick_hz=110", "params.laps=10000",
                                    NULL};
        scene s = scene_open("race", sets);
        int64_t ahead = 0;
        for (int k = 0; k < 20 * 60; k++) {
            scene_run(&s, k / 60.0, NULL);
            int64_t by = peer_of(&s, 0)->confirmed - ll_netgame_server(s.game)->step;
            ahead = by > ahead ? by : ahead;
        }
        const ll_desync *d = ll_netgame_desync(s.game, 0);
        assert_true(ahead > LL_PEER_RING);
        assert_true(d->compared > 1500);
        assert_int_equal(d->tick, -1);
        assert_true(d->error_max == 0);
        assert_int_equal(ll_netgame_server(s.game)->client_slots[0].peer.desync, -1);
        scene_close(&s);
    }
}

/* Without a timeout, or before it is reached. */
static void a_dead_link_stalls_all_clients_until_it_is_back(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        const char *const sets[] = {peer_syncs[i % 2],
                                    i < 2 ? "server.timeout_s=0" : "server.timeout_s=12",
                                    "server.update_hz=60",
                                    "players.0.lag_ms=30",
                                    "players.1.lag_ms=30",
                                    "players.0.input_delay_ticks=6",
                                    "players.1.input_delay_ticks=6",
                                    "warmup_s=0",
                                    NULL};
        scene s = scene_open("race", sets);
        ll_server *server = ll_netgame_server(s.game);
        const ll_stepping *n = &ll_netgame_client_metrics(s.game, 0)->stepping;
        scene_run(&s, 5, NULL);
        assert_int_equal(peer_of(&s, 0)->waiting, 0);
        int64_t stalls = n->stalls;
        int32_t waited = n->waited_frames[1];
        set_loss(&s, 1, 100);
        scene_run(&s, 6, NULL);
        int64_t step = server->step;
        scene_run(&s, 16, NULL);
        assert_int_equal(server->step, step);
        assert_int_equal(peer_of(&s, 0)->waiting, 1 << 1);
        assert_int_equal(n->stalls, stalls + 1);
        assert_true(n->waited_frames[1] - waited > 600);
        assert_int_equal(n->waited_frames[0], 0);
        set_loss(&s, 1, 0);
        scene_run(&s, 26, NULL);
        assert_true(server->step >= step + 590);
        assert_int_equal(peer_of(&s, 0)->waiting, 0);
        scene_close(&s);
    }
}

/* A client without packets from the server for `timeout_s` is dropped and the others continue; it detects
 * that it is alone. When its link is back it joins again, at the others' tick, and all worlds are equal as
 * before. */
static void a_silent_client_is_dropped_and_joins_again(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        const char *const sets[] = {peer_syncs[i % 2],
                                    i < 2 ? "server.timeout_s=2" : "server.timeout_s=3.5",
                                    "server.update_hz=60",
                                    "players.0.lag_ms=30",
                                    "players.1.lag_ms=50",
                                    "players.0.input_delay_ticks=6",
                                    "players.1.input_delay_ticks=6",
                                    "warmup_s=0",
                                    NULL};
        double timeout_s = i < 2 ? 2 : 3.5;
        scene s = scene_open("race", sets);
        ll_server *server = ll_netgame_server(s.game);
        const ll_connection *b = &ll_netgame_client(s.game, 1)->connection;
        scene_run(&s, 5, NULL);
        set_loss(&s, 1, 100);
        scene_run(&s, 5 + timeout_s - 0.4,
                  NULL); /* its last packet arrived a ping's interval and a delay before that */
        int64_t step = server->step;
        assert_true(step < 5.5 * 60);
        assert_int_equal(server->client_slots[1].connection.connected, 1);
        scene_run(&s, 5 + timeout_s + 0.8, NULL);
        assert_int_equal(server->client_slots[1].connection.connected, 0);
        assert_int_equal(b->state,
                         LL_CONNECTION_STALLED); /* its link down is good, but no other client sends */
        assert_int_equal(peer_of(&s, 0)->waiting, 0);
        step = server->step;
        scene_run(&s, 12.6, NULL);
        assert_true(server->step > step + (12.6 - 5 - timeout_s - 0.8) * 60 - 10);
        assert_int_equal(b->state, LL_CONNECTION_DISCONNECTED);
        set_loss(&s, 1, 0);
        scene_run(&s, 13.8, NULL); /* a retry, two round trips, five pings */
        assert_int_equal(b->state, LL_CONNECTION_PLAYING);
        assert_int_equal(server->client_slots[1].connection.connected, 1);
        assert_int_equal(b->joins, 2);
        step = server->step;
        int64_t applied = server->client_slots[1].inputs.acked;
        scene_run(&s, 20, NULL);
        assert_true(server->step > step + 6.2 * 60 - 15);
        assert_true(server->client_slots[1].inputs.acked > applied + 6.2 * 60 - 15); /* its own inputs */
        for (int p = 0; p < 2; p++) {
            assert_int_equal(server->client_slots[p].peer.desync, -1);
            assert_true(server->client_slots[p].peer.hashed > server->step - 60);
        }
        scene_close(&s);
    }
}

/* With D ticks of input delay a delay between clients costs D + 1 ticks; with M ticks to guess D + M + 1, but
 * then an input is made one frame after the step before it. */
static void rate_follows_lag_and_delay(void **state)
{
    (void)state;
    static const struct {
        const char *sync, *delay, *rollback;
        double per_s;
    } cases[] = {
        {"server.sync=deterministic", "players.0.input_delay_ticks=0", "server.max_rollback_ticks=8",
         1 / 0.2},
        {"server.sync=deterministic", "players.0.input_delay_ticks=5", "server.max_rollback_ticks=8",
         6 / 0.2},
        {"server.sync=deterministic", "players.0.input_delay_ticks=12", "server.max_rollback_ticks=8", 60},
        {"server.sync=rollback", "players.0.input_delay_ticks=0", "server.max_rollback_ticks=5",
         6 / (0.2 + 1.0 / 60)},
        {"server.sync=rollback", "players.0.input_delay_ticks=0", "server.max_rollback_ticks=16", 60},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char other[64];
        snprintf(other, sizeof other, "players.1%s", cases[i].delay + strlen("players.0"));
        const char *const sets[] = {cases[i].sync,
                                    cases[i].delay,
                                    other,
                                    cases[i].rollback,
                                    "server.update_hz=60",
                                    "players.0.lag_ms=100",
                                    "players.1.lag_ms=100",
                                    "players.0.clock_phase=0",
                                    "players.1.clock_phase=0",
                                    NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 10, NULL);
        int64_t before = ll_netgame_server(s.game)->step;
        scene_run(&s, 30, NULL);
        double per_s = (double)(ll_netgame_server(s.game)->step - before) / 20;
        assert_true(per_s > cases[i].per_s - 0.1 && per_s < cases[i].per_s + 0.1);
        scene_close(&s);
    }
}

/* A client whose frames are up to some milliseconds late makes fewer of them. The other waits a frame at
 * times for time sync; it does not run on until its prediction window is used up and it stalls. */
static void the_faster_client_waits_and_does_not_stall(void **state)
{
    (void)state;
    static const char *const jitters[] = {"players.1.timer_jitter_ms=1", "players.1.timer_jitter_ms=3"};
    for (size_t i = 0; i < sizeof jitters / sizeof jitters[0]; i++) {
        const char *const sets[] = {"server.sync=rollback",
                                    "server.max_rollback_ticks=8",
                                    "server.update_hz=60",
                                    "players.0.lag_ms=30",
                                    "players.1.lag_ms=30",
                                    jitters[i],
                                    NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 60, NULL);
        const ll_client_metrics *faster = ll_netgame_client_metrics(s.game, 0);
        assert_true(faster->stepping.stalls <= 12);
        assert_true(faster->stepping.time_sync_frames > 60);
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lag_does_not_change_the_result),
        cmocka_unit_test(a_client_far_ahead_alone_stays_in_step),
        cmocka_unit_test(a_dead_link_stalls_all_clients_until_it_is_back),
        cmocka_unit_test(a_silent_client_is_dropped_and_joins_again),
        cmocka_unit_test(rate_follows_lag_and_delay),
        cmocka_unit_test(the_faster_client_waits_and_does_not_stall),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
