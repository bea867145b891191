/* Packets that a receiver holds back in the link's store. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/rng.h"
#include "link/harness.h"

#define SLOTS 16

static const ll_link_params jitter = {.jitter_ms = 40};

static int64_t take(ll_link *link, uint32_t id)
{
    packet p;
    int size = ll_link_take_held(link, id, &p, (int)sizeof p);
    packet want = packet_make(p.number);
    assert_int_equal(size, packet_size(p.number));
    assert_memory_equal(&p, &want, (size_t)size);
    return p.number;
}

static void hold(ll_link *link, uint32_t id, int64_t number)
{
    packet p = packet_make(number);
    ll_link_hold(link, id, &p, packet_size(number));
}

/* A held packet is neither in flight nor due, and changes nothing for packets that are. */
static void held_packets_are_not_under_way(void **state)
{
    (void)state;
    ll_link *a = link_open(SLOTS, 1 << 12, 1, 1), *b = link_open(SLOTS, 1 << 12, 1, 1);
    ll_time sent, due, other;
    for (int64_t k = 0; k < 8; k++) {
        packet_send(a, &jitter, 100, k * LL_MS, k);
        packet_send(b, &jitter, 100, k * LL_MS, k);
    }
    for (int64_t k = 0; k < 4; k++)
        hold(a, (uint32_t)k, packet_receive(a, ll_link_next_due(a), &sent, &due));
    for (int64_t k = 0; k < 4; k++)
        packet_receive(b, ll_link_next_due(b), &sent, &other);
    assert_int_equal(ll_link_in_flight(a), 4);
    for (int64_t k = 0; k < 4; k++) {
        int64_t number = packet_receive(a, LL_SECOND, &sent, &due);
        assert_int_equal(packet_receive(b, LL_SECOND, &sent, &other), number);
        assert_int_equal(due, other);
    }
    assert_true(ll_link_next_due(a) == LL_NEVER && packet_receive(a, LL_SECOND, &sent, &due) == -1);
    assert_memory_equal(ll_link_get_stats(a), ll_link_get_stats(b), sizeof(ll_link_stats));
    assert_true(ll_link_valid(a));
    free(a);
    free(b);
}

/* By id, in any order; of several of one id the first that was held. */
static void held_packets_are_taken_by_id(void **state)
{
    (void)state;
    ll_link *link = link_open(SLOTS, 1 << 12, 1, 1);
    packet_send(link, &jitter, 0, 0, 0);
    hold(link, 7, 70);
    hold(link, 5, 50);
    hold(link, 7, 71);
    hold(link, 6, 60);
    assert_int_equal(take(link, 5), 50);
    assert_int_equal(take(link, 7), 70);
    assert_int_equal(take(link, 7), 71);
    hold(link, 5, 51);
    assert_int_equal(take(link, 6), 60);
    assert_int_equal(take(link, 5), 51);
    assert_int_equal(ll_link_in_flight(link), 1);
    free(link);
}

/* A long run in which each received packet is held for a while: nothing is lost or mixed up, though the store
 * is packed many times; held packets take room from sent ones. */
static void held_packets_share_the_store(void **state)
{
    (void)state;
    ll_link *link = link_open(SLOTS, SLOTS * 120, 3, 1);
    int64_t sent_number = 0, held[SLOTS], taken = 0, overflowed = 0;
    int count = 0;
    for (ll_time now = 0; now < 200 * LL_SECOND; now += 10 * LL_MS) {
        ll_time sent, due;
        overflowed += packet_send(link, &jitter, 60, now, sent_number).fate == LL_FATE_OVERFLOW;
        sent_number++;
        for (int64_t n; (n = packet_receive(link, now, &sent, &due)) >= 0;) {
            hold(link, (uint32_t)n, n);
            held[count++] = n;
        }
        while (count > 8) { /* at random */
            int i = (int)(ll_rng_u64(8, 0, (uint64_t)taken) % (uint64_t)count);
            assert_int_equal(take(link, (uint32_t)held[i]), held[i]);
            held[i] = held[--count];
            taken++;
        }
        assert_true(ll_link_valid(link) && ll_link_in_flight(link) + count <= SLOTS);
    }
    assert_true(taken > 15000 && overflowed > 0 && overflowed < 5000);
    assert_int_equal(ll_link_get_stats(link)->overflowed, overflowed);
    free(link);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(held_packets_are_not_under_way),
        cmocka_unit_test(held_packets_are_taken_by_id),
        cmocka_unit_test(held_packets_share_the_store),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
