/* The link as a part of a block: it can be moved, has the same bytes for the same history, and keeps its
 * limits. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/hash.h"
#include "link/harness.h"

#define SLOTS 60
#define ARENA 5000

static const ll_link_params rough = {.jitter_ms = 400, .loss_pct = 5, .duplicate_pct = 10};

/* One step of a session, folded into a hash of all output. */
static uint64_t step(ll_link *link, int64_t i, uint64_t hash)
{
    ll_time sent, due;
    ll_sending s = packet_send(link, &rough, 150, i * STEP, i);
    hash = ll_hash_u64(hash, (uint64_t)s.fate);
    for (int64_t number; (number = packet_receive(link, i * STEP, &sent, &due)) >= 0;)
        hash = ll_hash_u64(ll_hash_u64(ll_hash_u64(hash, (uint64_t)number), (uint64_t)sent), (uint64_t)due);
    assert_true(ll_link_valid(link));
    return hash;
}

static void a_link_can_be_moved_in_mid_flight(void **state)
{
    (void)state;
    size_t size = ll_link_size(SLOTS, ARENA);
    ll_link *stays = link_open(SLOTS, ARENA, 8, 1), *moves = link_open(SLOTS, ARENA, 8, 1);
    uint64_t a = 0, b = 0;
    for (int64_t i = 0; i < 20000; i++) {
        a = step(stays, i, a);
        b = step(moves, i, b);
        if (i % 7 == 0) {
            ll_link *place = malloc(size);
            memcpy(place, moves, size);
            memset(moves, 0xee, size);
            free(moves);
            moves = place;
        }
        assert_memory_equal(stays, moves, size);
    }
    assert_true(a == b);
    free(stays);
    free(moves);
}

static void going_back_to_a_snapshot_repeats_the_future(void **state)
{
    (void)state;
    size_t size = ll_link_size(SLOTS, ARENA);
    ll_link *link = link_open(SLOTS, ARENA, 8, 1), *snapshot = malloc(size);
    for (int64_t i = 0; i < 1000; i++)
        step(link, i, 0);
    memcpy(snapshot, link, size);
    uint64_t first = 0, again = 0;
    for (int64_t i = 1000; i < 3000; i++)
        first = step(link, i, first);
    uint64_t end = ll_hash(0, link, size);
    memcpy(link, snapshot, size);
    for (int64_t i = 1000; i < 3000; i++)
        again = step(link, i, again);
    assert_true(first == again && end == ll_hash(0, link, size));
    free(link);
    free(snapshot);
}

/* Nothing beyond the link's own size is written, and nothing in it depends on the memory's previous
 * contents. */
static void the_block_is_all_there_is(void **state)
{
    (void)state;
    size_t size = ll_link_size(SLOTS, ARENA);
    assert_int_equal(size % 8, 0);
    unsigned char *a = malloc(size + 64), *b = malloc(size + 64);
    memset(a, 0x11, size + 64);
    memset(b, 0xee, size + 64);
    ll_link_init((void *)a, SLOTS, ARENA, 8, 1);
    ll_link_init((void *)b, SLOTS, ARENA, 8, 1);
    for (int64_t i = 0; i < 5000; i++) {
        step((void *)a, i, 0);
        step((void *)b, i, 0);
    }
    assert_memory_equal(a, b, size);
    for (size_t i = size; i < size + 64; i++)
        assert_true(a[i] == 0x11 && b[i] == 0xee);
    free(a);
    free(b);
}

static void the_limit_of_packets_is_exact(void **state)
{
    (void)state;
    ll_link *link = link_open(5, 10000, 1, 1);
    ll_link_params params = {0};
    ll_time sent, due;
    for (int64_t i = 0; i < 8; i++)
        assert_int_equal(packet_send(link, &params, 100 + (double)i, 0, i).fate,
                         i < 5 ? LL_FATE_DELIVERED : LL_FATE_OVERFLOW);
    assert_int_equal(ll_link_get_stats(link)->overflowed, 3);
    assert_int_equal(packet_receive(link, LL_SECOND, &sent, &due), 0);
    assert_int_equal(packet_send(link, &params, 100, 0, 9).fate, LL_FATE_DELIVERED);
    assert_int_equal(packet_send(link, &params, 100, 0, 10).fate, LL_FATE_OVERFLOW);
    assert_int_equal(ll_link_in_flight(link), 5);
    free(link);
}

/* A packet that stays long while hundreds pass it takes only its own place. */
static void an_old_packet_does_not_block_the_others(void **state)
{
    (void)state;
    ll_link *link = link_open(4, 500, 1, 1);
    ll_link_params params = {0};
    ll_time sent, due;
    packet_send(link, &params, 1000, 0, 0);
    for (int64_t i = 1; i < 500; i++) {
        assert_int_equal(packet_send(link, &params, 1, i * LL_MS, i).fate, LL_FATE_DELIVERED);
        assert_int_equal(packet_receive(link, (i + 1) * LL_MS, &sent, &due), i);
    }
    assert_int_equal(ll_link_in_flight(link), 1);
    assert_int_equal(packet_receive(link, LL_SECOND, &sent, &due), 0);
    free(link);
}

/* Any mixture of sizes whose sum fits is accepted, to the byte, after any deliveries in between. */
static void the_limit_of_bytes_is_exact(void **state)
{
    (void)state;
    ll_link *link = link_open(100, 1003, 1, 1);
    ll_link_params params = {.jitter_ms = 100};
    ll_time sent, due;
    char bytes[1003] = {0};
    int in_flight = 0, refused = 0, filled = 0;
    for (int i = 0; i < 20000; i++) {
        ll_time now = i * LL_MS;
        int room = 1003 - in_flight;
        int size = i % 10 == 0 ? room : i * 37 % 97;
        ll_sending s = link_send(link, &params, 100, now, bytes, size);
        assert_int_equal(s.fate, size <= room && ll_link_in_flight(link) <= 100 ? LL_FATE_DELIVERED
                                                                                : LL_FATE_OVERFLOW);
        in_flight += s.fate == LL_FATE_DELIVERED ? size : 0;
        refused += s.fate == LL_FATE_OVERFLOW;
        filled += in_flight == 1003;
        assert_true(ll_link_valid(link));
        for (int got; (got = ll_link_receive(link, now, bytes, (int)sizeof bytes, &sent, &due)) >= 0;)
            in_flight -= got;
    }
    assert_true(refused > 1000 && filled > 1000);
    free(link);
}

static void a_copy_without_room_is_counted(void **state)
{
    (void)state;
    ll_link *link = link_open(3, 1000, 1, 1);
    ll_link_params params = {.duplicate_pct = 100};
    assert_true(packet_send(link, &params, 100, 0, 0).duplicated);
    ll_sending s = packet_send(link, &params, 100, 0, 1);
    assert_int_equal(s.fate, LL_FATE_DELIVERED);
    assert_true(s.duplicated);
    assert_int_equal(s.copy_fate, LL_FATE_OVERFLOW);
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_int_equal(stats->duplicated, 2);
    assert_int_equal(stats->overflowed, 1);
    assert_int_equal(stats->sent - stats->lost - stats->overflowed + stats->duplicated,
                     ll_link_in_flight(link));
    free(link);
}

static void validation_finds_broken_links(void **state)
{
    (void)state;
    size_t size = ll_link_size(SLOTS, ARENA);
    ll_link *link = link_open(SLOTS, ARENA, 8, 1), *broken = malloc(size);
    for (int64_t i = 0; i < 100; i++)
        step(link, i, 0);
    int found = 0;
    for (size_t at = 40; at < 68; at += 4) { /* limits, queue and store: one number is wrong */
        memcpy(broken, link, size);
        int32_t value;
        memcpy(&value, (char *)broken + at, sizeof value);
        value += 1000000;
        memcpy((char *)broken + at, &value, sizeof value);
        found += at >= 48 && !ll_link_valid(broken); /* a higher limit alone breaks nothing visible */
    }
    assert_int_equal(found, 5);
    free(link);
    free(broken);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_link_can_be_moved_in_mid_flight),
        cmocka_unit_test(going_back_to_a_snapshot_repeats_the_future),
        cmocka_unit_test(the_block_is_all_there_is),
        cmocka_unit_test(the_limit_of_packets_is_exact),
        cmocka_unit_test(an_old_packet_does_not_block_the_others),
        cmocka_unit_test(the_limit_of_bytes_is_exact),
        cmocka_unit_test(a_copy_without_room_is_counted),
        cmocka_unit_test(validation_finds_broken_links),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
