/* Sobol' points: published values, and the evenness that defines them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "experiment/statistics/sobol.h"

/* First points of Joe and Kuo's sequence in their order (Gray code): their point k is point k ^ k >> 1
 * here. */
static void begins_as_published(void **state)
{
    (void)state;
    static const double published[8][5] = {
        {0, 0, 0, 0, 0},
        {0.5, 0.5, 0.5, 0.5, 0.5},
        {0.75, 0.25, 0.25, 0.25, 0.75},
        {0.25, 0.75, 0.75, 0.75, 0.25},
        {0.375, 0.375, 0.625, 0.875, 0.375},
        {0.875, 0.875, 0.125, 0.375, 0.875},
        {0.625, 0.125, 0.875, 0.625, 0.625},
        {0.125, 0.625, 0.375, 0.125, 0.125},
    };
    for (uint32_t k = 0; k < 8; k++)
        for (int d = 0; d < 5; d++)
            assert_true(ll_sobol(d, k ^ k >> 1, 0) == published[k][d]);
}

/* Point 77 of SciPy 1.10's, in its order. */
static void forty_dimensions_are_scipys(void **state)
{
    (void)state;
    static const double known[LL_SOBOL_DIMENSIONS] = {
        0.8359375, 0.8359375, 0.0078125, 0.7734375, 0.8359375, 0.5078125, 0.2265625, 0.6484375,
        0.1796875, 0.4296875, 0.1328125, 0.7890625, 0.4921875, 0.3359375, 0.9921875, 0.0703125,
        0.8203125, 0.8828125, 0.7890625, 0.0078125, 0.1484375, 0.8828125, 0.8671875, 0.7890625,
        0.8515625, 0.6796875, 0.8046875, 0.3671875, 0.1640625, 0.4609375, 0.9765625, 0.7421875,
        0.1796875, 0.0546875, 0.6953125, 0.7734375, 0.5546875, 0.8984375, 0.1328125, 0.2734375};
    for (int d = 0; d < LL_SOBOL_DIMENSIONS; d++)
        assert_true(ll_sobol(d, 77 ^ 77 >> 1, 0) == known[d]);
}

/* Any 2^k consecutive points from a multiple of 2^k: one in each of 2^k equal intervals, shifted or not. */
static void each_interval_has_one(void **state)
{
    (void)state;
    enum { N = 256 };
    for (int d = 0; d < LL_SOBOL_DIMENSIONS; d++)
        for (uint32_t shift = 0; shift < 3; shift++)
            for (uint32_t from = 0; from < 4 * N; from += N) {
                int hits[N] = {0};
                for (uint32_t k = 0; k < N; k++)
                    hits[(int)(ll_sobol(d, from + k, shift * 0x9e3779b9u) * N)]++;
                for (int i = 0; i < N; i++)
                    assert_int_equal(hits[i], 1);
            }
}

/* The first two dimensions are a (0, 2)-sequence: every elementary box of area 1/256 has one point of 256. */
static void each_box_has_one(void **state)
{
    (void)state;
    for (int bits = 0; bits <= 8; bits++) {
        int hits[256] = {0};
        for (uint32_t k = 0; k < 256; k++) {
            int x = (int)(ll_sobol(0, k, 0) * (1 << bits)), y = (int)(ll_sobol(1, k, 0) * (1 << (8 - bits)));
            hits[x << (8 - bits) | y]++;
        }
        for (int i = 0; i < 256; i++)
            assert_int_equal(hits[i], 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(begins_as_published),
        cmocka_unit_test(forty_dimensions_are_scipys),
        cmocka_unit_test(each_interval_has_one),
        cmocka_unit_test(each_box_has_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
