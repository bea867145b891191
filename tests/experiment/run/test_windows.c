/* Metrics in windows: parts that cover a run add up to the whole, borders count each tick once, and nothing
 * else of a run changes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/fixture.h"
#include "experiment/spec/metric_path.h"
#include "support/near.h"

enum { TEXT = 4000 };

/* A row of a race of 4 s whose metrics count from 0.5 s on, at 60 ticks per second. */
static ll_row row_of(const char *windows, const char *metrics, const char *more)
{
    char text[TEXT];
    snprintf(
        text, sizeof text,
        "{\"scenario\":\"race\",\"set\":{\"duration_s\":4,\"warmup_s\":0.5,\"players.0.link.down.loss_pct\":"
        "20,\"players.0.lag_ms\":80},\"windows\":[%s],\"metrics\":[%s]%s}",
        windows, metrics, more);
    ll_experiment *e = experiment(text);
    ll_row row;
    must(ll_experiment_run(e, 0, NULL, NULL, &row));
    assert_int_equal(row.status, LL_ROW_OK);
    ll_experiment_free(e);
    return row;
}

#define THIRDS                                                                                               \
    "{\"name\":\"a\",\"to_s\":1.25},{\"name\":\"b\",\"from_s\":1.25,\"to_s\":2.5},{\"name\":\"c\","          \
    "\"from_s\":2.5}"
#define IN(metric) "\"" metric "\",\"" metric "@a\",\"" metric "@b\",\"" metric "@c\""

#define NEAR(value, wanted) assert_near(value, wanted, 1e-12 * larger(1, fabs((double)(wanted))))

#define ERROR "players.0.remote_error_m"
#define BYTES "players.0.bandwidth.down_bytes_per_s"

static void windows_that_cover_a_run_add_up(void **state)
{
    (void)state;
    ll_row row = row_of(THIRDS,
                        IN(ERROR ".mean") "," IN(ERROR ".rms") "," IN(ERROR ".count") "," IN(
                            BYTES) ","
                                   "\"counted_s@a\",\"counted_s@b\",\"counted_s@c\"",
                        "");
    const double *mean = row.metrics, *rms = mean + 4, *count = mean + 8, *rate = mean + 12, *s = mean + 16;
    static const double measured_s[] = {3.5, 0.75, 1.25, 1.5};
    double sum = 0, squares = 0, values = 0, bytes = 0;
    for (int i = 1; i < 4; i++) {
        sum += mean[i] * count[i];
        squares += rms[i] * rms[i] * count[i];
        values += count[i];
        bytes += rate[i] * measured_s[i];
        assert_true(mean[i] > 0 && rms[i] >= mean[i] && count[i] > 0 && rate[i] > 0);
    }
    assert_true(values == count[0]);
    NEAR(sum / values, mean[0]);
    NEAR(sqrt(squares / values), rms[0]);
    NEAR(bytes / measured_s[0], rate[0]);
    NEAR(s[0], 1.25);
    NEAR(s[1], 1.25);
    NEAR(s[2], 1.5);
}

/* Infinite latencies, of inputs that are lost, count, but are in no mean: without loss the means add up, with
 * loss the counts do. */
static void latencies_add_up(void **state)
{
    (void)state;
    for (int loss_pct = 0; loss_pct <= 40; loss_pct += 40) {
        char text[TEXT];
        snprintf(
            text, sizeof text,
            "{\"scenario\":\"behind_cover\",\"set\":{\"duration_s\":6,\"warmup_s\":0.5,"
            "\"players.0.link.up.loss_pct\":%d,\"players.0.redundancy\":1,\"players.0.prediction\":false},"
            "\"windows\":[" THIRDS "],\"metrics\":[" IN("players.0.input_latency_ms.mean") "," IN(
                "players.0.input_latency_ms.count") ",\"players.0.input_latency_ms.lost_ratio\"]}",
            loss_pct);
        ll_experiment *e = experiment(text);
        ll_row row;
        must(ll_experiment_run(e, 0, NULL, NULL, &row));
        const double *mean = row.metrics, *count = mean + 4;
        assert_true(count[1] + count[2] + count[3] == count[0] && count[0] > 20 && mean[0] > 0);
        assert_true((mean[8] > 0) == (loss_pct > 0));
        if (loss_pct == 0)
            NEAR((mean[1] * count[1] + mean[2] * count[2] + mean[3] * count[3]) / count[0], mean[0]);
        ll_experiment_free(e);
    }
}

#define STEPS(statistic, window) "\"server_step." statistic "@" window "\""

/* The server makes step k at tick k. */
static void borders_count_each_tick_once(void **state)
{
    (void)state;
    ll_row row = row_of(
        "{\"name\":\"a\",\"from_s\":1,\"to_s\":1.5},{\"name\":\"b\",\"from_s\":1.5,\"to_s\":2.5},"
        "{\"name\":\"all\"}",
        STEPS("min", "a") "," STEPS("max", "a") "," STEPS("mean", "a") "," STEPS("p50", "a") "," STEPS(
            "p95", "a") "," STEPS("min",
                                  "b") "," STEPS("max",
                                                 "b") "," STEPS("mean",
                                                                "b") ","
                                                                     "\"server.steps@a\",\"server.steps@b\","
                                                                     "\"server.steps@all\",\"server."
                                                                     "steps\"," STEPS("max", "all") "," STEPS(
                                                                         "mean",
                                                                         "all") ",\"server_step.rms@a\"",
        "");
    static const double wanted[] = {60, 89, 74.5, 74, 88, 90, 149, 119.5, 30, 60, 240, 240, 239, 119.5};
    for (int i = 0; i < (int)(sizeof wanted / sizeof *wanted); i++)
        NEAR(row.metrics[i], wanted[i]);
    NEAR(row.metrics[14], sqrt(74.5 * 74.5 + (30 * 30 - 1) / 12.0)); /* of 30 successive numbers */
}

static void an_empty_window_is_null(void **state)
{
    (void)state;
    ll_row row =
        row_of("{\"name\":\"late\",\"from_s\":100},{\"name\":\"never\",\"while\":{\"value\":"
               "\"server_step\",\"above\":1e6}},{\"name\":\"early\",\"to_s\":0.4}",
               "\"" ERROR ".mean@late\",\"" BYTES "@never\",\"server.steps@late\",\"server_step.mean@"
               "never\",\"server_step.p99@late\",\"" ERROR ".mean@early\",\"" BYTES
               "@early\",\"counted_s@late\",\"counted_s@early\"",
               "");
    for (int i = 0; i < 7; i++) /* the early one ends before warmup_s */
        assert_true(isnan(row.metrics[i]));
    NEAR(row.metrics[7], 0);
    NEAR(row.metrics[8], 0.4);
}

static void conditions_choose_ticks(void **state)
{
    (void)state;
    ll_row row = row_of(
        "{\"name\":\"steps\",\"while\":{\"value\":\"server_step\",\"above\":59.5,\"below\":90.5}},"
        "{\"name\":\"slow\",\"while\":{\"value\":\"players.0.lag_ms\",\"above\":150}},"
        "{\"name\":\"out\",\"while\":{\"value\":\"player_1_down_blackout\",\"above\":0}},"
        "{\"name\":\"both\",\"from_s\":1.25,\"while\":{\"value\":\"server_step\",\"below\":90}}",
        STEPS("min", "steps") "," STEPS("max", "steps") "," STEPS("min", "slow") "," STEPS(
            "max",
            "slow") ",\"counted_s@out\"," STEPS("min",
                                                "out") "," STEPS("min",
                                                                 "both") "," STEPS("max",
                                                                                   "both") ",\"counted_s@"
                                                                                           "steps\"",
        ",\"axes\":[{\"zip\":[{\"path\":\"players.1.link.down.blackout_at_ms\",\"values\":[1000]},"
        "{\"path\":\"players.1.link.down.blackout_every_ms\",\"values\":[2000]},"
        "{\"path\":\"players.1.link.down.blackout_length_ms\",\"values\":[500]}]}]");
    static const double wanted[] = {60, 90, NAN, NAN, 1, 60, 75, 89, 31.0 / 60};
    for (int i = 0; i < (int)(sizeof wanted / sizeof *wanted); i++)
        if (isnan(wanted[i]))
            assert_true(isnan(row.metrics[i])); /* no lag is above 150 ms */
        else if (i == 8)
            assert_near(row.metrics[i], wanted[i], 2e-9); /* of whole ns */
        else
            NEAR(row.metrics[i], wanted[i]);
}

static void parameters_are_those_of_the_tick(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"race\",\"set\":{\"duration_s\":3,\"timeline\":[{\"at_s\":1,\"set\":{\"players.0.lag_"
        "ms\":"
        "300}},{\"at_s\":2,\"set\":{\"players.0.lag_ms\":20}}]},\"windows\":[{\"name\":\"slow\",\"while\":"
        "{\"value\":\"players.0.lag_ms\",\"above\":150}}],\"metrics\":[\"server_step.min@slow\","
        "\"server_step.max@slow\"]}");
    ll_row row;
    must(ll_experiment_run(e, 0, NULL, NULL, &row));
    NEAR(row.metrics[0], 60);
    NEAR(row.metrics[1], 119);
    ll_experiment_free(e);
}

/* Also where the run is stepped tick by tick. */
static void nothing_else_of_a_run_changes(void **state)
{
    (void)state;
    ll_row plain = row_of("", "\"" ERROR ".p95\"", "");
    ll_row some = row_of(THIRDS, "\"" ERROR ".p95\",\"" ERROR ".mean@a\"", "");
    ll_row each = row_of(THIRDS, "\"" ERROR ".p95\",\"player_0_view_age_ms.p95@b\"", "");
    assert_true(plain.hash == some.hash && plain.hash == each.hash);
    assert_true(plain.metrics[0] == some.metrics[0] && plain.metrics[0] == each.metrics[0]);
    ll_row again = row_of(THIRDS, "\"" ERROR ".p95\",\"player_0_view_age_ms.p95@b\"", "");
    assert_memory_equal(&each, &again, sizeof each);
}

static void a_stopped_run_closes_its_windows(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":\"race\",\"stop\":{\"metric\":\"server.steps\",\"above\":100,\"every_s\":0.5},"
        "\"windows\":[{\"name\":\"w\",\"from_s\":0.7}],\"metrics\":[\"server.steps@w\",\"counted_s@w\","
        "\"server_step.max@w\",\"server.steps\"]}");
    ll_row row;
    must(ll_experiment_run(e, 0, NULL, NULL, &row));
    assert_int_equal(row.status, LL_ROW_STOPPED);
    NEAR(row.metrics[0], 120 - 42);
    NEAR(row.metrics[1], 1.3);
    NEAR(row.metrics[2], 119);
    NEAR(row.metrics[3], 120);
    ll_experiment_free(e);
}

/* Of a motion: counts of its methods, and columns of its trace. */
static void other_kinds_have_windows(void **state)
{
    (void)state;
    ll_experiment *e = experiment(
        "{\"scenario\":{\"kind\":\"motion\",\"problem\":\"kepler\",\"duration_s\":2,\"methods\":[{\"method\":"
        "\"rk4\",\"dt_s\":0.01}]},\"windows\":[{\"name\":\"a\",\"to_s\":1},{\"name\":\"b\",\"from_s\":1}],"
        "\"metrics\":[\"methods.0.steps\",\"methods.0.steps@a\",\"methods.0.steps@b\",\"0_error.max@a\","
        "\"0_error.max@b\"]}");
    ll_row row;
    must(ll_experiment_run(e, 0, NULL, NULL, &row));
    assert_int_equal(row.status, LL_ROW_OK);
    NEAR(row.metrics[1] + row.metrics[2], row.metrics[0]);
    NEAR(row.metrics[0], 200);
    assert_true(row.metrics[3] > 0 && row.metrics[4] > row.metrics[3]);
    ll_experiment_free(e);
}

static void scales_are_those_of_the_metric(void **state)
{
    (void)state;
    ll_experiment *e = experiment("{\"scenario\":\"race\",\"windows\":[{\"name\":\"w\"}],\"metrics\":["
                                  "\"players.0.visible_corrections@w\","
                                  "\"players.0.visible_corrections_per_s@w\",\"player_0_remote_error_m.max@"
                                  "w\",\"players.0.pop_m.mean@w\","
                                  "\"player_0_own_lead_m.mean@w\"]}");
    static const ll_metric_scale wanted[] = {LL_SCALE_COUNT, LL_SCALE_AMOUNT, LL_SCALE_EXTREME,
                                             LL_SCALE_TAILED, LL_SCALE_AMOUNT};
    for (int i = 0; i < 5; i++)
        assert_int_equal(e->scales[i], wanted[i]);
    assert_true(ll_metric_is_signed(e->base.kind, e->metrics[4]));
    assert_false(ll_metric_is_signed(e->base.kind, e->metrics[0]));
    ll_experiment_free(e);
}

/* Columns for each of 64 players. */
static void a_trace_has_room_for_all_players(void **state)
{
    (void)state;
    char text[TEXT] =
        "{\"scenario\":{\"kind\":\"netgame\",\"game\":\"swarm\",\"duration_s\":0.1,\"players\":[";
    for (int i = 0; i < LL_PLAYERS_MAX; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s{\"name\":\"P%d\"}", i ? "," : "", i);
    strcat(text, "]},\"windows\":[{\"name\":\"w\"}],\"metrics\":[\"player_63_own_x_m.mean@w\"]}");
    ll_experiment *e = experiment(text);
    ll_row row;
    must(ll_experiment_run(e, 0, NULL, NULL, &row));
    assert_true(row.status == LL_ROW_OK && isfinite(row.metrics[0]));
    ll_experiment_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(windows_that_cover_a_run_add_up),
        cmocka_unit_test(latencies_add_up),
        cmocka_unit_test(borders_count_each_tick_once),
        cmocka_unit_test(an_empty_window_is_null),
        cmocka_unit_test(conditions_choose_ticks),
        cmocka_unit_test(parameters_are_those_of_the_tick),
        cmocka_unit_test(nothing_else_of_a_run_changes),
        cmocka_unit_test(a_stopped_run_closes_its_windows),
        cmocka_unit_test(other_kinds_have_windows),
        cmocka_unit_test(scales_are_those_of_the_metric),
        cmocka_unit_test(a_trace_has_room_for_all_players),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
