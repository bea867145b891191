/* Profiles of links in a netgame: who has one, who has none, and what is refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "library/library.h"
#include "sim/netgame/readings.h"
#include "support/netgame_valid.h"

#define DOWN "players.0.link.down."

static cJSON *metrics_of(const char *const *sets)
{
    scene s = scene_open("race", sets);
    scene_run(&s, 20, NULL);
    assert_null(netgame_broken(s.game));
    cJSON *metrics = s.scenario.kind->metrics(s.game);
    scene_close(&s);
    return metrics;
}

/* Profiles that no link names change no metric; nor does one that is named and in which nothing is chosen. */
static void a_profile_that_does_nothing_changes_no_metric(void **state)
{
    (void)state;
    cJSON *none = metrics_of((const char *const[]){NULL});
    cJSON *unnamed = metrics_of((const char *const[]){"profiles=[{\"slot_max_ms\":9},{\"ecn\":true}]", NULL});
    cJSON *empty = metrics_of(
        (const char *const[]){"profiles=[{\"slot_max_ms\":9},{}]", DOWN "profile=profile_1", NULL});
    assert_true(cJSON_Compare(none, unnamed, true));
    assert_true(cJSON_Compare(none, empty, true));
    cJSON_Delete(none);
    cJSON_Delete(unnamed);
    cJSON_Delete(empty);
}

/* The blackout of a window and that of a trace lose the same messages. */
static void a_trace_loses_what_a_blackout_does(void **state)
{
    (void)state;
    cJSON *window =
        metrics_of((const char *const[]){DOWN "blackout_at_ms=3000", DOWN "blackout_length_ms=1500", NULL});
    cJSON *trace = metrics_of((const char *const[]){"profiles=[{\"trace_t_ms\":[0,3000,4500,60000],\"trace_"
                                                    "delay_ms\":[0,0,0,0],\"trace_lost\":[0,1,0,0]}]",
                                                    DOWN "profile=profile_0", NULL});
    static const char *const alike[] = {"players.0.link_down.lost", "players.0.link_down.sent",
                                        "players.0.link_down.messages_lost", "players.0.remote_error_m.mean"};
    for (size_t i = 0; i < sizeof alike / sizeof alike[0]; i++)
        assert_true(value(window, alike[i]) == value(trace, alike[i]));
    assert_true(value(trace, "players.0.link_down.trace_lost") > 20);
    assert_true(value(trace, "players.0.link_down.trace_lost") ==
                value(window, "players.0.link_down.lost_in_blackouts"));
    cJSON_Delete(window);
    cJSON_Delete(trace);
}

/* A distance is a delay: the same race, to the last digit. */
static void a_distance_is_a_delay(void **state)
{
    (void)state;
    cJSON *delay = metrics_of((const char *const[]){DOWN "delay_ms=25", NULL});
    cJSON *far = metrics_of((const char *const[]){"profiles=[{\"distance_km\":4996.540975}]", /* 25 ms */
                                                  DOWN "profile=profile_0", NULL});
    assert_true(value(far, "players.0.link_down.delay_mean_ms") - 25 <
                value(delay, "players.0.link_down.delay_mean_ms") - 25 + 1e-6);
    assert_true(value(far, "players.0.game.laps") == value(delay, "players.0.game.laps"));
    assert_true(value(far, "players.0.link_down.sent") == value(delay, "players.0.link_down.sent"));
    cJSON_Delete(delay);
    cJSON_Delete(far);
}

/* A slow queue delays the packets of all, a fast one by no more than its transmission. */
static void a_shared_queue_is_felt_by_all(void **state)
{
    (void)state;
    cJSON *slow = metrics_of((const char *const[]){"bottleneck.rate_kbps=130", "server.update_hz=30", NULL});
    cJSON *fast = metrics_of((const char *const[]){"bottleneck.rate_kbps=100000", NULL});
    cJSON *crowded =
        metrics_of((const char *const[]){"bottleneck.rate_kbps=2000", "bottleneck.cross_load_pct=80", NULL});
    cJSON *none = metrics_of((const char *const[]){NULL});
    for (int i = 0; i < 2; i++) {
        char path[48];
        snprintf(path, sizeof path, "players.%d.link_down.delay_mean_ms", i);
        double plain = value(none, path);
        assert_true(value(slow, path) > plain + 2);
        assert_true(value(fast, path) > plain && value(fast, path) < plain + 0.1);
        /* M/D/1 of 6 ms at 80 %: 12 ms of wait, and the own transmission */
        assert_true(value(crowded, path) > plain + 8 && value(crowded, path) < plain + 18);
    }
    cJSON_Delete(slow);
    cJSON_Delete(fast);
    cJSON_Delete(crowded);
    cJSON_Delete(none);
}

/* Over tcp and quic nothing is lost where links mark, and so nothing is sent again; the window is smaller all
 * the same. A queue that marks drops only what cannot be marked. */
static void transports_react_to_marks(void **state)
{
    (void)state;
    static const char *const kinds[] = {"server.transport=tcp", "server.transport=quic"};
    for (int i = 0; i < 2; i++) {
        cJSON *lossy = metrics_of((const char *const[]){kinds[i], DOWN "loss_pct=3", NULL});
        cJSON *marking = metrics_of((const char *const[]){kinds[i], "profiles=[{\"ecn\":true}]",
                                                          DOWN "profile=profile_0", DOWN "loss_pct=3", NULL});
        static const char *const down = "players.0.transport_down.";
        char again[64], window[64], timeouts[64];
        snprintf(again, sizeof again, "%sretransmissions", down);
        snprintf(window, sizeof window, "%swindow_bytes.min", down);
        snprintf(timeouts, sizeof timeouts, "%stimeouts", down);
        assert_true(value(lossy, again) > 5 && value(lossy, "players.0.link_down.marked") == 0);
        assert_true(value(marking, again) == 0 && value(marking, timeouts) == 0);
        assert_true(value(marking, "players.0.link_down.marked") > 5);
        assert_true(value(marking, window) < 6000); /* of 10 mss at first */
        cJSON_Delete(lossy);
        cJSON_Delete(marking);
    }
}

static void what_a_link_cannot_have_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *sets[5], *sentence;
    } cases[] = {
        {{DOWN "profile=profile_0"},
         DOWN "profile: must be none or one of the scenario's 0 profiles; got profile_0"},
        {{"profiles=[{}]", DOWN "profile=profile_1"},
         DOWN "profile: must be none or one of the scenario's 1 profiles; got profile_1"},
        {{"profiles=[{\"capacity_ms\":[1]}]", DOWN "profile=profile_0", DOWN "rate_kbps=9"},
         DOWN "profile: profile_0 has a capacity, and rate_kbps must then be 0; got 9"},
        {{"profiles=[{\"capacity_ms\":[1],\"slot_max_ms\":9}]", DOWN "profile=profile_0",
          "players.0.lag_ms=300"},
         "players.0.link.down must delay a packet by at most 1250 ms: with the distance, trace and table of "
         "its "
         "profile, limit_ms of a capacity, of slots and of the bottleneck; got 1300"},
        {{"bottleneck.rate_kbps=100", "bottleneck.limit_ms=1000", "players.1.lag_ms=251"},
         "players.1.link.up must delay a packet by at most 1250 ms: with the distance, trace and table of "
         "its profile, "
         "limit_ms of a capacity, of slots and of the bottleneck; got 1251"},
        {{"profiles=[{\"capacity_ms\":[2,1]}]"},
         "profiles.0.capacity_ms.1: must be at least the one before it, 2 ms; got 1"},
        {{"profiles=[{},{\"capacity_ms\":[0.5]}]"},
         "profiles.1.capacity_ms.0: must be a whole number of ms; got 0.5"},
        {{"profiles=[{\"capacity_ms\":[0,0]}]"},
         "profiles.0.capacity_ms: the last time must be at least 1 ms; got 0"},
        {{"profiles=[{\"trace_t_ms\":[0]}]"},
         "profiles.0.trace_delay_ms: must have as many numbers as trace_t_ms, 1; got 0"},
        {{"profiles=[{\"trace_t_ms\":[1]}]"}, "profiles.0.trace_t_ms.0: must be 0; got 1"},
        {{"profiles=[{\"slot_min_ms\":3}]"},
         "profiles.0.slot_min_ms: must be at most slot_max_ms, 0 ms; got 3"},
        {{"profiles=[{\"slot_max_ms\":3,\"slot_start\":\"grid\"}]"},
         "profiles.0.slot_min_ms: must be slot_max_ms, 3 ms, where slot_start is grid; got 0"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        cJSON *json;
        ll_scenario s = {0};
        int n = 0;
        while (n < 5 && cases[i].sets[n])
            n++;
        ll_status status = ll_scenario_load("scenarios", "race", &json);
        assert_string_equal(status.text, "");
        status = ll_scenario_parse(json, &s);
        assert_string_equal(status.text, "");
        status = ll_param_put(s.kind->table, s.config, cases[i].sets, n);
        assert_string_equal(status.text, "");
        status = ll_param_check(s.kind->table, s.config);
        assert_string_equal(status.text, cases[i].sentence);
        ll_scenario_free(&s);
        cJSON_Delete(json);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_profile_that_does_nothing_changes_no_metric),
        cmocka_unit_test(a_trace_loses_what_a_blackout_does),
        cmocka_unit_test(a_distance_is_a_delay),
        cmocka_unit_test(a_shared_queue_is_felt_by_all),
        cmocka_unit_test(transports_react_to_marks),
        cmocka_unit_test(what_a_link_cannot_have_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
