/* Of runs until the mean is known the final interval covers it as often as stated. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "base/rng.h"
#include "experiment/spec/until.h"
#include "experiment/statistics/summary.h"

enum { EXPERIMENTS = 2000, MOST = 640 };

static ll_experiment *experiment(const char *until, int repeats)
{
    char text[300];
    ll_experiment *e;
    snprintf(text, sizeof text,
             "{\"scenario\":\"race\",\"repeats\":%d,\"until\":{%s},\"metrics\":[\"players.0.remote_error_m."
             "mean\"]}",
             repeats, until);
    cJSON *json = cJSON_Parse(text);
    ll_status status = ll_experiment_parse(json, "scenarios", NULL, &e);
    cJSON_Delete(json);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(final_intervals_cover),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
