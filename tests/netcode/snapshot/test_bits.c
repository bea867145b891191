/* Bits, numbers and malformed encodings. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "netcode/snapshot/bits.h"

static ll_bit_writer writer(uint8_t *bytes, size_t size)
{
    memset(bytes, 0xa5, size); /* a writer must not rely on zeros */
    return (ll_bit_writer){.bytes = bytes, .capacity = 8 * (int64_t)size};
}

static ll_bit_reader reader(const ll_bit_writer *w)
{
    return (ll_bit_reader){.bytes = w->bytes, .size = w->count};
}

/* Lowest first: 1011 0000 | 0001 1100 | 0011 01 = 0x0d 0x38 0x2c. */
static void bits_lie_lowest_first(void **state)
{
    (void)state;
    uint8_t bytes[4];
    ll_bit_writer w = writer(bytes, sizeof bytes);
    ll_bits_put(&w, 5, 3);       /* 1 0 1 */
    ll_bits_put(&w, 1, 1);       /* 1 */
    ll_bits_put(&w, 0xc380, 16); /* 0 0 0 0 | 0 0 0 1 1 1 0 0 | 0 0 1 1 */
    ll_bits_put(&w, 0xfe, 2);    /* 0 1: bits above the two are left out */
    assert_int_equal(w.count, 22);
    assert_int_equal(bytes[0], 0x0d);
    assert_int_equal(bytes[1], 0x38);
    assert_int_equal(bytes[2], 0x2c);
    assert_int_equal(bytes[3], 0xa5); /* untouched */
    ll_bit_reader r = reader(&w);
    assert_int_equal(ll_bits_get(&r, 3), 5);
    assert_int_equal(ll_bits_get(&r, 1), 1);
    assert_int_equal(ll_bits_get(&r, 16), 0xc380);
    assert_int_equal(ll_bits_get(&r, 2), 2);
    assert_true(ll_bits_ended_well(&r));
}

static const uint64_t numbers[] = {
    0, 1, 7, 8, 63, 64, 511, 512, 4095, 4096, 1u << 20, UINT32_MAX, UINT64_C(1) << 63, UINT64_MAX};

/* Four bits for each three that the number has, and four for zero. */
static void numbers_take_a_group_for_three_bits(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        uint8_t bytes[16];
        ll_bit_writer w = writer(bytes, sizeof bytes);
        int bits = 0;
        for (uint64_t n = numbers[i]; n != 0; n >>= 1)
            bits++;
        ll_bits_put_number(&w, numbers[i]);
        assert_int_equal(w.count, 4 * (bits == 0 ? 1 : (bits + 2) / 3));
        ll_bit_reader r = reader(&w);
        assert_true(ll_bits_get_number(&r) == numbers[i]);
        assert_true(ll_bits_ended_well(&r));
    }
}

static void signed_numbers_zigzag(void **state)
{
    (void)state;
    const struct {
        int64_t n;
        uint64_t z;
    } pairs[] = {
        {0, 0}, {-1, 1}, {1, 2}, {-2, 3}, {2, 4}, {INT64_MAX, UINT64_MAX - 1}, {INT64_MIN, UINT64_MAX}};
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; i++) {
        uint8_t bytes[16];
        ll_bit_writer w = writer(bytes, sizeof bytes);
        ll_bits_put_signed(&w, pairs[i].n);
        ll_bit_reader plain = reader(&w), r = reader(&w);
        assert_true(ll_bits_get_number(&plain) == pairs[i].z);
        assert_true(ll_bits_get_signed(&r) == pairs[i].n);
    }
}

static void a_full_writer_counts_and_does_not_write(void **state)
{
    (void)state;
    uint8_t bytes[2];
    ll_bit_writer w = writer(bytes, sizeof bytes);
    w.capacity = 8;
    ll_bits_put(&w, 0x2a, 7);
    ll_bits_put(&w, 3, 2);
    ll_bits_put(&w, 0, 1);
    assert_int_equal(w.count, 10);
    assert_int_equal(bytes[0], 0x2a);
    assert_int_equal(bytes[1], 0xa5);
}

static void reading_past_the_end_gives_zeros_and_is_detected(void **state)
{
    (void)state;
    const uint8_t bytes[] = {0xff, 0xff};
    ll_bit_reader r = {.bytes = bytes, .size = 12};
    assert_int_equal(ll_bits_get(&r, 11), 0x7ff);
    assert_int_equal(ll_bits_get(&r, 2), 0);
    assert_int_equal(ll_bits_get(&r, 1), 0); /* and not the remaining bit */
    assert_int_equal(ll_bits_get(&r, 0), 0);
    assert_int_equal(ll_bits_get_number(&r), 0);
    assert_false(ll_bits_ended_well(&r));
}

static void at_most_seven_zero_bits_may_remain(void **state)
{
    (void)state;
    const uint8_t zero[] = {0x01, 0x00}, one[] = {0x81};
    ll_bit_reader seven = {.bytes = zero, .size = 8, .at = 1}, eight = {.bytes = zero, .size = 16, .at = 8},
                  used = {.bytes = one, .size = 8, .at = 1};
    assert_true(ll_bits_ended_well(&seven));
    assert_false(ll_bits_ended_well(&eight));
    assert_false(ll_bits_ended_well(&used));
}

/* 22 groups hold 66 bits: the last may have only one of them. */
static void numbers_beyond_64_bits_are_detected(void **state)
{
    (void)state;
    uint8_t bytes[12];
    memset(bytes, 0xff, sizeof bytes);
    ll_bit_reader r = {.bytes = bytes, .size = 96};
    ll_bits_get_number(&r);
    assert_true(r.overlong);
    bytes[10] = 0x2f; /* group 21 of 0 to 21: 2, the end */
    r = (ll_bit_reader){.bytes = bytes, .size = 88};
    ll_bits_get_number(&r);
    assert_true(r.overlong && !ll_bits_ended_well(&r));
    bytes[10] = 0x1f;
    r = (ll_bit_reader){.bytes = bytes, .size = 88};
    assert_true(ll_bits_get_number(&r) == UINT64_MAX);
    assert_true(ll_bits_ended_well(&r));
}

/* Random fields of all widths, and numbers, against an array of bits: the same bits, and the same values
 * back. */
static void values_survive_a_round_trip(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 300; seed++) {
        uint8_t bytes[512];
        char bits[8 * sizeof bytes];
        int64_t count = 0;
        ll_bit_writer w = writer(bytes, 64 + seed % 400);
        for (uint64_t k = 0; w.count < w.capacity - 96; k++) {
            uint64_t draw = ll_rng_u64(seed, 0, k);
            int width = (int)(draw % 65);
            uint64_t value = ll_rng_u64(seed, 1, k) >> (draw / 65 % 64);
            if (draw >> 63) {
                ll_bits_put_number(&w, value);
                do {
                    uint64_t group = (value & 7) | (value >> 3 != 0 ? 8 : 0);
                    for (int i = 0; i < 4; i++)
                        bits[count++] = (char)(group >> i & 1);
                    value >>= 3;
                } while (value != 0);
            } else {
                ll_bits_put(&w, value, width);
                for (int i = 0; i < width; i++)
                    bits[count++] = (char)(value >> i & 1);
            }
        }
        assert_int_equal(w.count, count);
        for (int64_t i = 0; i < count; i++)
            assert_int_equal(bytes[i / 8] >> (i % 8) & 1, bits[i]);
        ll_bit_reader r = reader(&w);
        for (uint64_t k = 0; r.at < r.size; k++) {
            uint64_t draw = ll_rng_u64(seed, 0, k), value = ll_rng_u64(seed, 1, k) >> (draw / 65 % 64);
            int width = (int)(draw % 65);
            uint64_t want = draw >> 63 || width == 64 ? value : value & ((UINT64_C(1) << width) - 1);
            assert_true((draw >> 63 ? ll_bits_get_number(&r) : ll_bits_get(&r, width)) == want);
        }
        assert_true(r.at == r.size && !r.overlong);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bits_lie_lowest_first),
        cmocka_unit_test(numbers_take_a_group_for_three_bits),
        cmocka_unit_test(signed_numbers_zigzag),
        cmocka_unit_test(a_full_writer_counts_and_does_not_write),
        cmocka_unit_test(reading_past_the_end_gives_zeros_and_is_detected),
        cmocka_unit_test(at_most_seven_zero_bits_may_remain),
        cmocka_unit_test(numbers_beyond_64_bits_are_detected),
        cmocka_unit_test(values_survive_a_round_trip),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
