/* The timeline of a scenario, and its expected events. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"

#define STEPS                                                                                                \
    "[{\"at_s\":1,\"set\":{\"players.1.lag_ms\":300}},"                                                      \
    "{\"at_s\":2,\"set\":{\"players\":{\"0\":{\"link\":{\"up\":{\"delay_ms\":900}}}}}},"                     \
    "{\"at_s\":2.5,\"set\":{\"server.update_hz\":10}}]"

typedef struct text {
    char bytes[1 << 14];
    size_t size;
} text;

static void keep_line(void *context, const char *line, size_t length)
{
    text *t = context;
    assert_true(t->size + length + 1 < sizeof t->bytes);
    memcpy(t->bytes + t->size, line, length);
    t->size += length;
    t->bytes[t->size++] = '\n';
}

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

/* The race with one more member, as JSON. */
static ll_status make(const char *name, const char *value, text *log, ll_session **s)
{
    cJSON *json;
    must(ll_scenario_load("scenarios", "race", &json));
    cJSON_DeleteItemFromObject(json, name);
    cJSON_AddItemToObject(json, name, cJSON_Parse(value));
    ll_status status = ll_session_create(json, 7, log ? keep_line : NULL, log, s);
    cJSON_Delete(json);
    return status;
}

static double param(ll_session *s, const char *object, int player, const char *name)
{
    cJSON *all = ll_session_params(s), *o = cJSON_GetObjectItem(all, object);
    o = player < 0 ? o : cJSON_GetArrayItem(o, player);
    double value = cJSON_GetObjectItem(o, name)->valuedouble;
    cJSON_Delete(all);
    return value;
}

static ll_status patch(ll_session *s, const char *json)
{
    cJSON *o = cJSON_Parse(json);
    ll_status status = ll_session_patch(s, 0, o);
    cJSON_Delete(o);
    return status;
}

/* A step between two ticks acts at the later one, a step at a tick at that tick: never before its time. */
static void no_step_acts_before_its_time(void **state)
{
    (void)state;
    static const struct {
        const char *steps;
        int64_t tick;
    } cases[] = {{"[{\"at_s\":0,\"set\":{\"players.1.lag_ms\":40}}]", 0},
                 {"[{\"at_s\":0.001,\"set\":{\"players.1.lag_ms\":40}}]", 1},
                 {"[{\"at_s\":0.72,\"set\":{\"players.1.lag_ms\":40}}]", 44},        /* tick 43.2 */
                 {"[{\"at_s\":0.316666666,\"set\":{\"players.1.lag_ms\":40}}]", 19}, /* tick 19 */
                 {"[{\"at_s\":0.316666667,\"set\":{\"players.1.lag_ms\":40}}]", 20}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_session *s;
        must(make("timeline", cases[i].steps, NULL, &s));
        for (int64_t k = 0; k < 60; k++) {
            must(ll_session_run_to(s, k));
            assert_int_equal(param(s, "players", 1, "lag_ms") == 40, k >= cases[i].tick);
        }
        ll_session_destroy(s);
    }
}

static void steps_act_at_their_times(void **state)
{
    (void)state;
    ll_session *s;
    must(make("timeline", STEPS, NULL, &s));
    must(ll_session_run_to(s, 59));
    assert_true(param(s, "players", 1, "lag_ms") == 250);
    must(ll_session_run_to(s, 60));
    assert_true(param(s, "players", 1, "lag_ms") == 300);
    must(ll_session_run_to(s, 149));
    assert_true(param(s, "server", -1, "update_hz") == 30);
    must(ll_session_run_to(s, 151));
    assert_true(param(s, "server", -1, "update_hz") == 10);
    assert_int_equal(ll_session_get_info(s).timeline_skipped, 0);
    ll_session_destroy(s);
}

/* Equal to commands with the same values, except for the configuration in the block: so this compares the
 * cars, not the hash. */
static void steps_equal_commands(void **state)
{
    (void)state;
    ll_session *a, *b;
    must(make("timeline", STEPS, NULL, &a));
    must(make("timeline", "[]", NULL, &b));
    must(ll_session_run_to(b, 60));
    must(patch(b, "{\"players.1.lag_ms\":300}"));
    must(ll_session_run_to(b, 120));
    must(patch(b, "{\"players.0.link.up.delay_ms\":900}"));
    must(ll_session_run_to(b, 150));
    must(patch(b, "{\"server.update_hz\":10}"));
    must(ll_session_run_to(a, 600));
    must(ll_session_run_to(b, 600));
    cJSON *x = ll_session_metrics(a), *y = ll_session_metrics(b);
    assert_true(cJSON_Compare(cJSON_GetObjectItem(x, "metrics"), cJSON_GetObjectItem(y, "metrics"), true));
    cJSON_Delete(x);
    cJSON_Delete(y);
    ll_session_destroy(a);
    ll_session_destroy(b);
}

/* A command drops later commands, but no steps of the timeline; seeking, parking, forking and restoring keep
 * them too. */
static void steps_outlive_commands(void **state)
{
    (void)state;
    text log = {.size = 0};
    ll_session *s, *copy, *restored;
    must(make("timeline", STEPS, &log, &s));
    must(ll_session_run_to(s, 200));
    must(ll_session_run_to(s, 30));
    must(patch(s, "{\"players.1.lag_ms\":20}"));
    must(ll_session_run_to(s, 600));
    assert_true(param(s, "players", 1, "lag_ms") == 300);
    uint64_t hash = ll_session_hash(s);
    must(ll_session_run_to(s, 100));
    must(ll_session_run_to(s, 600));
    assert_true(ll_session_hash(s) == hash);
    ll_session_park(s);
    assert_true(ll_session_hash(s) == hash);
    must(ll_session_fork(s, NULL, NULL, &copy));
    assert_true(ll_session_hash(copy) == hash);
    must(ll_session_restore(log.bytes, log.size, NULL, NULL, &restored));
    must(ll_session_run_to(restored, 600));
    assert_true(ll_session_hash(restored) == hash);
    ll_session_destroy(restored);
    ll_session_destroy(copy);
    ll_session_destroy(s);
}

/* Steps that are no longer valid are skipped and counted: here lag and delay together are too long. */
static void invalid_steps_are_reported(void **state)
{
    (void)state;
    ll_session *s;
    must(make("timeline", STEPS, NULL, &s));
    must(patch(s, "{\"players.0.lag_ms\":800}"));
    must(ll_session_run_to(s, 300));
    assert_int_equal(ll_session_get_info(s).timeline_skipped, 1);
    assert_true(param(s, "server", -1, "update_hz") == 10);
    must(ll_session_run_to(s, 100));
    assert_int_equal(ll_session_get_info(s).timeline_skipped, 0);
    ll_session_destroy(s);
}

/* Also when they are from tick 0 on, by a restart: the log gives such a session again. */
static void a_restart_with_invalid_steps_is_restored(void **state)
{
    (void)state;
    text log = {.size = 0};
    ll_session *s, *restored;
    must(make("timeline", STEPS, &log, &s));
    must(ll_session_run_to(s, 10));
    must(patch(s, "{\"players.0.lag_ms\":840}"));
    cJSON *restart = cJSON_Parse("{\"op\":\"restart\"}");
    must(ll_session_control(s, 0, restart));
    cJSON_Delete(restart);
    must(ll_session_run_to(s, 310));
    assert_int_equal(ll_session_get_info(s).timeline_skipped, 1);
    must(ll_session_restore(log.bytes, log.size, NULL, NULL, &restored));
    must(ll_session_run_to(restored, 310));
    assert_true(ll_session_hash(restored) == ll_session_hash(s));
    ll_session_destroy(restored);
    ll_session_destroy(s);
}

static void bad_steps_are_named(void **state)
{
    (void)state;
    static const char *const bad[][2] = {
        {"[{\"at_s\":1,\"set\":{\"players.1.lag_ms\":3000}}]", "timeline.0.set"},
        {"[{\"at_s\":1,\"set\":{\"players.7.lag_ms\":30}}]", "timeline.0.set"},
        {"[{\"at_s\":1,\"set\":{\"game\":\"cannon\"}}]", "timeline.0.set"},
        {"[{\"at_s\":1,\"set\":3}]", "timeline.0.set"},
        {"[{\"at_s\":1,\"set\":{}},{\"at_s\":0.5,\"set\":{}}]", "timeline.1.at_s"},
        {"[{\"at_s\":-1,\"set\":{}}]", "timeline.0.at_s"},
        {"[{\"at_s\":1}]", "timeline.0.set"},
        {"[{\"at_s\":1,\"set\":{\"players.0.lag_ms\":800}},{\"at_s\":2,\"set\":{\"players.0.link.up.delay_"
         "ms\":900}}]",
         "timeline.1.set"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ll_session *s;
        ll_status status = make("timeline", bad[i][0], NULL, &s);
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_string_equal(status.field, bad[i][1]);
        assert_non_null(strstr(status.text, bad[i][1]));
    }
}

static void expectations_are_checked(void **state)
{
    (void)state;
    ll_session *s;
    must(make("expect",
              "[{\"metric\":\"players.0.unacked.mean\",\"min\":1},{\"metric\":\"players.1.corrections\"},"
              "{\"metric\":\"players.9.unacked.mean\"},{\"metric\":\"players\"}]",
              NULL, &s));
    must(ll_session_run_to(s, 300));
    cJSON *report = ll_session_metrics(s);
    cJSON *a = cJSON_GetObjectItem(cJSON_GetObjectItem(report, "metrics"), "expect");
    assert_int_equal(cJSON_GetArraySize(a), 4);
    for (int i = 0; i < 4; i++) {
        cJSON *item = cJSON_GetArrayItem(a, i);
        assert_int_equal(cJSON_IsTrue(cJSON_GetObjectItem(item, "met")), i == 0);
        assert_int_equal(cJSON_IsNull(cJSON_GetObjectItem(item, "value")), i >= 2);
    }
    cJSON_Delete(report);
    ll_session_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_step_acts_before_its_time),
        cmocka_unit_test(steps_act_at_their_times),
        cmocka_unit_test(steps_equal_commands),
        cmocka_unit_test(steps_outlive_commands),
        cmocka_unit_test(invalid_steps_are_reported),
        cmocka_unit_test(a_restart_with_invalid_steps_is_restored),
        cmocka_unit_test(bad_steps_are_named),
        cmocka_unit_test(expectations_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
