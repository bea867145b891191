/* Workloads: inputs recorded in one session drive another, at the same times. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "base/rng.h"
#include "library/library.h"
#include "session/scenario.h"
#include "session/workload.h"

typedef struct text {
    char *bytes;
    size_t size;
} text;

static void put(void *context, const char *piece, size_t length)
{
    text *t = context;
    t->bytes = realloc(t->bytes, t->size + length + 2);
    assert_non_null(t->bytes);
    memcpy(t->bytes + t->size, piece, length);
    t->size += length;
    t->bytes[t->size] = '\0';
}

static void put_line(void *context, const char *line, size_t length)
{
    put(context, line, length);
    put(context, "\n", 1);
}

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

/* `sets`: values by path, as JSON; NULL: none. */
static ll_session *open_session(const char *id, const char *sets, text *log)
{
    cJSON *json, *values = cJSON_Parse(sets ? sets : "{}");
    ll_scenario scenario = {0};
    ll_session *s;
    assert_non_null(values);
    must(ll_scenario_load("scenarios", id, &json));
    must(ll_scenario_parse(json, &scenario));
    must(ll_param_merge(scenario.kind->table, values, scenario.config));
    cJSON *whole = ll_param_write(scenario.kind->table, scenario.config);
    must(ll_session_create(whole, -1, log ? put_line : NULL, log, &s));
    ll_scenario_free(&scenario);
    cJSON_Delete(whole);
    cJSON_Delete(values);
    cJSON_Delete(json);
    return s;
}

static ll_status parse(const char *json, ll_workload **w)
{
    cJSON *o = cJSON_Parse(json);
    assert_non_null(o);
    ll_status status = ll_workload_parse(o, w);
    cJSON_Delete(o);
    return status;
}

static ll_workload *of_log(const char *log)
{
    ll_workload *w;
    cJSON *o = cJSON_CreateString(log);
    must(ll_workload_parse(o, &w));
    cJSON_Delete(o);
    return w;
}

static char *written(const ll_workload *w)
{
    cJSON *o = ll_workload_write(w);
    char *s = cJSON_PrintUnformatted(o);
    cJSON_Delete(o);
    return s;
}

static text trace_of(ll_session *s)
{
    text t = {0};
    must(ll_session_run_to(s, ll_session_get_info(s).end_tick));
    must(ll_session_trace(s, 0, ll_session_get_info(s).end_tick, put, &t));
    return t;
}

#define PEOPLE "\"players.0.control\":\"person\",\"players.1.control\":\"person\""

/* For every game and sync mode: a replay of a script's inputs gives the script's positions at every tick. */
static void recorded_scripts_are_replayed(void **state)
{
    (void)state;
    static const char *const rows[][2] = {
        {"contact",
         "\"seed\":31,\"players.0.lag_ms\":61,\"players.1.link.up.jitter_ms\":35,\"duration_s\":20"},
        {"gambetta", "\"seed\":5,\"players.0.lag_ms\":85,\"duration_s\":20"},
        {"rollback", "\"seed\":6,\"players.0.link.up.loss_pct\":7,\"duration_s\":15"},
        {"deterministic", "\"seed\":6,\"players.1.lag_ms\":45,\"duration_s\":15"},
        {"crates", "\"seed\":8,\"duration_s\":10"},
        {"rifle", "\"seed\":9,\"players.1.lag_ms\":66,\"duration_s\":10"},
        {"paper/fig10",
         "\"seed\":3,\"players.0.clock_phase\":0.3,\"players.1.clock_phase\":0.7,\"duration_s\":15"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        char script[256], person[320];
        text log = {0};
        snprintf(script, sizeof script, "{%s}", rows[i][1]);
        snprintf(person, sizeof person, "{%s,%s}", rows[i][1], PEOPLE);
        ll_session *s = open_session(rows[i][0], script, NULL), *p = open_session(rows[i][0], person, NULL);
        must(ll_session_record(s, put_line, &log));
        ll_workload *w = of_log(log.bytes);
        must(ll_session_load(p, w));
        text a = trace_of(s), b = trace_of(p);
        if (strcmp(a.bytes, b.bytes) != 0)
            fail_msg("%s: trace differs", rows[i][0]);
        free(a.bytes);
        free(b.bytes);
        free(log.bytes);
        ll_workload_free(w);
        ll_session_destroy(s);
        ll_session_destroy(p);
    }
}

/* A recording is a normal log, and recording does not change the run. */
static void a_record_is_a_log(void **state)
{
    (void)state;
    text log = {0};
    ll_session *s = open_session("contact", "{\"duration_s\":8}", NULL),
               *alone = open_session("contact", "{\"duration_s\":8}", NULL), *again;
    must(ll_session_record(s, put_line, &log));
    must(ll_session_run_to(alone, ll_session_get_info(alone).end_tick));
    assert_int_equal(ll_session_hash(s), ll_session_hash(alone));
    must(ll_session_restore(log.bytes, log.size, NULL, NULL, &again));
    assert_int_equal(ll_session_get_info(again).head_tick, ll_session_get_info(s).end_tick);
    text a = trace_of(s), b = trace_of(again);
    assert_string_equal(a.bytes, b.bytes);
    free(a.bytes);
    free(b.bytes);
    free(log.bytes);
    ll_session_destroy(s);
    ll_session_destroy(alone);
    ll_session_destroy(again);
}

/* A workload as JSON, and the log that it came from, parse to the same. */
static void forms_are_one(void **state)
{
    (void)state;
    ll_workload *w, *again;
    must(parse("{\"tick_hz\":50,\"inputs\":[{\"tick\":3,\"player\":1,\"axes\":[0.1,-1]},"
               "{\"op\":\"input\",\"tick\":3,\"player\":0,\"axes\":[0,0.7],\"buttons\":3}]}",
               &w));
    char *one = written(w);
    must(parse(one, &again));
    char *two = written(again);
    assert_string_equal(one, two);
    cJSON_free(one);
    cJSON_free(two);
    ll_workload_free(w);
    ll_workload_free(again);
}

/* Only the present log counts: inputs dropped by a command or a restart are not replayed, and parameters are
 * not part of it. */
static void logs_are_folded(void **state)
{
    (void)state;
    text log = {0};
    ll_session *s = open_session("race", "{" PEOPLE "}", &log);
    const ll_action full = {.axis = {1, 0}}, half = {.axis = {0.5f, 0}}, back = {.axis = {-1, 0}};
    must(ll_session_run_to(s, 100));
    must(ll_session_input(s, 0, 0, &full));
    must(ll_session_run_to(s, 300));
    must(ll_session_input(s, 0, 0, &back));
    must(ll_session_run_to(s, 200)); /* and again from there */
    cJSON *patch = cJSON_Parse("{\"players\":{\"0\":{\"lag_ms\":40}}}");
    must(ll_session_patch(s, 0, patch));
    cJSON_Delete(patch);
    must(ll_session_input(s, 0, 1, &half));
    ll_workload *w = of_log(log.bytes);
    char *is = written(w);
    assert_string_equal(
        is, "{\"tick_hz\":60,\"inputs\":[{\"tick\":100,\"player\":0,\"axes\":[1,0],\"buttons\":0},"
            "{\"tick\":200,\"player\":1,\"axes\":[0.5,0],\"buttons\":0}]}");
    cJSON_free(is);
    ll_workload_free(w);
    ll_session_destroy(s);
    free(log.bytes);
}

/* At another tick rate an input acts at the first tick at or after its time, by exact fractions. */
static void ticks_are_mapped_by_time(void **state)
{
    (void)state;
    for (uint64_t n = 0; n < 300; n++) {
        int64_t here = 10 + (int64_t)(ll_rng_u64(4, 0, n) % 111),
                there = 10 + (int64_t)(ll_rng_u64(4, 1, n) % 55),
                tick = (int64_t)(ll_rng_u64(4, 2, n) % (uint64_t)(9 * here));
        if (n % 3 == 0 && here <= 64)
            there = here;
        char json[200], sets[120], wanted[64];
        text log = {0};
        ll_workload *w;
        snprintf(json, sizeof json, "{\"tick_hz\":%d,\"inputs\":[{\"tick\":%d,\"player\":0,\"axes\":[1,0]}]}",
                 (int)here, (int)tick);
        snprintf(sets, sizeof sets, "{\"tick_hz\":%d,\"duration_s\":10," PEOPLE "}", (int)there);
        must(parse(json, &w));
        ll_session *s = open_session("race", sets, &log);
        must(ll_session_load(s, w));
        int64_t mapped = (tick * there + here - 1) / here;
        snprintf(wanted, sizeof wanted, "{\"op\":\"input\",\"tick\":%d,", (int)mapped);
        if (!strstr(log.bytes, wanted))
            fail_msg("tick %d of %d Hz is %d of %d Hz: %s", (int)tick, (int)here, (int)mapped, (int)there,
                     strrchr(log.bytes, '{'));
        ll_session_destroy(s);
        ll_workload_free(w);
        free(log.bytes);
    }
}

static void inputs_after_the_end_are_left_out(void **state)
{
    (void)state;
    ll_workload *w;
    must(parse(
        "{\"inputs\":[{\"tick\":30,\"player\":0,\"axes\":[1,0]},{\"tick\":119,\"player\":0,\"axes\":[0.2,0]},"
        "{\"tick\":120,\"player\":0,\"axes\":[0,0]},{\"tick\":9999,\"player\":0,\"axes\":[1,0]}]}",
        &w));
    ll_session *s = open_session("race", "{\"duration_s\":2," PEOPLE "}", NULL);
    must(ll_session_load(s, w));
    assert_int_equal(ll_session_get_info(s).log_entries, 2);
    assert_int_equal(ll_session_get_info(s).head_tick, 119);
    assert_int_equal(ll_session_get_info(s).tick, 0);
    must(ll_session_run_to(s, 120));
    ll_session_destroy(s);
    ll_workload_free(w);
}

/* A person's input drops the rest of the workload. */
static void a_command_drops_the_rest(void **state)
{
    (void)state;
    ll_workload *w;
    const ll_action brake = {.axis = {-1, 0}};
    must(parse(
        "{\"inputs\":[{\"tick\":0,\"player\":0,\"axes\":[1,0]},{\"tick\":200,\"player\":0,\"axes\":[0.2,0]},"
        "{\"tick\":300,\"player\":0,\"axes\":[1,0]}]}",
        &w));
    ll_session *s = open_session("race", "{" PEOPLE "}", NULL);
    must(ll_session_load(s, w));
    must(ll_session_run_to(s, 250));
    assert_int_equal(ll_session_get_info(s).log_entries, 3);
    must(ll_session_input(s, 0, 0, &brake));
    assert_int_equal(ll_session_get_info(s).log_entries, 3); /* of 0, 200 and 250 */
    assert_int_equal(ll_session_get_info(s).head_tick, 250);
    ll_session_destroy(s);
    ll_workload_free(w);
}

static void a_wrong_workload_is_a_sentence(void **state)
{
    (void)state;
#define INPUT "{\"tick\":5,\"player\":0,\"axes\":[0,0]}"
    static const struct {
        const char *json, *field, *sentence;
    } rows[] = {
        {"7", "workload", "the text of a log, or an object"},
        {"{}", "workload.inputs", "must be an array"},
        {"{\"inputs\":[]}", "workload", "has no inputs"},
        {"{\"hz\":60,\"inputs\":[" INPUT "]}", "workload", "hz is unknown"},
        {"{\"tick_hz\":0.5,\"inputs\":[" INPUT "]}", "workload.tick_hz", "from 1 to 1000"},
        {"{\"inputs\":[" INPUT ",{\"tick\":4,\"player\":0,\"axes\":[0,0]}]}", "workload.inputs.1",
         "must be at least 5, that of the previous input; got 4"},
        {"{\"inputs\":[" INPUT ",{\"tick\":6,\"player\":64,\"axes\":[0,0]}]}", "workload.inputs.1",
         "player: must be a whole number from 0 to 63; got 64"},
        {"{\"inputs\":[{\"tick\":6.5,\"player\":1,\"axes\":[0,0]}]}", "workload.inputs.0", "got 6.5"},
        {"{\"inputs\":[{\"tick\":6,\"player\":1,\"axes\":[0]}]}", "workload.inputs.0", "two numbers"},
        {"{\"inputs\":[{\"tick\":6,\"player\":1,\"axes\":[0,-1.25]}]}", "workload.inputs.0", "got -1.25"},
        {"{\"inputs\":[{\"tick\":6,\"player\":1,\"axes\":[0,0],\"buttons\":-1}]}", "workload.inputs.0",
         "buttons: must be a whole number from 0 to 4294967295; got -1"},
        {"{\"inputs\":[{\"tick\":6,\"player\":1,\"axes\":[0,0],\"buttons\":8589934592}]}",
         "workload.inputs.0", "buttons: must be a whole number from 0 to 4294967295; got 8589934592"},
        {"{\"inputs\":[{\"tick\":6,\"player\":1,\"axes\":[0,0],\"button\":1}]}", "workload.inputs.0",
         "button is unknown"},
        {"\"no log\"", "workload", "line 1 of the log"},
        {"\"{\\\"op\\\":\\\"input\\\",\\\"tick\\\":3}\"", "workload",
         "line 1 of the log: header missing before this line"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ll_workload *w;
        ll_status status = parse(rows[i].json, &w);
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_string_equal(status.field, rows[i].field);
        if (!strstr(status.text, rows[i].sentence))
            fail_msg("%s: %s", rows[i].json, status.text);
        assert_null(w);
    }
}

static void players_must_be_there_and_driven(void **state)
{
    (void)state;
    static const struct {
        const char *id, *sets, *json;
        ll_code code;
        const char *sentence;
    } rows[] = {
        {"race", "{" PEOPLE "}", "{\"inputs\":[{\"tick\":5,\"player\":2,\"axes\":[0,0]}]}", LL_BAD_INPUT,
         "player: must be 0 to 1; got 2"},
        {"race", NULL, "{\"inputs\":[" INPUT "]}", LL_CONFLICT, "set players.0.control, or"},
        {"race", "{\"players.1.control\":\"person\"}", "{\"inputs\":[" INPUT "]}", LL_CONFLICT,
         "no player takes"},
        {"motion/pendulum", NULL, "{\"inputs\":[" INPUT "]}", LL_BAD_INPUT, "kind motion has no players"}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        ll_workload *w;
        ll_session *s = open_session(rows[i].id, rows[i].sets, NULL);
        must(parse(rows[i].json, &w));
        ll_status status = ll_session_load(s, w);
        assert_int_equal(status.code, rows[i].code);
        if (!strstr(status.text, rows[i].sentence))
            fail_msg("%s", status.text);
        assert_int_equal(ll_session_get_info(s).log_entries, 0);
        ll_workload_free(w);
        ll_session_destroy(s);
    }
    ll_session *s = open_session("motion/pendulum", NULL, NULL);
    ll_status status = ll_session_record(s, put_line, &(text){0});
    assert_int_equal(status.code, LL_CONFLICT);
    ll_session_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(recorded_scripts_are_replayed),
        cmocka_unit_test(a_record_is_a_log),
        cmocka_unit_test(forms_are_one),
        cmocka_unit_test(logs_are_folded),
        cmocka_unit_test(ticks_are_mapped_by_time),
        cmocka_unit_test(inputs_after_the_end_are_left_out),
        cmocka_unit_test(a_command_drops_the_rest),
        cmocka_unit_test(a_wrong_workload_is_a_sentence),
        cmocka_unit_test(players_must_be_there_and_driven),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
