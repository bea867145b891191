/* A server on a player's machine: the same game as on one of its own, the times of a change of the host to
 * the nanosecond, one state for all afterwards, and one host at a time on any links. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "base/rng.h"
#include "sim/netgame/readings.h"

enum { MOST = 6 };

typedef struct table {
    int players;
    double lag_ms[MOST];
    const char *sync, *more; /* more: of every player, or empty */
} table;

static scene open_table(const table *t, const char *const *sets)
{
    char text[4096], *at = text, *end = text + sizeof text;
    at += snprintf(
        at, (size_t)(end - at),
        "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":3600,\"warmup_s\":0,\"params\":{\"laps\":"
        "10000},\"server\":{\"sync\":\"%s\",\"update_hz\":20,\"timeout_s\":1},\"hosting\":{\"by_player\":"
        "true},\"players\":[",
        t->sync);
    for (int p = 0; p < t->players; p++)
        at += snprintf(at, (size_t)(end - at), "%s{\"lag_ms\":%.6f,\"lane\":0%s}", p ? "," : "", t->lag_ms[p],
                       t->more);
    snprintf(at, (size_t)(end - at), "]}");
    return scene_make(text, sets);
}

static const ll_hosting *hosting(const scene *s)
{
    return &ll_netgame_hosts_of(s->game)->hosting;
}

static void assert_sound(const scene *s)
{
    const char *broken = ll_netgame_broken(s->game);
    if (broken)
        fail_msg("%s", broken);
}

/* ---- a listen server ---- */

/* The world after each step, and those of the clients at the end. */
static void same_game(scene *a, scene *b, double seconds)
{
    for (int k = 1; k <= (int)(seconds * 60); k++) {
        scene_run(a, k / 60.0 + 1e-6, NULL);
        scene_run(b, k / 60.0 + 1e-6, NULL);
        const ll_server *x = ll_netgame_server(a->game), *y = ll_netgame_server(b->game);
        assert_int_equal(x->step, y->step);
        assert_memory_equal(ll_server_world_const(x), ll_server_world_const(y),
                            ll_world_size(ll_server_world_const(x)));
    }
    for (int p = 0; p < a->game->config.player_count; p++)
        assert_memory_equal(ll_client_rendered_const(ll_netgame_client(a->game, p)),
                            ll_client_rendered_const(ll_netgame_client(b->game, p)),
                            ll_world_size(ll_server_world_const(ll_netgame_server(a->game))));
}

/* With a host without lag a message takes the same time as to a server in the middle: nothing else may
 * differ. */
static void a_host_without_lag_is_a_server_in_the_middle(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free", "deterministic", "rollback"};
    static const char *const own[] = {"hosting.by_player=false", NULL}, *const none[] = {NULL};
    for (int i = 0; i < 3; i++) {
        const table t = {4, {0, 30, 80, 125}, syncs[i], ""};
        scene a = open_table(&t, none), b = open_table(&t, own);
        same_game(&a, &b, 20);
        assert_sound(&a);
        scene_close(&a);
        scene_close(&b);
    }
}

/* The host's own messages take no time; those of others the links of both. */
static void lags_add_up_and_the_host_has_none(void **state)
{
    (void)state;
    static const char *const none[] = {NULL};
    const table t = {4, {40, 30, 80, 125}, "free", ""};
    scene s = open_table(&t, none);
    scene_run(&s, 10, NULL);
    for (int p = 0; p < 4; p++) {
        const ll_time trip = ll_clock_sync_round_trip(&ll_netgame_client(s.game, p)->connection.clock);
        assert_int_equal(trip, p == 0 ? 0 : 2 * (ll_ms(t.lag_ms[p]) + ll_ms(40)));
    }
    assert_int_equal(ll_link_get_stats(ll_netgame_up(s.game, 0))->overflowed, 0);
    cJSON *metrics = ll_netgame_metrics(s.game);
    assert_true(value(metrics, "players.0.hosting.hosted_s") == 10 && value(metrics, "hosting.host") == 0);
    assert_true(value(metrics, "hosting.changes") == 0 && value(metrics, "hosting.without_s") == 0);
    cJSON_Delete(metrics);
    scene_close(&s);
}

/* What a scenario does not choose changes nothing: neither the block nor its hash. */
static void without_a_host_other_parameters_change_nothing(void **state)
{
    (void)state;
    static const char *const plain[] = {NULL};
    static const char *const given[] = {"hosting.leaves_s=3", "hosting.election=newest_state",
                                        "hosting.host=1", NULL};
    scene a = scene_open("race", plain), b = scene_open("race", given);
    assert_int_equal(ll_netgame_bytes(a.game), ll_netgame_bytes(b.game));
    for (int k = 1; k <= 10; k++) {
        scene_run(&a, k, NULL);
        scene_run(&b, k, NULL);
        assert_true(a.scenario.kind->hash(a.game) == b.scenario.kind->hash(b.game));
    }
    scene_close(&a);
    scene_close(&b);
}

/* ---- when the next one hosts ---- */

enum { LEAVES_S = 5 };

static int by_time(const void *a, const void *b)
{
    const ll_time x = *(const ll_time *)a, y = *(const ll_time *)b;
    return x < y ? -1 : x > y;
}

/* By hand, from the lags alone: the times at which player `p` notices, asks `next`, and is let in, after the
 * host left; all exact. Votes of more than half of the players are needed, with the next host's own. */
static void expect_times(const table *t, int next, bool asks, ll_time notice, ll_time accepted[MOST])
{
    ll_time lag[MOST], notices[MOST], votes[MOST], come[MOST];
    const int n = t->players;
    int count = 0;
    for (int p = 0; p < n; p++)
        lag[p] = ll_ms(t->lag_ms[p]);
    for (int p = 1; p < n; p++) /* the last update was sent as the host left */
        notices[p] = lag[0] + lag[p] + notice;
    for (int p = 1; p < n; p++) {
        votes[p] = notices[p];
        for (int other = 1; asks && other < n; other++) {
            ll_time heard = notices[other] + lag[other] + lag[p];
            if (other != p && heard > votes[p])
                votes[p] = heard;
        }
        if (p != next)
            come[count++] = votes[p] + lag[p] + lag[next];
    }
    qsort(come, (size_t)count, sizeof come[0], by_time);
    ll_time hosts = come[n / 2 + 1 - 2]; /* besides its own */
    hosts = votes[next] > hosts ? votes[next] : hosts;
    for (int p = 1; p < n; p++) {
        ll_time let_in = p == next ? hosts : votes[p] + lag[p] + lag[next];
        let_in = let_in > hosts ? let_in : hosts;
        accepted[p] = let_in + (p == next ? 0 : lag[p] + lag[next]);
    }
}

static void migrate(const table *t, const char *election, bool announced, int next)
{
    char elects[64];
    ll_time expected[MOST];
    const bool asks = strcmp(election, "lowest_index") != 0;
    snprintf(elects, sizeof elects, "hosting.election=%s", election);
    const char *const sets[] = {elects, "hosting.leaves_s=5",
                                announced ? "hosting.leaving=announced" : "hosting.leaving=silent", NULL};
    scene s = open_table(t, sets);
    scene_run(&s, LEAVES_S - 0.01, NULL);
    assert_int_equal(hosting(&s)->host, 0);
    scene_run(&s, LEAVES_S + 6, NULL);
    assert_int_equal(hosting(&s)->host, next);
    assert_int_equal(hosting(&s)->changes, 1);
    expect_times(t, next, asks, announced ? 0 : LL_SECOND, expected);
    for (int p = 1; p < t->players; p++) {
        assert_int_equal(hosting(&s)->view[p].without_sum, expected[p]);
        assert_true(ll_netgame_server(s.game)->client_slots[p].connection.connected);
    }
    assert_int_equal(hosting(&s)->since - LEAVES_S * LL_SECOND, expected[next]);
    assert_false(ll_netgame_server(s.game)->client_slots[0].connection.connected);
    if (announced)
        assert_int_equal(hosting(&s)->lost_ticks, 0);
    assert_sound(&s);
    scene_close(&s);
}

static void the_time_without_a_host_is_that_of_the_lags(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free", "deterministic", "rollback"};
    for (int i = 0; i < 3; i++) {
        const table t = {4, {40, 60, 25, 90}, syncs[i], ""}, five = {5, {10, 90, 30, 60, 5}, syncs[i], ""};
        for (int announced = 0; announced < 2; announced++) {
            migrate(&t, "lowest_index", announced, 1);
            migrate(&t, "best_connection", announced, 2);
            migrate(&five, "lowest_index", announced, 1);
            migrate(&five, "best_connection", announced, 4);
        }
    }
}

/* netcode-2.md: at most the time-out and two of the longest round trips. */
static void the_gap_is_bounded(void **state)
{
    (void)state;
    static const char *const elections[] = {"lowest_index", "newest_state", "best_connection"};
    for (uint64_t n = 0; n < 30; n++) {
        table t = {3 + (int)(3 * ll_rng_unit(11, 0, n)), {0}, n % 2 ? "free" : "rollback", ""};
        double most = 0;
        char elects[64];
        for (int p = 0; p < t.players; p++) {
            t.lag_ms[p] = 60 * ll_rng_unit(11, 1 + (uint64_t)p, n);
            for (int other = 0; other < p; other++)
                most = fmax(most, 2 * (t.lag_ms[p] + t.lag_ms[other]));
        }
        snprintf(elects, sizeof elects, "hosting.election=%s", elections[n % 3]);
        const char *const sets[] = {elects, "hosting.leaves_s=5", NULL};
        scene s = open_table(&t, sets);
        scene_run(&s, LEAVES_S + 4, NULL);
        assert_int_equal(hosting(&s)->changes, 1);
        for (int p = 1; p < t.players; p++)
            assert_true(hosting(&s)->view[p].without_sum > 0 &&
                        hosting(&s)->view[p].without_sum <= LL_SECOND + ll_ms(2 * most) + 1000);
        scene_close(&s);
    }
}

/* ---- what becomes of the state ---- */

/* With `free` the next host goes on from its newest snapshot: what the last one made after that is lost, and
 * an announcement saves it. */
static void a_silent_host_takes_its_last_steps_along(void **state)
{
    (void)state;
    const table t = {4, {40, 60, 25, 90}, "free", ""};
    static const char *const silent[] = {"hosting.leaves_s=5.1", NULL};
    static const char *const announced[] = {"hosting.leaves_s=5.1", "hosting.leaving=announced", NULL};
    static const char *const goes_on[] = {"hosting.leaves_s=5.1", "hosting.meanwhile=run_on", NULL};
    scene a = open_table(&t, silent), b = open_table(&t, announced), c = open_table(&t, goes_on);
    scene_run(&a, 9, NULL);
    scene_run(&b, 9, NULL);
    scene_run(&c, 9, NULL);
    assert_int_equal(hosting(&a)->lost_ticks, 0); /* an update was sent as it left, and it arrives */
    assert_int_equal(hosting(&b)->lost_ticks, 0);
    for (int p = 0; p < 4; p++)
        assert_true(hosting(&a)->view[p].set_back_m == 0 && hosting(&b)->view[p].set_back_m == 0);
    /* all steps from the last snapshot to the present, at once */
    const ll_time gap = hosting(&c)->since - (ll_time)(5.1 * 1e9);
    assert_int_equal(hosting(&c)->again_ticks, (gap - 1) * 60 / LL_SECOND);
    assert_int_equal(ll_netgame_server(a.game)->step, ll_netgame_server(c.game)->step);
    assert_true(ll_server_world_const(ll_netgame_server(c.game))->entity[1].x >
                ll_server_world_const(ll_netgame_server(a.game))->entity[1].x + 1);
    scene_close(&a);
    scene_close(&b);
    scene_close(&c);
}

/* Between two updates: the steps since the last one are lost. 5.3 s are 318 steps, and updates of 7 Hz the
 * 37th at 5.285 s, which sends step 317; the 36th, at 5.142 s, step 308. */
static void steps_after_the_last_snapshot_are_lost(void **state)
{
    (void)state;
    const table t = {4, {40, 60, 25, 90}, "free", ""};
    static const char *const sets[] = {"hosting.leaves_s=5.3", "server.update_hz=7", NULL};
    scene s = open_table(&t, sets);
    scene_run(&s, 5.25, NULL);
    const double before = ll_server_world_const(ll_netgame_server(s.game))->entity[1].x;
    scene_run(&s, 9, NULL);
    assert_int_equal(hosting(&s)->lost_ticks, 1);
    assert_true(before > 0 && hosting(&s)->view[1].set_back_m > 0 && hosting(&s)->view[1].set_back_m < 1);
    scene_close(&s);
}

/* Afterwards all replicas are equal at each tick: no desync, for every host, election and leaving.
 */
static void peers_agree_after_every_change(void **state)
{
    (void)state;
    static const char *const syncs[] = {"deterministic", "rollback"};
    static const char *const elections[] = {"hosting.election=lowest_index", "hosting.election=newest_state",
                                            "hosting.election=best_connection"};
    int moved = 0;
    for (uint64_t n = 0; n < 24; n++) {
        char seed[32];
        table t = {5,
                   {0},
                   syncs[n % 2],
                   n % 4 < 2
                       ? ""
                       : ",\"link\":{\"up\":{\"loss_pct\":3,\"jitter_ms\":10},\"down\":{\"loss_pct\":3}}"};
        for (int p = 0; p < 5; p++)
            t.lag_ms[p] = 5 + 60 * ll_rng_unit(13, (uint64_t)p, n);
        snprintf(seed, sizeof seed, "seed=%d", (int)n);
        const char *const sets[] = {elections[n % 3],
                                    n % 5 < 3 ? "hosting.leaving=silent" : "hosting.leaving=announced",
                                    "hosting.leaves_s=3",
                                    "hosting.every_s=6",
                                    seed,
                                    NULL};
        scene s = open_table(&t, sets);
        for (int k = 1; k <= 130; k++) {
            scene_run(&s, k / 10.0, NULL);
            assert_sound(&s);
        }
        /* the second host leaves at about 10 s; three of five are left, and go on */
        assert_int_equal(hosting(&s)->changes, 2);
        const int64_t step = ll_netgame_server(s.game)->step;
        scene_run(&s, 15, NULL);
        assert_true(ll_netgame_server(s.game)->step > step + 2);
        for (int p = 0; p < 5; p++) {
            assert_int_equal(ll_netgame_server(s.game)->client_slots[p].peer.desync, -1);
            assert_int_equal(ll_netgame_desync(s.game, p)->tick, -1);
            if (!(hosting(&s)->gone >> p & 1))
                assert_true(ll_netgame_desync(s.game, p)->compared > step - 60);
        }
        moved += hosting(&s)->lost_ticks > 0;
        scene_close(&s);
    }
    assert_true(moved > 0); /* or nothing was tested */
}

/* With the newest state no tick is lost that a remaining player had confirmed, though the first in the list
 * lacks the last ones: its line is cut for a moment as the host leaves. */
static void the_newest_state_loses_no_confirmed_tick(void **state)
{
    (void)state;
    int older = 0;
    for (int n = 0; n < 24; n++) {
        char cut[64];
        const table t = {4, {10, 60, 20, 35}, n % 2 ? "rollback" : "deterministic", ""};
        snprintf(cut, sizeof cut, "players.1.link.down.blackout_at_ms=%d", 3800 + 10 * n);
        const char *const sets[] = {
            n % 4 < 2 ? "hosting.election=newest_state" : "hosting.election=lowest_index",
            "hosting.leaves_s=4", cut, "players.1.link.down.blackout_length_ms=250", NULL};
        scene s = open_table(&t, sets);
        int64_t newest = 0;
        while (hosting(&s)->changes == 0) {
            for (int p = 1; p < 4; p++) {
                const int64_t confirmed = ll_client_peer(ll_netgame_client(s.game, p))->confirmed;
                newest = confirmed > newest ? confirmed : newest;
            }
            scene_run(&s, (double)s.game->now / 1e9 + 1.0 / 60, NULL);
            assert_true(s.game->now < 10 * LL_SECOND);
        }
        older += n % 4 >= 2 && ll_netgame_server(s.game)->step < newest;
        assert_true(n % 4 >= 2 || ll_netgame_server(s.game)->step >= newest);
        scene_close(&s);
    }
    assert_true(older > 0); /* the election by index does lose some */
}

/* ---- one host at a time ---- */

/* A host whose line is cut for longer than the time-out stops by itself before the others have the next one,
 * and comes back as a player. */
static void a_host_that_is_cut_off_steps_down(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free", "rollback"};
    for (int i = 0; i < 2; i++) {
        const table t = {4, {40, 60, 25, 90}, syncs[i], ""};
        static const char *const sets[] = {
            "players.0.link.up.blackout_at_ms=4000", "players.0.link.up.blackout_length_ms=6000",
            "players.0.link.down.blackout_at_ms=4000", "players.0.link.down.blackout_length_ms=6000", NULL};
        scene s = open_table(&t, sets);
        for (int k = 1; k <= 160; k++) {
            scene_run(&s, k / 10.0, NULL);
            assert_sound(&s);
        }
        assert_int_equal(hosting(&s)->step_downs, 1);
        assert_int_equal(hosting(&s)->changes, 1);
        assert_int_equal(hosting(&s)->host, 1);
        for (int p = 0; p < 4; p++)
            assert_true(ll_netgame_server(s.game)->client_slots[p].connection.connected);
        if (i == 1)
            for (int p = 0; p < 4; p++)
                assert_int_equal(ll_netgame_desync(s.game, p)->tick, -1);
        scene_close(&s);
    }
}

/* A player whose line is cut asks for another host, gets none, and finds its own again. */
static void a_player_that_is_cut_off_changes_nothing(void **state)
{
    (void)state;
    const table t = {4, {40, 60, 25, 90}, "free", ""};
    static const char *const sets[] = {
        "players.2.link.up.blackout_at_ms=4000", "players.2.link.up.blackout_length_ms=5000",
        "players.2.link.down.blackout_at_ms=4000", "players.2.link.down.blackout_length_ms=5000", NULL};
    scene s = open_table(&t, sets);
    scene_run(&s, 13, NULL);
    assert_int_equal(hosting(&s)->changes, 0);
    assert_int_equal(hosting(&s)->step_downs, 0);
    assert_true(ll_netgame_client(s.game, 2)->connection.joins == 2);
    assert_true(ll_netgame_server(s.game)->client_slots[2].connection.connected);
    scene_close(&s);
}

/* Without a majority no one hosts, and the game stands still. */
static void two_of_four_do_not_go_on(void **state)
{
    (void)state;
    const table t = {4, {40, 60, 25, 90}, "free", ""};
    static const char *const sets[] = {"hosting.leaves_s=4", "hosting.every_s=3", NULL};
    scene s = open_table(&t, sets);
    scene_run(&s, 30, NULL);
    assert_int_equal(hosting(&s)->changes, 1);
    assert_int_equal(hosting(&s)->host, -1);
    const int64_t step = ll_netgame_server(s.game)->step;
    cJSON *metrics = ll_netgame_metrics(s.game);
    assert_true(is_null(metrics, "hosting.host") && value(metrics, "hosting.without_s") > 20);
    cJSON_Delete(metrics);
    scene_run(&s, 40, NULL);
    assert_int_equal(ll_netgame_server(s.game)->step, step);
    scene_close(&s);
}

/* On any links: never a second host (an assertion of the engine), sound blocks, and the game goes
 * on. */
static void bad_links_elect_one_host(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free", "deterministic", "rollback"};
    static const char *const elections[] = {"hosting.election=lowest_index", "hosting.election=newest_state",
                                            "hosting.election=best_connection"};
    int changes = 0, stood = 0;
    for (uint64_t n = 0; n < 36; n++) {
        char seed[32], patience[48], more[256];
        snprintf(seed, sizeof seed, "seed=%d", 900 + (int)n);
        snprintf(patience, sizeof patience, "hosting.patience_s=%g", n % 3 ? 2.0 : 0.5);
        snprintf(more, sizeof more,
                 ",\"link\":{\"up\":{\"loss_pct\":%d,\"jitter_ms\":30,\"duplicate_pct\":5},\"down\":{\"loss_"
                 "pct\":%d,"
                 "\"blackout_at_ms\":%d,\"blackout_every_ms\":9000,\"blackout_length_ms\":1500}}",
                 (int)(n % 4) * 10, (int)(n % 3) * 10, 2000 + (int)(n * 370 % 9000));
        table t = {3 + (int)(n % 4), {0}, syncs[n % 3], n % 6 < 4 ? more : ""};
        for (int p = 0; p < t.players; p++)
            t.lag_ms[p] = 1 + 150 * ll_rng_unit(17, (uint64_t)p, n);
        const char *const sets[] = {elections[n / 3 % 3],
                                    "hosting.leaves_s=4",
                                    "hosting.every_s=5",
                                    seed,
                                    patience,
                                    n % 7 < 3 ? "hosting.leaving=announced" : "hosting.leaving=silent",
                                    NULL};
        scene s = open_table(&t, sets);
        for (int k = 1; k <= 60; k++) {
            scene_run(&s, k / 4.0, NULL);
            assert_sound(&s);
        }
        changes += (int)hosting(&s)->changes;
        stood += hosting(&s)->host < 0;
        for (int p = 0; p < t.players; p++) {
            assert_int_equal(ll_link_get_stats(ll_netgame_up(s.game, p))->overflowed, 0);
            assert_int_equal(ll_link_get_stats(ll_netgame_down(s.game, p))->overflowed, 0);
        }
        scene_close(&s);
    }
    assert_true(changes > 30 && stood < 36);
}

/* The same seed gives the same game, and names are only names. */
static void names_are_only_names(void **state)
{
    (void)state;
    const table t = {4, {40, 60, 25, 90}, "free", ""};
    static const char *const plain[] = {"hosting.leaves_s=4", NULL};
    static const char *const named[] = {"hosting.leaves_s=4", "players.0.name=D", "players.1.name=C",
                                        "players.2.name=B",   "players.3.name=A", NULL};
    scene a = open_table(&t, plain), b = open_table(&t, named), c = open_table(&t, plain);
    same_game(&a, &b, 10);
    scene_run(&c, 10 + 1e-6, NULL);
    assert_true(a.scenario.kind->hash(a.game) == c.scenario.kind->hash(c.game));
    assert_memory_equal(hosting(&a), hosting(&b), sizeof *hosting(&a));
    scene_close(&a);
    scene_close(&b);
    scene_close(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_host_without_lag_is_a_server_in_the_middle),
                                       cmocka_unit_test(lags_add_up_and_the_host_has_none),
                                       cmocka_unit_test(without_a_host_other_parameters_change_nothing),
                                       cmocka_unit_test(the_time_without_a_host_is_that_of_the_lags),
                                       cmocka_unit_test(the_gap_is_bounded),
                                       cmocka_unit_test(a_silent_host_takes_its_last_steps_along),
                                       cmocka_unit_test(steps_after_the_last_snapshot_are_lost),
                                       cmocka_unit_test(peers_agree_after_every_change),
                                       cmocka_unit_test(the_newest_state_loses_no_confirmed_tick),
                                       cmocka_unit_test(a_host_that_is_cut_off_steps_down),
                                       cmocka_unit_test(a_player_that_is_cut_off_changes_nothing),
                                       cmocka_unit_test(two_of_four_do_not_go_on),
                                       cmocka_unit_test(bad_links_elect_one_host),
                                       cmocka_unit_test(names_are_only_names)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
