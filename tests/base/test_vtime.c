#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/rng.h"
#include "base/vtime.h"

__extension__ typedef __int128 wide;

static const ll_freq freqs[] = {1,       2,         3,          999,       1000,   7001,    23976,
                                29970,   30000,     59940,      60000,     144000, 1000000, 1000003,
                                7919000, 999999937, 1000000000, 333333333, 120000, 240000};
#define FREQS (sizeof freqs / sizeof freqs[0])

static int64_t floor_wide(wide a, wide b)
{
    wide q = a / b;
    return (int64_t)(a % b < 0 ? q - 1 : q);
}

static int64_t exact_time(int64_t k, ll_freq freq)
{
    return floor_wide((wide)k * 1000000000000, freq);
}

static void check_tick(int64_t k, ll_freq freq)
{
    ll_time t = ll_tick_time(k, freq);
    assert_int_equal(t, exact_time(k, freq));
    /* the tick is its own last tick, and the one before is that of the nanosecond before */
    assert_int_equal(ll_tick_at(t, freq), k);
    assert_int_equal(ll_tick_at(t - 1, freq), k - 1);
}

/* Every tick of the first, and 1e9 ticks and more in strides that are coprime to everything here. */
static void ticks_are_exact(void **state)
{
    (void)state;
    for (size_t f = 0; f < FREQS; f++) {
        for (int64_t k = 0; k < 20000; k++)
            check_tick(k, freqs[f]);
        int64_t last = freqs[f] < 1000 ? 1000000 * freqs[f] : 1100000000; /* within the range of ll_time */
        for (int64_t k = 0; k < last; k += 7919 + k % 3)
            check_tick(k, freqs[f]);
    }
}

static void a_day_of_60_hz_ends_on_the_second(void **state)
{
    (void)state;
    assert_int_equal(ll_tick_time(INT64_C(86400) * 60, 60000), 86400 * LL_SECOND);
    assert_int_equal(ll_tick_time(1, 60000), 16666666);
    assert_int_equal(ll_tick_time(2, 60000), 33333333);
    assert_int_equal(ll_tick_time(3, 60000), 50000000);
}

static void ticks_at_any_time_are_exact(void **state)
{
    (void)state;
    for (size_t f = 0; f < FREQS; f++) {
        for (uint64_t i = 0; i < 200000; i++) {
            ll_time t = (ll_time)(ll_rng_u64(1, f, i) >> (2 + i % 40)) % (INT64_C(4000000) * LL_SECOND);
            int64_t k = ll_tick_at(t, freqs[f]);
            assert_true(exact_time(k, freqs[f]) <= t);
            assert_true(exact_time(k + 1, freqs[f]) > t);
        }
    }
}

/* A clock that changed its rate asks for ticks before the change too. */
static void negative_ticks_round_down(void **state)
{
    (void)state;
    for (size_t f = 0; f < FREQS; f++)
        for (int64_t k = -3000; k < 0; k++)
            assert_int_equal(ll_tick_time(k, freqs[f]), exact_time(k, freqs[f]));
}

static void a_clock_goes_on_from_its_epoch(void **state)
{
    (void)state;
    ll_clock c = {.epoch = 5 * LL_SECOND, .k0 = 300, .freq = 30000};
    assert_int_equal(ll_clock_time(&c, 300), 5 * LL_SECOND);
    assert_int_equal(ll_clock_time(&c, 301), 5 * LL_SECOND + 33333333);
    assert_int_equal(ll_clock_time(&c, 330), 6 * LL_SECOND);
}

static void frequencies_are_whole_millihertz(void **state)
{
    (void)state;
    assert_int_equal(ll_freq_from_hz(60), 60000);
    assert_int_equal(ll_freq_from_hz(59.94), 59940);
    assert_int_equal(ll_freq_from_hz(0.0004), 1);
    assert_int_equal(ll_freq_from_hz(0), 1);
    assert_int_equal(ll_freq_from_hz(-5), 1);
    assert_int_equal(ll_freq_from_hz((double)NAN), 1);
    assert_int_equal(ll_freq_from_hz(1e6), 1000000000);
    assert_int_equal(ll_freq_from_hz(1e300), 1000000000);
}

static void milliseconds_round_to_the_nearest(void **state)
{
    (void)state;
    assert_int_equal(ll_ms(1), LL_MS);
    assert_int_equal(ll_ms(0.0000006), 1);
    assert_int_equal(ll_ms(-0.0000006), -1);
    assert_int_equal(ll_ms(0.0000004), 0);
    assert_true(ll_to_ms(1500000) == 1.5 && ll_to_s(1500000000) == 1.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ticks_are_exact),
        cmocka_unit_test(a_day_of_60_hz_ends_on_the_second),
        cmocka_unit_test(ticks_at_any_time_are_exact),
        cmocka_unit_test(negative_ticks_round_down),
        cmocka_unit_test(a_clock_goes_on_from_its_epoch),
        cmocka_unit_test(frequencies_are_whole_millihertz),
        cmocka_unit_test(milliseconds_round_to_the_nearest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
