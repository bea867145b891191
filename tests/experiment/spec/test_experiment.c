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

#include "experiment/fixture.h"
#include "support/near.h"

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
        assert_near(value(e, p, "server.update_hz") / wanted[p], 1, 1e-15);
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
            assert_near(counts[i], 1024 * log((i + 1.5) / (i + 0.5)) / log(17), 2);
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
            assert_near(value(e, 4 * j + k, "server.update_hz"), (10 + y[k] / 2), 1e-9);
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

/* Each value asks the interrupt, which then ends it; with too many runs no value is checked. */
static bool ask(void *context)
{
    return --*(int *)context > 0;
}

static int64_t soon(void)
{
    static int64_t now;
    return now += 1000000000; /* each value takes long */
}

static ll_status parse_within(const char *text, int *asks, ll_experiment **e)
{
    cJSON *json = cJSON_Parse(text);
    const ll_interrupt interrupt = {.go_on = ask, .now_ns = soon, .context = asks};
    assert_non_null(json);
    ll_status status = ll_experiment_parse(json, "scenarios", &interrupt, e);
    cJSON_Delete(json);
    return status;
}

static void values_come_last_and_can_be_interrupted(void **state)
{
    (void)state;
    const char *many = "{\"scenario\":\"race\"," METRICS
                       ",\"axes\":[{\"path\":\"players.0.lag_ms\",\"from\":0,\"to\":900,\"count\":9000}]}";
    const char *too_many =
        "{\"scenario\":\"race\",\"repeats\":90000," METRICS
        ",\"axes\":[{\"path\":\"players.0.lag_ms\",\"from\":0,\"to\":1e9,\"count\":9000}]}";
    int asks = 10;
    ll_experiment *e = NULL;
    ll_status status = parse_within(many, &asks, &e);
    assert_int_equal(status.code, LL_INTERRUPTED);
    assert_non_null(strstr(status.text, "of axes.0"));
    assert_null(e);
    asks = 10;
    status = parse_within(too_many, &asks, &e);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.field, "axes");
    assert_int_equal(asks, 10);
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
        cmocka_unit_test(bad_input_is_reported),
        cmocka_unit_test(keys_differ_between_experiments),
        cmocka_unit_test(values_come_last_and_can_be_interrupted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
