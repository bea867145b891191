/* Points of an experiment: fronts of metrics, and comparisons by common random numbers. */
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
#include "experiment/fixture.h"
#include "experiment/format/compare.h"
#include "experiment/spec/metric_path.h"
#include "library/library.h"
#include "support/near.h"

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
    assert_near(points.points[1].metrics[0].mean, 0, 1e-15);
    assert_near(points.points[1].size[0], 0.9, 1e-15);
    assert_near(points.points[2].size[0], 0.15, 1e-15);
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
    assert_near(cell_of(t, cells, LEAD ".diff"), (0.5 + 0.02 / 11), 1e-12);
    assert_true(cell_of(t, cells, LEAD ".diff_pairs") == 11);
    double low = cell_of(t, cells, LEAD ".diff_low"), high = cell_of(t, cells, LEAD ".diff_high");
    assert_true(low > 0.35 && low < 0.5 && high > 0.5 && high < 0.65);
    assert_string_equal(text_of(t, cells, LEAD ".diff_method"), "bootstrap-t");
    /* unpaired it would be unknown: the seeds have a standard deviation of 5 */
    assert_true(cell_of(t, cells, LEAD ".ci95_high") - cell_of(t, cells, LEAD ".ci95_low") > 5);
    assert_near(cell_of(t, cells, LEAD ".sd"), 5, 1);
    assert_true(cell_of(t, cells, HITCHES ".ci95_low") == 0);
    assert_near(cell_of(t, cells, HITCHES ".ci95_high"), 3.6888794541139354 / 11, 1e-9);
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
        if (!(value >= 0) && item->string && !ll_metric_is_signed(kind, path))
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fronts_of_several_metrics_are_naive_ones),
        cmocka_unit_test(fronts_take_magnitudes_and_no_failures),
        cmocka_unit_test(points_are_compared_by_seed),
        cmocka_unit_test(baselines_are_found),
        cmocka_unit_test(scales_are_known),
        cmocka_unit_test(signed_metrics_are_declared),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
