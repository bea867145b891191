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

#include "base/hash.h"
#include "base/rng.h"
#include "support/scene.h"

#define TICKS_MAX 40000

/* All worlds by tick, or their hashes: recorded when they are made, compared afterwards. */
typedef struct world_log {
    scene *s;
    int ticks;                        /* number of whole worlds that are kept */
    size_t size;                      /* of a world */
    int64_t seen[1 + LL_PLAYERS_MAX]; /* ticks recorded, of the server and of each client */
    uint64_t *hashes[1 + LL_PLAYERS_MAX];
    char *worlds[1 + LL_PLAYERS_MAX];
} world_log;

static void write_down(world_log *d, int whose, int64_t tick, const ll_world *world)
{
    assert_true(tick == d->seen[whose] + 1 && tick < TICKS_MAX);
    d->hashes[whose][tick] = ll_hash(1, world, d->size);
    if (tick < d->ticks)
        memcpy(d->worlds[whose] + (size_t)tick * d->size, world, d->size);
    d->seen[whose] = tick;
}

static void on_event(void *context, const void *row)
{
    const ll_event *event = row;
    world_log *d = context;
    ll_server *server = ll_netgame_server(d->s->game);
    if (event->type == LL_EVENT_STEP)
        write_down(d, 0, server->step, ll_server_world(server));
}

static world_log log_of(scene *s, int ticks)
{
    world_log d = {
        .s = s, .ticks = ticks, .size = ll_world_size(ll_server_world(ll_netgame_server(s->game)))};
    for (int i = 0; i <= s->game->config.player_count; i++) {
        d.hashes[i] = calloc(TICKS_MAX, sizeof *d.hashes[i]);
        d.worlds[i] = calloc((size_t)ticks + 1, d.size);
    }
    return d;
}

static void log_free(world_log *d)
{
    for (int i = 0; i <= LL_PLAYERS_MAX; i++) {
        free(d->hashes[i]);
        free(d->worlds[i]);
    }
}

static const ll_peer *peer_of(const scene *s, int player)
{
    return ll_client_peer(ll_netgame_client(s->game, player));
}

/* Continues frame by frame. */
static void run(world_log *d, double from_s, double until_s)
{
    ll_recorder r = {on_event, d};
    for (int64_t k = (int64_t)(from_s * 60) + 1; k <= (int64_t)(until_s * 60); k++) {
        scene_run(d->s, (double)k / 60 + 1e-6, &r);
        for (int p = 0; p < d->s->game->config.player_count; p++)
            while (d->seen[1 + p] < peer_of(d->s, p)->confirmed) {
                int64_t tick = d->seen[1 + p] + 1;
                write_down(d, 1 + p, tick, ll_peer_world(ll_netgame_client(d->s->game, p), tick));
            }
    }
}

static void set_loss(scene *s, int player, double percent)
{
    ll_netgame_config config = s->game->config;
    config.players[player].link.up.loss_pct = percent;
    s->scenario.kind->change(s->game, &config, s->game->now);
}

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

static const char *const syncs[] = {"server.sync=deterministic", "server.sync=rollback"};

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
        honest_clients_agree("race", syncs[i], links, 600);
}

static void eight_honest_clients_agree_at_every_tick(void **state)
{
    (void)state;
    static const char *const links[] = {BAD_LINKS("0"), BAD_LINKS("1"), BAD_LINKS("2"),
                                        BAD_LINKS("3"), BAD_LINKS("4"), BAD_LINKS("5"),
                                        BAD_LINKS("6"), BAD_LINKS("7"), NULL};
    for (int i = 0; i < 2; i++)
        honest_clients_agree("eight", syncs[i], links, 600);
}

/* The rings are large enough for the widest parameters and the worst links; no packet is lost to a full
 * queue. */
static void extremes_of_the_ranges_agree(void **state)
{
    (void)state;
    static const char *const rates[] = {"server.update_hz=1", "server.update_hz=120"};
    for (int i = 0; i < 2 * 2; i++) {
        const char *const sets[] = {syncs[i % 2],
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
        ll_netgame_config config = s.game->config;
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
    for (int i = 0; i < 3 * 3 * 2; i++) {
        const char *const sets[] = {syncs[i / 9],
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
        const char *const sets[] = {syncs[i], "players.1.cheat=magnitude", "players.0.input_delay_ticks=8",
                                    "players.1.input_delay_ticks=8", NULL};
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
    assert_true(stalled_ms > 700 && fabs(stalled_ms - 1000 * (double)n->stalled_frames / 60) < 0.01);
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

static void run_to_tick(world_log *d, int64_t tick)
{
    ll_recorder r = {on_event, d};
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
        const char *const without[] = {syncs[i % 2],
                                       "server.update_hz=120",
                                       "players.0.input_delay_ticks=3",
                                       "players.0.script=hold", /* a shooter: aims at the other player */
                                       "players.0.lag_ms=0",
                                       "players.1.lag_ms=0",
                                       NULL};
        const char *const with[] = {syncs[i % 2],
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
        const char *const sets[] = {players[i / 2], syncs[i % 2], "tick_hz=110", "params.laps=10000", NULL};
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

/* ---- stalls ---- */

/* Without a timeout, or before it is reached. */
static void a_dead_link_stalls_all_clients_until_it_is_back(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        const char *const sets[] = {syncs[i % 2],
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
        const char *const sets[] = {syncs[i % 2],
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

/* ---- sync test ---- */

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
            const char *const sets[] = {syncs[i], NULL};
            scene s = scene_make(text, sets);
            scene_run(&s, 12, NULL);
            for (int p = 0; p < 3; p++) {
                const ll_stepping *n = &ll_netgame_client_metrics(s.game, p)->stepping;
                assert_int_equal(n->sync_tests, 600); /* after the warm-up, at any phase of the clock */
                if (n->sync_test_mismatches != 0)
                    fail_msg("%s: %lld of %lld sync tests of player %d differ", ll_games[game]->name,
                             (long long)n->sync_test_mismatches, (long long)n->sync_tests, p);
            }
            scene_close(&s);
        }
}

int main(void)
{
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
        cmocka_unit_test(lag_does_not_change_the_result),
        cmocka_unit_test(a_client_far_ahead_alone_stays_in_step),
        cmocka_unit_test(deterministic_lockstep_draws_the_newest_confirmed_tick),
        cmocka_unit_test(a_dead_link_stalls_all_clients_until_it_is_back),
        cmocka_unit_test(a_silent_client_is_dropped_and_joins_again),
        cmocka_unit_test(rate_follows_lag_and_delay),
        cmocka_unit_test(the_faster_client_waits_and_does_not_stall),
        cmocka_unit_test(going_back_and_on_changes_nothing_in_any_game),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
