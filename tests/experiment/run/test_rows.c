/* Rows of an experiment: what a run gives, what it costs, and how it fails. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/fixture.h"
#include "library/library.h"

static void a_row_is_that_of_a_session(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"race\",\"set\":{\"duration_s\":3},\"axes\":[{\"path\":\"players.0.lag_ms\","
        "\"values\":[50,120]}],\"repeats\":3," METRICS "}");
    ll_row row, again;
    must(ll_experiment_run(e, 5, NULL, NULL, &row));
    must(ll_experiment_run(e, 0, NULL, NULL, &again));
    must(ll_experiment_run(e, 5, NULL, NULL, &again));
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

/* Of states of several sizes, larger and smaller than the one before. */
static void a_kept_block_changes_no_row(void **state)
{
    (void)state;
    static const char *const forms[] = {
        "{\"scenario\":\"race\",\"set\":{\"duration_s\":2}," METRICS "}",
        "{\"scenario\":\"eight\",\"set\":{\"duration_s\":1}," METRICS "}",
        "{\"scenario\":\"rigid/column\",\"set\":{\"duration_s\":0.5},\"metrics\":[\"energy_change_j\"]}",
    };
    static const int order[] = {0, 1, 1, 2, 0, 2, 1};
    ll_kept_block kept = {0};
    void *block = NULL;
    for (int i = 0; i < (int)(sizeof order / sizeof *order); i++) {
        ll_experiment *e = experiment(forms[order[i]]);
        ll_row row, alone;
        must(ll_experiment_run(e, 0, NULL, NULL, &alone));
        size_t before = kept.size;
        must(ll_experiment_run(e, 0, NULL, &kept, &row));
        assert_memory_equal(&row, &alone, sizeof row);
        assert_non_null(kept.block); /* returned */
        assert_true(i == 0 || order[i] != order[i - 1] || (kept.block == block && kept.size == before));
        block = kept.block;
        ll_experiment_free(e);
    }
    ll_kept_block_free(&kept);
}

static void a_stop_rule_ends_a_run(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"race\",\"stop\":{\"metric\":\"server.steps\",\"above\":100,\"every_s\":0.5},"
        "\"metrics\":[\"server.steps\"]}");
    ll_row row;
    must(ll_experiment_run(e, 0, NULL, NULL, &row));
    assert_int_equal(row.status, LL_ROW_STOPPED); /* 60 steps per second: 90 at 1.5 s, 120 at 2 s */
    assert_true(row.t_s == 2 && row.metrics[0] == 120);
    ll_experiment_free(e);
}

#define COST "cost.ns_per_sim_s"

/* Sixteen times the steps cost more; hashes and all other metrics are unchanged by measuring. */
static void cost_is_measured_and_changes_nothing(void **state)
{
    (void)state;
    static const char form[] =
        "{\"scenario\":\"rigid/column\",\"set\":{\"duration_s\":1},\"axes\":[{\"path\":\"hz\","
        "\"values\":[60,960]}],\"repeats\":2,\"metrics\":[%s\"energy_change_j\"]}";
    char with[400], without[400];
    snprintf(with, sizeof with, form, "\"" COST "\",");
    snprintf(without, sizeof without, form, "");
    ll_experiment *e = experiment(with), *plain = experiment(without);
    ll_row rows[4], row;
    for (int run = 0; run < 4; run++) {
        must(ll_experiment_run(e, run, NULL, NULL, &rows[run]));
        must(ll_experiment_run(plain, run, NULL, NULL, &row));
        assert_true(rows[run].hash == row.hash && rows[run].metrics[1] == row.metrics[0]);
        assert_true(rows[run].metrics[0] > 0 && rows[run].metrics[0] < 1e10);
    }
    assert_true(rows[2].metrics[0] > 3 * rows[0].metrics[0]);
    ll_points points;
    rows[1].metrics[0] = rows[0].metrics[0] + 1;
    must(ll_points_read(e, next_given, &(given){rows, 0, 4}, &points));
    assert_int_equal(points.identical, 2); /* all metrics equal, except the measured one */
    ll_points_free(&points);
    ll_experiment_free(e);
    ll_experiment_free(plain);
}

/* A failed run has no cost. */
static void failed_runs_have_no_cost(void **state)
{
    (void)state;
    ll_row row;
    ll_experiment *e = experiment(
        "{\"scenario\":{\"kind\":\"rigid\",\"duration_s\":20,\"gravity\":[0,0],\"bodies\":[{},{\"velocity\":"
        "[800000,0],\"position\":[990000000,3]}]},\"metrics\":[\"" COST "\"]}");
    must(ll_experiment_run(e, 0, NULL, NULL, &row));
    assert_true(row.status == LL_ROW_DIVERGED && isnan(row.metrics[0]));
    ll_experiment_free(e);
}

/* As when a session is made of the run's scenario: steps out of order, and one that the point's values
 * forbid. */
static void a_timeline_that_a_point_contradicts_is_refused(void **state)
{
    (void)state;
    static const char *const of[][2] = {
        {"{\"scenario\":\"race\",\"set\":{\"duration_s\":0.5,\"timeline\":[{\"at_s\":0.1,\"set\":{\"players."
         "0.lag_ms\":9}},"
         "{\"at_s\":0.2,\"set\":{\"players.0.lag_ms\":5}}]},\"axes\":[{\"path\":\"timeline.0.at_s\","
         "\"values\":[0.1,0.3]}]," METRICS "}",
         "timeline.1.at_s"},
        {"{\"scenario\":{\"kind\":\"motion\",\"problem\":\"free_fall\",\"duration_s\":10,\"methods\":[{"
         "\"method\":\"rk4\"}],"
         "\"timeline\":[{\"at_s\":0.5,\"set\":{\"methods.0.dt_s\":5}}]},\"axes\":[{\"path\":\"duration_s\","
         "\"values\":[10,1]}],"
         "\"metrics\":[\"methods.0.e_final\"]}",
         "timeline.0.set"},
    };
    for (size_t k = 0; k < sizeof of / sizeof of[0]; k++) {
        ll_experiment *e = experiment(of[k][0]);
        for (int i = 0; i < 2; i++) {
            ll_row row;
            must(ll_experiment_run(e, i, NULL, NULL, &row));
            assert_int_equal(row.status, i == 1 ? LL_ROW_REFUSED : LL_ROW_OK);
            assert_true((strstr(row.error, of[k][1]) != NULL) == (i == 1));
        }
        ll_experiment_free(e);
    }
}

/* A step of 5 s is valid with a duration of 10 s but not of 1 s: each value is valid alone. */
static void invalid_combinations_are_reported_in_the_row(void **state)
{
    (void)state;
    ll_experiment *e =
        experiment("{\"scenario\":{\"kind\":\"motion\",\"problem\":\"free_fall\",\"duration_s\":"
                   "10,\"methods\":[{\"method\":\"rk4\"}]},"
                   "\"axes\":[{\"path\":\"methods.0.dt_s\",\"values\":[0.01,5]},{\"path\":"
                   "\"duration_s\",\"values\":[10,1]}],"
                   "\"metrics\":[\"methods.0.e_final\"]}");
    for (int i = 0; i < 4; i++) {
        ll_row row;
        must(ll_experiment_run(e, i, NULL, NULL, &row));
        assert_int_equal(row.status, i == 3 ? LL_ROW_REFUSED : LL_ROW_OK);
        assert_true(isnan(row.metrics[0]) == (i == 3));
        assert_true((strstr(row.error, "methods.0.dt_s") != NULL) == (i == 3));
    }
    ll_experiment_free(e);
}

/* Two side-by-side methods: a failed one has no metrics and makes the row fail; the other's metrics are
 * there. */
static void a_part_that_fails_has_no_metrics(void **state)
{
    (void)state;
    static const struct {
        const char *first; /* method */
        ll_row_status status;
        const char *error;
    } known[] = {
        {"{\"method\":\"rk4\",\"dt_s\":0.01}", LL_ROW_OK, ""},
        {"{\"method\":\"velocity_verlet\",\"dt_s\":0.3}", LL_ROW_DIVERGED, "methods.0: "},
        {"{\"method\":\"rk4\",\"shown\":false}", LL_ROW_FAILED, "methods.0: It was not run"},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        char text[600];
        ll_row row;
        snprintf(text, sizeof text,
                 "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"oscillator\",\"params\":{\"omega\":8},"
                 "\"duration_s\":20,\"methods\":[%s,{\"method\":\"rk4\",\"dt_s\":0.02}]},"
                 "\"metrics\":[\"methods.0.e_max\",\"methods.1.e_max\",\"methods.0.evaluations\"]}",
                 known[i].first);
        ll_experiment *e = experiment(text);
        must(ll_experiment_run(e, 0, NULL, NULL, &row));
        assert_int_equal(row.status, known[i].status);
        assert_memory_equal(row.error, known[i].error, strlen(known[i].error));
        assert_true(isnan(row.metrics[0]) == (i > 0) && isnan(row.metrics[2]) == (i > 0));
        assert_true(row.metrics[1] > 0 && row.metrics[1] < 0.5);
        ll_experiment_free(e);
    }
}

/* A failed part without metrics in the experiment does not make the row fail. */
static void a_part_that_is_not_asked_for_does_not_matter(void **state)
{
    (void)state;
    ll_row row;
    ll_experiment *e = experiment(
        "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"oscillator\",\"params\":{\"omega\":8},\"duration_"
        "s\":"
        "20,\"methods\":[{\"method\":\"velocity_verlet\",\"dt_s\":0.3},{\"method\":\"rk4\",\"dt_s\":0.02}]},"
        "\"metrics\":[\"methods.1.e_max\"]}");
    must(ll_experiment_run(e, 0, NULL, NULL, &row));
    assert_true(row.status == LL_ROW_OK && row.metrics[0] > 0);
    ll_experiment_free(e);
}

/* A run that its kind stops has no metrics of that moment. */
static void a_run_that_is_lost_has_no_metrics(void **state)
{
    (void)state;
    ll_row row;
    ll_experiment *e = experiment(
        "{\"scenario\":{\"kind\":\"rigid\",\"duration_s\":20,\"gravity\":[0,0],\"bodies\":[{},{\"velocity\":"
        "[800000,0],\"position\":[990000000,3]}]},\"metrics\":[\"speed_max_mps\",\"body_count\"]}");
    must(ll_experiment_run(e, 0, NULL, NULL, &row));
    assert_true(row.status == LL_ROW_DIVERGED && isnan(row.metrics[0]) && isnan(row.metrics[1]));
    ll_experiment_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_row_is_that_of_a_session),
        cmocka_unit_test(a_kept_block_changes_no_row),
        cmocka_unit_test(cost_is_measured_and_changes_nothing),
        cmocka_unit_test(failed_runs_have_no_cost),
        cmocka_unit_test(a_stop_rule_ends_a_run),
        cmocka_unit_test(a_part_that_fails_has_no_metrics),
        cmocka_unit_test(a_part_that_is_not_asked_for_does_not_matter),
        cmocka_unit_test(a_run_that_is_lost_has_no_metrics),
        cmocka_unit_test(a_timeline_that_a_point_contradicts_is_refused),
        cmocka_unit_test(invalid_combinations_are_reported_in_the_row),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
