/* Errors in units of the last place against long double, whose own error is 1/2000 of that. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "base/pair.h"
#include "base/rng.h"
#include "support/near.h"

#define COUNT 1000000

typedef double function(double);
typedef long double reference(long double);

static double error_ulp(double got, long double want)
{
    int exponent;
    frexp((double)want, &exponent);
    double ulp = ldexp(1, exponent < -1021 ? -1074 : exponent - 53);
    return (double)(fabsl((long double)got - want) / ulp);
}

/* Worst of COUNT arguments, evenly spread over [from, to]. */
static double worst(function *f, reference *r, double from, double to)
{
    double most = 0;
    for (uint64_t i = 0; i < COUNT; i++) {
        double x = from + (to - from) * ll_rng_unit(1, 2, i);
        double error = error_ulp(f(x), r((long double)x));
        most = larger(most, error);
    }
    return most;
}

static void exp_is_within_an_ulp(void **state)
{
    (void)state;
    assert_true(worst(ll_exp, expl, -1, 1) <= 1);
    assert_true(worst(ll_exp, expl, -1e-3, 1e-3) <= 0.51);
    assert_true(worst(ll_exp, expl, -708, 709.7) <= 1);
    assert_true(worst(ll_exp, expl, -745, -708) <= 1.001); /* subnormal results are rounded twice */
}

static void log_is_within_an_ulp(void **state)
{
    (void)state;
    assert_true(worst(ll_detmath_log, logl, 0.5, 2) <= 1);
    assert_true(worst(ll_detmath_log, logl, 0.99, 1.01) <=
                1); /* the result is small here, and still right in every bit */
    assert_true(worst(ll_detmath_log, logl, 1e-300, 1) <= 1);
    assert_true(worst(ll_detmath_log, logl, 1, 1e300) <= 1);
    assert_true(worst(ll_detmath_log, logl, 0x1p-1074, 0x1p-1022) <= 1);
}

static void sine_and_cosine_are_within_an_ulp(void **state)
{
    (void)state;
    static const double limits[] = {0.7853, 3, 30, 1000, 1e6};
    for (int i = 0; i < 5; i++) {
        assert_true(worst(ll_sin, sinl, -limits[i], limits[i]) <= 1);
        assert_true(worst(ll_cos, cosl, -limits[i], limits[i]) <= 1);
    }
}

static void arctangent_is_within_two_and_a_half_ulp(void **state)
{
    (void)state;
    static const double sizes[] = {1, 1e-3, 1e3, 1e-12};
    double most = 0;
    for (uint64_t i = 0; i < COUNT; i++) {
        double y = 2 * ll_rng_unit(1, 2, i) - 1, x = (2 * ll_rng_unit(1, 3, i) - 1) * sizes[i % 4];
        double error = error_ulp(ll_atan2(y, x), atan2l((long double)y, (long double)x));
        most = larger(most, error);
    }
    assert_true(most <= 2.5);
    assert_true(ll_atan2(0, 1) == 0 && ll_atan2(0, 0) == 0 && ll_atan2(1, 1) == atan(1));
    assert_true(ll_atan2(1, 0) == acos(0) && ll_atan2(-1, 0) == -acos(0) && ll_atan2(0, -1) == acos(-1));
}

/* The double nearest to k pi is the hardest argument near it: what is left is the rounding error of that
 * double. */
static void zeros_of_the_sine_are_found(void **state)
{
    (void)state;
    for (int k = 1; k <= 318309; k += k < 1000 ? 1 : 97) {
        double x = (double)((long double)k * 3.14159265358979323846264338327950288L);
        assert_true(error_ulp(ll_sin(x), sinl((long double)x)) <= 1);
    }
}

static void special_values(void **state)
{
    (void)state;
    assert_true(ll_exp(0) == 1 && ll_detmath_log(1) == 0 && ll_sin(0) == 0 && ll_cos(0) == 1);
    assert_true(ll_exp(-800) == 0 && isinf(ll_exp(710)) && ll_exp(709.7) < DBL_MAX);
    assert_true(ll_exp(-(double)INFINITY) == 0 && isinf(ll_exp((double)INFINITY)));
    assert_true(isinf(ll_detmath_log(0)) && ll_detmath_log(0) < 0 && isnan(ll_detmath_log(-1)) &&
                isinf(ll_detmath_log((double)INFINITY)));
    assert_true(isnan(ll_exp((double)NAN)) && isnan(ll_detmath_log((double)NAN)));
    assert_true(isnan(ll_sin((double)NAN)) && isnan(ll_cos((double)INFINITY)));
    assert_true(ll_sqrt(2) == sqrt(2.0));
}

static bool same(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* Each lane of two at once, and both functions at once. */
static void two_at_once_have_the_bits_of_one(void **state)
{
    (void)state;
    static const double sizes[] = {1e-9, 1, 30, 1e6, 1e20};
    for (uint64_t i = 0; i < 100000; i++) {
        double size = sizes[i % 5], a = size * (2 * ll_rng_unit(1, 2, i) - 1), b = 7 * ll_rng_unit(1, 3, i);
        double sin, cos;
        ll_pair x = {a, b}, s, c, s1 = ll_pair_sin(x), c1 = ll_pair_cos(x);
        ll_pair_sincos(x, &s, &c);
        for (int lane = 0; lane < 2; lane++) {
            ll_sincos(x[lane], &sin, &cos);
            assert_true(same(sin, ll_sin(x[lane])) && same(cos, ll_cos(x[lane])));
            assert_true(same(s[lane], sin) && same(c[lane], cos) && same(s1[lane], sin));
            assert_true(same(c1[lane], cos) && same(ll_pair_sqrt(x * x)[lane], ll_sqrt(x[lane] * x[lane])));
        }
    }
}

/* The same bits on every compiler and optimisation level: each build runs this. */
static void bits_are_pinned(void **state)
{
    (void)state;
    double sum = 0;
    for (uint64_t i = 0; i < 1000; i++) {
        double u = ll_rng_unit(3, 4, i);
        sum = sum * 0.75 + ll_sin(100 * u) + ll_cos(1000 * u) + ll_exp(2 * u) + ll_detmath_log(u + 0.125);
    }
    char text[40];
    snprintf(text, sizeof text, "%a", sum);
    assert_string_equal(text, "0x1.a951740cb6838p+2");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exp_is_within_an_ulp),
        cmocka_unit_test(log_is_within_an_ulp),
        cmocka_unit_test(sine_and_cosine_are_within_an_ulp),
        cmocka_unit_test(arctangent_is_within_two_and_a_half_ulp),
        cmocka_unit_test(zeros_of_the_sine_are_found),
        cmocka_unit_test(special_values),
        cmocka_unit_test(two_at_once_have_the_bits_of_one),
        cmocka_unit_test(bits_are_pinned),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
