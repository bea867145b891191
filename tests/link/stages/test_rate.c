/* The queue of a link's rate, against fluid queues, Lindley's recursion and a model that keeps every
 * departure. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "base/rng.h"
#include "link/harness.h"

#define LAG 100.0

/* A packet of 72 bytes is 100 with the headers, which takes 100 * 8 / rate. */
enum { SIZE = 72 };

static ll_link_params rated(double kbps)
{
    ll_link_params params = link_params();
    params.rate_kbps = kbps;
    params.limit_ms = 1250;
    return params;
}

static ll_sending send(ll_link *link, const ll_link_params *params, ll_time now)
{
    char bytes[SIZE] = {0};
    link_drain(link, now);
    return link_send(link, params, LAG, now, bytes, SIZE);
}

static void without_a_rate_nothing_queues(void **state)
{
    (void)state;
    ll_link_params params = rated(0);
    ll_link *link = link_open(200, 40000, 1, 1);
    for (int i = 0; i < 100; i++)
        assert_int_equal(send(link, &params, 0).due, ll_ms(LAG));
    assert_int_equal(ll_link_get_stats(link)->queue.count, 0);
    assert_true(ll_link_delay_max_ms(&params, LAG) == LAG);
    free(link);
}

/* Slower arrivals than departures: each takes its transmission alone. */
static void below_the_rate_packets_take_their_transmission(void **state)
{
    (void)state;
    ll_link_params params = rated(80); /* 10 ms */
    ll_link *link = link_open(200, 40000, 1, 1);
    for (int i = 0; i < 1000; i++) {
        ll_time now = i * 10 * LL_MS;
        ll_sending s = send(link, &params, now);
        assert_int_equal(s.queued, 10 * LL_MS);
        assert_int_equal(s.due, now + ll_ms(LAG) + 10 * LL_MS);
    }
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_int_equal(stats->queue.count, 1000);
    assert_true(stats->queue.max_ms == 10 && stats->queue.sum_ms == 10000);
    free(link);
}

/* A fluid queue: packets that arrive faster than they leave add up by the difference, and drain at the rate.
 * Packets of 10 ms arrive every 4 ms for 400 ms: the last waits for 594 ms of others. */
static void a_queue_fills_and_empties_as_a_fluid(void **state)
{
    (void)state;
    ll_link_params params = rated(80);
    ll_link *link = link_open(200, 40000, 1, 1);
    for (int i = 0; i < 100; i++)
        assert_int_equal(send(link, &params, i * 4 * LL_MS).queued, (10 + i * 6) * LL_MS);
    assert_int_equal(send(link, &params, 700 * LL_MS).queued, (1000 - 700 + 10) * LL_MS);
    assert_int_equal(send(link, &params, 1010 * LL_MS).queued, 10 * LL_MS); /* as it runs empty */
    assert_int_equal(send(link, &params, 5000 * LL_MS).queued, 10 * LL_MS);
    assert_true(ll_link_get_stats(link)->queue.max_ms == 604);
    free(link);
}

/* Bufferbloat: at twice the rate half is dropped, and the rest waits for nearly all of limit_ms. */
static void a_full_queue_drops_what_exceeds_the_rate(void **state)
{
    (void)state;
    ll_link_params params = rated(24); /* 33.3 ms a packet, one every 16.7 ms */
    params.limit_ms = 400;
    ll_link *link = link_open(200, 40000, 1, 1);
    double waits = 0;
    int64_t dropped = 0, late = 0;
    for (int64_t i = 0; i < 100000; i++) {
        ll_sending s = send(link, &params, i * STEP);
        assert_true(s.fate == LL_FATE_DELIVERED || s.fate == LL_FATE_OVERFLOW);
        dropped += s.fate == LL_FATE_OVERFLOW;
        if (i >= 1000 && s.fate == LL_FATE_DELIVERED) {
            waits += ll_to_ms(s.queued);
            late++;
        }
        assert_true(s.queued <= ll_ms(400) && s.due <= i * STEP + ll_ms(LAG + 400));
    }
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_int_equal(stats->queue_drops, dropped);
    assert_int_equal(stats->overflowed, 0);
    /* of 100000 the queue held 400 ms over when it filled; one packet is 33.3 ms of it */
    assert_near((double)dropped, 50000 - 400 / (100.0 / 3), 1);
    assert_true(waits / (double)late > 400 - 100.0 / 3 && stats->queue.max_ms <= 400);
    assert_true(ll_link_delay_max_ms(&params, LAG) == LAG + 400);
    free(link);
}

static void the_limit_of_packets_counts_the_one_in_transmission(void **state)
{
    (void)state;
    ll_link_params params = rated(80);
    params.limit_packets = 3;
    ll_link *link = link_open(200, 40000, 1, 1);
    for (int i = 0; i < 5; i++)
        assert_int_equal(send(link, &params, 0).fate, i < 3 ? LL_FATE_DELIVERED : LL_FATE_OVERFLOW);
    assert_int_equal(send(link, &params, 10 * LL_MS - 1).fate, LL_FATE_OVERFLOW);
    assert_int_equal(send(link, &params, 10 * LL_MS).queued, 30 * LL_MS); /* the first is through */
    assert_int_equal(send(link, &params, 10 * LL_MS).fate, LL_FATE_OVERFLOW);
    assert_int_equal(ll_link_get_stats(link)->queue_drops, 4);
    free(link);
}

/* The queue has a place for each slot of the link and one for each 1200 bytes of its store. Corrupted packets
 * take no slot, but their time in the queue. */
static void the_slots_bound_the_queue(void **state)
{
    (void)state;
    ll_link_params params = rated(80);
    params.corrupt_pct = 100;
    ll_link *link = link_open(7, 2500, 1, 1);
    for (int i = 0; i < 12; i++) {
        char bytes[SIZE] = {0};
        ll_sending s = link_send(link, &params, 0, i, bytes, SIZE);
        assert_int_equal(s.fate, i < 9 ? LL_FATE_CORRUPTED : LL_FATE_OVERFLOW);
        link_drain(link, i);
        assert_int_equal(ll_link_in_flight(link), 0);
        assert_true(ll_link_valid(link));
    }
    assert_int_equal(ll_link_get_stats(link)->queue_drops, 3);
    free(link);
}

static void sizes_and_overhead_count(void **state)
{
    (void)state;
    ll_link_params params = rated(64);
    ll_link *link = link_open(200, 40000, 1, 1);
    char bytes[172] = {0};
    assert_int_equal(link_send(link, &params, 0, 0, bytes, 172).queued, 25 * LL_MS); /* 200 bytes */
    params.packet_overhead_bytes = 0;
    assert_int_equal(link_send(link, &params, 0, 25 * LL_MS, bytes, 172).queued, ll_ms(21.5));
    params.rate_kbps = 1e-300; /* no time is long enough */
    assert_int_equal(link_send(link, &params, 0, 0, bytes, 172).fate, LL_FATE_OVERFLOW);
    free(link);
}

/* Lost packets never reach the queue, and reordered packets bypass it; copies and corrupted packets take
 * their time in it. */
static void copies_and_corrupted_packets_take_queue_time(void **state)
{
    (void)state;
    ll_link_params params = rated(80);
    params.delay_ms = 1;
    struct {
        double loss, duplicate, reorder, corrupt;
        int64_t second; /* ms of queue that the packet after it sees */
    } cases[] = {
        {0, 0, 0, 0, 20}, {100, 0, 0, 0, 10}, {0, 100, 0, 0, 30}, {0, 0, 100, 0, 10}, {0, 0, 0, 100, 20}};
    for (int i = 0; i < 5; i++) {
        ll_link *link = link_open(200, 40000, 1, 1);
        ll_link_params first = params;
        first.loss_pct = cases[i].loss;
        first.duplicate_pct = cases[i].duplicate;
        first.reorder_pct = cases[i].reorder;
        first.corrupt_pct = cases[i].corrupt;
        send(link, &first, 0);
        assert_int_equal(send(link, &params, 0).queued, cases[i].second * LL_MS);
        free(link);
    }
}

/* Packets are sent at the rate in the order of sending, after any delay: the departures are those of a queue
 * whose arrivals are the delays of the same draws without a rate. */
static void under_a_rate_jitter_never_reorders(void **state)
{
    (void)state;
    static const double rates[] = {90, 130, 2000, 1e6};
    for (int k = 0; k < 4; k++) {
        ll_link_params params = rated(rates[k]), without = link_params();
        params.jitter_ms = without.jitter_ms = 70;
        ll_link *link = link_open(200, 40000, 4, 1), *twin = link_open(200, 40000, 4, 1);
        ll_time exit = 0, transmission = ll_ms(800 / rates[k]), now = 0;
        int64_t waited = 0;
        for (int64_t i = 0; i < 20000; i++) {
            now += i % 3 * STEP;
            ll_sending s = send(link, &params, now), drawn = send(twin, &without, now);
            waited += drawn.due < exit;
            exit = (drawn.due > exit ? drawn.due : exit) + transmission;
            assert_int_equal(s.fate, LL_FATE_DELIVERED);
            assert_int_equal(s.due, exit);
            assert_int_equal(s.queued, exit - drawn.due);
        }
        link_drain(link, LL_NEVER - 1);
        assert_int_equal(ll_link_get_stats(link)->reordered, 0);
        assert_true(ll_link_get_stats(twin)->reordered > 5000 && waited > 5000);
        free(link);
        free(twin);
    }
}

/* A wait for an earlier packet that is late is no queue: the limits count the rate alone. */
static void jitter_fills_no_queue(void **state)
{
    (void)state;
    ll_link_params params = rated(10000); /* 0.08 ms a packet */
    params.jitter_ms = 90;
    params.limit_ms = 1;
    params.limit_packets = 1;
    ll_link *link = link_open(200, 40000, 4, 1);
    for (int64_t i = 0; i < 10000; i++)
        assert_int_equal(send(link, &params, i * STEP).fate, LL_FATE_DELIVERED);
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_true(stats->queue_drops == 0 && stats->queue.max_ms > 100 && stats->delay.max_ms < LAG + 90 + 1);
    free(link);
}

/* With any jitter and load, no packet takes longer than the longest delay plus the queue's length. */
static void the_longest_delay_holds(void **state)
{
    (void)state;
    ll_link_params params = rated(100);
    params.jitter_ms = 60;
    params.limit_ms = 150;
    params.duplicate_pct = 30;
    ll_link *link = link_open(200, 40000, 6, 1);
    ll_time most = ll_ms(ll_link_delay_max_ms(&params, LAG)), longest = 0, now = 0;
    for (int64_t i = 0; i < 50000; i++) {
        now += (ll_time)(ll_rng_unit(1, 1, (uint64_t)i) * 16e6);
        ll_sending s = send(link, &params, now);
        if (s.fate == LL_FATE_DELIVERED && s.due - now > longest)
            longest = s.due - now;
    }
    if (longest > most || longest < most - 20 * LL_MS)
        fail_msg("%lld of %lld", (long long)longest, (long long)most);
    assert_true(ll_link_get_stats(link)->queue_drops > 1000);
    free(link);
}

/* Departures of all packets, kept without limit: W = max(0, W - gap) + service; packets still in the queue
 * count. */
typedef struct model {
    ll_time departures[1 << 17];
    int first, count;
} model;

static bool model_takes(model *m, const ll_link_params *params, ll_time now, int size, ll_time *queued)
{
    while (m->first < m->count && m->departures[m->first] <= now)
        m->first++;
    ll_time start = m->first < m->count ? m->departures[m->count - 1] : now;
    double ms =
        ll_to_ms(start - now) + 8.0 * (double)(size + params->packet_overhead_bytes) / params->rate_kbps;
    if (m->count - m->first >= params->limit_packets || ms > params->limit_ms)
        return false;
    m->departures[m->count++] = now + ll_ms(ms);
    *queued = m->departures[m->count - 1] - now;
    return true;
}

/* Any sizes, bursts and pauses, also longer than 2^31 and 2^32 ns, and any change of the rate. */
static void queues_agree_with_a_model(void **state)
{
    (void)state;
    model *m = calloc(1, sizeof *m);
    ll_link *link = link_open(60, 40000, 1, 1);
    ll_link_params params = rated(64);
    params.limit_packets = 25;
    char bytes[400] = {0};
    ll_time now = 0;
    int dropped_by_packets = 0, dropped_by_time = 0;
    for (uint64_t i = 0; i < 100000; i++) {
        double u = ll_rng_unit(9, 1, i);
        now += u < 0.0005 ? 6 * LL_SECOND : u < 0.001 ? 3 * LL_SECOND : u < 0.3 ? 0 : (ll_time)(u * 45e6);
        if (i % 1000 == 0) {
            params.rate_kbps = 20 + 400 * ll_rng_unit(9, 2, i);
            params.limit_ms = 100 + 1100 * ll_rng_unit(9, 3, i);
        }
        int size = (int)(ll_rng_u64(9, 4, i) % 250);
        ll_time want = 0;
        int waiting = m->count - m->first;
        bool taken = model_takes(m, &params, now, size, &want);
        link_drain(link, now - 2 * LL_SECOND);
        ll_sending s = link_send(link, &params, 0, now, bytes, size);
        while (ll_link_in_flight(link) > 30) { /* so that no slot is missing */
            ll_time sent, due;
            ll_link_receive(link, ll_link_next_due(link), bytes, (int)sizeof bytes, &sent, &due);
        }
        assert_int_equal(s.fate, taken ? LL_FATE_DELIVERED : LL_FATE_OVERFLOW);
        assert_int_equal(s.queued, want);
        dropped_by_packets += !taken && waiting >= 25;
        dropped_by_time += !taken && waiting < 25;
    }
    assert_true(dropped_by_packets > 1000 && dropped_by_time > 1000);
    assert_int_equal(ll_link_get_stats(link)->overflowed, 0);
    free(link);
    free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_a_rate_nothing_queues),
        cmocka_unit_test(below_the_rate_packets_take_their_transmission),
        cmocka_unit_test(a_queue_fills_and_empties_as_a_fluid),
        cmocka_unit_test(a_full_queue_drops_what_exceeds_the_rate),
        cmocka_unit_test(the_limit_of_packets_counts_the_one_in_transmission),
        cmocka_unit_test(the_slots_bound_the_queue),
        cmocka_unit_test(sizes_and_overhead_count),
        cmocka_unit_test(copies_and_corrupted_packets_take_queue_time),
        cmocka_unit_test(under_a_rate_jitter_never_reorders),
        cmocka_unit_test(jitter_fills_no_queue),
        cmocka_unit_test(the_longest_delay_holds),
        cmocka_unit_test(queues_agree_with_a_model),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
