/* Keys, their hashes, and rate limits. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "daemon/support/digest.h"
#include "daemon/support/keys.h"
#include "daemon/support/rate_limits.h"

/* Two vectors of FIPS 180, the second in two parts: the digest is of both parts. */
static void digests_are_sha256_of_both_parts(void **state)
{
    (void)state;
    static const unsigned char empty[] = {0xe3, 0xb0, 0xc4, 0x42, 0x98, 0xfc, 0x1c, 0x14},
                               abc[] = {0xba, 0x78, 0x16, 0xbf, 0x8f, 0x01, 0xcf, 0xea};
    unsigned char digest[LL_DIGEST_SIZE];
    assert_true(ll_digest("", 0, "", 0, digest));
    assert_memory_equal(digest, empty, sizeof empty);
    assert_true(ll_digest("a", 1, "bc", 2, digest));
    assert_memory_equal(digest, abc, sizeof abc);
}

static void names_have_their_alphabets(void **state)
{
    (void)state;
    char id[LL_ID_LENGTH + 1], other[LL_ID_LENGTH + 1], code[LL_CODE_LENGTH + 1];
    unsigned seen[256] = {0};
    for (int i = 0; i < 2000; i++) {
        assert_true(ll_new_id("", id) && ll_new_id("", other) && ll_new_code("", code));
        assert_true(ll_is_id(id) && ll_is_code(code));
        assert_string_not_equal(id, other);
        assert_true(strlen(id) == LL_ID_RANDOM && strlen(code) == LL_CODE_RANDOM);
        for (int k = 0; k < LL_CODE_RANDOM; k++)
            seen[(unsigned char)code[k]]++;
    }
    int letters = 0;
    for (int c = 0; c < 256; c++)
        letters += seen[c] > 0;
    assert_int_equal(letters, 31);
    assert_int_equal(seen['0'] + seen['O'] + seen['1'] + seen['I'] + seen['L'], 0);
    assert_false(ll_is_id("") || ll_is_id("A2345678901234567890123456") || ll_is_code("ABC0") ||
                 ll_is_code("ABCDE"));
}

static void names_begin_with_their_shard(void **state)
{
    (void)state;
    char id[LL_ID_LENGTH + 1], code[LL_CODE_LENGTH + 1];
    assert_true(ll_new_id("s0", id) && ll_new_code("s0", code));
    assert_memory_equal(id, "s0-", 3);
    assert_memory_equal(code, "S0-", 3);
    assert_int_equal(strlen(id), 3 + LL_ID_RANDOM);
    assert_int_equal(strlen(code), 3 + LL_CODE_RANDOM);
    assert_true(ll_is_id(id) && ll_is_code(code) && !ll_is_id(code) && !ll_is_code(id));
    assert_true(ll_new_id("wxyz", id) && ll_new_code("wxyz", code) && ll_is_id(id) && ll_is_code(code));
    assert_true(strlen(id) == LL_ID_LENGTH && strlen(code) == LL_CODE_LENGTH);
    static const char *const bad[] = {"-abcdefghijklmnopqrstuvwxyz",    "abcde-abcdefghijklmnopqrstuvwxyz",
                                      "A-abcdefghijklmnopqrstuvwxyz",   "l-abcdefghijklmnopqrstuvwxyz",
                                      "a-b-abcdefghijklmnopqrstuvwxyz", "a-abcdefghijklmnopqrstuvwxy"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_false(ll_is_id(bad[i]));
    assert_false(ll_is_code("-K7QF") || ll_is_code("a-K7QF") || ll_is_code("A-K7Q") ||
                 ll_is_code("ABCDE-K7QF"));
}

static void a_bad_name_of_a_shard_is_refused(void **state)
{
    (void)state;
    static const char *const good[] = {"", "a", "7", "s0", "wxyz"}, *const bad[] = {"A",   "l",     "nord",
                                                                                    "a-b", "ab cd", "abcde"};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        ll_status status = ll_shard_check(good[i]);
        assert_false(ll_failed(&status));
    }
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        ll_status status = ll_shard_check(bad[i]);
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_string_equal(status.field, "shard");
        assert_non_null(strstr(status.text, bad[i]));
    }
}

static void codes_are_read_in_either_case(void **state)
{
    (void)state;
    char code[LL_CODE_LENGTH + 1];
    assert_true(ll_code_read("k7qf", code));
    assert_string_equal(code, "K7QF");
    assert_true(ll_code_read("s0-k7qf", code));
    assert_string_equal(code, "S0-K7QF");
    static const char *const others[] = {"",     "K7Q",  "K7QFX",   "K7Q0",    "K7QO",
                                         "k7ql", "K7Q ", "K7Q\xc3", "so-k7qf", "abcde-k7qf"};
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        assert_false(ll_code_read(others[i], code));
}

static void a_key_matches_its_hash_only(void **state)
{
    (void)state;
    char key[LL_KEY_LENGTH + 1], other[LL_KEY_LENGTH + 1];
    ll_key_hash hash, again;
    assert_true(ll_new_key(key) && ll_new_key(other));
    assert_true(ll_key_hash_make(key, &hash) && ll_key_hash_make(key, &again));
    assert_memory_not_equal(hash.bytes, again.bytes, LL_KEY_RECORD); /* salted */
    assert_true(ll_key_matches(&hash, key, LL_KEY_LENGTH) && ll_key_matches(&again, key, LL_KEY_LENGTH));
    char text[LL_KEY_HASH_TEXT + 1];
    ll_key_hash read;
    ll_key_hash_write(&hash, text);
    assert_true(ll_key_hash_read(text, &read) && ll_key_matches(&read, key, LL_KEY_LENGTH));
    text[7] = 'g';
    assert_false(ll_key_hash_read(text, &read) || ll_key_hash_read(text + 1, &read) ||
                 ll_key_hash_read(NULL, &read));
    assert_false(ll_key_matches(&hash, other, LL_KEY_LENGTH) ||
                 ll_key_matches(&hash, key, LL_KEY_LENGTH - 1) || ll_key_matches(&hash, "", 0));
}

static void a_bucket_gives_its_rate_and_burst(void **state)
{
    (void)state;
    ll_bucket bucket = {0};
    ll_time now = 5 * LL_SECOND;
    int taken = 0;
    for (int i = 0; i < 100; i++)
        taken += ll_bucket_take(&bucket, 10, 20, now);
    assert_int_equal(taken, 20);
    for (taken = 0; now < 15 * LL_SECOND; now += LL_SECOND / 100)
        taken += ll_bucket_take(&bucket, 10, 20, now);
    assert_in_range(taken, 98, 101);
    taken = 0;
    for (int i = 0; i < 10; i++) /* a clock that goes back adds no tokens */
        taken += ll_bucket_take(&bucket, 10, 20, 0);
    assert_in_range(taken, 0, 1);
}

static void rates_are_per_name(void **state)
{
    (void)state;
    ll_rate_limits *rates = ll_rate_limits_new(1, 2);
    int a = 0, b = 0;
    for (int i = 0; i < 5; i++) {
        a += ll_rate_limits_take(rates, "192.0.2.1", LL_SECOND);
        b += ll_rate_limits_take(rates, "192.0.2.2", LL_SECOND);
    }
    assert_int_equal(a, 2);
    assert_int_equal(b, 2);
    ll_rate_limits_free(rates);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(digests_are_sha256_of_both_parts),
        cmocka_unit_test(names_have_their_alphabets),
        cmocka_unit_test(names_begin_with_their_shard),
        cmocka_unit_test(a_bad_name_of_a_shard_is_refused),
        cmocka_unit_test(codes_are_read_in_either_case),
        cmocka_unit_test(a_key_matches_its_hash_only),
        cmocka_unit_test(a_bucket_gives_its_rate_and_burst),
        cmocka_unit_test(rates_are_per_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
