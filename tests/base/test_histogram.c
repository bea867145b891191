#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/histogram.h"
#include "base/rng.h"
#include "support/near.h"

#define COUNT 20000

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The smallest value that at least the share q does not exceed. */
static double sorted_quantile(const double *sorted, int n, double q)
{
    int rank = (int)ceil(q * n - 1e-9);
    return sorted[rank < 1 ? 0 : rank - 1];
}

/* Half a unit below 32 units, a 63rd above. */
static double width(double value, double unit)
{
    return (value < 32 * unit ? unit / 2 : value / 63) * (1 + 1e-12);
}

static void compare_with_sorting(double (*draw)(uint64_t), double unit)
{
    static double values[COUNT];
    ll_histogram h;
    ll_histogram_init(&h, unit);
    double sum = 0, squares = 0;
    for (uint64_t i = 0; i < COUNT; i++) {
        values[i] = draw(i);
        ll_histogram_add(&h, values[i]);
        sum += values[i];
        squares += values[i] * values[i];
    }
    qsort(values, COUNT, sizeof values[0], by_value);
    for (int percent = 0; percent <= 100; percent++) {
        double q = percent / 100.0;
        double got = ll_histogram_quantile(&h, q);
        assert_near(got, sorted_quantile(values, COUNT, q), width(sorted_quantile(values, COUNT, q), unit));
        assert_true(got >= values[0] && got <= values[COUNT - 1]);
    }
    assert_true(ll_histogram_quantile(&h, 0) == values[0]);
    assert_true(ll_histogram_quantile(&h, 1) == values[COUNT - 1]);
    ll_summary s = ll_histogram_summary(&h);
    assert_true(s.count == COUNT && s.max == values[COUNT - 1]);
    assert_true(s.mean == sum / COUNT && s.rms == sqrt(squares / COUNT));
    assert_near(s.p50, sorted_quantile(values, COUNT, 0.5), width(sorted_quantile(values, COUNT, 0.5), unit));
    assert_near(s.p95, sorted_quantile(values, COUNT, 0.95),
                width(sorted_quantile(values, COUNT, 0.95), unit));
    assert_near(s.p99, sorted_quantile(values, COUNT, 0.99),
                width(sorted_quantile(values, COUNT, 0.99), unit));
}

static double uniform(uint64_t i)
{
    return 500 * ll_rng_unit(1, 1, i);
}

static double normal(uint64_t i)
{
    return fabs(ll_rng_normal(1, 2, i));
}

static double wide_range(uint64_t i)
{
    return exp(13 * ll_rng_unit(1, 3, i) - 2); /* 0.1 to 6e4 */
}

static double mostly_zero(uint64_t i)
{
    double u = ll_rng_unit(1, 4, i);
    return u < 0.7 ? 0 : u;
}

static void quantiles_agree_with_sorting(void **state)
{
    (void)state;
    compare_with_sorting(uniform, 1);
    compare_with_sorting(uniform, 0.01);
    compare_with_sorting(normal, 0.001);
    compare_with_sorting(wide_range, 0.25);
    compare_with_sorting(mostly_zero, 0.01);
}

static double small_count(uint64_t i)
{
    return (double)(ll_rng_u64(1, 5, i) % 63);
}

static void counts_come_out_whole(void **state)
{
    (void)state;
    ll_histogram h;
    ll_histogram_init(&h, 1);
    static double values[COUNT];
    for (uint64_t i = 0; i < COUNT; i++) {
        values[i] = small_count(i);
        ll_histogram_add(&h, values[i]);
    }
    qsort(values, COUNT, sizeof values[0], by_value);
    for (int percent = 0; percent <= 100; percent++)
        assert_true(ll_histogram_quantile(&h, percent / 100.0) ==
                    sorted_quantile(values, COUNT, percent / 100.0));
}

static void many_zeros_have_a_median_of_zero(void **state)
{
    (void)state;
    ll_histogram h;
    ll_histogram_init(&h, 0.5);
    for (int i = 0; i < 100; i++)
        ll_histogram_add(&h, i < 60 ? 0 : 7);
    assert_true(ll_histogram_quantile(&h, 0.5) == 0);
    assert_true(ll_histogram_quantile(&h, 0.6) == 0);
    assert_true(ll_histogram_quantile(&h, 0.61) == 7);
}

static void one_value_is_every_quantile(void **state)
{
    (void)state;
    ll_histogram h;
    ll_histogram_init(&h, 0.1);
    for (int i = 0; i < 10; i++)
        ll_histogram_add(&h, 123.456);
    ll_summary s = ll_histogram_summary(&h);
    assert_true(s.p50 == 123.456 && s.p95 == 123.456 && s.p99 == 123.456 && s.max == 123.456);
    assert_near(s.mean, 123.456, 1e-12);
    assert_near(s.rms, 123.456, 1e-12);
}

static void empty_is_no_number(void **state)
{
    (void)state;
    ll_histogram h;
    ll_histogram_init(&h, 1);
    ll_summary s = ll_histogram_summary(&h);
    assert_true(isnan(s.mean) && isnan(s.rms) && isnan(s.p50) && isnan(s.p95) && isnan(s.p99) &&
                isnan(s.max));
    assert_int_equal(s.count, 0);
    assert_true(isnan(ll_histogram_quantile(&h, 0.5)));
}

/* What never comes about is infinite: it moves quantiles, and leaves the mean of the others as it is. */
static void infinite_values_count_in_quantiles(void **state)
{
    (void)state;
    ll_histogram h;
    ll_histogram_init(&h, 1);
    for (int i = 1; i <= 4; i++)
        ll_histogram_add(&h, i);
    for (int i = 0; i < 4; i++)
        ll_histogram_add_never(&h);
    ll_summary s = ll_histogram_summary(&h);
    assert_true(s.mean == 2.5 && s.max == 4 && s.rms == sqrt(30 / 4.0));
    assert_int_equal(s.count, 8);
    assert_int_equal(s.never, 4);
    assert_true(s.p50 == 4 && isinf(s.p95) && isinf(s.p99)); /* the fourth of eight, and the last */
    assert_true(ll_histogram_quantile(&h, 0.25) == 2 && isinf(ll_histogram_quantile(&h, 0.51)));
    ll_histogram_add_never(&h);
    assert_true(isinf(ll_histogram_quantile(&h, 0.5))); /* more than half never come */

    ll_histogram_init(&h, 1);
    ll_histogram_add_never(&h);
    s = ll_histogram_summary(&h);
    assert_true(isnan(s.mean) && isnan(s.max) && isinf(s.p50));
    assert_int_equal(s.count, 1);
}

/* A value beyond every bucket is counted, and its size is not lost. */
static void beyond_the_last_bucket(void **state)
{
    (void)state;
    ll_histogram h;
    ll_histogram_init(&h, 1);
    ll_histogram_add(&h, 1e9);
    ll_histogram_add(&h, 1e300);
    ll_histogram_add(&h, 3);
    assert_int_equal(h.bucket[LL_HISTOGRAM_BUCKETS - 1], 2);
    assert_int_equal(h.count, 3);
    assert_true(ll_histogram_quantile(&h, 1) == 1e300);
    assert_true(ll_histogram_quantile(&h, 0.5) >= 250000); /* at least the last bucket */
}

/* Every bucket holds an interval, and the next begins where it ends. */
static void buckets_ascend_without_gaps(void **state)
{
    (void)state;
    int before = 0;
    for (double v = 0; v < 300000; v += v < 64 ? 0.01 : v / 4000) {
        ll_histogram h;
        ll_histogram_init(&h, 1);
        ll_histogram_add(&h, v);
        int at = 0;
        while (h.bucket[at] == 0)
            at++;
        assert_true(at == before || at == before + 1);
        before = at;
    }
    assert_int_equal(before, LL_HISTOGRAM_BUCKETS - 1);
}

/* A value added several times is the same, to the bit, as one call for each time. */
static void several_at_once(void **state)
{
    (void)state;
    ll_histogram at_once, one_by_one;
    ll_histogram_init(&at_once, 0.1);
    ll_histogram_init(&one_by_one, 0.1);
    for (uint64_t i = 0; i < 1000; i++) {
        const double value = i % 5 == 0 ? 0 : ll_rng_unit(1, 2, i) * (double)(i * i);
        const int times = (int)(i % 9);
        if (times > 0)
            ll_histogram_add_times(&at_once, value, times);
        for (int k = 0; k < times; k++)
            ll_histogram_add(&one_by_one, value);
    }
    assert_memory_equal(&at_once, &one_by_one, sizeof at_once);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quantiles_agree_with_sorting),
        cmocka_unit_test(counts_come_out_whole),
        cmocka_unit_test(many_zeros_have_a_median_of_zero),
        cmocka_unit_test(one_value_is_every_quantile),
        cmocka_unit_test(empty_is_no_number),
        cmocka_unit_test(infinite_values_count_in_quantiles),
        cmocka_unit_test(beyond_the_last_bucket),
        cmocka_unit_test(buckets_ascend_without_gaps),
        cmocka_unit_test(several_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
