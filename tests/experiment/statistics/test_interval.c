/* Intervals cover the mean as often as stated: counted over simulated experiments, with distributions of
 * known mean and with metrics of real runs. */
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
#include "experiment/spec/experiment.h"
#include "experiment/statistics/interval.h"
#include "support/stride.h"

enum { EXPERIMENTS = 2000, QUICK = 400 / LL_TEST_STRIDE, MOST = 300 };

static int experiments = EXPERIMENTS / LL_TEST_STRIDE; /* of each case */
static bool is_full;

/* ---- draws ---- */

typedef struct draws {
    uint64_t seed, at;
} draws;

static double unit(draws *d)
{
    return ll_rng_unit(d->seed, 17, d->at++) + 0x1p-54;
}

static double normal(draws *d)
{
    return 10 + ll_normal_quantile(unit(d));
}

static double uniform(draws *d)
{
    return unit(d);
}

static double exponential(draws *d)
{
    return -log(unit(d));
}

static double left(draws *d)
{
    return 5 - exponential(d);
}

static double gamma_2(draws *d)
{
    return exponential(d) + exponential(d);
}

static double student_5(draws *d)
{
    double z = normal(d) - 10, squares = 0;
    for (int i = 0; i < 5; i++) {
        double v = normal(d) - 10;
        squares += v * v;
    }
    return z / sqrt(squares / 5);
}

static double lognormal_half(draws *d)
{
    return exp((normal(d) - 10) / 2);
}

static double lognormal_1(draws *d)
{
    return exp(normal(d) - 10);
}

static double two_modes(draws *d)
{
    double z = (normal(d) - 10) / 5;
    return z + (unit(d) < 0.5);
}

/* Two different groups: `share` per cent are 5 standard deviations above the others. */
static double groups(draws *d, double share)
{
    double z = (normal(d) - 10) / 5;
    return z + (unit(d) < share);
}

static double groups_5(draws *d)
{
    return groups(d, 0.05);
}

static double groups_10(draws *d)
{
    return groups(d, 0.1);
}

static double groups_20(draws *d)
{
    return groups(d, 0.2);
}

static double groups_30(draws *d)
{
    return groups(d, 0.3);
}

static double poisson_of(draws *d, double mean)
{
    double product = unit(d), least = exp(-mean);
    int k = 0;
    for (; product > least; k++)
        product *= unit(d);
    return k;
}

static double event_1(draws *d)
{
    return unit(d) < 0.01;
}

static double event_5(draws *d)
{
    return unit(d) < 0.05;
}

static double event_20(draws *d)
{
    return unit(d) < 0.2;
}

static double poisson_2(draws *d)
{
    return poisson_of(d, 0.02);
}

static double poisson_30(draws *d)
{
    return poisson_of(d, 0.3);
}

static double poisson_300(draws *d)
{
    return poisson_of(d, 3);
}

static double poisson_2000(draws *d)
{
    return poisson_of(d, 20);
}

/* Of 100 runs 30, or 10, have an amount. */
static double rare_30(draws *d)
{
    double x = exponential(d);
    return unit(d) < 0.3 ? x : 0;
}

static double rare_10(draws *d)
{
    double x = exponential(d);
    return unit(d) < 0.1 ? x : 0;
}

/* ---- coverage ---- */

typedef struct coverage {
    double told, covered; /* share of the experiments with an interval, and of these that cover */
} coverage;

static coverage count_of(double (*next)(void *context), void *context, double mean,
                         const ll_interval_request *like)
{
    double x[MOST];
    int told = 0, covered = 0;
    ll_resampler resampler = {0};
    ll_interval_request request = *like;
    request.values = x;
    for (int i = 0; i < experiments; i++) {
        for (int64_t k = 0; k < request.n; k++)
            x[k] = next(context);
        ll_interval interval = ll_interval_of(&request, &resampler);
        if (interval.method == LL_INTERVAL_NONE) {
            assert_true(isnan(interval.low) && isnan(interval.high) && interval.why);
            continue;
        }
        assert_true(interval.low < interval.high);
        told++;
        covered += interval.low <= mean && mean <= interval.high;
    }
    ll_resampler_free(&resampler);
    return (coverage){(double)told / experiments, told ? (double)covered / told : NAN};
}

static coverage count(double (*next)(void *context), void *context, double mean, ll_metric_scale scale, int n,
                      double error)
{
    return count_of(next, context, mean, &(ll_interval_request){.scale = scale, .n = n, .error = error});
}

static const int sizes[] = {5, 8, 10, 12, 15, 20, 30, 50, 100, 300};
enum { SIZES = sizeof sizes / sizeof sizes[0] };

typedef struct known {
    const char *name;
    double (*draw)(draws *d);
    double mean;
    ll_metric_scale scale;
    double least, most; /* bounds of the coverage, in %, at every size */
    int first;          /* first of the sizes with intervals, and of those that are checked */
} known;

typedef struct source {
    const known *of;
    draws draws;
} source;

static double next_known(void *context)
{
    source *s = context;
    return s->of->draw(&s->draws);
}

static void check(const known *of, double error)
{
    char line[300];
    int used = snprintf(line, sizeof line, "%-16s", of->name);
    bool good = true;
    for (int k = 0; k < SIZES; k++) {
        source s = {of, {1234 + (uint64_t)k, 0}};
        coverage c = count(next_known, &s, of->mean, of->scale, sizes[k], error);
        if (sizes[k] < of->first)
            continue;
        used += snprintf(line + used, sizeof line - (size_t)used, " %4d: %5.1f", sizes[k], 100 * c.covered);
        double room = experiments < EXPERIMENTS ? 200 * sqrt(0.05 * 0.95 / experiments) : 0;
        good &= 100 * c.covered >= of->least - room && 100 * c.covered <= of->most + room;
    }
    print_message("%s\n", line);
    if (!good)
        fail_msg("%s is to be covered by %g to %g %%", of->name, of->least, of->most);
}

static const known amounts[] = {
    {"normal", normal, 10, LL_SCALE_AMOUNT, 93, 97, 20},
    {"uniform", uniform, 0.5, LL_SCALE_AMOUNT, 93, 97, 20},
    {"t, 5 df", student_5, 0, LL_SCALE_AMOUNT, 93, 97, 20},
    {"gamma 2", gamma_2, 2, LL_SCALE_AMOUNT, 93, 97, 20},
    {"exponential", exponential, 1, LL_SCALE_AMOUNT, 93, 97, 20},
    {"5 - exponential", left, 4, LL_SCALE_AMOUNT, 93, 97, 20},
    {"lognormal 0.5", lognormal_half, 1.1331484530668263, LL_SCALE_AMOUNT, 93, 97, 20},
    {"lognormal 1", lognormal_1, 1.6487212707001282, LL_SCALE_AMOUNT, 93, 97, 20},
    {"two modes", two_modes, 0.5, LL_SCALE_AMOUNT, 93, 97, 20},
    {"Poisson 20", poisson_2000, 20, LL_SCALE_COUNT, 93, 97, 20},
};

static void amounts_are_covered(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof amounts / sizeof amounts[0]; i++)
        check(&amounts[i], 0.05);
}

/* With fewer than 20 values skewed distributions cannot be distinguished from flat ones: the interval is a
 * bound, which covers the former at least 93 % of the time, and the latter more often. */
static void few_amounts_are_covered_at_least(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof amounts / sizeof amounts[0]; i++) {
        known few = amounts[i];
        few.first = 10;
        few.most = 100;
        check(&few, 0.05);
    }
}

/* The same, declared to have a long tail: also what has none, or one to the left, is covered. */
static void tailed_amounts_are_covered(void **state)
{
    (void)state;
    experiments = is_full ? EXPERIMENTS : QUICK;
    for (size_t i = 0; i < sizeof amounts / sizeof amounts[0]; i++) {
        known tailed = amounts[i];
        if (tailed.scale == LL_SCALE_COUNT)
            continue;
        tailed.scale = LL_SCALE_TAILED;
        tailed.first = 10;
        tailed.most = 100;
        check(&tailed, 0.05);
    }
    experiments = EXPERIMENTS / LL_TEST_STRIDE;
}

/* With fewer there is none. */
static void fewer_than_10_amounts_have_no_interval(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof amounts / sizeof amounts[0]; i++) {
        source s = {&amounts[i], {8, 0}};
        double told = count(next_known, &s, amounts[i].mean, amounts[i].scale, 9, 0.05).told;
        assert_true(told < 0.001); /* few Poisson counts by chance; these are treated as rare events */
    }
}

/* If a few runs dominate the mean, or two groups differ in size, coverage differs from the level, as
 * ll_interval_covers says. */
static void different_groups_are_covered_as_stated(void **state)
{
    (void)state;
    static const known all[] = {
        {"groups of 5 %", groups_5, 0.05, LL_SCALE_AMOUNT, 89, 98.5, 10},
        {"groups of 10 %", groups_10, 0.1, LL_SCALE_AMOUNT, 89, 98.5, 10},
        {"groups of 20 %", groups_20, 0.2, LL_SCALE_AMOUNT, 89, 98.5, 10},
        {"groups of 30 %", groups_30, 0.3, LL_SCALE_AMOUNT, 89, 100, 10},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        known many = all[i];
        check(&all[i], 0.05);
        many.least = 93;
        many.most = 97;
        many.first = 100;
        check(&many, 0.05);
    }
    double x[100] = {0};
    ll_interval_request order = {.values = x, .error = 0.05};
    static const struct {
        int n;
        const char *words;
    } told[] = {{19, "a bound: at least 93 %, down to 90 %"},
                {20, "93 to 97 %, down to 89 %"},
                {99, "up to 98 %"},
                {100, "93 to 97 %"}};
    for (size_t i = 0; i < sizeof told / sizeof told[0]; i++) {
        order.n = told[i].n;
        assert_non_null(strstr(ll_interval_covers(&order, LL_INTERVAL_BOOTSTRAP_T), told[i].words));
    }
    assert_string_equal(ll_interval_covers(&order, LL_INTERVAL_SKEWNESS_T), "93 to 97 %");
    assert_string_equal(ll_interval_covers(&order, LL_INTERVAL_NONE), "");
}

/* Exact bounds of whole numbers have at least the level; 0.7 % allows for 2000 experiments. */
static void rare_events_are_covered_at_least(void **state)
{
    (void)state;
    static const known all[] = {
        {"flag 1 %", event_1, 0.01, LL_SCALE_FLAG, 94.3, 100, 5},
        {"flag 5 %", event_5, 0.05, LL_SCALE_FLAG, 94.3, 100, 5},
        {"flag 20 %", event_20, 0.2, LL_SCALE_FLAG, 94.3, 100, 5},
        {"0 or 1, 1 %", event_1, 0.01, LL_SCALE_COUNT, 94.3, 100, 5},
        {"0 or 1, 20 %", event_20, 0.2, LL_SCALE_COUNT, 94.3, 100, 5},
        {"Poisson 0.02", poisson_2, 0.02, LL_SCALE_COUNT, 94.3, 100, 5},
        {"Poisson 0.3", poisson_30, 0.3, LL_SCALE_COUNT, 94.3, 100, 5},
        {"Poisson 3", poisson_300, 3, LL_SCALE_COUNT, 94, 100, 5},
        {"0 of 10, amount", rare_30, 0.3, LL_SCALE_AMOUNT, 93, 100, 10},
        {"0 of 100, amount", rare_10, 0.1, LL_SCALE_AMOUNT, 93, 100, 10},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        check(&all[i], 0.05);
}

/* For smaller errors, as repeated checks use them. */
static void other_levels_are_covered(void **state)
{
    (void)state;
    check(&(known){"normal, 99 %", normal, 10, LL_SCALE_AMOUNT, 98.2, 99.7, 20}, 0.01);
    check(&(known){"exponential, 99 %", exponential, 1, LL_SCALE_AMOUNT, 97, 99.7, 20}, 0.01);
    check(&(known){"normal, 90 %", normal, 10, LL_SCALE_AMOUNT, 88, 93, 20}, 0.1);
}

/* ---- metrics of runs ---- */

/* Of `metrics`: the first TAILED are declared to have a long tail, the last MEDIANS to have none of the mean.
 */
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
    ll_status status = ll_experiment_parse(json, "scenarios", &e);
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

/* Most of the error is below the interval; differences mirror it. Without a tail all is as it was. */
static void long_tails_have_bounds_farther_up(void **state)
{
    (void)state;
    draws d = {5, 0};
    double x[40], y[40];
    for (int k = 0; k < 40; k++) {
        x[k] = normal(&d);
        y[k] = -x[k];
    }
    ll_resampler resampler = {0};
    ll_interval_request request = {.values = x, .n = 40, .error = 0.05};
    ll_interval even = ll_interval_of(&request, &resampler);
    request.difference = true;
    ll_interval same = ll_interval_of(&request, &resampler);
    assert_true(same.low == even.low && same.high == even.high);
    request.scale = LL_SCALE_TAILED;
    ll_interval apart = ll_interval_of(&request, &resampler);
    assert_true(apart.low == even.low && apart.high > even.high);
    request.values = y;
    ll_interval other = ll_interval_of(&request, &resampler);
    assert_true(fabs(other.low + apart.high) < 0.1 && fabs(other.high + apart.low) < 0.1);
    assert_true(other.low < -even.high);
    request = (ll_interval_request){.values = x, .n = 40, .error = 0.05, .scale = LL_SCALE_TAILED};
    ll_interval tailed = ll_interval_of(&request, &resampler);
    assert_true(tailed.low > even.low && tailed.high > even.high);
    ll_resampler_free(&resampler);
}

/* What certainty about a long tail costs where there is none: mean widths over those of even sides. */
static void long_tails_cost_a_tenth_of_normal_widths(void **state)
{
    (void)state;
    ll_resampler resampler = {0};
    for (int k = 0; k < SIZES; k++) {
        draws d = {77, 0};
        double x[MOST], widths[2] = {0};
        for (int i = 0; i < 200 && sizes[k] >= LL_INTERVAL_MIN; i++) {
            for (int j = 0; j < sizes[k]; j++)
                x[j] = normal(&d);
            for (int tailed = 0; tailed < 2; tailed++) {
                ll_interval interval =
                    ll_interval_of(&(ll_interval_request){.values = x,
                                                          .n = sizes[k],
                                                          .scale = tailed ? LL_SCALE_TAILED : LL_SCALE_AMOUNT,
                                                          .error = 0.05},
                                   &resampler);
                widths[tailed] += interval.high - interval.low;
            }
        }
        if (sizes[k] >= LL_INTERVAL_MIN)
            print_message("normal, %d runs: width %.3f of that of even sides\n", sizes[k],
                          widths[1] / widths[0]);
        assert_true(sizes[k] < LL_INTERVAL_MIN ||
                    widths[1] < (sizes[k] < LL_INTERVAL_LEVEL ? 1.2 : 1.15) * widths[0]);
    }
    ll_resampler_free(&resampler);
}

/* ---- single cases ---- */

static ll_interval of(const double *x, int n, ll_metric_scale scale, double unit_of)
{
    ll_resampler resampler = {0};
    ll_interval i = ll_interval_of(
        &(ll_interval_request){.values = x, .n = n, .scale = scale, .unit = unit_of, .error = 0.05},
        &resampler);
    ll_resampler_free(&resampler);
    return i;
}

static void near(double got, double wanted)
{
    if (!(fabs(got - wanted) <= 1e-9 * fabs(wanted)))
        fail_msg("%.12g is wanted, got %.12g", wanted, got);
}

/* Clopper and Pearson's by SciPy 1.10 (binomtest, exact); Garwood's by its gamma.ppf. */
static void exact_bounds_are_the_published_ones(void **state)
{
    (void)state;
    static const struct {
        int k, n;
        double low, high;
    } shares[] = {{0, 20, 0, 0.168433470983},
                  {1, 20, 0.00126508949796, 0.248732762772},
                  {3, 10, 0.0667395111777, 0.65245285006},
                  {10, 10, 0.691502892181, 1},
                  {37, 400, 0.0659659425907, 0.125243313097}};
    for (size_t i = 0; i < sizeof shares / sizeof shares[0]; i++) {
        ll_interval share = ll_interval_share(shares[i].k, shares[i].n, 0.05);
        assert_true(fabs(share.low - shares[i].low) < 1e-11 && fabs(share.high - shares[i].high) < 1e-11);
    }
    double none[7] = {0};
    ll_interval i = of(none, 7, LL_SCALE_COUNT, 0);
    assert_int_equal(i.method, LL_INTERVAL_POISSON);
    assert_true(i.low == 0);
    near(i.high, 3.6888794541139354 / 7);
    near(of(none, 7, LL_SCALE_COUNT, 0.25).high, 0.25 * 3.6888794541139354 / 7); /* a rate over 4 s */
    double one[8] = {0, 0, 0, 1, 0, 0, 0, 0}; /* as an event of weight 1: Garwood's */
    i = of(one, 8, LL_SCALE_COUNT, 0);
    assert_int_equal(i.method, LL_INTERVAL_RARE);
    near(i.low, 0.025317807984289876 / 8);
    near(i.high, 5.5716433909388 / 8);
}

static void missing_intervals_have_a_reason(void **state)
{
    (void)state;
    static const double same[6] = {3, 3, 3, 3, 3, 3}, zeros[6] = {0}, four[4] = {1, 2, 3, 4},
                        alone[12] = {0, 0, 2}, top[12] = {5, 5, 5, 1, 5, 5, 5, 5, 5, 5, 5, 5};
    assert_string_equal(of(same, 6, LL_SCALE_AMOUNT, 0).why, "all runs gave the same");
    assert_string_equal(of(zeros, 6, LL_SCALE_AMOUNT, 0).why, "all runs gave the same");
    assert_string_equal(of(four, 4, LL_SCALE_AMOUNT, 0).why, "fewer than 10 runs have it");
    assert_string_equal(of(four, 4, LL_SCALE_COUNT, 0).why, "fewer than 5 runs have it");
    assert_string_equal(of(four, 1, LL_SCALE_AMOUNT, 0).why, "one run alone has it");
    assert_string_equal(of(four, 0, LL_SCALE_AMOUNT, 0).why, "no run has it");
    ll_interval i = of(alone, 12, LL_SCALE_AMOUNT, 0);
    assert_true(i.method == LL_INTERVAL_RARE && i.low > 0 && i.low < 2. / 12 && i.high == INFINITY);
    i = of(top, 12, LL_SCALE_AMOUNT, 0);
    assert_true(i.method == LL_INTERVAL_RARE && i.low == -INFINITY && i.high > 56. / 12 && i.high < 5);
}

/* Shifted and scaled values have shifted and scaled intervals, mirrored ones mirrored: up to rounding. */
static void intervals_follow_their_values(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed < 60; seed++) {
        draws d = {seed, 0};
        double x[40], y[40];
        int n = 10 + (int)(unit(&d) * 30);
        double by = exp(20 * (unit(&d) - 0.5)) * (seed % 2 ? 1 : -1), from = by * (unit(&d) - 0.5);
        for (int k = 0; k < n; k++) {
            x[k] = exponential(&d);
            y[k] = from + by * x[k];
        }
        ll_interval a = of(x, n, LL_SCALE_AMOUNT, 0), b = of(y, n, LL_SCALE_AMOUNT, 0);
        assert_int_equal(a.method, b.method);
        double low = from + by * (by > 0 ? a.low : a.high), high = from + by * (by > 0 ? a.high : a.low);
        assert_true(fabs(b.low - low) < 1e-9 * fabs(by) && fabs(b.high - high) < 1e-9 * fabs(by));
    }
}

/* A skewed distribution and one without a mean: the median's interval has no conditions. By SciPy 1.10
 * (quantile_test) for 10 values it is from the second to the ninth. */
static void medians_are_covered(void **state)
{
    (void)state;
    static const int counts[] = {6, 7, 10, 25, 60};
    for (size_t k = 0; k < sizeof counts / sizeof counts[0]; k++) {
        int n = counts[k], covered[2] = {0};
        draws d = {3, 0};
        for (int i = 0; i < EXPERIMENTS; i++)
            for (int kind = 0; kind < 2; kind++) {
                double x[60];
                for (int j = 0; j < n; j++) {
                    double u = unit(&d), at = kind ? -log(u) : tan(3.14159265358979 * (u - 0.5));
                    int to = j;
                    for (; to > 0 && x[to - 1] > at; to--)
                        x[to] = x[to - 1];
                    x[to] = at;
                }
                ll_interval m = ll_interval_median(x, n, 0.05);
                double median = kind ? log(2) : 0;
                covered[kind] += m.low <= median && median <= m.high;
                assert_true(n != 10 || (m.low == x[1] && m.high == x[8]));
            }
        assert_true(covered[0] > 0.943 * EXPERIMENTS && covered[1] > 0.943 * EXPERIMENTS);
    }
    assert_string_equal(ll_interval_median((double[5]){1, 2, 3, 4, 5}, 5, 0.05).why,
                        "fewer than 6 runs have it");
}

static void t_is_available_on_request(void **state)
{
    (void)state;
    static const double x[3] = {1, 2, 6};
    ll_resampler resampler = {0};
    ll_interval i =
        ll_interval_of(&(ll_interval_request){.values = x, .n = 3, .error = 0.05, .use_t = true}, &resampler);
    assert_int_equal(i.method, LL_INTERVAL_T);
    near(i.high - 3, 4.3026527299112765 * sqrt(7. / 3));
    near(3 - i.low, i.high - 3);
}

static void quantiles_are_numpys(void **state)
{
    (void)state;
    static const double x[5] = {1, 2, 4, 8, 16};
    assert_true(ll_sample_quantile(x, 5, 0.25) == 2 && ll_sample_quantile(x, 5, 0.5) == 4);
    near(ll_sample_quantile(x, 5, 0.9), 12.8);
    near(ll_sample_quantile(x, 4, 0.25), 1.75);
    assert_true(ll_sample_quantile(x, 1, 0.75) == 1 && ll_sample_quantile(x, 5, 1) == 16);
}

/* `--full` [TESTS]: 2,000 experiments for tailed amounts and pools of runs too; only tests whose names match.
 */
int main(int count, char **arguments)
{
    is_full = count > 1 && strcmp(arguments[1], "--full") == 0;
    if (count > 2)
        cmocka_set_test_filter(arguments[2]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(amounts_are_covered),
        cmocka_unit_test(few_amounts_are_covered_at_least),
        cmocka_unit_test(fewer_than_10_amounts_have_no_interval),
        cmocka_unit_test(different_groups_are_covered_as_stated),
        cmocka_unit_test(rare_events_are_covered_at_least),
        cmocka_unit_test(other_levels_are_covered),
        cmocka_unit_test(tailed_amounts_are_covered),
        cmocka_unit_test(metrics_of_runs_are_covered),
        cmocka_unit_test(differences_of_runs_are_covered),
        cmocka_unit_test(long_tails_have_bounds_farther_up),
        cmocka_unit_test(long_tails_cost_a_tenth_of_normal_widths),
        cmocka_unit_test(exact_bounds_are_the_published_ones),
        cmocka_unit_test(missing_intervals_have_a_reason),
        cmocka_unit_test(intervals_follow_their_values),
        cmocka_unit_test(medians_are_covered),
        cmocka_unit_test(t_is_available_on_request),
        cmocka_unit_test(quantiles_are_numpys),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
