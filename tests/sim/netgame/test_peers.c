/* Deterministic lockstep and rollback as a whole: all clients have the same world at every tick, on any
 * links; other float modes are detected; late inputs cause resimulation. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "sim/netgame/world_log.h"
#include "support/many.h"
#include "support/near.h"
#include "support/stride.h"

/* The first tick at which a client's world differs from the server's; -1: none. */
static int64_t first_difference(const world_log *d, int player)
{
    int64_t end = d->seen[0] < d->seen[1 + player] ? d->seen[0] : d->seen[1 + player];
    for (int64_t tick = 1; tick <= end; tick++)
        if (d->hashes[0][tick] != d->hashes[1 + player][tick])
            return tick;
    return -1;
}

#define BAD_LINKS(p)                                                                                         \
    "players." p ".lag_ms=100", "players." p ".link.up.jitter_ms=100", "players." p ".link.up.loss_pct=5",   \
        "players." p ".link.down.jitter_ms=100", "players." p ".link.down.loss_pct=5",                       \
        "players." p ".input_delay_ticks=8"

static void honest_clients_agree(const char *id, const char *sync, const char *const *more, double seconds)
{
    const char *sets[64] = {sync, "server.update_hz=60", "params.laps=10000", "duration_s=3600"};
    int n = 4;
    for (; *more; more++)
        sets[n++] = *more;
    scene s = scene_open(id, sets);
    world_log d = log_of(&s, 0);
    run(&d, 0, seconds);
    assert_true(d.seen[0] > (int64_t)seconds * 30);
    for (int p = 0; p < s.game->config.player_count; p++) {
        assert_true(d.seen[1 + p] > d.seen[0] - 40);
        assert_int_equal(first_difference(&d, p), -1);
        const ll_peer_status *known = &ll_netgame_server(s.game)->client_slots[p].peer;
        assert_int_equal(known->desync, -1);
        assert_true(known->hashed > d.seen[0] - 100);
        assert_int_equal(ll_netgame_desync(s.game, p)->tick, -1);
        assert_true(ll_netgame_desync(s.game, p)->compared > d.seen[0] - 100);
    }
    log_free(&d);
    scene_close(&s);
}

static void two_honest_clients_agree_at_every_tick(void **state)
{
    (void)state;
    static const char *const links[] = {"players.0.lane=0", "players.1.lane=0", BAD_LINKS("0"),
                                        BAD_LINKS("1"), NULL};
    for (int i = 0; i < 2; i++)
        honest_clients_agree("race", peer_syncs[i], links, 600);
}

static void eight_honest_clients_agree_at_every_tick(void **state)
{
    (void)state;
    static const char *const links[] = {BAD_LINKS("0"), BAD_LINKS("1"), BAD_LINKS("2"),
                                        BAD_LINKS("3"), BAD_LINKS("4"), BAD_LINKS("5"),
                                        BAD_LINKS("6"), BAD_LINKS("7"), NULL};
    for (int i = 0; i < 2; i++)
        honest_clients_agree("eight", peer_syncs[i], links, 600);
}

/* The rings are large enough for the widest parameters and the worst links; no packet is lost to a full
 * queue. */
static void extremes_of_the_ranges_agree(void **state)
{
    (void)state;
    static const char *const rates[] = {"server.update_hz=1", "server.update_hz=120"};
    for (int i = 0; i < 2 * 2; i++) {
        const char *const sets[] = {peer_syncs[i % 2],
                                    rates[i / 2],
                                    "tick_hz=64",
                                    "server.max_rollback_ticks=16",
                                    "server.sync_test_ticks=8",
                                    "players.0.input_delay_ticks=16",
                                    "players.1.input_delay_ticks=16",
                                    "players.0.lag_ms=1000",
                                    "players.0.link.up.jitter_ms=250",
                                    "players.0.link.down.jitter_ms=250",
                                    "players.0.link.up.loss_pct=30",
                                    "players.1.link.down.loss_pct=30",
                                    "players.1.link.up.duplicate_pct=50",
                                    NULL};
        scene s = scene_open("race", sets);
        world_log d = log_of(&s, 0);
        run(&d, 0, 120);
        assert_true(d.seen[0] > 600);
        for (int p = 0; p < 2; p++) {
            const ll_client_slot *client_slot = &ll_netgame_server(s.game)->client_slots[p];
            assert_int_equal(first_difference(&d, p), -1);
            assert_int_equal(ll_netgame_desync(s.game, p)->tick, -1);
            assert_true(ll_netgame_desync(s.game, p)->compared > d.seen[0] - 100);
            assert_int_equal(client_slot->peer.desync, -1);
            assert_true(client_slot->peer.hashed > d.seen[0] - 200);
            assert_int_equal(ll_netgame_client_metrics(s.game, p)->stepping.sync_test_mismatches, 0);
            assert_int_equal(ll_link_get_stats(ll_netgame_up(s.game, p))->overflowed, 0);
            assert_int_equal(ll_link_get_stats(ll_netgame_down(s.game, p))->overflowed, 0);
            for (int rule = 1; rule < LL_RULES; rule++)
                assert_int_equal(client_slot->counts.refused[rule], 0);
        }
        log_free(&d);
        scene_close(&s);
    }
}

/* Packets of the largest size, and as many in flight as possible: links hold them all. */
static void links_hold_the_longest_packets(void **state)
{
    (void)state;
    enum { MANY = 8 };
    for (int k = 0; k < 2; k++) {
        char text[4096], *at = text, *end = text + sizeof text;
        at += snprintf(at, (size_t)(end - at),
                       "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":60,\"tick_hz\":%d,\"server\":{"
                       "\"sync\":\"%s\","
                       "\"update_hz\":%d,\"max_rollback_ticks\":16},\"players\":[",
                       k ? 60 : 128, k ? "deterministic" : "rollback", k ? 60 : 128);
        for (int p = 0; p < MANY; p++)
            at += snprintf(at, (size_t)(end - at),
                           "%s{\"control\":\"person\",\"lag_ms\":1000,\"link\":{\"up\":{\"delay_ms\":240},"
                           "\"down\":{\"delay_ms\":240}},\"input_delay_ticks\":16}",
                           p ? "," : "");
        snprintf(at, (size_t)(end - at), "]}");
        scene s = scene_make(text, NULL);
        for (int64_t t = 1; t < 20 * 128; t++) {
            scene_run(&s, (double)t / 128, NULL);
            for (int p = 0; p < MANY; p++) {
                ll_action a = {.axis = {(float)ll_rng_unit(7, (uint64_t)p, (uint64_t)t)}};
                s.scenario.kind->input(s.game, p, &a);
            }
        }
        for (int p = 0; p < MANY; p++) {
            const ll_link_stats *up = ll_link_get_stats(ll_netgame_up(s.game, p));
            const ll_link_stats *down = ll_link_get_stats(ll_netgame_down(s.game, p));
            assert_int_equal(up->overflowed, 0);
            assert_int_equal(down->overflowed, 0);
        }
        scene_close(&s);
    }
}

/* Every live parameter changes every second: the worlds stay the same. */
static void live_changes_keep_all_worlds_equal(void **state)
{
    (void)state;
    const char *const sets[] = {"server.sync=rollback", "server.update_hz=60", "params.laps=10000",
                                BAD_LINKS("0"),         BAD_LINKS("1"),        NULL};
    scene s = scene_open("contact", sets);
    world_log d = log_of(&s, 0);
    for (int k = 0; k < 120; k++) {
        ll_netgame_config config = scene_config(s.game);
        config.server.max_rollback_ticks = k * 7 % 17;
        config.server.sync_test_ticks = k * 5 % 9;
        config.server.update_hz = 10 + k * 13 % 111;
        config.players[k % 2].input_delay_ticks = k * 11 % 17;
        config.players[k % 2].lag_ms = k * 37 % 200;
        s.scenario.kind->change(s.game, &config, s.game->now);
        run(&d, k, k + 1);
    }
    assert_true(d.seen[0] > 2000);
    for (int p = 0; p < 2; p++) {
        assert_int_equal(first_difference(&d, p), -1);
        assert_int_equal(ll_netgame_client_metrics(s.game, p)->stepping.sync_test_mismatches, 0);
    }
    log_free(&d);
    scene_close(&s);
}

/* ---- other float modes ---- */

static void other_hardware_is_named(void **state)
{
    (void)state;
    static const char *const hardware[] = {"players.1.float_mode=float", "players.1.float_mode=fma",
                                           "players.1.float_mode=ulp"};
    static const char *const games[] = {"contact", "cannon", "desync_fma"};
    for (int i = 0; i < 3 * 3 * 2; i += LL_TEST_STRIDE) {
        const char *const sets[] = {peer_syncs[i / 9],
                                    hardware[i % 3],
                                    "players.0.input_delay_ticks=4",
                                    "players.1.input_delay_ticks=4",
                                    "server.update_hz=60",
                                    NULL};
        scene s = scene_open(games[i / 3 % 3], sets);
        world_log d = log_of(&s, 4000);
        run(&d, 0, 60);
        const ll_desync *found = ll_netgame_desync(s.game, 1);
        int64_t tick = first_difference(&d, 1);
        assert_int_equal(first_difference(&d, 0), -1);
        assert_true(tick > 0 && tick < d.ticks);
        assert_int_equal(found->tick, tick);
        assert_int_equal(ll_netgame_server(s.game)->client_slots[1].peer.desync, tick);
        assert_int_equal(ll_netgame_desync(s.game, 0)->tick, -1);

        const ll_world *truth = (const ll_world *)(const void *)(d.worlds[0] + (size_t)tick * d.size);
        const ll_world *world = (const ll_world *)(const void *)(d.worlds[2] + (size_t)tick * d.size);
        const double *a = &truth->entity[0].x, *b = &world->entity[0].x; /* seven numbers per entity */
        int first = 0;
        while (memcmp(&a[first], &b[first], sizeof *a) == 0)
            first++;
        assert_int_equal(found->entity * LL_FIELDS + found->field, first);
        assert_true(found->ulps == ll_ulps(a[first], b[first]) && found->ulps >= 1);
        assert_true(found->ulps_max >= found->ulps);
        log_free(&d);
        scene_close(&s);
    }
}

/* The relay server replaces a refused input for all clients, so only the cheat's own world differs. */
static void a_cheat_leaves_the_common_world_alone(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const char *const sets[] = {peer_syncs[i], "players.1.cheat=magnitude",
                                    "players.0.input_delay_ticks=8", "players.1.input_delay_ticks=8", NULL};
        scene s = scene_open("contact", sets);
        world_log d = log_of(&s, 0);
        run(&d, 0, 20);
        const ll_client_slot *client_slots = ll_netgame_server(s.game)->client_slots;
        assert_int_equal(first_difference(&d, 0), -1);
        assert_int_equal(first_difference(&d, 1), 9); /* the first tick that it has an input for */
        assert_int_equal(ll_netgame_desync(s.game, 1)->tick, 9);
        assert_int_equal(client_slots[1].peer.desync, 9);
        assert_true(client_slots[1].counts.refused[LL_RULE_MAGNITUDE] > 500);
        assert_true(ll_netgame_client(s.game, 1)->inputs.refused > 500);
        log_free(&d);
        scene_close(&s);
    }
}

/* Events report stalls and the players waited for, the lengths of rollbacks, and where a world departed. */
static void events_match_the_counters(void **state)
{
    (void)state;
    tape all = {0};
    ll_recorder r = tape_recorder(&all);
    const char *const sets[] = {"warmup_s=0", "players.1.float_mode=fma", NULL};
    scene s = scene_open("rollback_loss", sets);
    scene_run(&s, 15, &r);
    set_loss(&s, 1, 100);
    scene_run(&s, 16, &r);
    set_loss(&s, 1, 5);
    scene_run(&s, 30, &r);
    const ll_stepping *n = &ll_netgame_client_metrics(s.game, 0)->stepping;
    int64_t stalls = 0, rollbacks = 0, ticks = 0, desyncs = 0;
    double stalled_ms = 0;
    for (size_t i = 0; i < all.count; i++) {
        const ll_event *e = &all.events[i];
        desyncs += e->type == LL_EVENT_DESYNC;
        if (e->type == LL_EVENT_DESYNC) {
            assert_int_equal(e->player, 1);
            assert_int_equal(e->number, ll_netgame_desync(s.game, 1)->tick);
        } else if (e->type == LL_EVENT_STALL && e->player == 0) {
            assert_int_equal(e->number, 1 << 1);
            stalls++;
            stalled_ms += (double)e->value;
        } else if (e->type == LL_EVENT_ROLLBACK && e->player == 0) {
            rollbacks++;
            ticks += (int64_t)e->value;
        }
    }
    assert_int_equal(desyncs, 1);
    assert_true(stalls > 0 && stalls == n->stalls);
    assert_true(stalled_ms > 700);
    assert_near(stalled_ms, 1000 * (double)n->stalled_frames / 60, 0.01);
    assert_true(rollbacks > 10 && rollbacks == n->rollbacks && ticks == n->rollback_ticks);
    scene_close(&s);
    tape_free(&all);
}

/* ---- the same result as without lag ---- */

static void rollback_of_none_is_deterministic_lockstep(void **state)
{
    (void)state;
    const char *const rollback[] = {"server.sync=rollback", "server.max_rollback_ticks=0", NULL};
    scene a = scene_open("deterministic", NULL), b = scene_open("deterministic", rollback);
    world_log x = log_of(&a, 0), y = log_of(&b, 0);
    run(&x, 0, 40);
    run(&y, 0, 40);
    assert_true(x.seen[0] > 2000);
    for (int i = 0; i <= 3; i++) {
        assert_int_equal(x.seen[i], y.seen[i]);
        assert_memory_equal(x.hashes[i], y.hashes[i], TICKS_MAX * sizeof x.hashes[i][0]);
    }
    log_free(&x);
    log_free(&y);
    scene_close(&a);
    scene_close(&b);
}

/* ---- ages ---- */

/* With `deterministic` all clients draw the newest confirmed tick: the others are as old as what is known.
 * Ticks that the server has not made have no age yet, and tick 0 is of time 0 at every display. */
static void deterministic_lockstep_draws_the_newest_confirmed_tick(void **state)
{
    (void)state;
    const char *const sets[] = {"server.sync=deterministic",     "server.update_hz=12",
                                "players.0.lag_ms=210",          "players.1.lag_ms=35",
                                "players.0.input_delay_ticks=7", "players.0.display_hz=144",
                                "players.1.display_hz=75",       NULL};
    scene s = scene_open("contact", sets);
    int ahead = 0, at_start = 0;
    for (int k = 0; k < 600; k++) {
        scene_run(&s, k / 60.0, NULL);
        for (int p = 0; p < 2; p++) {
            const ll_client_metrics *in = ll_netgame_client_metrics(s.game, p);
            assert_true(in->last.view_age == in->last.age_of_information);
            ahead += peer_of(&s, p)->tick > ll_netgame_server(s.game)->step;
            at_start += peer_of(&s, p)->tick == 0 && in->last.view_age > 0;
        }
    }
    assert_true(ahead > 10 && at_start > 10);
    scene_close(&s);
}

/* ---- sync test ---- */

static int sync_test_s = 4; /* of each game, two of them to warm up; `test_sim peers many`: 12 */

static void going_back_and_on_changes_nothing_in_any_game(void **state)
{
    (void)state;
    for (int game = 0; ll_games[game]; game++)
        for (int i = 0; i < 2; i++) {
            char text[256];
            snprintf(
                text, sizeof text,
                "{\"kind\":\"netgame\",\"game\":\"%s\",\"server\":{\"sync_test_ticks\":8,\"update_hz\":60},"
                "\"players\":[{\"lag_ms\":50,\"lane\":0},{\"lag_ms\":20,\"lane\":0,\"input_delay_ticks\":2},{"
                "}]}",
                ll_games[game]->name);
            const char *const sets[] = {peer_syncs[i], NULL};
            scene s = scene_make(text, sets);
            scene_run(&s, sync_test_s, NULL);
            for (int p = 0; p < 3; p++) {
                const ll_stepping *n = &ll_netgame_client_metrics(s.game, p)->stepping;
                assert_int_equal(n->sync_tests,
                                 60 * (sync_test_s - 2)); /* after the warm-up, at any phase of the clock */
                if (n->sync_test_mismatches != 0)
                    fail_msg("%s: %lld of %lld sync tests of player %d differ", ll_games[game]->name,
                             (long long)n->sync_test_mismatches, (long long)n->sync_tests, p);
            }
            scene_close(&s);
        }
}

int main(int count, char **arguments)
{
    if (ll_test_many(count, arguments))
        sync_test_s = 12;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(links_hold_the_longest_packets),
        cmocka_unit_test(two_honest_clients_agree_at_every_tick),
        cmocka_unit_test(eight_honest_clients_agree_at_every_tick),
        cmocka_unit_test(extremes_of_the_ranges_agree),
        cmocka_unit_test(live_changes_keep_all_worlds_equal),
        cmocka_unit_test(other_hardware_is_named),
        cmocka_unit_test(a_cheat_leaves_the_common_world_alone),
        cmocka_unit_test(events_match_the_counters),
        cmocka_unit_test(rollback_of_none_is_deterministic_lockstep),
        cmocka_unit_test(deterministic_lockstep_draws_the_newest_confirmed_tick),
        cmocka_unit_test(going_back_and_on_changes_nothing_in_any_game),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
