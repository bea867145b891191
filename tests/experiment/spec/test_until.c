/* Runs until the mean is known: when they stop, and the coverage of the final interval. */
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
#include "experiment/spec/until.h"
#include "experiment/statistics/summary.h"
#include "support/near.h"

enum { EXPERIMENTS = 2000, MOST = 640 };

static ll_status parse(const char *until, int repeats, ll_experiment **e)
{
    char text[600];
    snprintf(
        text, sizeof text,
        "{\"scenario\":\"race\",\"repeats\":%d,\"until\":{%s},\"metrics\":[\"players.0.remote_error_m.mean\","
        "\"players.0.remote_error_m.max\"]}",
        repeats, until);
    cJSON *json = cJSON_Parse(text);
    ll_status status = ll_experiment_parse(json, "scenarios", NULL, e);
    cJSON_Delete(json);
    return status;
}

static ll_experiment *experiment(const char *until, int repeats)
{
    ll_experiment *e;
    ll_status status = parse(until, repeats, &e);
    if (ll_failed(&status))
        fail_msg("%s", status.text);
    return e;
}

static double normal(double u)
{
    return 3 + ll_normal_quantile(u);
}

static double exponential(double u)
{
    return -log(u);
}

static double lognormal(double u)
{
    return exp(ll_normal_quantile(u) / 2);
}

/* Rows of a point until they are enough; the rest is never read. */
static int64_t run_point(const ll_experiment *e, uint64_t seed, double (*of)(double u), ll_row *rows,
                         ll_resampler *resampler)
{
    for (int64_t k = 0; k < e->head.repeats; k++) {
        ll_row_clear(&rows[k]);
        rows[k].run = k;
        rows[k].metrics[0] = of(ll_rng_unit(seed, 5, (uint64_t)k) + 0x1p-54);
        if (ll_until_reached(e, rows, k + 1, resampler))
            return k + 1;
    }
    return e->head.repeats;
}

static ll_interval told(const ll_experiment *e, const ll_row *rows, int64_t n, ll_resampler *resampler)
{
    double values[MOST];
    ll_interval_request order = ll_experiment_interval_request(e, 0, 0, NAN);
    for (int64_t k = 0; k < n; k++)
        values[k] = rows[k].metrics[0];
    order.values = values;
    order.n = n;
    return ll_summarise(&order, values, resampler).of_mean;
}

static void looks_double(void **state)
{
    (void)state;
    ll_experiment *e = experiment("\"half_width\":0.1,\"least\":10", 100); /* 10, 20, 40, 80, 100 */
    assert_int_equal(ll_until_checks(e), 5);
    assert_near(ll_experiment_interval_request(e, 0, 0, NAN).error, 0.05 / 1.5, 1e-15);
    ll_experiment_free(e);
    e = experiment("", 100);
    assert_true(ll_until_checks(e) == 1 && !ll_until_is_set(e));
    ll_experiment_free(e);
    e = experiment("\"relative\":0.5,\"least\":20", 20);
    assert_int_equal(ll_until_checks(e), 1);
    ll_experiment_free(e);
}

/* Both rules and three distributions: 93 to 98 %, including early stops. */
static void final_intervals_cover(void **state)
{
    (void)state;
    static const struct {
        const char *until;
        int repeats;
        double (*of)(double u);
        double mean;
    } cases[] = {{"\"half_width\":0.5,\"least\":10", 160, normal, 3},
                 {"\"half_width\":0.6,\"least\":10", 40, normal, 3},
                 {"\"half_width\":0.3,\"least\":10", 640, normal, 3},
                 {"\"relative\":0.3,\"least\":10", 160, exponential, 1},
                 {"\"half_width\":0.4,\"least\":10", 160, exponential, 1},
                 {"\"half_width\":0.3,\"least\":10", 640, exponential, 1},
                 {"\"relative\":0.2,\"least\":10", 160, lognormal, 1.1331484530668263},
                 {"\"relative\":0.15,\"least\":20", 320, lognormal, 1.1331484530668263}};
    ll_row *rows = malloc(MOST * sizeof *rows);
    bool good = true;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_experiment *e = experiment(cases[i].until, cases[i].repeats);
        ll_resampler resampler = {0};
        int covered = 0, early = 0;
        double made = 0;
        for (int k = 0; k < EXPERIMENTS; k++) {
            int64_t n = run_point(e, 9000 + (uint64_t)k, cases[i].of, rows, &resampler);
            ll_interval interval = told(e, rows, n, &resampler);
            covered += interval.low <= cases[i].mean && cases[i].mean <= interval.high;
            early += n < cases[i].repeats;
            made += (double)n / EXPERIMENTS;
        }
        print_message("%s of %d: %.1f %% covered, %.1f runs\n", cases[i].until, cases[i].repeats,
                      100. * covered / EXPERIMENTS, made);
        good &= covered >= 0.93 * EXPERIMENTS && covered <= 0.98 * EXPERIMENTS && early > EXPERIMENTS / 2;
        ll_resampler_free(&resampler);
        ll_experiment_free(e);
    }
    free(rows);
    assert_true(good);
}

static void bad_rules_are_reported(void **state)
{
    (void)state;
    static const struct {
        const char *until, *field, *words;
    } cases[] = {{"\"half_width\":-1", "until.half_width", "-1"},
                 {"\"relative\":1.5", "until.relative", "1.5"},
                 {"\"relative\":0.1,\"least\":4", "until.least", "4"},
                 {"\"relative\":0.1,\"least\":50", "until.least", "at most repeats, which is 40"},
                 {"\"relative\":0.1,\"metric\":\"tick\"", "until.metric", "one of the metrics"},
                 {"\"relative\":0.1,\"metric\":\"players.0.remote_error_m.max\"", "until.metric",
                  "depends on rare runs"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_experiment *e = NULL;
        ll_status status = parse(cases[i].until, 40, &e);
        if (status.code != LL_BAD_INPUT || strcmp(status.field, cases[i].field) != 0 ||
            !strstr(status.text, cases[i].words))
            fail_msg("%s gives %s: %s", cases[i].until, status.field, status.text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(looks_double),
        cmocka_unit_test(final_intervals_cover),
        cmocka_unit_test(bad_rules_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
