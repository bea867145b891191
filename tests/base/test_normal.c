#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/rng.h"
#include "support/near.h"

#define COUNT 1000000

/* The distribution function of the quantile is p again. An error e of the quantile changes p by e times the
 * density, so that is what it is compared with. */
static void assert_inverse(double p, int lower)
{
    long double x = ll_normal_quantile(p);
    long double back = lower ? erfcl(-x / sqrtl(2)) / 2 : erfcl(x / sqrtl(2)) / 2;
    long double density = expl(-x * x / 2) / sqrtl(2 * acosl(-1));
    long double want = lower ? p : 1 - (long double)p;
    assert_true(fabsl(back - want) <= 2e-15L * fabsl(x) * density + 1e-16L * want);
}

static void quantile_inverts_the_distribution(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 200000; i++) {
        double p = ll_rng_unit(1, 1, i) / 2 + 0x1p-60;
        assert_inverse(p, 1);
    }
    for (double p = 1e-300; p < 0.49; p *= 1.01)
        assert_inverse(p, 1);
    for (double p = 0.51; p < 1; p += 0.001)
        assert_inverse(p, 0);
}

static void quantile_is_odd_about_a_half(void **state)
{
    (void)state;
    assert_true(ll_normal_quantile(0.5) == 0);
    for (int i = 1; i < 1024; i++) {
        double p = i / 2048.0; /* 1 - p is exact */
        assert_true(ll_normal_quantile(1 - p) == -ll_normal_quantile(p));
    }
}

/* Known quantiles, from tables. */
static void quantile_of_known_values(void **state)
{
    (void)state;
    assert_near(ll_normal_quantile(0.975), 1.959963984540054, 1e-15);
    assert_near(ll_normal_quantile(0.25), -0.6744897501960817, 1e-15);
    assert_near(ll_normal_quantile(1e-20), -9.262340089798409, 1e-13);
}

/* Against the error function of libm in long double; equal to the relative error that is stated. */
static void distribution_agrees_with_libm(void **state)
{
    (void)state;
    for (int i = -36000; i <= 9000; i++) {
        double x = i / 1000.0 + 1e-5;
        long double want = erfcl(-x / sqrtl(2)) / 2;
        assert_true(fabsl(ll_normal_cdf(x) - want) <= (fabs(x) <= 7 ? 1e-14L : 3e-13L) * want);
    }
    assert_true(ll_normal_cdf(0) == 0.5 && ll_normal_cdf(40) == 1 && ll_normal_cdf(-1e9) == 0);
}

/* Moments of COUNT deviates within 4 standard errors: 0, 1, 0, 3. */
static void moments_are_normal(void **state)
{
    (void)state;
    double m1 = 0, m2 = 0, m3 = 0, m4 = 0;
    for (uint64_t i = 0; i < COUNT; i++) {
        double x = ll_rng_normal(3, 4, i);
        m1 += x;
        m2 += x * x;
        m3 += x * x * x;
        m4 += x * x * x * x;
    }
    assert_near(m1 / COUNT, 0, 4 * sqrt(1.0 / COUNT));
    assert_near(m2 / COUNT, 1, 4 * sqrt(2.0 / COUNT));
    assert_near(m3 / COUNT, 0, 4 * sqrt(15.0 / COUNT));
    assert_near(m4 / COUNT, 3, 4 * sqrt(96.0 / COUNT));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quantile_inverts_the_distribution),
        cmocka_unit_test(quantile_is_odd_about_a_half),
        cmocka_unit_test(quantile_of_known_values),
        cmocka_unit_test(distribution_agrees_with_libm),
        cmocka_unit_test(moments_are_normal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
