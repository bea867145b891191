/* Intervals cover the mean as often as stated, with metrics of real runs. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/spec/experiment.h"
#include "experiment/statistics/coverage.h"

/* Of `metrics` the first TAILED are declared to have a long tail, the next EXTREMES to be extremes. */
enum { RUNS = 600, TAILED = 3, EXTREMES = 4, METRICS = 12 };

static const char metrics[] =
    "\"players.0.own_timeline_error_m.mean\",\"players.0.pop_m.mean\",\"players.0.timeline_error_m.mean\","
    "\"players.0.own_timeline_error_m.rms\",\"players.0.correction_m.mean\",\"players.0.pop_m.max\","
    "\"players.0.visible_correction_m.mean\",\"players.0.corrections_per_s\","
    "\"players.0.remote_error_m.mean\",\"players.0.visible_corrections\",\"players.0.smoothness.hitches\","
    "\"players.0.buffer.underruns\"";

static const int pool_sizes[] = {5, 8, 10, 16, 20, 32, 64};
enum { POOL_SIZES = sizeof pool_sizes / sizeof pool_sizes[0] };

/* Values of the runs that have the metric. */
typedef struct pool {
    double values[RUNS];
    int count;
    ll_metric_scale scale;
    draws draws;
} pool;

static double next_of_pool(void *context)
{
    pool *p = context;
    return p->values[(int)(unit(&p->draws) * p->count)];
}

static void read_pools(const char *scenario, double loss_pct, pool pools[METRICS])
{
    char text[1500];
    ll_experiment *e;
    snprintf(text, sizeof text,
             "{\"scenario\":\"%s\",\"set\":{\"duration_s\":6,\"players.0.lag_ms\":120,"
             "\"players.0.link.up.loss_pct\":%g,\"players.0.link.down.loss_pct\":%g},\"repeats\":%d,"
             "\"metrics\":[%s]}",
             scenario, loss_pct, loss_pct, RUNS, metrics);
    cJSON *json = cJSON_Parse(text);
    ll_status status = ll_experiment_parse(json, "scenarios", NULL, &e);
    cJSON_Delete(json);
    if (ll_failed(&status))
        fail_msg("%s", status.text);
    for (int m = 0; m < METRICS; m++)
        pools[m] = (pool){.scale = e->scales[m]};
    ll_kept_block kept = {0};
    for (int run = 0; run < RUNS; run++) {
        ll_row row;
        status = ll_experiment_run(e, run, NULL, &kept, &row);
        assert_false(ll_failed(&status));
        for (int m = 0; m < METRICS; m++)
            if (isfinite(row.metrics[m]))
                pools[m].values[pools[m].count++] = row.metrics[m];
    }
    ll_kept_block_free(&kept);
    ll_experiment_free(e);
}

/* Whether intervals of samples of the pool cover its mean, at every size, by `least` to `most` %; most only
 * where the interval is no bound. Twice the standard error is allowed if less than half exist, and in the
 * quick version. */
static bool pool_is_covered(const char *name, pool *p, bool difference, double least, double most)
{
    char line[300];
    int used = snprintf(line, sizeof line, "%-32s", name);
    bool good = true;
    double mean = 0;
    for (int run = 0; run < p->count; run++)
        mean += p->values[run] / p->count;
    for (int k = 0; k < POOL_SIZES && p->count > 0; k++) {
        p->draws = (draws){99 + (uint64_t)k, 0};
        const ll_interval_request request = {
            .scale = p->scale, .n = pool_sizes[k], .error = 0.05, .difference = difference};
        coverage c = count_of(next_of_pool, p, mean, &request);
        if (c.told == 0)
            continue;
        bool few = c.told < 0.5 || experiments < EXPERIMENTS;
        double room = few ? 200 * sqrt(0.05 * 0.95 / (c.told * experiments)) : 0;
        double highest = pool_sizes[k] < LL_INTERVAL_LEVEL || c.told < 1 ? 100 : most;
        good &= 100 * c.covered >= least - room && 100 * c.covered <= highest + room;
        used +=
            snprintf(line + used, sizeof line - (size_t)used, " %4d: %5.1f", pool_sizes[k], 100 * c.covered);
    }
    print_message("%s%s\n", line, good ? "" : "  <-");
    return good;
}

/* Of samples a third of whose values are equal the interval is that of rare events, a bound. */
static bool is_often_least(const pool *p)
{
    int same = 0;
    for (int run = 0; run < p->count; run++) {
        int below = 0;
        for (int k = 0; k < p->count && below == 0; k++)
            below += p->values[k] < p->values[run];
        same += below == 0;
    }
    return 5 * same > p->count;
}

static const struct {
    const char *scenario;
    double loss_pct;
} cases[] = {{"contact", 0.5}, {"contact", 5}, {"contact", 10}, {"race", 0},
             {"race", 1},      {"race", 5},    {"race", 10}};
enum { CASES = sizeof cases / sizeof cases[0] };

/* Experiments drawn from real runs, whose mean is the truth, with the scales that the table of metrics
 * declares. Counts of events have exact bounds. */
static void metrics_of_runs_are_covered(void **state)
{
    (void)state;
    pool *pools = malloc(METRICS * sizeof *pools);
    bool good = true;
    experiments = is_full ? EXPERIMENTS : QUICK;
    for (int i = 0; i < CASES; i++) {
        read_pools(cases[i].scenario, cases[i].loss_pct, pools);
        for (int m = 0; m < METRICS; m++) {
            char name[64];
            snprintf(name, sizeof name, "%s %g %%, metric %d", cases[i].scenario, cases[i].loss_pct, m);
            assert_int_equal(pools[m].scale == LL_SCALE_TAILED, m < TAILED);
            assert_int_equal(pools[m].scale == LL_SCALE_EXTREME, m >= TAILED && m < TAILED + EXTREMES);
            bool exact = pools[m].scale == LL_SCALE_COUNT || is_often_least(&pools[m]);
            good &= pool_is_covered(name, &pools[m], false, 93, exact ? 100 : 98);
        }
    }
    experiments = EXPERIMENTS / LL_TEST_STRIDE;
    free(pools);
    assert_true(good);
}

/* Differences of runs with the same seeds, in both directions: the tail is on the side of the mean. */
static void differences_of_runs_are_covered(void **state)
{
    (void)state;
    pool *pools = malloc(2 * METRICS * sizeof *pools), *few = pools + METRICS;
    bool good = true;
    experiments = is_full ? EXPERIMENTS : QUICK;
    for (int i = 0; i < 2; i++) {
        const char *scenario = i == 0 ? "race" : "contact";
        read_pools(scenario, 10, pools);
        read_pools(scenario, 5, few);
        for (int m = 0; m < TAILED; m++)
            for (int sign = -1; sign <= 1; sign += 2) {
                pool apart = pools[m];
                char name[64];
                assert_int_equal(pools[m].count, few[m].count);
                for (int run = 0; run < apart.count; run++)
                    apart.values[run] = sign * (pools[m].values[run] - few[m].values[run]);
                snprintf(name, sizeof name, "%s difference %d, %d", scenario, m, sign);
                good &= pool_is_covered(name, &apart, true, 93, 98.5);
            }
    }
    experiments = EXPERIMENTS / LL_TEST_STRIDE;
    free(pools);
    assert_true(good);
}

int main(int count, char **arguments)
{
    read_arguments(count, arguments);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(metrics_of_runs_are_covered),
        cmocka_unit_test(differences_of_runs_are_covered),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
