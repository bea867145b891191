#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/mix.h"
#include "base/rng.h"
#include "support/near.h"

#define COUNT 1000000

/* Replays and golden hashes rest on these. */
static void values_are_pinned(void **state)
{
    (void)state;
    assert_true(ll_rng_u64(0, 0, 0) == UINT64_C(0xc2c3084164f8b2d0));
    assert_true(ll_rng_u64(1, 0, 0) == UINT64_C(0x031d980289ad1c32));
    assert_true(ll_rng_u64(0, 1, 0) == UINT64_C(0x1b34c2651f0832ea));
    assert_true(ll_rng_u64(0, 0, 1) == UINT64_C(0xa9356d348ec3730e));
    assert_true(ll_rng_u64(42, 7, 1000000) == UINT64_C(0x41873790ea042e36));
    assert_true(ll_rng_u64(UINT64_MAX, UINT64_MAX, UINT64_MAX) == UINT64_C(0xff86806c9c442e99));
}

static void values_of_all_kinds_are_pinned(void **state)
{
    (void)state;
    assert_true(ll_rng_unit(1, 2, 3) == 0x1.eb47ee03fbc52p-2);
    assert_true(ll_rng_normal(1, 2, 3) == -0x1.9fa84cc847538p-5);
}

/* Mean and variance of `COUNT` draws lie within 4 standard errors of 1/2 and 1/12. */
static void units_are_uniform(void **state)
{
    (void)state;
    for (uint64_t stream = 0; stream < 5; stream++) {
        double sum = 0, squares = 0, least = 1, most = 0;
        for (uint64_t i = 0; i < COUNT; i++) {
            double u = ll_rng_unit(7, stream, i);
            sum += u - 0.5;
            squares += (u - 0.5) * (u - 0.5);
            least = smaller(least, u);
            most = larger(most, u);
        }
        assert_true(least >= 0 && most < 1);
        assert_true(least < 20.0 / COUNT && most > 1 - 20.0 / COUNT);
        assert_near(sum / COUNT, 0, 4 * sqrt(1.0 / 12 / COUNT));
        assert_near(squares / COUNT, 1.0 / 12, 4 * sqrt(1.0 / 180 / COUNT));
    }
}

/* Chi-squared with many degrees of freedom, as a standard deviate. */
static double chi_squared_deviate(const int *cells, int count, double expected)
{
    double chi = 0;
    for (int i = 0; i < count; i++)
        chi += (cells[i] - expected) * (cells[i] - expected) / expected;
    return (chi - (count - 1)) / sqrt(2.0 * (count - 1));
}

/* Pairs of neighbouring draws, of the same counter in neighbouring streams, and of neighbouring seeds fill a
 * 64 x 64 board evenly; by the high bits and by the low ones. */
static void neighbours_are_independent(void **state)
{
    (void)state;
    static int cells[4096];
    for (int kind = 0; kind < 3; kind++) {
        for (int shift = 0; shift <= 58; shift += 29) {
            for (int i = 0; i < 4096; i++)
                cells[i] = 0;
            for (uint64_t i = 0; i < COUNT; i++) {
                uint64_t a = ll_rng_u64(5, 9, i) >> shift;
                uint64_t b = ll_rng_u64(5 + (kind == 2), 9 + (kind == 1), i + (kind == 0)) >> shift;
                cells[(a & 63) * 64 + (b & 63)]++;
            }
            assert_near(chi_squared_deviate(cells, 4096, COUNT / 4096.0), 0, 4);
        }
    }
}

/* The first draws of many streams and of many seeds are as good as many draws of one. */
static void first_draws_are_uniform(void **state)
{
    (void)state;
    double by_stream = 0, by_seed = 0;
    for (uint64_t i = 0; i < COUNT; i++) {
        by_stream += ll_rng_unit(1, i, 0) - 0.5;
        by_seed += ll_rng_unit(i, 0, 0) - 0.5;
    }
    assert_near(by_stream / COUNT, 0, 4 * sqrt(1.0 / 12 / COUNT));
    assert_near(by_seed / COUNT, 0, 4 * sqrt(1.0 / 12 / COUNT));
}

/* Every input bit turns every output bit over in half of the cases: the worst of 64 x 64 deviates. */
static void every_bit_reaches_every_bit(void **state)
{
    (void)state;
    enum { TRIALS = 20000 };
    static int flips[64][64];
    for (uint64_t i = 0; i < TRIALS; i++) {
        uint64_t x = i * LL_MIX_STEP, h = ll_mix(x);
        for (int in = 0; in < 64; in++) {
            uint64_t changed = h ^ ll_mix(x ^ (UINT64_C(1) << in));
            for (int out = 0; out < 64; out++)
                flips[in][out] += (int)(changed >> out & 1);
        }
    }
    double chi = 0;
    for (int in = 0; in < 64; in++) {
        for (int out = 0; out < 64; out++) {
            double deviate = (flips[in][out] - TRIALS / 2.0) / sqrt(TRIALS / 4.0);
            assert_near(deviate, 0, 6);
            chi += deviate * deviate;
        }
    }
    assert_near(chi / 4096, 1, 4 * sqrt(2.0 / 4096));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_pinned),       cmocka_unit_test(values_of_all_kinds_are_pinned),
        cmocka_unit_test(units_are_uniform),       cmocka_unit_test(neighbours_are_independent),
        cmocka_unit_test(first_draws_are_uniform), cmocka_unit_test(every_bit_reaches_every_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
