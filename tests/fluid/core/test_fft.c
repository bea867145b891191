/* Transforms against the sums that define them, in long double. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "fluid/core/fft.h"

static const long double turn = 6.283185307179586476925286766559L;

static const int lengths[] = {1,  2,  3,  4,  5,  6,  8,  9,  10, 12, 15, 16, 20, 24,  25,  27,
                              30, 32, 36, 40, 45, 48, 50, 60, 64, 75, 81, 90, 96, 100, 125, 128};
enum { LENGTHS = sizeof lengths / sizeof lengths[0], MOST = 256 };

static void fill(double *data, int n)
{
    for (int i = 0; i < n; i++)
        data[i] = 2 * ll_rng_unit(7, 0, (uint64_t)i) - 1;
}

static ll_fft *plan_of(int n)
{
    ll_fft *plan = malloc(ll_fft_size(n));
    assert_non_null(plan);
    ll_fft_init(plan, n);
    return plan;
}

static void close_to(const char *what, int n, double got, long double wanted)
{
    if (!(fabsl(got - wanted) <= 1e-12L))
        fail_msg("%s of %d: %.17g, the sum is %.17Lg", what, n, got, wanted);
}

static void complex_transforms_equal_the_sum(void **state)
{
    (void)state;
    for (int l = 0; l < LENGTHS; l++)
        for (int sign = 1; sign >= -1; sign -= 2) {
            int n = lengths[l], count = 3;
            ll_complex x[3 * MOST], y[3 * MOST], work[3 * MOST];
            ll_fft *plan = plan_of(n);
            fill(&x[0].re, 2 * n * count);
            memcpy(y, x, sizeof x[0] * (size_t)(n * count));
            ll_fft_run(plan, y, work, count, sign > 0 ? LL_FFT_FORWARD : LL_FFT_INVERSE);
            for (int q = 0; q < count; q++)
                for (int k = 0; k < n; k++) {
                    long double re = 0, im = 0;
                    for (int j = 0; j < n; j++) {
                        long double angle = -sign * turn * (j * k % n) / n, c = cosl(angle), s = sinl(angle);
                        re += x[j * count + q].re * c - x[j * count + q].im * s;
                        im += x[j * count + q].re * s + x[j * count + q].im * c;
                    }
                    close_to("re", n, y[k * count + q].re, re);
                    close_to("im", n, y[k * count + q].im, im);
                }
            free(plan);
        }
}

static void there_and_back_in_two_dimensions(void **state)
{
    (void)state;
    enum { NX = 24, NY = 20 };
    static ll_complex x[NX * NY], y[NX * NY], work[NX * NY];
    ll_fft *px = plan_of(NX), *py = plan_of(NY);
    fill(&x[0].re, 2 * NX * NY);
    memcpy(y, x, sizeof x);
    ll_fft_run_2d(px, py, y, work, LL_FFT_FORWARD, NULL);
    long double re = 0, energy = 0, bins = 0;
    for (int j = 0; j < NY; j++)
        for (int i = 0; i < NX; i++) {
            long double angle = -turn * (3.0L * i / NX + 7.0L * j / NY);
            re += x[j * NX + i].re * cosl(angle) - x[j * NX + i].im * sinl(angle);
        }
    close_to("a bin", NX, y[7 * NX + 3].re, re);
    for (int i = 0; i < NX * NY; i++) {
        energy += (long double)x[i].re * x[i].re + (long double)x[i].im * x[i].im;
        bins += (long double)y[i].re * y[i].re + (long double)y[i].im * y[i].im;
    }
    assert_true(fabsl(bins / (NX * NY) / energy - 1) < 1e-14L); /* Parseval */
    ll_fft_run_2d(px, py, y, work, LL_FFT_INVERSE, NULL);
    for (int i = 0; i < NX * NY; i++)
        close_to("the way back", NX, y[i].re / (NX * NY), x[i].re);
    free(px);
    free(py);
}

static void cosine_transforms_equal_the_sum(void **state)
{
    (void)state;
    for (int l = 0; l < LENGTHS; l++) {
        int n = lengths[l], row = 6;
        double x[6 * MOST], y[6 * MOST], work[6 * MOST];
        ll_fft *plan = plan_of(n);
        fill(x, n * row);
        memcpy(y, x, sizeof x[0] * (size_t)(n * row));
        ll_dct_run(plan, y, work, row / 2, LL_FFT_FORWARD);
        for (int q = 0; q < row; q++)
            for (int k = 0; k < n; k++) {
                long double sum = 0;
                for (int j = 0; j < n; j++)
                    sum += 2 * x[j * row + q] * cosl(turn * (k * (2 * j + 1) % (4 * n)) / (4 * n));
                close_to("cosine sum", n, y[k * row + q], sum);
            }
        ll_dct_run(plan, y, work, row / 2, LL_FFT_INVERSE);
        for (int i = 0; i < n * row; i++)
            close_to("the way back", n, y[i], x[i]);
        free(plan);
    }
}

static void cosines_in_two_dimensions_pick_their_mode(void **state)
{
    (void)state;
    enum { NX = 30, NY = 16, KX = 4, KY = 9 };
    static double x[NX * NY], first[NX * NY], work[NX * NY];
    ll_fft *px = plan_of(NX), *py = plan_of(NY);
    for (int j = 0; j < NY; j++)
        for (int i = 0; i < NX; i++)
            x[j * NX + i] =
                (double)(cosl(turn * KX * (2 * i + 1) / (4 * NX)) * cosl(turn * KY * (2 * j + 1) / (4 * NY)));
    memcpy(first, x, sizeof x);
    ll_dct_run_2d(px, py, x, work, LL_FFT_FORWARD, NULL);
    for (int i = 0; i < NX * NY; i++)
        close_to("mode", i, x[i], i == KY * NX + KX ? NX * NY : 0);
    ll_dct_run_2d(px, py, x, work, LL_FFT_INVERSE, NULL);
    for (int i = 0; i < NX * NY; i++)
        close_to("the way back", i, x[i], first[i]);
    free(px);
    free(py);
}

static void lengths_with_other_factors_are_told(void **state)
{
    (void)state;
    assert_true(ll_fft_allowed(1));
    assert_true(ll_fft_allowed(LL_FFT_MAX));
    assert_true(ll_fft_allowed(960));
    assert_false(ll_fft_allowed(0));
    assert_false(ll_fft_allowed(-4));
    assert_false(ll_fft_allowed(7));
    assert_false(ll_fft_allowed(22));
    assert_false(ll_fft_allowed(2 * (int64_t)LL_FFT_MAX));
    assert_false(ll_fft_allowed((INT64_C(1) << 32) + 4));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(complex_transforms_equal_the_sum),
        cmocka_unit_test(there_and_back_in_two_dimensions),
        cmocka_unit_test(cosine_transforms_equal_the_sum),
        cmocka_unit_test(cosines_in_two_dimensions_pick_their_mode),
        cmocka_unit_test(lengths_with_other_factors_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
