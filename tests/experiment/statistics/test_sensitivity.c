/* Sobol' indices of functions with known indices, and the coverage of their intervals. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "experiment/statistics/sample.h"
#include "experiment/statistics/sensitivity.h"
#include "support/near.h"

#define PI 3.14159265358979323846

enum { DIMENSIONS_MAX = 4 };

typedef struct function {
    const char *name;
    int dimensions;
    double (*f)(const double *u);
    double first[DIMENSIONS_MAX], total[DIMENSIONS_MAX];
} function;

/* Ishigami and Homma (1990), a = 7, b = 0.1. */
static double ishigami(const double *u)
{
    double x = PI * (2 * u[0] - 1), y = PI * (2 * u[1] - 1), z = PI * (2 * u[2] - 1);
    return sin(x) + 7 * sin(y) * sin(y) + 0.1 * z * z * z * z * sin(x);
}

/* Sobol's g-function with a = 0, 1, 4.5, 9. */
static const double weights[4] = {0, 1, 4.5, 9};

static double g(const double *u)
{
    double product = 1;
    for (int i = 0; i < 4; i++)
        product *= (fabs(4 * u[i] - 2) + weights[i]) / (1 + weights[i]);
    return product;
}

static double sum(const double *u)
{
    return 3 * u[0] + 4 * u[1] + 1e6;
}

static function functions[3] = {
    {"ishigami", 3, ishigami, {0}, {0}}, {"g", 4, g, {0}, {0}}, {"sum", 2, sum, {0.36, 0.64}, {0.36, 0.64}}};

/* The closed forms (Saltelli et al., Global Sensitivity Analysis, 2008). */
static void solve(void)
{
    double a = 7, b = 0.1, v1 = pow(1 + b * pow(PI, 4) / 5, 2) / 2, v2 = a * a / 8;
    double v13 = b * b * pow(PI, 8) * 8 / 225, v = v1 + v2 + v13, product = 1, own[4];
    functions[0].first[0] = v1 / v;
    functions[0].first[1] = functions[0].total[1] = v2 / v;
    functions[0].total[0] = (v1 + v13) / v;
    functions[0].total[2] = v13 / v;
    for (int i = 0; i < 4; i++) {
        own[i] = 1 / (3 * (1 + weights[i]) * (1 + weights[i]));
        product *= 1 + own[i];
    }
    for (int i = 0; i < 4; i++) {
        functions[1].first[i] = own[i] / (product - 1);
        functions[1].total[i] = own[i] * product / (1 + own[i]) / (product - 1);
    }
}

static void find(const function *of, int64_t count, uint64_t seed, ll_sensitivity *indices)
{
    ll_sample_request order = {LL_SAMPLE_SALTELLI, of->dimensions, count, seed};
    int64_t points = ll_sample_points(&order);
    double *values = malloc((size_t)points * sizeof *values);
    assert_int_equal(points, count * (of->dimensions + 2));
    for (int64_t p = 0; p < points; p++) {
        double u[DIMENSIONS_MAX];
        for (int d = 0; d < of->dimensions; d++)
            u[d] = ll_sample_coordinate(&order, d, p);
        values[p] = of->f(u);
    }
    ll_status status = ll_sensitivity_of(values, count, of->dimensions, indices);
    assert_false(ll_failed(&status));
    free(values);
}

static void indices_are_those_of_the_closed_forms(void **state)
{
    (void)state;
    solve();
    for (int k = 0; k < 3; k++) {
        ll_sensitivity s[DIMENSIONS_MAX];
        find(&functions[k], 8192, 3, s);
        for (int d = 0; d < functions[k].dimensions; d++) {
            print_message("%s %d: first %.4f (%.4f), total %.4f (%.4f)\n", functions[k].name, d, s[d].first,
                          functions[k].first[d], s[d].total, functions[k].total[d]);
            assert_near(s[d].first, functions[k].first[d], 0.01);
            assert_near(s[d].total, functions[k].total[d], 0.01);
            assert_int_equal(s[d].samples, 8192);
        }
    }
}

/* Over 400 seeds, for two functions. Sobol' points are more even than resamples, so the intervals cover more
 * than stated. */
static void intervals_cover(void **state)
{
    (void)state;
    enum { SEEDS = 400 };
    solve();
    for (int k = 0; k < 2; k++) {
        int first[DIMENSIONS_MAX] = {0}, total[DIMENSIONS_MAX] = {0};
        const function *of = &functions[k];
        for (uint64_t seed = 1; seed <= SEEDS; seed++) {
            ll_sensitivity s[DIMENSIONS_MAX];
            find(of, 256, seed, s);
            for (int d = 0; d < of->dimensions; d++) {
                first[d] += s[d].first_low <= of->first[d] && of->first[d] <= s[d].first_high;
                total[d] += s[d].total_low <= of->total[d] && of->total[d] <= s[d].total_high;
            }
        }
        for (int d = 0; d < of->dimensions; d++) {
            print_message("%s %d: first %.1f %%, total %.1f %%\n", of->name, d, 100. * first[d] / SEEDS,
                          100. * total[d] / SEEDS);
            assert_true(first[d] >= 0.93 * SEEDS && total[d] >= 0.93 * SEEDS);
        }
    }
}

static void missing_values_are_left_out(void **state)
{
    (void)state;
    double values[30 * 4];
    ll_sensitivity s[2];
    ll_sample_request order = {LL_SAMPLE_SALTELLI, 2, 30, 8};
    for (int p = 0; p < 30 * 4; p++)
        values[p] = 3 * ll_sample_coordinate(&order, 0, p);
    values[4 * 7 + 2] = NAN;
    assert_false(ll_failed(&(ll_status){ll_sensitivity_of(values, 30, 2, s).code, "", ""}));
    assert_true(s[0].samples == 29);
    assert_near(s[0].total, 1, 0.2);
    assert_true(s[1].total == 0);
    assert_true(s[1].first == 0);
    for (int p = 0; p < 30 * 4; p++)
        values[p] = 5;
    ll_sensitivity_of(values, 30, 2, s);
    assert_true(isnan(s[0].first) && isnan(s[1].total) && s[0].samples == 30);
    ll_sensitivity_of(values, 0, 2, s);
    assert_true(s[0].samples == 0 && isnan(s[0].total_low));
}

/* In each dimension every n-th part of the range has one of n points; dimensions have different orders. */
static void latin_hypercubes_have_one_in_each_stratum(void **state)
{
    (void)state;
    static const int64_t counts[] = {1, 2, 3, 17, 64, 1000};
    for (int k = 0; k < 6; k++)
        for (uint64_t seed = 0; seed < 5; seed++) {
            int64_t n = counts[k];
            int taken[2][1000] = {{0}};
            double together = 0;
            ll_sample_request order = {LL_SAMPLE_LHS, 2, n, seed};
            for (int64_t p = 0; p < n; p++) {
                double u[2];
                for (int d = 0; d < 2; d++) {
                    u[d] = ll_sample_coordinate(&order, d, p);
                    assert_true(u[d] >= 0 && u[d] < 1);
                    taken[d][(int)(u[d] * (double)n)]++;
                }
                together += (u[0] - 0.5) * (u[1] - 0.5) * 12 / (double)n;
            }
            for (int64_t i = 0; i < n; i++)
                assert_true(taken[0][i] == 1 && taken[1][i] == 1);
            assert_true(n < 1000 || fabs(together) < 0.15);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(indices_are_those_of_the_closed_forms),
        cmocka_unit_test(intervals_cover),
        cmocka_unit_test(missing_values_are_left_out),
        cmocka_unit_test(latin_hypercubes_have_one_in_each_stratum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
