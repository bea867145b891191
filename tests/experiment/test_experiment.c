/* Specifications: what they count, what they refuse, and that a row is a function of its index. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/experiment.h"
#include "session/session.h"

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static ll_status parse(const char *text, ll_experiment **e)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    ll_status status = ll_experiment_parse(json, "scenarios", e);
    cJSON_Delete(json);
    return status;
}

static ll_experiment *experiment(const char *text)
{
    ll_experiment *e;
    must(parse(text, &e));
    return e;
}

static double value(const ll_experiment *e, int64_t point, const char *path)
{
    cJSON *values = ll_experiment_point(e, point);
    const cJSON *item = cJSON_GetObjectItem(values, path);
    assert_non_null(item);
    double number = cJSON_IsBool(item) ? cJSON_IsTrue(item) : item->valuedouble;
    cJSON_Delete(values);
    return number;
}

#define METRICS "\"metrics\":[\"players.0.own_lead_m.mean\"]"

/* ---- points ---- */

static void the_last_axis_is_the_fastest(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\",\"values\":[0,100,200]},"
        "{\"path\":\"players.1.lag_ms\",\"from\":10,\"to\":20,\"count\":2}],\"repeats\":4," METRICS "}");
    assert_int_equal(e->points, 6);
    assert_int_equal(e->runs, 24);
    for (int p = 0; p < 6; p++) {
        assert_true(value(e, p, "players.0.lag_ms") == 100 * (p / 2));
        assert_true(value(e, p, "players.1.lag_ms") == 10 + 10 * (p % 2));
    }
    assert_int_equal(ll_experiment_seed(e, 0), 1);
    assert_int_equal(ll_experiment_seed(e, 7), 4); /* the fourth repeat, of any point */
    ll_experiment_free(e);
}

static void zipped_axes_go_together(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"race\",\"axes\":[{\"path\":\"server.update_hz\",\"values\":[10,20]},{\"zip\":["
        "{\"path\":\"players.0.lag_ms\",\"values\":[1,2,3]},{\"path\":\"players.1.lag_ms\",\"values\":[4,5,6]"
        "}]}]," METRICS "}");
    assert_int_equal(e->points, 6);
    for (int p = 0; p < 6; p++) {
        assert_true(value(e, p, "server.update_hz") == (p < 3 ? 10 : 20));
        assert_true(value(e, p, "players.0.lag_ms") == 1 + p % 3);
        assert_true(value(e, p, "players.1.lag_ms") == 4 + p % 3);
    }
    ll_experiment_free(e);
}

static void ranges_hit_both_ends(void **state)
{
    (void)state;
    ll_experiment *e =
        experiment("{\"scenario\":\"race\",\"axes\":[{\"path\":\"server.update_hz\",\"from\":1,\"to\":100,"
                   "\"count\":5,\"scale\":\"log\"}]," METRICS "}");
    static const double wanted[] = {1, 3.1622776601683795, 10, 31.622776601683793, 100};
    for (int p = 0; p < 5; p++)
        assert_true(fabs(value(e, p, "server.update_hz") / wanted[p] - 1) < 1e-15);
    assert_true(value(e, 4, "server.update_hz") == 100);
    ll_experiment_free(e);
}

static void samples_fill_the_range(void **state)
{
    (void)state;
    static const char *const methods[] = {"sobol", "random"};
    for (int k = 0; k < 2; k++) {
        char text[400];
        snprintf(text, sizeof text,
                 "{\"scenario\":\"race\",\"sample\":{\"method\":\"%s\",\"count\":256},\"axes\":[{\"path\":"
                 "\"players.0.lag_ms\",\"from\":100,\"to\":356},{\"path\":\"players.0.prediction\","
                 "\"values\":[false,true]}]," METRICS "}",
                 methods[k]);
        ll_experiment *e = experiment(text);
        int hits[256] = {0}, filled = 0, predicted = 0;
        for (int p = 0; p < 256; p++) {
            double lag = value(e, p, "players.0.lag_ms");
            assert_true(lag >= 100 && lag < 356);
            filled += hits[(int)(lag - 100)]++ == 0;
            predicted += (int)value(e, p, "players.0.prediction");
        }
        if (k == 0) /* a net: each interval once, each choice half of the times */
            assert_true(filled == 256 && predicted == 128);
        else /* 256 (1 - 1/e) = 162 are expected, with a deviation of 5 */
            assert_true(filled > 132 && filled < 192 && predicted > 80 && predicted < 176);
        ll_experiment_free(e);
    }
}

/* ---- rows ---- */

static void a_row_is_that_of_a_session(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"race\",\"set\":{\"duration_s\":3},\"axes\":[{\"path\":\"players.0.lag_ms\","
        "\"values\":[50,120]}],\"repeats\":3," METRICS "}");
    ll_row row, again;
    must(ll_experiment_run(e, 5, NULL, &row));
    must(ll_experiment_run(e, 0, NULL, &again));
    must(ll_experiment_run(e, 5, NULL, &again));
    assert_memory_equal(&row, &again, sizeof row);
    cJSON *json;
    ll_session *s;
    must(ll_scenario_load("scenarios", "race", &json));
    cJSON_ReplaceItemInObject(json, "duration_s", cJSON_CreateNumber(3));
    cJSON_ReplaceItemInObject(cJSON_GetArrayItem(cJSON_GetObjectItem(json, "players"), 0), "lag_ms",
                              cJSON_CreateNumber(120));
    must(ll_session_create(json, 3, NULL, NULL, &s));
    must(ll_session_run_to(s, ll_session_get_info(s).end_tick));
    cJSON *metrics = ll_session_metrics(s);
    assert_true(ll_session_hash(s) == row.hash);
    assert_true(ll_param_number_at(metrics, "metrics.players.0.own_lead_m.mean")->valuedouble ==
                row.metrics[0]);
    assert_true(row.t_s == 3 && row.status == LL_ROW_OK && isnan(row.metrics[1]));
    cJSON_Delete(metrics);
    cJSON_Delete(json);
    ll_session_destroy(s);
    ll_experiment_free(e);
}

static void a_stop_rule_ends_a_run(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"race\",\"stop\":{\"metric\":\"server.steps\",\"above\":100,\"every_s\":0.5},"
        "\"metrics\":[\"server.steps\"]}");
    ll_row row;
    must(ll_experiment_run(e, 0, NULL, &row));
    assert_int_equal(row.status, LL_ROW_STOPPED); /* 60 steps per second: 90 at 1.5 s, 120 at 2 s */
    assert_true(row.t_s == 2 && row.metrics[0] == 120);
    ll_experiment_free(e);
}

/* A step of 5 s suits a duration of 10 s and not one of 1 s: each value is right alone. */
static void what_does_not_go_together_is_told_in_the_row(void **state)
{
    (void)state;
    ll_experiment *e = experiment("{\"scenario\":{\"kind\":\"motion\",\"problem\":\"kepler\",\"duration_s\":"
                                  "10,\"methods\":[{\"method\":\"rk4\"}]},"
                                  "\"axes\":[{\"path\":\"methods.0.dt_s\",\"values\":[0.01,5]},{\"path\":"
                                  "\"duration_s\",\"values\":[10,1]}],"
                                  "\"metrics\":[\"methods.0.e_final\"]}");
    for (int i = 0; i < 4; i++) {
        ll_row row;
        must(ll_experiment_run(e, i, NULL, &row));
        assert_int_equal(row.status, i == 3 ? LL_ROW_REFUSED : LL_ROW_OK);
        assert_true(isnan(row.metrics[0]) == (i == 3));
        assert_true((strstr(row.error, "methods.0.dt_s") != NULL) == (i == 3));
    }
    ll_experiment_free(e);
}

/* ---- refusals ---- */

static void bad_input_is_told(void **state)
{
    (void)state;
    static const struct {
        const char *text, *field, *words;
    } cases[] = {
        {"{" METRICS "}", "scenario", "scenario must be"},
        {"{\"scenario\":\"nosuch\"," METRICS "}", "scenario", "nosuch"},
        {"{\"scenario\":\"race\"," METRICS ",\"axis\":[]}", "axis", "axes"},
        {"{\"scenario\":\"race\"}", "metrics", "metrics must be"},
        {"{\"scenario\":\"race\",\"metrics\":[\"players.0.lag\"]}", "metrics.0", "players.0 has name"},
        {"{\"scenario\":\"race\",\"metrics\":[\"players.7.own_lead_m.mean\"]}", "metrics.0", "2 elements"},
        {"{\"scenario\":\"race\",\"metrics\":[\"players.0.own_lead_m\"]}", "metrics.0", "mean"},
        {"{\"scenario\":\"race\",\"metrics\":[\"server.sync\"]}", "metrics.0", "no number"},
        {"{\"scenario\":\"race\",\"set\":{\"players.0.lags\":1}," METRICS "}", "set.players.0.lags",
         "lag_ms"},
        {"{\"scenario\":\"race\",\"set\":{\"players.0.lag_ms\":-1}," METRICS "}", "set.players.0.lag_ms",
         "-1"},
        {"{\"scenario\":\"race\",\"repeats\":0," METRICS "}", "repeats", "got 0"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.nosuch\",\"values\":[1]}]," METRICS "}",
         "axes.0.path", "players.0.nosuch"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\",\"values\":[]}]," METRICS "}",
         "axes.0", "nothing to run"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\"}]," METRICS "}", "axes.0",
         "needs values"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\",\"values\":[1],\"count\":2}]"
         "," METRICS "}",
         "axes.0", "both"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\",\"values\":[1,-5]}]," METRICS "}",
         "axes.0.players.0.lag_ms", "-5"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"server.update_hz\",\"from\":0,\"to\":9,\"count\":3,"
         "\"scale\":\"log\"}]," METRICS "}",
         "axes.0", "above 0"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"server.sync\",\"from\":0,\"to\":9,\"count\":3}]"
         "," METRICS "}",
         "axes.0", "no number"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players\",\"values\":[1]}]," METRICS "}", "axes.0",
         "one value"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"seed\",\"values\":[1]}]," METRICS "}", "axes.0",
         "repeats"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"server.update_hz\",\"values\":[1]},{\"path\":\"server."
         "update_hz\","
         "\"values\":[2]}]," METRICS "}",
         "axes.1", "already"},
        {"{\"scenario\":\"race\",\"axes\":[{\"zip\":[{\"path\":\"players.0.lag_ms\",\"values\":[1]},{"
         "\"path\":"
         "\"players.1.lag_ms\",\"values\":[1,2]}]}]," METRICS "}",
         "axes.0.zip.1", "2 values"},
        {"{\"scenario\":\"race\",\"repeats\":10,\"axes\":[{\"path\":\"players.0.lag_ms\",\"from\":0,\"to\":9,"
         "\"count\":10000},"
         "{\"path\":\"players.1.lag_ms\",\"from\":0,\"to\":9,\"count\":5000}]," METRICS "}",
         "axes", "10000 x 5000 points, with 10 repeats 5e+08 runs"},
        {"{\"scenario\":\"race\",\"sample\":{\"method\":\"halton\"}," METRICS "}", "sample.method", "sobol"},
        {"{\"scenario\":\"race\",\"stop\":{\"metric\":\"nosuch\"}," METRICS "}", "stop.metric",
         "server, players"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_experiment *e = NULL;
        ll_status status = parse(cases[i].text, &e);
        if (status.code != LL_BAD_INPUT || e || strcmp(status.field, cases[i].field) != 0 ||
            !strstr(status.text, cases[i].words))
            fail_msg("%s\n gives %d, field %s: %s", cases[i].text, (int)status.code, status.field,
                     status.text);
    }
}

static void the_key_knows_what_differs(void **state)
{
    (void)state;
    ll_experiment *a = experiment("{\"scenario\":\"race\"," METRICS "}");
    ll_experiment *b = experiment("{\"scenario\":\"race\",\"repeats\":2," METRICS "}");
    char *text =
        ll_experiment_text(a); /* with the scenario in it: read elsewhere, it is the same experiment */
    ll_experiment *c = experiment(text);
    assert_true(ll_experiment_key(a) != ll_experiment_key(b));
    assert_true(ll_experiment_key(a) == ll_experiment_key(c));
    assert_string_equal(c->head.scenario_id, "race");
    free(text);
    ll_experiment_free(a);
    ll_experiment_free(b);
    ll_experiment_free(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_last_axis_is_the_fastest),
        cmocka_unit_test(zipped_axes_go_together),
        cmocka_unit_test(ranges_hit_both_ends),
        cmocka_unit_test(samples_fill_the_range),
        cmocka_unit_test(a_row_is_that_of_a_session),
        cmocka_unit_test(a_stop_rule_ends_a_run),
        cmocka_unit_test(what_does_not_go_together_is_told_in_the_row),
        cmocka_unit_test(bad_input_is_told),
        cmocka_unit_test(the_key_knows_what_differs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
