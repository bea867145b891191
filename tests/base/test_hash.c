#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/hash.h"

static unsigned char bytes[200];

static int prepare(void **state)
{
    (void)state;
    for (int i = 0; i < 200; i++)
        bytes[i] = (unsigned char)(i * 7 + 1);
    return 0;
}

/* Logs and golden hashes rest on these. The sizes are around the edges of words and rounds. */
static void values_are_pinned(void **state)
{
    (void)state;
    assert_true(ll_hash(5, bytes, 0) == UINT64_C(0x7e2ee84048113193));
    assert_true(ll_hash(5, bytes, 1) == UINT64_C(0x98d916f928d56578));
    assert_true(ll_hash(5, bytes, 7) == UINT64_C(0xff6b51e662a3b470));
    assert_true(ll_hash(5, bytes, 8) == UINT64_C(0x03da4944020a050d));
    assert_true(ll_hash(5, bytes, 9) == UINT64_C(0xd074d3dd6c3881fa));
    assert_true(ll_hash(5, bytes, 31) == UINT64_C(0xae275cf05de26e24));
    assert_true(ll_hash(5, bytes, 32) == UINT64_C(0x44e7209984da22b2));
    assert_true(ll_hash(5, bytes, 33) == UINT64_C(0x0d38574b1b1204ca));
    assert_true(ll_hash(5, bytes, 64) == UINT64_C(0x59c0818cdc5fe6f7));
    assert_true(ll_hash(5, bytes, 100) == UINT64_C(0x2656d2460a1eeef5));
    assert_true(ll_hash_u64(0, 0) == UINT64_C(0x41baa426b4c37b3f));
    assert_true(ll_hash_u64(5, 6) == UINT64_C(0x9557bd031e9c286b));
}

static void place_in_memory_does_not_matter(void **state)
{
    (void)state;
    unsigned char moved[128];
    for (size_t shift = 0; shift < 16; shift++) {
        memcpy(moved + shift, bytes, 100);
        assert_true(ll_hash(5, moved + shift, 100) == ll_hash(5, bytes, 100));
    }
}

static int ones(uint64_t x)
{
    return __builtin_popcountll(x);
}

/* One bit changed, anywhere, changes about half of the result; likewise the seed. */
static void every_bit_counts(void **state)
{
    (void)state;
    for (size_t size = 1; size <= 100; size++) {
        uint64_t h = ll_hash(5, bytes, size);
        for (size_t bit = 0; bit < size * 8; bit++) {
            bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
            int changed = ones(h ^ ll_hash(5, bytes, size));
            bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
            assert_true(changed > 8 && changed < 56); /* 6 standard deviations */
        }
        int changed = ones(h ^ ll_hash(4, bytes, size));
        assert_true(changed > 8 && changed < 56);
    }
}

static void lengths_of_zeros_differ(void **state)
{
    (void)state;
    static const unsigned char zeros[200];
    uint64_t seen[200];
    for (size_t size = 0; size < 200; size++) {
        seen[size] = ll_hash(0, zeros, size);
        for (size_t other = 0; other < size; other++)
            assert_true(seen[size] != seen[other]);
    }
}

/* Words that change places are told apart, also between lanes. */
static void order_counts(void **state)
{
    (void)state;
    uint64_t words[16], swapped[16];
    for (uint64_t i = 0; i < 16; i++)
        words[i] = i + 1;
    for (int a = 0; a < 16; a++) {
        for (int b = 0; b < a; b++) {
            memcpy(swapped, words, sizeof words);
            swapped[a] = words[b];
            swapped[b] = words[a];
            assert_true(ll_hash(0, words, sizeof words) != ll_hash(0, swapped, sizeof words));
        }
    }
}

static void hash_of_a_number_depends_on_both(void **state)
{
    (void)state;
    for (uint64_t a = 0; a < 64; a++)
        for (uint64_t b = 0; b < 64; b++)
            if (a != b) {
                assert_true(ll_hash_u64(0, a) != ll_hash_u64(0, b));
                assert_true(ll_hash_u64(a, 0) != ll_hash_u64(b, 0));
                assert_true(ll_hash_u64(a, b) != ll_hash_u64(b, a));
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_pinned), cmocka_unit_test(place_in_memory_does_not_matter),
        cmocka_unit_test(every_bit_counts),  cmocka_unit_test(lengths_of_zeros_differ),
        cmocka_unit_test(order_counts),      cmocka_unit_test(hash_of_a_number_depends_on_both),
    };
    return cmocka_run_group_tests(tests, prepare, NULL);
}
