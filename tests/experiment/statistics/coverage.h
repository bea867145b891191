/* How often intervals cover a mean, counted over simulated experiments. cmocka.h and what it needs come
 * before. */
#pragma once

#include <math.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "experiment/statistics/interval.h"
#include "support/stride.h"

enum { EXPERIMENTS = 2000, QUICK = 400 / LL_TEST_STRIDE, MOST = 300 };

static int experiments = EXPERIMENTS / LL_TEST_STRIDE; /* of each case */
static bool is_full;

/* `--full` [TESTS]: 2,000 experiments where there are fewer, too; only tests whose names match. */
static inline void read_arguments(int count, char **arguments)
{
    is_full = count > 1 && strcmp(arguments[1], "--full") == 0;
    if (count > 2)
        cmocka_set_test_filter(arguments[2]);
}

/* ---- draws ---- */

typedef struct draws {
    uint64_t seed, at;
} draws;

static inline double unit(draws *d)
{
    return ll_rng_unit(d->seed, 17, d->at++) + 0x1p-54;
}

static inline double normal(draws *d)
{
    return 10 + ll_normal_quantile(unit(d));
}

static inline double exponential(draws *d)
{
    return -log(unit(d));
}

/* ---- coverage ---- */

typedef struct coverage {
    double told, covered; /* share of the experiments with an interval, and of these that cover */
} coverage;

static inline coverage count_of(double (*next)(void *context), void *context, double mean,
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

/* Numbers of runs. */
static const int sizes[] = {5, 8, 10, 12, 15, 20, 30, 50, 100, 300};
enum { SIZES = sizeof sizes / sizeof sizes[0] };
