/* Intervals of single samples, medians and quantiles; what a long tail changes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "experiment/statistics/coverage.h"
#include "support/near.h"

/* ---- long tails ---- */

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
    assert_near(other.low, -apart.high, 0.1);
    assert_near(other.high, -apart.low, 0.1);
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

#define NEAR(got, wanted) assert_near(got, wanted, 1e-9 * fabs(wanted))

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
        assert_near(share.low, shares[i].low, 1e-11);
        assert_near(share.high, shares[i].high, 1e-11);
    }
    double none[7] = {0};
    ll_interval i = of(none, 7, LL_SCALE_COUNT, 0);
    assert_int_equal(i.method, LL_INTERVAL_POISSON);
    assert_true(i.low == 0);
    NEAR(i.high, 3.6888794541139354 / 7);
    NEAR(of(none, 7, LL_SCALE_COUNT, 0.25).high, 0.25 * 3.6888794541139354 / 7); /* a rate over 4 s */
    double one[8] = {0, 0, 0, 1, 0, 0, 0, 0}; /* as an event of weight 1: Garwood's */
    i = of(one, 8, LL_SCALE_COUNT, 0);
    assert_int_equal(i.method, LL_INTERVAL_RARE);
    NEAR(i.low, 0.025317807984289876 / 8);
    NEAR(i.high, 5.5716433909388 / 8);
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
        assert_near(b.low, low, 1e-9 * fabs(by));
        assert_near(b.high, high, 1e-9 * fabs(by));
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
    NEAR(i.high - 3, 4.3026527299112765 * sqrt(7. / 3));
    NEAR(3 - i.low, i.high - 3);
}

static void quantiles_are_numpys(void **state)
{
    (void)state;
    static const double x[5] = {1, 2, 4, 8, 16};
    assert_true(ll_sample_quantile(x, 5, 0.25) == 2 && ll_sample_quantile(x, 5, 0.5) == 4);
    NEAR(ll_sample_quantile(x, 5, 0.9), 12.8);
    NEAR(ll_sample_quantile(x, 4, 0.25), 1.75);
    assert_true(ll_sample_quantile(x, 1, 0.75) == 1 && ll_sample_quantile(x, 5, 1) == 16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
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
