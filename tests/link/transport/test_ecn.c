/* Transports and ECN: marks reduce the window as losses do, at most once a round trip, and nothing is sent
 * again; a shared queue that marks stays as short as one that drops. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "link/harness.h"
#include "link/transport/core.h"
#include "link/transport/pipe.h"
#include "support/stride.h"

#define SECONDS(s) ((ll_time)((s)*1e9))

enum { MESSAGE = 1000 };

/* A pipe whose way up can mark. */
typedef struct road {
    pipe *tube;
    ll_link_profile profile;
    ll_profile_state state;
    ll_bottleneck queue;
    double lag_ms;
    int kind;
} road;

static void plan(road *r)
{
    r->tube->plan[0] = ll_link_plan_with(&r->tube->params[0], r->lag_ms, &r->profile, &r->state);
    if (r->queue.params.rate_kbps > 0)
        ll_link_plan_share(&r->tube->plan[0], &r->queue, &r->state);
    r->tube->plan[0].ecn = ll_transport_ecn(r->kind);
}

static road *road_open(int kind, int congestion, double lag_ms, uint64_t seed)
{
    ll_transport_setup setup = {.kind = kind,
                                .delivery = LL_DELIVERY_ORDERED,
                                .congestion = congestion,
                                .flow = {{1000, MESSAGE}, {160, MESSAGE}}};
    ll_link_params params = {0};
    road *r = calloc(1, sizeof *r);
    assert_non_null(r);
    *r = (road){.lag_ms = lag_ms, .kind = kind, .profile.ecn = 1};
    ll_profile_state_init(&r->state);
    r->tube = pipe_open(setup, &params, lag_ms, seed);
    plan(r);
    return r;
}

static void road_close(road *r)
{
    pipe_close(r->tube);
    free(r);
}

/* From now on the share `p` of packets is marked. */
static void mark_share(road *r, double p)
{
    r->tube->params[0].loss_pct = 100 * p;
    plan(r);
}

/* The client has always more to send, for `ms`. */
static void press(road *r, double ms)
{
    pipe *tube = r->tube;
    for (int k = 0; k < 500 && tube->sent[0] < PIPE_MESSAGES && pipe_send(tube, LL_CLIENT_SIDE, 0, MESSAGE);
         k++)
        ;
    pipe_run(tube, tube->now + ll_ms(ms));
}

static double window(const road *r)
{
    return r->tube->transport->flow[LL_CLIENT_SIDE].sender.window.bytes;
}

/* ---- the law ---- */

/* Mathis: MSS/R sqrt(1.5/p), with marks in the place of losses (the mean over independent runs, within three
 * of its errors and 5 %: the law neglects the floor of two mss and whole packets). Nothing is sent again, and
 * no timer ends. */
static void throughput_falls_with_the_root_of_the_share(void **state)
{
    (void)state;
    static const double shares[] = {0.005, 0.01, 0.02};
    static const int kinds[] = {LL_TRANSPORT_TCP, LL_TRANSPORT_QUIC};
    enum { RUNS = 6 };
    for (int k = 0; k < 2; k++)
        for (int i = 2; i >= 0; i -= LL_TEST_STRIDE) {
            double want = sqrt(MESSAGE * 1140.0) / 0.1 * sqrt(1.5 / shares[i]), sum = 0, squares = 0;
            for (int run = 1; run <= RUNS; run++) {
                road *r = road_open(kinds[k], LL_CONGESTION_RENO, 50, (uint64_t)run);
                mark_share(r, shares[i]);
                while (r->tube->now < SECONDS(60))
                    press(r, 5);
                double rate = (double)r->tube->bytes_handed[0] / ll_to_s(r->tube->now) / want;
                sum += rate, squares += rate * rate;
                assert_true(r->state.marked > 20);
                assert_int_equal(r->tube->resent[0], 0);
                assert_int_equal(r->tube->timeouts, 0);
                road_close(r);
            }
            double mean = sum / RUNS, error = sqrt((squares / RUNS - mean * mean) / (RUNS - 1));
            print_message("kind %d, %g %%: %.3f +- %.3f of the law\n", kinds[k], 100 * shares[i], mean,
                          error);
            assert_near(mean, 1, 3 * error + 0.05);
        }
}

/* ---- the window ---- */

typedef struct reductions {
    int count;
    double least, most; /* new over old window */
} reductions;

/* Watches the window for `ms`, in which the client sends a message each ms: a window of 100 and more is not
 * in use, and packets leave at all phases of a round trip. */
static void watch_window(road *r, double ms, reductions *all)
{
    pipe *tube = r->tube;
    for (int quarter = 0; quarter < 4 * ms; quarter++) {
        double before = window(r);
        if (quarter % 4 == 0)
            assert_true(pipe_send(tube, LL_CLIENT_SIDE, 0, MESSAGE));
        pipe_run(tube, tube->now + LL_MS / 4);
        double share = window(r) / before;
        if (share >= 1)
            continue;
        all->count++;
        all->least = smaller(all->least, share);
        all->most = larger(all->most, share);
    }
}

/* Every packet is marked for a part of a round trip, or for several: one reduction for each of them, the last
 * one a round trip after the marks. (While the halved window drains, reno sends nothing that could be
 * marked.) */
static void the_window_halves_once_a_round_trip(void **state)
{
    (void)state;
    static const struct {
        double ms;
        int from, to;
    } rows[] = {{0, 0, 0}, {10, 1, 1}, {60, 1, 1}, {95, 1, 1}, {150, 1, 2}, {350, 3, 4}};
    static const int kinds[] = {LL_TRANSPORT_TCP, LL_TRANSPORT_QUIC};
    for (int k = 0; k < 2; k++)
        for (int congestion = 0; congestion < LL_CONGESTION_KINDS; congestion++)
            for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
                double beta = congestion == LL_CONGESTION_RENO ? 0.5 : 0.7;
                road *r = road_open(kinds[k], congestion, 50, 1);
                reductions all = {0, 1, 0};
                watch_window(r, 1000, &all);
                mark_share(r, rows[i].ms > 0);
                watch_window(r, rows[i].ms, &all);
                mark_share(r, 0);
                watch_window(r, 400, &all);
                if (all.count < rows[i].from || all.count > rows[i].to)
                    fail_msg("kind %d, %g ms: %d reductions", kinds[k], rows[i].ms, all.count);
                assert_int_equal(r->tube->resent[0], 0);
                if (all.count > 0) /* and what grew in the same 0.25 ms */
                    assert_true(all.least > beta - 1e-9 && all.most < beta + 0.06);
                road_close(r);
            }
}

/* Acknowledgements that are lost lose no mark: those that come later report it too. */
static void a_lost_echo_is_told_again(void **state)
{
    (void)state;
    static const int kinds[] = {LL_TRANSPORT_TCP, LL_TRANSPORT_QUIC};
    for (int k = 0; k < 2; k++)
        for (int ms = 20; ms <= 120; ms += 20) {
            road *r = road_open(kinds[k], LL_CONGESTION_RENO, 50, 1);
            reductions all = {0, 1, 0};
            watch_window(r, 1000, &all);
            r->tube->params[1] =
                (ll_link_params){.blackout_at_ms = ll_to_ms(r->tube->now) + 50, .blackout_length_ms = ms};
            r->tube->plan[1] = ll_link_plan_of(&r->tube->params[1], r->lag_ms);
            mark_share(r, 1); /* what of it is acknowledged at once is acknowledged in vain */
            watch_window(r, 10, &all);
            mark_share(r, 0);
            watch_window(r, 600, &all);
            assert_int_equal(all.count, 1);
            assert_true(r->state.marked > 0);
            assert_int_equal(r->tube->resent[0], 0);
            road_close(r);
        }
}

/* ---- a queue that marks ---- */

typedef struct pressed {
    double wait_ms, rate_kbps; /* mean of the queue, and what it carried of messages, after 5 s */
    int64_t resent, marked;
} pressed;

static pressed press_queue(int kind, int congestion, bool ecn, int discipline)
{
    road *r = road_open(kind, congestion, 20, 1);
    ll_bottleneck_params params;
    ll_param_defaults(&ll_bottleneck_table, &params);
    params.rate_kbps = 4000;
    params.limit_ms = 1250;
    params.discipline = discipline;
    params.ecn = ecn;
    ll_bottleneck_init(&r->queue, &params, 1, 1000);
    plan(r);
    pressed p = {0};
    int64_t probes = 0, handed = 0;
    while (r->tube->now < SECONDS(45)) {
        press(r, 1);
        if (r->tube->now < SECONDS(5)) {
            handed = r->tube->bytes_handed[0];
            continue;
        }
        ll_time wait = r->queue.leaves - r->tube->now;
        p.wait_ms += wait > 0 ? ll_to_ms(wait) : 0;
        probes++;
    }
    p.wait_ms /= (double)probes;
    p.rate_kbps = (double)(r->tube->bytes_handed[0] - handed) * 8e-3 / (ll_to_s(r->tube->now) - 5);
    p.resent = r->tube->resent[0];
    p.marked = r->state.marked;
    road_close(r);
    return p;
}

/* CoDel keeps its queue near the target of 5 ms, whether it drops or marks; with marks nothing is sent again.
 * Without it the queue is as long as its limit lets it be. */
static void a_queue_that_marks_is_as_short(void **state)
{
    (void)state;
    static const int kinds[] = {LL_TRANSPORT_TCP, LL_TRANSPORT_QUIC};
    for (int k = 0; k < 2; k += LL_TEST_STRIDE)
        for (int congestion = 0; congestion < LL_CONGESTION_KINDS; congestion += LL_TEST_STRIDE) {
            pressed drops = press_queue(kinds[k], congestion, false, LL_DISCIPLINE_CODEL),
                    marks = press_queue(kinds[k], congestion, true, LL_DISCIPLINE_CODEL);
            print_message(
                "kind %d %d: drops %.2f ms %.0f kbit/s %lld again, marks %.2f ms %.0f kbit/s %lld\n",
                kinds[k], congestion, drops.wait_ms, drops.rate_kbps, (long long)drops.resent, marks.wait_ms,
                marks.rate_kbps, (long long)marks.marked);
            assert_true(drops.resent > 10 && drops.marked == 0);
            assert_true(marks.resent == 0 && marks.marked > 10);
            assert_true(marks.wait_ms > 1 && marks.wait_ms < 10);
            assert_true(marks.rate_kbps > 0.8 * 4000 * MESSAGE / 1100.0);
        }
    pressed full = press_queue(LL_TRANSPORT_TCP, LL_CONGESTION_RENO, true, LL_DISCIPLINE_TAIL_DROP);
    assert_true(full.wait_ms > 100 && full.marked == 0);
    pressed red = press_queue(LL_TRANSPORT_TCP, LL_CONGESTION_RENO, true, LL_DISCIPLINE_RED);
    assert_true(red.resent == 0 && red.marked > 10 && red.wait_ms < 40);
}

/* A transport that does not react is not marked by a queue: its packets are dropped as before. */
static void who_does_not_react_is_not_marked(void **state)
{
    (void)state;
    pressed without = press_queue(LL_TRANSPORT_WEBRTC, LL_CONGESTION_RENO, false, LL_DISCIPLINE_CODEL),
            with = press_queue(LL_TRANSPORT_WEBRTC, LL_CONGESTION_RENO, true, LL_DISCIPLINE_CODEL);
    assert_true(with.marked == 0 && with.resent > 10);
    assert_memory_equal(&with, &without, sizeof with);
    assert_int_equal(ll_transport_ecn(LL_TRANSPORT_UDP), 0);
    assert_int_equal(ll_transport_ecn(LL_TRANSPORT_WEBRTC), 0);
}

/* ---- what is not marked ---- */

/* Over a bad link without marks a transport that could be marked is the same to the last bit. */
static void without_marks_not_a_bit_differs(void **state)
{
    (void)state;
    static const int kinds[] = {LL_TRANSPORT_TCP, LL_TRANSPORT_QUIC};
    for (int k = 0; k < 2; k++) {
        road *r[2];
        for (int i = 0; i < 2; i++) {
            r[i] = road_open(kinds[k], LL_CONGESTION_CUBIC, 30, 9);
            r[i]->profile.ecn = 0;
            r[i]->tube->params[0] = (ll_link_params){
                .loss_pct = 4, .duplicate_pct = 5, .jitter_ms = 20, .delay_ms = 1, .mtu_bytes = 600};
            plan(r[i]);
            r[i]->tube->plan[0].ecn *= (uint32_t)i;
            while (r[i]->tube->now < SECONDS(8))
                press(r[i], 20);
        }
        ll_transport_setup setup = {
            .kind = kinds[k], .delivery = LL_DELIVERY_ORDERED, .flow = {{1000, MESSAGE}, {160, MESSAGE}}};
        assert_true(r[0]->tube->resent[0] > 20);
        assert_memory_equal(r[0]->tube->transport, r[1]->tube->transport, ll_transport_size(&setup));
        road_close(r[0]);
        road_close(r[1]);
    }
}

/* A fragment's mark is that of its packet, and a copy's is its own. */
static void fragments_and_copies_carry_marks(void **state)
{
    (void)state;
    static const int kinds[] = {LL_TRANSPORT_TCP, LL_TRANSPORT_QUIC};
    for (int k = 0; k < 2; k++) {
        road *r = road_open(kinds[k], LL_CONGESTION_RENO, 50, 1);
        r->tube->params[0] = (ll_link_params){.duplicate_pct = 30, .mtu_bytes = 600};
        reductions all = {0, 1, 0};
        mark_share(r, 0);
        watch_window(r, 1000, &all);
        mark_share(r, 1);
        watch_window(r, 20, &all);
        mark_share(r, 0);
        watch_window(r, 300, &all);
        assert_int_equal(all.count, 1);
        road_close(r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(throughput_falls_with_the_root_of_the_share),
        cmocka_unit_test(the_window_halves_once_a_round_trip),
        cmocka_unit_test(a_lost_echo_is_told_again),
        cmocka_unit_test(a_queue_that_marks_is_as_short),
        cmocka_unit_test(who_does_not_react_is_not_marked),
        cmocka_unit_test(without_marks_not_a_bit_differs),
        cmocka_unit_test(fragments_and_copies_carry_marks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
