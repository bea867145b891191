/* Specifications: counts, refusals, and that a row is a function of its index. */
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
#include "experiment/format/compare.h"
#include "experiment/format/points.h"
#include "experiment/spec/experiment.h"
#include "experiment/spec/metric_path.h"
#include "library/library.h"
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
        if (k == 0) /* a (0, 2)-net: each interval once, each choice half of the times */
            assert_true(filled == 256 && predicted == 128);
        else /* expected: 256 (1 - 1/e) = 162, with a standard deviation of 5 */
            assert_true(filled > 132 && filled < 192 && predicted > 80 && predicted < 176);
        ll_experiment_free(e);
    }
}

/* Counts the values of an axis over a sample, from `least` on. */
static void count_values(const char *sample, const char *axis, const char *path, int least, int *counts,
                         int kinds)
{
    char text[600];
    snprintf(text, sizeof text,
             "{\"scenario\":\"race\",\"sample\":%s,\"axes\":[{\"path\":\"%s\",%s}]," METRICS "}", sample,
             path, axis);
    ll_experiment *e = experiment(text);
    memset(counts, 0, (size_t)kinds * sizeof *counts);
    for (int p = 0; p < e->points; p++) {
        int at = (int)value(e, p, path) - least;
        assert_true(at >= 0 && at < kinds);
        counts[at]++;
    }
    ll_experiment_free(e);
}

/* All whole numbers are equally likely, the ends too, in both directions; on a logarithmic scale 1 has the
 * part below 1.5: log(1.5 / 0.5) of log(8.5 / 0.5). */
static void whole_numbers_are_drawn_evenly(void **state)
{
    (void)state;
    static const char *const methods[] = {"sobol", "lhs"};
    static const char path[] = "players.0.redundancy";
    int counts[16];
    for (int m = 0; m < 2; m++) {
        char sample[80];
        snprintf(sample, sizeof sample, "{\"method\":\"%s\",\"count\":1024}", methods[m]);
        count_values(sample, "\"from\":3,\"to\":10", path, 3, counts, 8);
        for (int i = 0; i < 8; i++)
            assert_int_equal(counts[i], 128);
        count_values(sample, "\"from\":10,\"to\":3", path, 3, counts, 8);
        for (int i = 0; i < 8; i++)
            assert_int_equal(counts[i], 128);
        count_values(sample, "\"from\":1,\"to\":8,\"scale\":\"log\"", path, 1, counts, 8);
        for (int i = 0; i < 8; i++)
            assert_true(fabs(counts[i] - 1024 * log((i + 1.5) / (i + 0.5)) / log(17)) < 2);
    }
}

/* A range with a count gives only its values, all equally often. */
static void a_count_is_honoured_when_sampled(void **state)
{
    (void)state;
    ll_experiment *e = experiment("{\"scenario\":\"race\",\"sample\":{\"method\":\"sobol\",\"count\":128},"
                                  "\"axes\":[{\"path\":\"players.0."
                                  "lag_ms\",\"from\":10,\"to\":25,\"count\":4}]," METRICS "}");
    int counts[4] = {0};
    for (int p = 0; p < 128; p++) {
        double lag = value(e, p, "players.0.lag_ms");
        assert_true(lag == 10 || lag == 15 || lag == 20 || lag == 25);
        counts[(int)(lag - 10) / 5]++;
    }
    for (int i = 0; i < 4; i++)
        assert_int_equal(counts[i], 32);
    ll_experiment_free(e);
}

/* Base sample j: A, B, and A with one dimension of B; zipped axes are one dimension. */
static void saltelli_mixes_two_samples(void **state)
{
    (void)state;
    ll_experiment *e = experiment("{\"scenario\":\"race\",\"sample\":{\"method\":\"saltelli\",\"count\":32},"
                                  "\"axes\":[{\"path\":\"players.0."
                                  "lag_ms\",\"from\":0,\"to\":100},{\"zip\":[{\"path\":\"players.1.lag_ms\","
                                  "\"from\":0,\"to\":100},{\"path\":"
                                  "\"server.update_hz\",\"from\":10,\"to\":60}]}]," METRICS "}");
    assert_int_equal(e->points, 32 * 4);
    for (int j = 0; j < 32; j++) {
        double x[4], y[4];
        for (int k = 0; k < 4; k++) {
            x[k] = value(e, 4 * j + k, "players.0.lag_ms");
            y[k] = value(e, 4 * j + k, "players.1.lag_ms");
            assert_true(fabs(value(e, 4 * j + k, "server.update_hz") - (10 + y[k] / 2)) < 1e-9);
        }
        assert_true(x[2] == x[1] && y[2] == y[0] && x[3] == x[0] && y[3] == y[1] && x[0] != x[1]);
    }
    ll_experiment_free(e);
}

static void there_may_be_twenty_axes(void **state)
{
    (void)state;
    for (int axes = 20; axes <= 21; axes++) {
        char text[3000];
        int used = snprintf(text, sizeof text,
                            "{\"scenario\":\"race\",\"sample\":{\"method\":\"saltelli\",\"count\":2}," METRICS
                            ",\"axes\":[");
        static const char *const rows[] = {"jitter_ms", "loss_pct", "loss_corr_pct", "ge_1h_pct",
                                           "ge_1k_pct", "p13_pct",  "p31_pct",       "p32_pct",
                                           "p23_pct",   "p14_pct",  "delay_ms"};
        for (int a = 0; a < axes; a++)
            used += snprintf(text + used, sizeof text - (size_t)used,
                             "%s{\"path\":\"players.0.link.%s.%s\",\"from\":1,\"to\":2}", a ? "," : "",
                             a % 2 ? "up" : "down", rows[a / 2]);
        snprintf(text + used, sizeof text - (size_t)used, "]}");
        ll_experiment *e = NULL;
        ll_status status = parse(text, &e);
        if (axes == 20 && ll_failed(&status))
            fail_msg("%s", status.text);
        assert_true(axes == 20 ? e->points == 44 : strstr(status.text, "at most 20") != NULL);
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

/* Given rows, by run. */
typedef struct given {
    const ll_row *rows;
    int at, count;
} given;

static bool next_given(void *context, ll_row *row, ll_status *status)
{
    given *g = context;
    *status = ll_ok();
    if (g->at == g->count)
        return false;
    *row = g->rows[g->at++];
    return true;
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
        must(ll_experiment_run(e, run, NULL, &rows[run]));
        must(ll_experiment_run(plain, run, NULL, &row));
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
    must(ll_experiment_run(e, 0, NULL, &row));
    assert_true(row.status == LL_ROW_DIVERGED && isnan(row.metrics[0]));
    ll_experiment_free(e);
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
        must(ll_experiment_run(e, i, NULL, &row));
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
        must(ll_experiment_run(e, 0, NULL, &row));
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
    must(ll_experiment_run(e, 0, NULL, &row));
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
    must(ll_experiment_run(e, 0, NULL, &row));
    assert_true(row.status == LL_ROW_DIVERGED && isnan(row.metrics[0]) && isnan(row.metrics[1]));
    ll_experiment_free(e);
}

/* Cost and error of four points with two runs each: the first is best but failed once, the second has large
 * errors of either sign, the third and the last are on the front. */
static void fronts_take_magnitudes_and_no_failures(void **state)
{
    (void)state;
    static const double values[8][2] = {{1, 0.001}, {1, 0.001}, {2, -0.9}, {2, 0.9},
                                        {3, 0.1},   {3, -0.2},  {9, 0.05}, {9, 0.05}};
    static const bool front[4] = {false, true, true, true};
    ll_row rows[8];
    ll_points points;
    ll_experiment *e = experiment(
        "{\"scenario\":\"rigid/pyramid\",\"repeats\":2,\"axes\":[{\"path\":\"hz\",\"values\":[10,20,30,40]}],"
        "\"metrics\":[\"energy_change_j\",\"passes_per_s\"]}");
    for (int i = 0; i < 8; i++) {
        ll_row_clear(&rows[i]);
        rows[i].run = i;
        rows[i].metrics[1] = values[i][0];
        rows[i].metrics[0] = values[i][1];
    }
    rows[1].status = LL_ROW_FAILED;
    rows[1].metrics[0] = rows[1].metrics[1] = NAN;
    must(ll_points_read(e, next_given, &(given){rows, 0, 8}, &points));
    ll_points_mark_front(&points, (const int[]){1, 0}, 2);
    assert_int_equal(points.count, 4);
    for (int i = 0; i < 4; i++)
        assert_int_equal(points.points[i].front, front[i]);
    assert_true(points.points[0].runs == 1 && points.points[0].failed == 1);
    assert_true(points.points[0].metrics[0].mean == 0.001 && isnan(points.points[0].size[0]));
    assert_true(fabs(points.points[1].metrics[0].mean) < 1e-15 &&
                fabs(points.points[1].size[0] - 0.9) < 1e-15);
    assert_true(fabs(points.points[2].size[0] - 0.15) < 1e-15);
    ll_points_free(&points);
    ll_experiment_free(e);
}

/* Compared with a naive search, over random points with ties and two to four metrics. */
static void fronts_of_several_metrics_are_naive_ones(void **state)
{
    (void)state;
    enum { POINTS = 200 };
    ll_point *p = calloc(POINTS, sizeof *p);
    double *sizes = calloc(POINTS * 8, sizeof *sizes);
    static const int metrics[4] = {3, 0, 7, 1};
    for (int i = 0; i < POINTS; i++)
        p[i].size = &sizes[8 * i];
    for (uint64_t seed = 0; seed < 30; seed++)
        for (int count = 2; count <= 4; count++) {
            for (int i = 0; i < POINTS; i++)
                for (int k = 0; k < 4; k++) {
                    double u = ll_rng_unit(seed, (uint64_t)k, (uint64_t)i);
                    p[i].size[metrics[k]] = u < 0.02 ? NAN : floor(u * 12);
                }
            ll_points_mark_front(&(ll_points){.points = p, .count = POINTS}, metrics, count);
            for (int i = 0; i < POINTS; i++) {
                bool on = true;
                for (int k = 0; k < count; k++)
                    on &= !isnan(p[i].size[metrics[k]]);
                for (int j = 0; j < POINTS && on; j++) {
                    bool as_good = true, better = false;
                    for (int k = 0; k < count; k++) {
                        as_good &= p[j].size[metrics[k]] <= p[i].size[metrics[k]];
                        better |= p[j].size[metrics[k]] < p[i].size[metrics[k]];
                    }
                    for (int k = 0; k < count; k++)
                        as_good &= !isnan(p[j].size[metrics[k]]);
                    on = !(as_good && better);
                }
                assert_int_equal(p[i].front, on);
            }
        }
    free(p);
    free(sizes);
}

/* Of any number at most the maximum is shown: those in `first` before the others, evenly spaced. */
static void shown_points_are_evenly_spaced(void **state)
{
    (void)state;
    enum { MOST = 700 };
    bool first[MOST], shown[MOST];
    for (uint64_t seed = 0; seed < 400; seed++) {
        int count = (int)(ll_rng_u64(seed, 0, 0) % MOST), most = 1 + (int)(ll_rng_u64(seed, 1, 0) % 150);
        double share = ll_rng_unit(seed, 2, 0);
        int firsts = 0, seen[2] = {0}, last[2] = {-1, -1}, all = 0;
        for (int i = 0; i < count; i++)
            firsts += first[i] = ll_rng_unit(seed, 3, (uint64_t)i) < share * share;
        ll_choice c = ll_choose_shown(first, count, most, shown);
        for (int i = 0; i < count; i++) {
            int kind = first[i], every = kind ? c.every_first : c.every_other, place = seen[kind]++;
            assert_int_equal(shown[i], every > 0 && (last[kind] < 0 || place == last[kind] + every));
            last[kind] = shown[i] ? place : last[kind];
            all += shown[i];
        }
        assert_int_equal(all, c.shown);
        assert_true(all <= most && (all == count || count > most));
        assert_true(firsts <= most ? c.every_first == (firsts > 0) : c.every_first > 1);
    }
}

/* ---- points and comparisons ---- */

typedef struct spread {
    ll_row rows[24];
} spread;

/* Two points of twelve runs: both have the seed's contribution, and the second has 0.5 more, within 0.1. The
 * fourth run of the second failed. */
static void fill(const ll_experiment *e, spread *s)
{
    static const double luck[12] = {3, -1, 4, -1.5, 5, -9, 2.6, -5, 7, -3, 1, -2},
                        rest[12] = {0.1, -0.1, 0.05, 0, -0.08, 0.03, 0, 0.02, 0.04, -0.06, 0.02, 0};
    assert_int_equal(e->runs, 24);
    for (int i = 0; i < 24; i++) {
        ll_row_clear(&s->rows[i]);
        s->rows[i].run = i;
        s->rows[i].metrics[0] = 20 + luck[i % 12] + (i / 12) * (0.5 + rest[i % 12]);
        s->rows[i].metrics[1] = 0;
    }
    s->rows[15].status = LL_ROW_FAILED;
    s->rows[15].metrics[0] = s->rows[15].metrics[1] = NAN;
}

static double cell_of(const ll_table *t, const ll_cell *cells, const char *name)
{
    for (int i = 0; i < t->column_count; i++)
        if (strcmp(t->columns[i].name, name) == 0)
            return cells[i].null ? NAN : cells[i].number;
    fail_msg("there is no column %s", name);
    return 0;
}

static const char *text_of(const ll_table *t, const ll_cell *cells, const char *name)
{
    for (int i = 0; i < t->column_count; i++)
        if (strcmp(t->columns[i].name, name) == 0)
            return cells[i].null ? "" : cells[i].text;
    fail_msg("there is no column %s", name);
    return NULL;
}

#define LEAD "players.0.own_lead_m.mean"
#define HITCHES "players.0.smoothness.hitches"
#define PAIR                                                                                                 \
    "{\"scenario\":\"race\",\"repeats\":12,\"axes\":[{\"path\":\"players.0.lag_ms\",\"values\":[0,100]}],"   \
    "\"metrics\":[\"" LEAD "\",\"" HITCHES "\"]}"

static void points_are_compared_by_seed(void **state)
{
    (void)state;
    ll_experiment *e = experiment(PAIR);
    ll_result_table *table;
    ll_cell cells[LL_COLUMNS_MAX];
    ll_status status = ll_ok();
    spread s;
    fill(e, &s);
    must(ll_result_table_compared(e, s.rows, 12, next_given, &(given){s.rows, 0, 24}, &table));
    const ll_table *t = ll_result_table_get(table);
    assert_true(t->next(t->context, cells, &status));
    assert_true(cell_of(t, cells, LEAD ".diff") == 0 && isnan(cell_of(t, cells, LEAD ".diff_low")));
    assert_true(t->next(t->context, cells, &status));
    /* 0.5 + (0.1 - 0.1 + 0.05 - 0.08 + 0.03 + 0 + 0.02 + 0.04 - 0.06 + 0.02 + 0) / 11 */
    assert_true(fabs(cell_of(t, cells, LEAD ".diff") - (0.5 + 0.02 / 11)) < 1e-12);
    assert_true(cell_of(t, cells, LEAD ".diff_pairs") == 11);
    double low = cell_of(t, cells, LEAD ".diff_low"), high = cell_of(t, cells, LEAD ".diff_high");
    assert_true(low > 0.35 && low < 0.5 && high > 0.5 && high < 0.65);
    assert_string_equal(text_of(t, cells, LEAD ".diff_method"), "bootstrap-t");
    /* unpaired it would be unknown: the seeds have a standard deviation of 5 */
    assert_true(cell_of(t, cells, LEAD ".ci95_high") - cell_of(t, cells, LEAD ".ci95_low") > 5);
    assert_true(fabs(cell_of(t, cells, LEAD ".sd") - 5) < 1);
    assert_true(cell_of(t, cells, HITCHES ".ci95_low") == 0);
    assert_true(fabs(cell_of(t, cells, HITCHES ".ci95_high") - 3.6888794541139354 / 11) < 1e-9);
    assert_string_equal(text_of(t, cells, HITCHES ".ci95_method"), "poisson");
    assert_false(t->next(t->context, cells, &status));
    ll_result_table_free(table);
    ll_experiment_free(e);
}

static void baselines_are_found(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\",\"values\":[0,100,200]},{\"path\":"
        "\"players.0.prediction\",\"values\":[false,true]}]," METRICS "}");
    static const struct {
        const char *text;
        int64_t point;
        const char *words; /* of the error */
    } cases[] = {{"first", 0, NULL},
                 {"5", 5, NULL},
                 {"players.0.lag_ms=200", 4, NULL},
                 {"players.0.prediction=true,players.0.lag_ms=100", 3, NULL},
                 {"6", 0, "from 0 to 5; got 6"},
                 {"-1", 0, "got -1"},
                 {"players.0.lag_ms=150", 0, "no point has players.0.lag_ms=150"},
                 {"players.1.lag_ms=0", 0, "not on an axis"},
                 {"last", 0, "must be first"},
                 {"", 0, "must be first"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        int64_t point;
        ll_status status = ll_compare_point(e, "compare", cases[i].text, &point);
        if (cases[i].words)
            assert_true(status.code == LL_BAD_INPUT && strstr(status.text, cases[i].words) &&
                        strcmp(status.field, "compare") == 0);
        else
            assert_true(!ll_failed(&status) && point == cases[i].point);
    }
    ll_experiment_free(e);
}

static void scales_are_known(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"rifle\",\"metrics\":[\"players.0.shots.hitscan.false_hits\",\"players.0.connection."
        "connected\","
        "\"players.0.pop_m.max\",\"players.0.visible_corrections_per_s\",\"players.0.corrections\","
        "\"players.0.remote_error_m.mean\"]}");
    static const ll_metric_scale scales[] = {LL_SCALE_COUNT, LL_SCALE_FLAG,   LL_SCALE_EXTREME,
                                             LL_SCALE_COUNT, LL_SCALE_AMOUNT, LL_SCALE_AMOUNT};
    for (int i = 0; i < 6; i++)
        assert_int_equal(e->scales[i], scales[i]);
    ll_experiment_free(e);
}

/* Every metric of a library scenario that is negative must be declared as signed. Not for netgames, which
 * have another table. */
static void check_signs(const ll_sim_kind *kind, const char *id, const char *path, const cJSON *item)
{
    if (cJSON_IsNumber(item) || cJSON_IsRaw(item)) {
        double value = cJSON_IsRaw(item) ? strtod(item->valuestring, NULL) : item->valuedouble;
        if (value < 0 && item->string && !ll_metric_is_signed(kind, path))
            fail_msg("%s: %s is %g", id, path, value);
    }
    const cJSON *child;
    int i = 0;
    cJSON_ArrayForEach(child, item)
    {
        char below[256], index[16];
        snprintf(index, sizeof index, "%d", i++);
        snprintf(below, sizeof below, "%s%s%s", path, path[0] != '\0' ? "." : "",
                 child->string ? child->string : index);
        check_signs(kind, id, below, child);
    }
}

static void signed_metrics_are_declared(void **state)
{
    (void)state;
    static const char *const ids[] = {
        "motion/orbit",          "motion/spring", "motion/clock_drift", "rigid/column",
        "rigid/inverse_pyramid", "rigid/bridge",  "rigid/windmill",     "fluid/taylor_green",
        "fluid/dam_break",       "fluid/sea",     "fluid/cylinder",     "fluid/poiseuille",
        "fluid/hydrostatic",     "fluid/raft",    "fluid/rotation"};
    for (size_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        cJSON *json;
        ll_session *s;
        ll_scenario scenario;
        must(ll_scenario_load("scenarios", ids[i], &json));
        must(ll_scenario_parse(json, &scenario));
        must(ll_session_create(json, 3, NULL, NULL, &s));
        ll_session_info info = ll_session_get_info(s);
        must(ll_session_run_to(s, info.end_tick < 90 ? info.end_tick : 90));
        cJSON *report = ll_session_metrics(s);
        check_signs(scenario.kind, ids[i], "", cJSON_GetObjectItem(report, "metrics"));
        cJSON_Delete(report);
        ll_session_destroy(s);
        ll_scenario_free(&scenario);
        cJSON_Delete(json);
    }
}

/* ---- refusals ---- */

static void bad_input_is_reported(void **state)
{
    (void)state;
    static const struct {
        const char *text, *field, *words;
    } cases[] = {
        {"{" METRICS "}", "scenario", "scenario: must be"},
        {"{\"scenario\":\"nosuch\"," METRICS "}", "scenario", "nosuch"},
        {"{\"scenario\":\"race\"," METRICS ",\"axis\":[]}", "axis", "axes"},
        {"{\"scenario\":\"race\"}", "metrics", "metrics: must be"},
        {"{\"scenario\":\"race\",\"metrics\":[\"players.0.lag\"]}", "metrics.0", "players.0 has name"},
        {"{\"scenario\":\"race\",\"metrics\":[\"players.7.own_lead_m.mean\"]}", "metrics.0", "2 elements"},
        {"{\"scenario\":\"race\",\"metrics\":[\"players.0.own_lead_m\"]}", "metrics.0", "mean"},
        {"{\"scenario\":\"race\",\"metrics\":[\"server.sync\"]}", "metrics.0", "not a number"},
        {"{\"scenario\":\"race\",\"set\":{\"players.0.lags\":1}," METRICS "}", "set.players.0.lags",
         "lag_ms"},
        {"{\"scenario\":\"race\",\"set\":{\"players.0.lag_ms\":-1}," METRICS "}", "set.players.0.lag_ms",
         "-1"},
        {"{\"scenario\":\"race\",\"repeats\":0," METRICS "}", "repeats", "got 0"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.nosuch\",\"values\":[1]}]," METRICS "}",
         "axes.0.path", "players.0.nosuch"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\",\"values\":[]}]," METRICS "}",
         "axes.0", "got 0"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\"}]," METRICS "}", "axes.0",
         "must have values"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\",\"values\":[1],\"count\":2}]"
         "," METRICS "}",
         "axes.0", "either values or a range"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players.0.lag_ms\",\"values\":[1,-5]}]," METRICS "}",
         "axes.0.players.0.lag_ms", "-5"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"server.update_hz\",\"from\":0,\"to\":9,\"count\":3,"
         "\"scale\":\"log\"}]," METRICS "}",
         "axes.0", "above 0"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"server.sync\",\"from\":0,\"to\":9,\"count\":3}]"
         "," METRICS "}",
         "axes.0", "not a number"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"players\",\"values\":[1]}]," METRICS "}", "axes.0",
         "one value"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"seed\",\"values\":[1]}]," METRICS "}", "axes.0",
         "repeats"},
        {"{\"scenario\":\"race\",\"axes\":[{\"path\":\"server.update_hz\",\"values\":[1]},{\"path\":\"server."
         "update_hz\","
         "\"values\":[2]}]," METRICS "}",
         "axes.1", "another axis"},
        {"{\"scenario\":\"race\",\"axes\":[{\"zip\":[{\"path\":\"players.0.lag_ms\",\"values\":[1]},{"
         "\"path\":"
         "\"players.1.lag_ms\",\"values\":[1,2]}]}]," METRICS "}",
         "axes.0.zip.1", "2 values"},
        {"{\"scenario\":\"race\",\"repeats\":10,\"axes\":[{\"path\":\"players.0.lag_ms\",\"from\":0,\"to\":9,"
         "\"count\":10000},"
         "{\"path\":\"players.1.lag_ms\",\"from\":0,\"to\":9,\"count\":5000}]," METRICS "}",
         "axes", "10000 x 5000 points, with 10 repeats 5e+08 runs"},
        {"{\"scenario\":\"race\",\"sample\":{\"method\":\"halton\"}," METRICS "}", "sample.method", "sobol"},
        {"{\"scenario\":\"race\",\"front\":[\"players.0.own_lead_m.mean\"]," METRICS "}", "front", "2 to 32"},
        {"{\"scenario\":\"race\",\"front\":[\"players.0.own_lead_m.mean\",\"tick\"]," METRICS "}", "front.1",
         "one of the metrics; got tick"},
        {"{\"scenario\":\"race\",\"front\":[\"players.0.own_lead_m.mean\",\"players.0.own_lead_m.mean\"]"
         "," METRICS "}",
         "front.1", "duplicate"},
        {"{\"scenario\":\"race\",\"interval\":\"bca\"," METRICS "}", "interval", "auto, t"},
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

static void keys_differ_between_experiments(void **state)
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
        cmocka_unit_test(whole_numbers_are_drawn_evenly),
        cmocka_unit_test(a_count_is_honoured_when_sampled),
        cmocka_unit_test(saltelli_mixes_two_samples),
        cmocka_unit_test(there_may_be_twenty_axes),
        cmocka_unit_test(fronts_of_several_metrics_are_naive_ones),
        cmocka_unit_test(shown_points_are_evenly_spaced),
        cmocka_unit_test(a_row_is_that_of_a_session),
        cmocka_unit_test(cost_is_measured_and_changes_nothing),
        cmocka_unit_test(failed_runs_have_no_cost),
        cmocka_unit_test(a_stop_rule_ends_a_run),
        cmocka_unit_test(a_part_that_fails_has_no_metrics),
        cmocka_unit_test(a_part_that_is_not_asked_for_does_not_matter),
        cmocka_unit_test(a_run_that_is_lost_has_no_metrics),
        cmocka_unit_test(fronts_take_magnitudes_and_no_failures),
        cmocka_unit_test(points_are_compared_by_seed),
        cmocka_unit_test(baselines_are_found),
        cmocka_unit_test(scales_are_known),
        cmocka_unit_test(signed_metrics_are_declared),
        cmocka_unit_test(invalid_combinations_are_reported_in_the_row),
        cmocka_unit_test(bad_input_is_reported),
        cmocka_unit_test(keys_differ_between_experiments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
