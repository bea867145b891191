/* Profiles of links: traces against Mahimahi's own procedure and closed forms, slots, cells, ECN, tables of
 * delays and distances against theirs. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "base/rng.h"
#include "link/harness.h"
#include "link/stages/stage.h"

#define LAG 20.0

/* A link with a profile. */
typedef struct path {
    ll_link *link;
    ll_link_params params;
    ll_profile_params *given;
    ll_link_profile *profile;
    ll_profile_state state;
} path;

static void path_open(path *p)
{
    p->link = link_open(4000, 4000000, 5, 2);
    p->params = link_params();
    p->params.limit_ms = 1250;
    p->params.mtu_bytes = 0; /* one packet each */
    p->given = malloc(sizeof *p->given);
    assert_non_null(p->given);
    ll_param_defaults(&ll_profile_table, p->given);
    p->profile = NULL;
    ll_profile_state_init(&p->state);
}

/* After `given` is complete. */
static void path_settle(path *p)
{
    p->profile = malloc(ll_profile_size(p->given));
    assert_non_null(p->profile);
    ll_profile_init(p->profile, p->given);
}

static void path_close(path *p)
{
    free(p->link);
    free(p->given);
    free(p->profile);
}

static ll_sending send(path *p, ll_time now, int size)
{
    static const char bytes[2000];
    const ll_link_plan plan = ll_link_plan_with(&p->params, LAG, p->profile, &p->state);
    return ll_link_send_by(p->link, &plan, now, bytes, size);
}

static void drain(path *p)
{
    char bytes[2000];
    ll_time sent, due;
    while (ll_link_receive(p->link, LL_NEVER - 1, bytes, (int)sizeof bytes, &sent, &due) >= 0)
        ;
}

static ll_sending send_alone(path *p, ll_time now, int size)
{
    ll_sending s = send(p, now, size);
    drain(p);
    return s;
}

/* ---- capacity ---- */

/* Every phase of the trace is met once, each in a turn of its own: the mean wait is sum g^2 / (2 sum g). */
static void a_lone_packet_waits_by_the_squares_of_the_gaps(void **state)
{
    (void)state;
    path p;
    path_open(&p);
    double time = 0, gaps = 0, squares = 0, waited = 0;
    for (int i = 0; i < 50; i++) {
        double g = (double)(ll_rng_u64(3, 0, (uint64_t)i) % 40); /* some are 0 */
        time += g;
        gaps += g;
        squares += g * g;
        p.given->capacity_ms[p.given->capacity_count++] = time;
    }
    path_settle(&p);
    const int64_t phases = 20000;
    const double step = time / (double)phases;
    for (int64_t k = 0; k < phases; k++) {
        ll_sending s = send_alone(&p, ll_ms((double)k * time + ((double)k + 0.5) * step - LAG), 100);
        assert_int_equal(s.fate, LL_FATE_DELIVERED);
        waited += ll_to_ms(s.queued);
    }
    assert_near(waited / (double)phases, squares / (2 * gaps), 50 * step * step);
    path_close(&p);
}

/* The trace "1" is 1504 bytes a millisecond. */
static void the_trace_of_one_is_12_mbit_per_s(void **state)
{
    (void)state;
    path p;
    path_open(&p);
    p.given->capacity_ms[0] = 1;
    p.given->capacity_count = 1;
    p.params.limit_ms = 100;
    path_settle(&p);
    int64_t bytes = 0;
    for (int i = 0; i < 20000; i++) /* 24 Mbit/s for 10 s */
        bytes += send_alone(&p, i * LL_MS / 2, 1504 - 28).fate == LL_FATE_DELIVERED ? 1504 : 0;
    double mbps = 8 * (double)bytes / 10.1 / 1e6; /* the queue holds another 100 ms */
    assert_near(mbps, 12.032, 0.01);
    assert_true(ll_link_get_stats(p.link)->queue_drops > 9000);
    path_close(&p);
}

/* Mahimahi's procedure, byte by byte: every opportunity in turn sends from the queue what it can. */
typedef struct emulated {
    double arrives[600], leaves[600];
    int bytes[600], count;
} emulated;

static void emulate(emulated *e, const ll_profile_params *trace)
{
    int next = 0, left = e->bytes[0];
    double period = trace->capacity_ms[trace->capacity_count - 1];
    for (int turn = 0; next < e->count; turn++)
        for (int i = 0; i < trace->capacity_count && next < e->count; i++) {
            double now = turn * period + trace->capacity_ms[i];
            for (int room = 1504; room > 0 && next < e->count && e->arrives[next] < now;) {
                int sent = left < room ? left : room;
                room -= sent;
                left -= sent;
                if (left > 0)
                    continue;
                e->leaves[next++] = now;
                left = next < e->count ? e->bytes[next] : 0;
            }
        }
}

static void packets_leave_as_mahimahi_lets_them(void **state)
{
    (void)state;
    int waited = 0;
    for (uint64_t seed = 1; seed <= 40; seed++) {
        path p;
        emulated e = {.count = 600};
        double time = 0;
        path_open(&p);
        p.params.limit_ms = 1e6;
        for (int i = 0; i < 1 + (int)(seed % 30); i++) {
            time += (double)(ll_rng_u64(seed, 1, (uint64_t)i) % 12) + (i == 0);
            p.given->capacity_ms[p.given->capacity_count++] = time;
        }
        path_settle(&p);
        double now = 0;
        for (int i = 0; i < e.count; i++) {
            now += (double)(ll_rng_u64(seed, 2, (uint64_t)i) % 8) * 0.5;
            e.bytes[i] = 30 + (int)(ll_rng_u64(seed, 3, (uint64_t)i) % 1900);
            e.arrives[i] = now;
        }
        emulate(&e, p.given);
        for (int i = 0; i < e.count; i++) {
            ll_sending s = send(&p, ll_ms(e.arrives[i] - LAG), e.bytes[i] - 28);
            if (s.fate != LL_FATE_DELIVERED || e.leaves[i] - e.arrives[i] > 3900)
                break; /* the ring of departures is full, or the wait longer than a link may hold */
            assert_int_equal(s.due, ll_ms(e.leaves[i]));
            waited += s.queued > 0;
        }
        path_close(&p);
    }
    assert_true(waited > 5000);
}

static void the_queue_of_a_capacity_has_both_limits(void **state)
{
    (void)state;
    path p;
    path_open(&p);
    p.given->capacity_ms[0] = 10;
    p.given->capacity_count = 1;
    p.params.limit_packets = 3;
    path_settle(&p);
    for (int i = 0; i < 5; i++) /* each takes an opportunity of its own */
        assert_int_equal(send(&p, 0, 1504 - 28).fate, i < 3 ? LL_FATE_DELIVERED : LL_FATE_OVERFLOW);
    p.params.limit_packets = 1000;
    p.params.limit_ms = 35;
    assert_int_equal(send(&p, 0, 1504 - 28).fate, LL_FATE_OVERFLOW); /* would wait 40 ms */
    p.params.limit_ms = 40;
    assert_int_equal(send(&p, 0, 1504 - 28).queued, 40 * LL_MS);
    assert_int_equal(ll_link_get_stats(p.link)->queue_drops, 3);
    path_close(&p);
}

/* A packet meets the queue when it comes to it, a lag after it was sent: those that have left by then are no
 * longer in it. */
static void a_capacitys_queue_is_full_when_a_packet_comes_to_it(void **state)
{
    (void)state;
    path p;
    path_open(&p);
    p.given->capacity_ms[0] = 10;
    p.given->capacity_count = 1;
    p.params.limit_packets = 3;
    path_settle(&p);
    for (int i = 0; i < 20; i++) /* each leaves 10 ms after it came, and two others are on their way to it */
        assert_int_equal(send(&p, i * 10 * LL_MS, 1504 - 28).queued, 10 * LL_MS);
    for (int i = 0; i < 5; i++) /* come at 220 ms, when the last of these leaves; leave at 230, 240, 250 */
        assert_int_equal(send(&p, 200 * LL_MS, 1504 - 28).fate, i < 3 ? LL_FATE_DELIVERED : LL_FATE_OVERFLOW);
    for (int i = 0; i < 3; i++) /* come at 235 ms: one has left */
        assert_int_equal(send(&p, 215 * LL_MS, 1504 - 28).fate, i < 1 ? LL_FATE_DELIVERED : LL_FATE_OVERFLOW);
    assert_int_equal(ll_link_get_stats(p.link)->queue_drops, 4);
    path_close(&p);
}

/* Under a rate, and so under a capacity, jitter never changes the order. */
static void a_capacity_never_reorders(void **state)
{
    (void)state;
    path p;
    ll_time last = 0;
    path_open(&p);
    p.given->capacity_ms[0] = 3;
    p.given->capacity_ms[1] = 7;
    p.given->capacity_count = 2;
    p.params.jitter_ms = 15;
    path_settle(&p);
    for (int i = 0; i < 5000; i++) {
        ll_sending s = send_alone(&p, i * 2 * LL_MS, 200);
        assert_int_equal(s.fate, LL_FATE_DELIVERED);
        assert_true(s.due >= last);
        last = s.due;
    }
    path_close(&p);
}

/* ---- delay and loss ---- */

static void a_trace_of_delays_holds_and_repeats(void **state)
{
    (void)state;
    static const double t[] = {0, 10, 15, 40}, d[] = {5, 0, 80.5, 33}, lost[] = {0, 1, 0, 0};
    path p;
    path_open(&p);
    for (int i = 0; i < 4; i++) {
        p.given->trace_t_ms[i] = t[i];
        p.given->trace_delay_ms[i] = d[i];
        p.given->trace_lost[i] = lost[i];
    }
    p.given->time_count = p.given->delay_count = p.given->lost_count = 4;
    path_settle(&p);
    int64_t losses = 0;
    for (int i = -500; i < 5000; i++) { /* the last row holds for 25 ms: the period is 65 */
        double now = 0.25 * i, at = fmod(now + 65 * 10, 65);
        int row = at < 10 ? 0 : at < 15 ? 1 : at < 40 ? 2 : 3;
        ll_sending s = send_alone(&p, ll_ms(now), 60);
        assert_int_equal(s.fate, lost[row] > 0 ? LL_FATE_LOST : LL_FATE_DELIVERED);
        if (s.fate == LL_FATE_DELIVERED)
            assert_int_equal(s.due, ll_ms(now) + ll_ms(LAG + d[row]));
        losses += s.fate == LL_FATE_LOST;
    }
    assert_int_equal(p.state.trace_lost, losses);
    assert_int_equal(ll_link_get_stats(p.link)->lost, losses);
    path_close(&p);
}

static void a_table_has_netems_scale(void **state)
{
    (void)state;
    static const double table[] = {-8192, 0, 4096, 16384};
    path p;
    int64_t counts[4] = {0};
    path_open(&p);
    for (int i = 0; i < 4; i++)
        p.given->delay_table[i] = table[i];
    p.given->table_count = 4;
    p.params.delay_ms = 30;
    p.params.jitter_ms = 10;
    path_settle(&p);
    for (int64_t i = 0; i < 40000; i++) {
        ll_time now = i * STEP, took = send_alone(&p, now, 60).due - now;
        int k = 0;
        while (k < 4 && took != ll_ms(LAG + 30 + 10 * table[k] / 8192))
            k++;
        assert_true(k < 4);
        counts[k]++;
    }
    for (int k = 0; k < 4; k++) /* binomial: a standard deviation of 87 */
        assert_near((double)counts[k], 10000, 4.5 * 86.6);
    assert_true(ll_link_delay_max_with_ms(&p.params, LAG, p.given) == LAG + 30 + 20);
    path_close(&p);
}

/* ---- slots ---- */

static void slots(path *p, double length_ms, int32_t start, int packets)
{
    path_open(p);
    p->given->slot_min_ms = p->given->slot_max_ms = length_ms;
    p->given->slot_start = start;
    p->given->slot_packets = packets;
    path_settle(p);
}

static void after_idling_a_packet_waits_a_whole_slot(void **state)
{
    (void)state;
    path p;
    slots(&p, 8, LL_SLOT_IDLE, 2);
    for (int i = 0; i < 100; i++)
        assert_int_equal(send_alone(&p, i * 37 * LL_MS, 100).due, i * 37 * LL_MS + ll_ms(LAG + 8));
    path_close(&p);
}

static void on_a_grid_a_packet_waits_half_a_slot_in_the_mean(void **state)
{
    (void)state;
    path p;
    double waited = 0;
    slots(&p, 8, LL_SLOT_GRID, 2);
    for (int64_t i = 0; i < 8000; i++) {
        ll_time now = i * 24 * LL_MS + i * 1000 + 500; /* every phase, by the microsecond */
        ll_time due = send_alone(&p, now, 100).due;
        assert_int_equal(due % (8 * LL_MS), 0);
        waited += ll_to_ms(due - now) - LAG;
    }
    assert_near(waited / 8000, 4, 1e-6);
    path_close(&p);
}

/* n packets leave together, then the next n a slot later. */
static void a_slot_takes_its_packets_and_bytes(void **state)
{
    (void)state;
    path p;
    slots(&p, 5, LL_SLOT_IDLE, 3);
    for (int i = 0; i < 12; i++)
        assert_int_equal(send(&p, 0, 100).due, ll_ms(LAG + 5 * (1 + i / 3)));
    path_close(&p);
    slots(&p, 5, LL_SLOT_GRID, 1000);
    p.profile->slot_bytes = 300; /* full after three of 128 */
    for (int i = 0; i < 12; i++)
        assert_int_equal(send(&p, LL_MS, 100).due, ll_ms(LAG + 5 * (1 + i / 3)));
    path_close(&p);
}

/* netem's procedure, as its queue would be served: at each event the first packet is taken up. */
static void slots_are_those_of_netem(void **state)
{
    (void)state;
    const int64_t length = 6 * LL_MS;
    path p;
    slots(&p, 6, LL_SLOT_IDLE, 2);
    int64_t slot_next = -1, left = 0, freed = 0, late = 0;
    ll_time now = LL_SECOND;
    for (int i = 0; i < 3000; i++) {
        now += (int64_t)(ll_rng_u64(9, 0, (uint64_t)i) % 9) * LL_MS + 1;
        ll_time ready = now + ll_ms(LAG), taken = ready > freed ? ready : freed, leaves;
        if (slot_next < taken) { /* the packet is taken up when the one before it has left, and when due */
            slot_next = taken + length;
            left = 2;
        }
        leaves = slot_next;
        if (--left == 0) {
            slot_next = leaves + length;
            left = 2;
        }
        freed = leaves;
        late += leaves > ready + length;
        assert_int_equal(send_alone(&p, now, 100).due, leaves);
    }
    assert_true(late > 100);
    path_close(&p);
}

static void a_slot_has_the_limit_of_the_queue(void **state)
{
    (void)state;
    path p;
    int delivered = 0;
    slots(&p, 10, LL_SLOT_IDLE, 1);
    p.params.limit_ms = 55;
    for (int i = 0; i < 20; i++)
        delivered += send(&p, 0, 100).fate == LL_FATE_DELIVERED;
    assert_int_equal(delivered, 5); /* after 10, 20, ... 50 ms */
    assert_int_equal(ll_link_get_stats(p.link)->queue_drops, 15);
    assert_true(ll_link_delay_max_with_ms(&p.params, LAG, p.given) == LAG + 55);
    path_close(&p);
}

/* ---- cells, ECN, distance ---- */

static void a_hundred_bytes_are_159_in_cells(void **state)
{
    (void)state;
    path p;
    path_open(&p);
    p.given->cell_bytes = 48;
    p.given->cell_overhead_bytes = 5;
    p.params.rate_kbps = 8; /* a byte per millisecond */
    p.params.packet_overhead_bytes = 0;
    path_settle(&p);
    assert_int_equal(send_alone(&p, 0, 100).queued, 159 * LL_MS);
    assert_int_equal(send_alone(&p, LL_SECOND, 96).queued, 106 * LL_MS);
    assert_int_equal(send_alone(&p, 2 * LL_SECOND, 1).queued, 53 * LL_MS);
    p.params.packet_overhead_bytes = 28;
    assert_int_equal(send_alone(&p, 3 * LL_SECOND, 100).queued, 159 * LL_MS); /* 128: three cells too */
    path_close(&p);
}

/* With ECN the packets arrive that were lost without it, marked, and no other is. */
static void marks_stand_where_losses_were(void **state)
{
    (void)state;
    path lossy, marking;
    int64_t marked = 0;
    path_open(&lossy);
    path_open(&marking);
    marking.given->ecn = true;
    path_settle(&lossy);
    path_settle(&marking);
    lossy.params.loss_pct = marking.params.loss_pct = 7;
    lossy.params.jitter_ms = marking.params.jitter_ms = 5;
    for (int64_t i = 0; i < 5000; i++) {
        ll_sending a = send_alone(&lossy, i * STEP, 50), b = send_alone(&marking, i * STEP, 50);
        assert_int_equal(b.fate, LL_FATE_DELIVERED);
        assert_int_equal(b.marked, a.fate == LL_FATE_LOST);
        if (a.fate == LL_FATE_DELIVERED)
            assert_int_equal(a.due, b.due);
        marked += b.marked;
    }
    assert_true(marked > 250);
    assert_int_equal(marking.state.marked, marked);
    assert_int_equal(ll_link_get_stats(marking.link)->lost, 0);
    path_close(&lossy);
    path_close(&marking);
}

/* 2/3 of 299,792.458 km/s. */
static void light_in_fibre_takes_its_time(void **state)
{
    (void)state;
    path p;
    path_open(&p);
    p.given->distance_km = 5570; /* London to New York */
    p.given->route_factor = 1.5;
    path_settle(&p);
    double want = 5570 * 1.5 / (299792.458 * 2 / 3) * 1000;
    assert_near(want, 41.8, 0.01);
    assert_near(ll_to_ms(send_alone(&p, 0, 50).due) - LAG, want, 2e-6);
    p.params.order = LL_ORDER_FREE;
    p.params.delay_ms = 30;
    p.params.reorder_pct = 100; /* no packet sent ahead is faster than light */
    assert_near(ll_to_ms(send_alone(&p, LL_SECOND, 50).due) - 1000 - LAG, want, 2e-6);
    path_close(&p);
}

/* ---- none ---- */

/* A profile in which nothing is chosen is none, to the byte of the link. */
static void an_empty_profile_changes_nothing(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        path with, without;
        path_open(&with);
        path_open(&without);
        with.params.loss_pct = without.params.loss_pct = (double)(seed % 3) * 10;
        with.params.jitter_ms = without.params.jitter_ms = (double)(seed % 5);
        with.params.duplicate_pct = without.params.duplicate_pct = (double)(seed % 2) * 10;
        with.params.rate_kbps = without.params.rate_kbps = seed % 4 == 3 ? 200 : 0;
        path_settle(&with);
        for (int64_t i = 0; i < 500; i++) {
            send_alone(&with, i * STEP, 100);
            send_alone(&without, i * STEP, 100);
        }
        assert_memory_equal(with.link, without.link, ll_link_size(4000, 4000000));
        path_close(&with);
        path_close(&without);
    }
}

static void the_table_is_sound(void **state)
{
    (void)state;
    assert_string_equal(ll_param_table_valid(&ll_profile_table).text, "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lone_packet_waits_by_the_squares_of_the_gaps),
        cmocka_unit_test(the_trace_of_one_is_12_mbit_per_s),
        cmocka_unit_test(packets_leave_as_mahimahi_lets_them),
        cmocka_unit_test(the_queue_of_a_capacity_has_both_limits),
        cmocka_unit_test(a_capacitys_queue_is_full_when_a_packet_comes_to_it),
        cmocka_unit_test(a_capacity_never_reorders),
        cmocka_unit_test(a_trace_of_delays_holds_and_repeats),
        cmocka_unit_test(a_table_has_netems_scale),
        cmocka_unit_test(after_idling_a_packet_waits_a_whole_slot),
        cmocka_unit_test(on_a_grid_a_packet_waits_half_a_slot_in_the_mean),
        cmocka_unit_test(a_slot_takes_its_packets_and_bytes),
        cmocka_unit_test(slots_are_those_of_netem),
        cmocka_unit_test(a_slot_has_the_limit_of_the_queue),
        cmocka_unit_test(a_hundred_bytes_are_159_in_cells),
        cmocka_unit_test(marks_stand_where_losses_were),
        cmocka_unit_test(light_in_fibre_takes_its_time),
        cmocka_unit_test(an_empty_profile_changes_nothing),
        cmocka_unit_test(the_table_is_sound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
