/* A mesh next to the relay: the same settled world, N - 1 copies up, one direct path, and players who leave.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "netcode/protocol/packet.h"
#include "sim/netgame/readings.h"
#include "sim/netgame/world_log.h"
#include "support/near.h"
#include "support/netgame_valid.h"

#define MESH "peers.topology=mesh"

/* The first tick at which a client's world differs from the server's; -1: none. */
static int64_t first_difference(const world_log *d, int player)
{
    int64_t end = d->seen[0] < d->seen[1 + player] ? d->seen[0] : d->seen[1 + player];
    for (int64_t tick = 1; tick <= end; tick++)
        if (d->hashes[0][tick] != d->hashes[1 + player][tick])
            return tick;
    return -1;
}

static void assert_in_step(const scene *s)
{
    const char *broken = netgame_broken(s->game);
    if (broken)
        fail_msg("%s", broken);
    for (int p = 0; p < s->game->config.player_count; p++) {
        const ll_peer_status *known = &ll_netgame_server(s->game)->client_slots[p].peer;
        assert_int_equal(known->desync, -1);
        assert_int_equal(ll_netgame_desync(s->game, p)->tick, -1);
        assert_true(known->hashed > ll_netgame_server(s->game)->step - 100);
        assert_int_equal(ll_link_get_stats(ll_netgame_up(s->game, p))->overflowed, 0);
        assert_int_equal(ll_link_get_stats(ll_netgame_down(s->game, p))->overflowed, 0);
    }
}

#define BAD_LINKS                                                                                            \
    "players.0.lag_ms=40", "players.1.lag_ms=90", "players.0.link.up.jitter_ms=30",                          \
        "players.1.link.down.jitter_ms=30", "players.0.link.down.loss_pct=10",                               \
        "players.1.link.up.loss_pct=10", "players.1.link.up.duplicate_pct=10"

/* For every loss, jitter and duplicate of the links. */
static void the_settled_world_is_that_of_the_relay(void **state)
{
    (void)state;
    static const char *const games[] = {"contact", "cannon", "rollback_shooter", "eight"};
    for (int i = 0; i < 4 * 2; i++) {
        const char *const relay[] = {peer_syncs[i % 2],
                                     "server.update_hz=60",
                                     "players.0.input_delay_ticks=3",
                                     "players.0.script=hold",
                                     BAD_LINKS,
                                     NULL};
        const char *const mesh[] = {peer_syncs[i % 2],
                                    "server.update_hz=20",
                                    "players.0.input_delay_ticks=3",
                                    "players.0.script=hold",
                                    MESH,
                                    BAD_LINKS,
                                    NULL};
        scene a = scene_open(games[i / 2], relay), b = scene_open(games[i / 2], mesh);
        world_log x = log_of(&a, 0), y = log_of(&b, 0);
        const int seconds = i / 2 < 3 ? 20 : 8;
        run(&x, 0, seconds);
        run(&y, 0, seconds);
        int64_t ticks = x.seen[0] < y.seen[0] ? x.seen[0] : y.seen[0];
        assert_true(ticks > (i / 2 < 3 ? 100 : 10));
        assert_memory_equal(x.hashes[0], y.hashes[0], (size_t)(ticks + 1) * sizeof x.hashes[0][0]);
        for (int p = 0; p < b.game->config.player_count; p++) {
            assert_int_equal(first_difference(&y, p), -1);
            assert_true(y.seen[1 + p] > y.seen[0] - 40);
        }
        assert_in_step(&b);
        log_free(&x);
        log_free(&y);
        scene_close(&a);
        scene_close(&b);
    }
}

/* ---- bandwidth ---- */

enum { CROWD = 5 };

static scene crowd(int players, const char *const *sets)
{
    char text[1024], *at = text, *end = text + sizeof text;
    at += snprintf(at, (size_t)(end - at),
                   "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":60,\"server\":{\"sync\":"
                   "\"deterministic\",\"update_hz\":10},\"players\":[");
    for (int p = 0; p < players; p++)
        at += snprintf(at, (size_t)(end - at), "%s{\"lag_ms\":50,\"clock_phase\":0,\"input_delay_ticks\":8}",
                       p ? "," : "");
    snprintf(at, (size_t)(end - at), "]}");
    return scene_make(text, sets);
}

/* Bytes of inputs from the warm-up on, by sender and receiver; a packet to the server has receiver 0. */
typedef struct copies {
    int64_t bytes[CROWD][CROWD], count[CROWD][CROWD];
} copies;

static void count_copy(void *context, const void *row)
{
    copies *all = context;
    const ll_packet *packet = row;
    ll_peer_message m;
    memcpy(&m, packet->bytes, sizeof m.head);
    if (!packet->up || m.head.type != LL_MESSAGE_INPUT || packet->sent < 2 * LL_SECOND)
        return;
    memcpy(&m, packet->bytes, sizeof m);
    int to = m.other > 0 ? m.other - 1 : 0;
    all->bytes[packet->player][to] += packet->size + LL_UDP_OVERHEAD;
    all->count[packet->player][to]++;
}

static void ignore(void *context, const void *row)
{
    (void)context, (void)row;
}

/* Over equal links each of the others gets equal copies, which have the size of the one to a relay that
 * acknowledges as late as they do: the payload is counted here, and by the metrics. */
static void a_player_sends_a_copy_to_each_other(void **state)
{
    (void)state;
    const char *const mesh[] = {MESH, NULL};
    for (int players = 1; players <= CROWD; players++) {
        copies sent = {0};
        ll_recorder r = {.record = ignore, .packet = count_copy, .context = &sent};
        scene s = crowd(players, mesh);
        scene_run(&s, 12, &r);
        cJSON *metrics = ll_netgame_metrics(s.game);
        int others = players > 1 ? players - 1 : 1;
        for (int p = 0; p < players; p++) {
            int64_t one = sent.bytes[p][p == 0 && players > 1], sum = 0;
            char path[80];
            for (int to = 0; to < players; to++) {
                bool is_sent = players == 1 || to != p;
                assert_int_equal(sent.bytes[p][to], is_sent ? one : 0);
                assert_int_equal(sent.count[p][to], is_sent ? 601 : 0); /* with that of the last instant */
                sum += sent.bytes[p][to];
            }
            assert_int_equal(sum, others * one);
            snprintf(path, sizeof path, "players.%d.bandwidth.input.wire_bytes_per_s", p);
            assert_near(value(metrics, path), (double)sum / 10, 1e-6);
            snprintf(path, sizeof path, "players.%d.bandwidth.input.messages_per_s", p);
            assert_near(value(metrics, path), 60.1 * others, 1e-6);
            snprintf(path, sizeof path, "players.%d.bandwidth.relay.messages_per_s", p);
            assert_near(value(metrics, path) - 10.1, (players > 1 ? 60.0 * others : 0), 0.11 * others);
        }
        cJSON_Delete(metrics);
        scene_close(&s);
    }
}

/* The relay's upload does not depend on the number of players but for the 8 bytes of each in a packet. */
static void the_relay_gets_one_copy(void **state)
{
    (void)state;
    for (int players = 2; players <= CROWD; players++) {
        scene s = crowd(players, NULL);
        scene_run(&s, 12, NULL);
        cJSON *metrics = ll_netgame_metrics(s.game);
        assert_near(value(metrics, "players.0.bandwidth.input.messages_per_s"), 60.1, 1e-6);
        cJSON_Delete(metrics);
        scene_close(&s);
    }
}

/* ---- one direct path ---- */

static void run_to(const scene *s, ll_time until)
{
    ll_status status = s->scenario.kind->advance(s->game, until, NULL, NULL, NULL, NULL);
    assert_false(ll_failed(&status));
}

/* On clean links an input that is made at a machine's tick is known to each other at that time + the delay up
 * + the delay down to the nanosecond, at any rate of the server's updates. A relay adds its wait. */
static void inputs_take_the_two_delays_and_nothing_more(void **state)
{
    (void)state;
    static const double lag_ms[] = {10, 35, 60};
    for (int meshed = 0; meshed < 2; meshed++) {
        const char *const sets[] = {meshed ? MESH : "peers.topology=relay", "server.sync=deterministic",
                                    "server.update_hz=7",
                                    "players=[{\"lag_ms\":10,\"clock_phase\":0,\"input_delay_ticks\":16},"
                                    "{\"lag_ms\":35,\"clock_phase\":0,\"input_delay_ticks\":16},"
                                    "{\"lag_ms\":60,\"clock_phase\":0,\"input_delay_ticks\":16}]",
                                    NULL};
        scene s = scene_open("race", sets);
        int late = 0;
        scene_run(&s, 3, NULL);
        for (int64_t frame = 181; frame < 195; frame++)
            for (int from = 0; from < 3; from++)
                for (int to = 0; to < 3; to++) {
                    if (from == to)
                        continue;
                    scene one = s;
                    size_t bytes = ll_netgame_bytes(s.game);
                    one.game = memcpy(malloc(bytes), s.game, bytes); /* looks ahead, and forgets it */
                    ll_time made = ll_tick_time(frame, ll_freq_from_hz(60));
                    ll_time comes = made + ll_ms(lag_ms[from]) + ll_ms(lag_ms[to]);
                    run_to(&one, made);
                    int64_t newest = ll_netgame_client(one.game, from)->inputs.tick;
                    run_to(&one, comes - 1);
                    assert_true(peer_of(&one, to)->player[from].known < newest);
                    run_to(&one, comes);
                    if (meshed)
                        assert_int_equal(peer_of(&one, to)->player[from].known, newest);
                    late += peer_of(&one, to)->player[from].known < newest;
                    free(one.game);
                    scene_run(&s, (double)(frame - 1) / 60, NULL);
                }
        assert_true(meshed ? late == 0 : late > 40);
        if (meshed)
            for (int p = 0; p < 3; p++) /* 16 ticks of input delay are longer than 95 ms */
                assert_int_equal(ll_netgame_client_metrics(s.game, p)->stepping.stalls, 0);
        scene_close(&s);
    }
}

/* Without input delay a tick takes the two delays, 180 ms, rounded up to frames: 11 of them. With D ticks of
 * input delay D + 1 ticks are made in that time. A relay that updates each 100 ms makes fewer. */
static void ticks_follow_the_direct_delay(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        const char *const sets[] = {i % 2 ? MESH : "peers.topology=relay",
                                    "server.sync=deterministic",
                                    "server.update_hz=10",
                                    i < 2 ? "players.0.input_delay_ticks=0" : "players.0.input_delay_ticks=4",
                                    i < 2 ? "players.1.input_delay_ticks=0" : "players.1.input_delay_ticks=4",
                                    "players.0.lag_ms=90",
                                    "players.1.lag_ms=90",
                                    "players.0.clock_phase=0",
                                    "players.1.clock_phase=0",
                                    NULL};
        const double per_s = (i < 2 ? 1 : 5) * 60 / 11.0;
        scene s = scene_open("race", sets);
        scene_run(&s, 10, NULL);
        int64_t before = ll_netgame_server(s.game)->step;
        scene_run(&s, 30, NULL);
        double measured = (double)(ll_netgame_server(s.game)->step - before) / 20;
        if (i % 2 ? !(fabs(measured - per_s) < 0.11) : !(measured < 0.93 * per_s))
            fail_msg("%d: %g ticks/s in place of %g", i, measured, per_s);
        scene_close(&s);
    }
}

/* ---- coming and going ---- */

#define THREE                                                                                                \
    "players=[{\"lag_ms\":30,\"input_delay_ticks\":6},{\"lag_ms\":50,\"input_delay_ticks\":6},{\"lag_ms\":"  \
    "20,\"input_delay_ticks\":6}]"

/* The server drops a silent player and makes its inputs; the others go on without it. It joins again. */
static void a_player_leaves_and_joins_again(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const char *const sets[] = {peer_syncs[i],
                                    MESH,
                                    "server.timeout_s=2",
                                    "server.update_hz=30",
                                    "params.laps=10000",
                                    "warmup_s=0",
                                    THREE,
                                    NULL};
        scene s = scene_open("race", sets);
        const ll_server *server = ll_netgame_server(s.game);
        scene_run(&s, 5, NULL);
        set_loss(&s, 1, 100);
        scene_run(&s, 9, NULL);
        int64_t step = server->step;
        assert_int_equal(server->client_slots[1].connection.connected, 0);
        scene_run(&s, 12, NULL);
        assert_true(server->step > step + 3 * 60 - 10);
        set_loss(&s, 1, 0);
        scene_run(&s, 14.5, NULL);
        assert_int_equal(server->client_slots[1].connection.connected, 1);
        step = server->step;
        int64_t applied = server->client_slots[1].inputs.acked;
        scene_run(&s, 20, NULL);
        assert_true(server->step > step + 5.5 * 60 - 20);
        assert_true(server->client_slots[1].inputs.acked > applied + 5.5 * 60 - 20); /* its own inputs */
        for (int p = 0; p < 3; p++)
            assert_int_equal(peer_of(&s, p)->waiting, 0);
        assert_in_step(&s);
        scene_close(&s);
    }
}

/* One direction at a time is cut for a while shorter than the timeout, and every live sync mode follows. */
static void outages_and_changes_of_the_sync_lose_nothing(void **state)
{
    (void)state;
    static const int32_t modes[] = {3, 4, 0, 4, 1, 3};
    const char *const sets[] = {peer_syncs[1], MESH, "server.update_hz=30", "params.laps=10000", THREE, NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, 3, NULL);
    for (int k = 0; k < 24; k++) {
        ll_netgame_config config = scene_config(s.game);
        for (int p = 0; p < 3; p++)
            config.players[p].link.up.loss_pct = config.players[p].link.down.loss_pct = 5;
        ll_link_pair *link = &config.players[k % 3].link;
        (k / 3 % 2 ? &link->up : &link->down)->loss_pct = 100;
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, 3 + k * 2 + 0.7, NULL);
        link->up.loss_pct = link->down.loss_pct = 5;
        if (k % 4 == 3)
            config.server.sync = modes[k / 4];
        s.scenario.kind->change(s.game, &config, s.game->now);
        int64_t step = ll_netgame_server(s.game)->step;
        scene_run(&s, 5 + k * 2, NULL);
        assert_null(netgame_broken(s.game));
        if (!ll_netgame_sync(s.game)->observe)
            continue;
        assert_true(ll_netgame_server(s.game)->step > step + 30);
        assert_in_step(&s);
    }
    scene_close(&s);
}

/* No server stands between the players: an input that breaks a rule acts in all worlds. */
static void no_one_validates(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const char *const sets[] = {peer_syncs[i],
                                    "players.1.cheat=magnitude",
                                    MESH,
                                    "players.0.input_delay_ticks=8",
                                    "players.1.input_delay_ticks=8",
                                    NULL};
        scene s = scene_open("contact", sets);
        scene_run(&s, 20, NULL);
        const ll_client_slot *client_slots = ll_netgame_server(s.game)->client_slots;
        assert_int_equal(client_slots[1].counts.refused[LL_RULE_MAGNITUDE], 0);
        assert_in_step(&s);
        scene_close(&s);
    }
}

static void streams_have_no_direct_path(void **state)
{
    (void)state;
    const char *const tcp[] = {"server.transport=tcp", MESH};
    scene s = scene_open("rollback", NULL);
    ll_netgame_config *config = malloc(ll_netgame_table.size);
    memcpy(config, s.scenario.config, ll_netgame_table.size);
    ll_status status = ll_param_put(&ll_netgame_table, config, tcp, 2);
    assert_false(ll_failed(&status));
    status = ll_param_check(&ll_netgame_table, config);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.text,
                        "peers.topology: must be relay unless server.transport is udp; got mesh with tcp");
    free(config);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_settled_world_is_that_of_the_relay),
        cmocka_unit_test(a_player_sends_a_copy_to_each_other),
        cmocka_unit_test(the_relay_gets_one_copy),
        cmocka_unit_test(inputs_take_the_two_delays_and_nothing_more),
        cmocka_unit_test(ticks_follow_the_direct_delay),
        cmocka_unit_test(a_player_leaves_and_joins_again),
        cmocka_unit_test(outages_and_changes_of_the_sync_lose_nothing),
        cmocka_unit_test(no_one_validates),
        cmocka_unit_test(streams_have_no_direct_path),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
