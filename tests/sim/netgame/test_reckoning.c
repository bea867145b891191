/* Dead reckoning in whole games: what it saves and what it costs. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "support/near.h"
#include "support/scene.h"

typedef struct outcome {
    double mean_m, max_m, bytes_per_s, model_max_m;
    int64_t updates, by_heartbeat, unreadable;
} outcome;

static outcome play(const char *const *sets, double until_s)
{
    scene s = scene_open("dead_reckoning_dis", sets);
    scene_run(&s, until_s, NULL);
    const ll_client_metrics *in = ll_netgame_client_metrics(s.game, 0);
    ll_summary error = ll_histogram_summary(&in->histogram[LL_METRIC_REMOTE_ERROR]);
    outcome o = {.mean_m = error.mean,
                 .max_m = error.max,
                 .bytes_per_s = (double)in->traffic.bytes[LL_MESSAGE_SNAPSHOT] / until_s,
                 .unreadable = ll_netgame_client(s.game, 0)->snapshots.unreadable};
    if (ll_netgame_reckoning(s.game)) {
        const ll_reckoning_counts *c = ll_reckoning_counted(ll_netgame_reckoning(s.game), 0);
        o.updates = c->by_threshold + c->by_heartbeat + c->first;
        o.by_heartbeat = c->by_heartbeat;
        o.model_max_m = ll_histogram_summary(&c->model_error).max;
    }
    scene_close(&s);
    return o;
}

/* The larger the threshold, the fewer states and bytes, and the larger the error; a fifth of the bytes of
 * whole snapshots at the default. */
static void the_threshold_trades_bytes_for_error(void **state)
{
    (void)state;
    const char *const none[] = {"reckoning.model=none", NULL};
    outcome whole = play(none, 60), last = {0};
    const double thresholds[] = {0.05, 0.2, 1, 4};
    for (int i = 0; i < 4; i++) {
        char set[64];
        snprintf(set, sizeof set, "reckoning.threshold_m=%g", thresholds[i]);
        const char *const sets[] = {set, NULL};
        outcome o = play(sets, 60);
        assert_int_equal(o.unreadable, 0);
        assert_true(i == 0 || (o.updates < last.updates && o.bytes_per_s < last.bytes_per_s));
        assert_true(i == 0 || (o.mean_m > last.mean_m && o.max_m > last.max_m));
        assert_true(o.model_max_m >= thresholds[i] && o.bytes_per_s < whole.bytes_per_s);
        if (i == 2)
            assert_true(o.bytes_per_s < whole.bytes_per_s / 4);
        last = o;
    }
}

/* A state is sent at the first update that finds the model too far off, and is believed until the next one
 * arrives: at most an update, the way and a frame later. A car changes its velocity by at most 13.8 m/s2
 * (brakes 9, drag 0.3 / s at 16 m/s), so that an error that never was beyond E grows by at most sqrt(4 a E)
 * m/s. */
static void the_error_is_bounded_by_threshold_and_delay(void **state)
{
    (void)state;
    double last = 0;
    for (int lag = 0; lag <= 200; lag += 100) {
        char own[64];
        snprintf(own, sizeof own, "players.0.lag_ms=%d", lag);
        const char *const sets[] = {own, "players.0.link.down.jitter_ms=0", "reckoning.convergence=snap",
                                    "reckoning.threshold_m=0.5", NULL};
        outcome o = play(sets, 120);
        const double late = lag / 1000.0 + 2.0 / 60 + 1.0 / 30, a = 9 + 0.3 * 16;
        assert_true(o.max_m <= o.model_max_m + sqrt(4 * a * o.model_max_m) * late + a * late * late / 2);
        assert_true(o.max_m >= 0.5 && o.max_m >= last);
        last = o.max_m;
    }
}

/* Losses leave errors until the next state; the more often a heartbeat is due, the sooner it comes. */
static void heartbeats_make_up_for_losses(void **state)
{
    (void)state;
    double last = INFINITY;
    const char *const beats[] = {"reckoning.heartbeat_s=0", "reckoning.heartbeat_s=2",
                                 "reckoning.heartbeat_s=0.2"};
    for (int i = 0; i < 3; i++) {
        const char *const sets[] = {beats[i], "players.0.link.down.loss_pct=30", NULL};
        outcome o = play(sets, 300);
        assert_true(o.mean_m < last);
        assert_true((o.by_heartbeat > 0) == (i > 0));
        last = o.mean_m;
    }
}

/* After an outage a player has all again: the server sends everything until it is acknowledged. */
static void a_player_who_comes_back_has_all_again(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.link.down.blackout_at_ms=20000",
                                "players.0.link.down.blackout_length_ms=8000", "reckoning.heartbeat_s=0",
                                NULL};
    scene s = scene_open("dead_reckoning_dis", sets);
    scene_run(&s, 58, NULL);
    const ll_client *c = ll_netgame_client(s.game, 0);
    assert_true(ll_netgame_server(s.game)->client_slots[0].connection.joins >= 2);
    assert_int_equal(c->snapshots.unreadable, 0);
    const ll_world *truth = ll_server_world_const(ll_netgame_server(s.game)),
                   *shown = ll_client_rendered_const(c);
    for (int i = 1; i < truth->entities; i++)
        assert_near(shown->entity[i].x, truth->entity[i].x, 3);
    scene_close(&s);
}

/* The block may be moved, and its hash covers the states of sender and receivers. */
static void runs_are_equal(void **state)
{
    (void)state;
    const char *const other[] = {"reckoning.tau_s=0.31", NULL};
    scene a = scene_open("dead_reckoning_dis", NULL), b = scene_open("dead_reckoning_dis", NULL),
          c = scene_open("dead_reckoning_dis", other);
    for (int i = 1; i <= 20; i++) {
        scene_run(&a, i, NULL);
        ll_netgame *elsewhere = malloc(ll_netgame_bytes(a.game));
        memcpy(elsewhere, a.game, ll_netgame_bytes(a.game));
        free(a.game);
        a.game = elsewhere;
    }
    scene_run(&b, 20, NULL);
    scene_run(&c, 20, NULL);
    assert_true(a.scenario.kind->hash(a.game) == b.scenario.kind->hash(b.game));
    assert_true(a.scenario.kind->hash(a.game) != c.scenario.kind->hash(c.game));
    scene_close(&a);
    scene_close(&b);
    scene_close(&c);
}

static void refusal(const char *set, const char *field)
{
    ll_scenario scenario;
    char text[200];
    snprintf(text, sizeof text, "{\"kind\": \"netgame\", \"players\": [{}, {}], %s}", set);
    cJSON *json = cJSON_Parse(text);
    ll_status status = ll_scenario_parse(json, &scenario);
    assert_true(ll_failed(&status));
    assert_non_null(strstr(status.text, field));
    cJSON_Delete(json);
}

static void what_cannot_be_reckoned_is_refused(void **state)
{
    (void)state;
    refusal("\"reckoning\": {\"model\": \"velocity\"}, \"server\": {\"sync\": \"rollback\"}",
            "reckoning.model");
    refusal("\"reckoning\": {\"model\": \"velocity\"}, \"server\": {\"snapshot_encoding\": \"delta\"}",
            "reckoning.model");
    refusal("\"reckoning\": {\"tau_s\": 0}", "reckoning.tau_s");
    refusal("\"reckoning\": {\"threshold_m\": -1}", "reckoning.threshold_m");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_threshold_trades_bytes_for_error),
        cmocka_unit_test(the_error_is_bounded_by_threshold_and_delay),
        cmocka_unit_test(heartbeats_make_up_for_losses),
        cmocka_unit_test(a_player_who_comes_back_has_all_again),
        cmocka_unit_test(runs_are_equal),
        cmocka_unit_test(what_cannot_be_reckoned_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
