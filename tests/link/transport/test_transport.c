/* Transports by themselves: what is delivered, when, and how it stands to theory (netcode-2.md's formulas:
 * head of line blocking, Reno). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "base/rng.h"
#include "link/transport/pipe.h"
#include "support/near.h"
#include "support/stride.h"

#define SECONDS(s) ((ll_time)((s)*1e9))

static ll_transport_setup setup_of(int kind, int delivery)
{
    return (ll_transport_setup){
        .kind = kind, .delivery = delivery, .flow = {{160, PIPE_MESSAGE_MAX}, {160, PIPE_MESSAGE_MAX}}};
}

/* Each `kind`, in each way that it can deliver. */
static void for_each(void (*test)(int kind, int delivery))
{
    for (int kind = LL_TRANSPORT_TCP; kind < LL_TRANSPORT_KINDS; kind++)
        for (int delivery = LL_DELIVERY_UNRELIABLE; delivery < LL_DELIVERY_CLASSES; delivery++)
            if (ll_transport_delivers(kind, delivery))
                test(kind, delivery);
}

static bool reliable(int delivery)
{
    return delivery >= LL_DELIVERY_UNORDERED;
}

/* ---- delivery ---- */

static double draw(uint64_t seed, int k, uint64_t counter)
{
    return ll_rng_unit(seed, (uint64_t)k, counter);
}

static ll_link_params bad_link(uint64_t seed)
{
    return (ll_link_params){.loss_pct = 15 * draw(seed, 1, 0),
                            .jitter_ms = 40 * draw(seed, 2, 0),
                            .duplicate_pct = 10 * draw(seed, 3, 0),
                            .corrupt_pct = 3 * draw(seed, 4, 0),
                            .delay_ms = 1,
                            .reorder_pct = 20 * draw(seed, 5, 0),
                            .mtu_bytes = 1200};
}

/* Whether message `i` as handed over comes after all that its stream asks for. */
static void check_order(const pipe *p, int side, int delivery)
{
    int64_t last = -1, last_of[LL_TRANSPORT_TYPES];
    memset(last_of, 0xff, sizeof last_of);
    for (int64_t i = 0; i < p->handed[side]; i++) {
        int64_t number = p->order[side][i];
        int type = p->message[side][number].type;
        if (delivery == LL_DELIVERY_ORDERED)
            assert_int_equal(number, last + 1);
        if (delivery == LL_DELIVERY_BY_TYPE || delivery == LL_DELIVERY_SEQUENCED)
            assert_true(number > last_of[type]);
        last = number;
        last_of[type] = number;
    }
}

/* Messages of all lengths and types in both directions over links with every impairment. */
static void deliver_at_random(int kind, int delivery)
{
    for (uint64_t seed = 1; seed <= 12; seed += LL_TEST_STRIDE) {
        ll_link_params params = bad_link(seed);
        ll_transport_setup setup = setup_of(kind, delivery);
        setup.congestion = seed % 2 == 0;
        setup.nagle = kind == LL_TRANSPORT_TCP && seed % 3 == 0;
        pipe *p = pipe_open(setup, &params, 10 + 90 * draw(seed, 6, 0), seed);
        for (uint64_t i = 0; i < 600; i++) {
            int side = draw(seed, 7, i) < 0.5;
            int size = draw(seed, 8, i) < 0.9 ? 8 + (int)(200 * draw(seed, 9, i))
                                              : 8 + (int)(3900 * draw(seed, 9, i));
            if (side == LL_SERVER_SIDE && p->now < SECONDS(0.5))
                side = LL_CLIENT_SIDE; /* the server speaks when it was spoken to */
            pipe_send(p, side, (int)(8 * draw(seed, 10, i)), size);
            pipe_run(p, p->now + SECONDS(0.02 * draw(seed, 11, i)));
        }
        pipe_run(p, p->now + SECONDS(120));
        for (int side = 0; side < LL_SIDES; side++) {
            for (int64_t n = 0; n < p->sent[side]; n++) {
                assert_true(p->message[side][n].times <= 1);
                if (reliable(delivery))
                    assert_int_equal(p->message[side][n].times, 1);
            }
            check_order(p, side, delivery);
            assert_true(p->handed[side] > p->sent[side] / 3);
        }
        assert_int_equal(ll_transport_due(p->transport), LL_NEVER);
        pipe_close(p);
    }
}

static void messages_come_once_and_in_order(void **state)
{
    (void)state;
    for_each(deliver_at_random);
}

/* On a clean link all transports deliver at the same times as udp: the delay of the link. */
static void clean_link(int kind, int delivery)
{
    ll_link_params params = {.mtu_bytes = 1200};
    pipe *p = pipe_open(setup_of(kind, delivery), &params, 40, 1);
    for (int i = 0; i < 300; i++) {
        pipe_send(p, LL_CLIENT_SIDE, i % 8, 8 + i % 100);
        if (i > 3)
            pipe_send(p, LL_SERVER_SIDE, i % 8, 8 + i % 300);
        pipe_run(p, p->now + SECONDS(1 / 60.0));
    }
    pipe_run(p, p->now + SECONDS(10));
    for (int side = 0; side < LL_SIDES; side++) {
        assert_int_equal(p->handed[side], p->sent[side]);
        assert_int_equal(p->resent[side], 0);
        for (int64_t n = 0; n < p->sent[side]; n++)
            assert_int_equal(p->message[side][n].handed - p->message[side][n].made, 40 * LL_MS);
    }
    pipe_close(p);
}

static void without_loss_only_headers_differ(void **state)
{
    (void)state;
    for_each(clean_link);
}

/* A lone message of 100 bytes, and the acknowledgement that answers it. */
static void headers_have_the_sizes_of_their_protocols(void **state)
{
    static const int message[] = {
        [LL_TRANSPORT_TCP] = 52 + 2, [LL_TRANSPORT_QUIC] = 28 + 30, [LL_TRANSPORT_WEBRTC] = 28 + 29 + 28};
    static const int answer[] = {[LL_TRANSPORT_TCP] = 52,
                                 [LL_TRANSPORT_QUIC] = 28 + 22 + 10,
                                 [LL_TRANSPORT_WEBRTC] = 28 + 29 + 12 + 16};
    ll_link_params params = {.mtu_bytes = 1200};
    (void)state;
    for (int kind = LL_TRANSPORT_TCP; kind < LL_TRANSPORT_KINDS; kind++) {
        pipe *p = pipe_open(setup_of(kind, LL_DELIVERY_USUAL), &params, 40, 1);
        pipe_send(p, LL_CLIENT_SIDE, 0, 100);
        pipe_run(p, SECONDS(1));
        assert_int_equal(p->packets[LL_CLIENT_SIDE], 1);
        assert_int_equal(p->wire_bytes[LL_CLIENT_SIDE], 100 + message[kind]);
        assert_int_equal(p->packets[LL_SERVER_SIDE], 1);
        assert_int_equal(p->wire_bytes[LL_SERVER_SIDE], answer[kind]);
        pipe_close(p);
    }
}

/* ---- head-of-line blocking ---- */

typedef struct line {
    double delayed, extra_ms; /* share of messages; mean */
    double loss;              /* share of packets that was really lost */
} line;

/* Messages of one direction, `streams` types in turn, every `t_ms`, over a lag of `d_ms` with loss p up. */
static line measure(int kind, int delivery, int streams, double t_ms, double d_ms, double p, int count)
{
    line sum = {0};
    ll_link_params params = {.loss_pct = 100 * p};
    pipe *tube = pipe_open(setup_of(kind, delivery), &params, d_ms, 7);
    tube->params[LL_SERVER_SIDE].loss_pct = 0; /* acknowledgements come */
    tube->plan[LL_SERVER_SIDE] = ll_link_plan_of(&tube->params[LL_SERVER_SIDE], d_ms);
    for (int i = 0; i < count; i++) {
        pipe_send(tube, LL_CLIENT_SIDE, i % streams, 16);
        pipe_run(tube, ll_ms(t_ms * (i + 1)));
    }
    pipe_run(tube, tube->now + SECONDS(30));
    assert_int_equal(tube->handed[LL_CLIENT_SIDE], count);
    for (int64_t n = 0; n < count; n++) {
        double extra = ll_to_ms(tube->message[0][n].handed - tube->message[0][n].made) - d_ms;
        sum.delayed += extra > 1e-6;
        sum.extra_ms += extra;
    }
    const ll_link_stats *stats = ll_link_get_stats(tube->env.link[LL_CLIENT_SIDE]);
    sum.loss = (double)stats->lost / (double)stats->sent;
    pipe_close(tube);
    return (line){sum.delayed / count, sum.extra_ms / count, sum.loss};
}

/* First order in p, at the loss that was met: a lost message is D late, the n - 1 after it wait for it. What
 * is sent again may be lost again: netcode-2.md has 8.9 % and 7.95 ms at 1 % by a model, where the formulas
 * say 8.65 % and 7.5 ms, and 40 % and 50 ms at 5 %, where they say 37.5 ms. */
static void blocking_is_as_theory_says(void **state)
{
    static const double losses[] = {0.005, 0.01, 0.02, 0.05};
    const double t = 1000 / 60.0, d = 50, late = 3 * t + 2 * d;
    const int n = (int)ceil(late / t - 1e-9);
    (void)state;
    for (size_t i = 0; i < sizeof losses / sizeof losses[0]; i += LL_TEST_STRIDE) {
        line tcp = measure(LL_TRANSPORT_TCP, LL_DELIVERY_ORDERED, 1, t, d, losses[i], 36000);
        double p = tcp.loss, delayed = 1 - pow(1 - p, n), extra = p * (n * late - t * n * (n - 1) / 2);
        assert_true(tcp.delayed / delayed > 0.97 && tcp.delayed / delayed < 1.1);
        assert_true(tcp.extra_ms / extra > 0.95 && tcp.extra_ms / extra < 1.05 + 7 * p);
    }
}

/* S streams in turn: only every S-th message waits, n = ceil(D / (S T)) in steps of S T. */
static void streams_block_less(void **state)
{
    const double t = 1000 / 60.0, d = 50, late = 3 * t + 2 * d;
    double before = INFINITY;
    (void)state;
    for (int streams = 1; streams <= 8; streams *= 2) {
        const double step = streams * t;
        const int n = (int)ceil(late / step - 1e-9);
        line many = measure(LL_TRANSPORT_WEBRTC, LL_DELIVERY_BY_TYPE, streams, t, d, 0.01, 36000);
        double extra = many.loss * (n * late - step * n * (n - 1) / 2);
        assert_true(many.extra_ms < before);
        assert_near(many.extra_ms / extra, 1, 0.1);
        before = many.extra_ms;
    }
    line none = measure(LL_TRANSPORT_WEBRTC, LL_DELIVERY_UNORDERED, 8, t, d, 0.01, 36000);
    assert_near(none.delayed / none.loss, 1, 0.05); /* only what was lost itself */
    assert_near(none.extra_ms / (none.loss * late), 1, 0.1);
}

/* At 10 Hz three later packets come after the timer. It runs from the last acknowledgement, which the other
 * side holds for 40 ms: so the lost message comes again 240 ms after it was sent, by the least RTO of 200 ms.
 */
static void the_timer_fires_where_packets_are_rare(void **state)
{
    const double t = 100, d = 50, late = 40 + 200;
    const int n = (int)ceil(late / t - 1e-9);
    (void)state;
    line tcp = measure(LL_TRANSPORT_TCP, LL_DELIVERY_ORDERED, 1, t, d, 0.01, 20000);
    double extra = tcp.loss * (n * late - t * n * (n - 1) / 2);
    assert_true(tcp.extra_ms / extra > 0.9 && tcp.extra_ms / extra < 1.2);
}

/* RFC 9002: lost with the acknowledgement of the third later packet, or of a later one when 9/8 of a round
 * trip have passed: min(3 T + R, max(T + R, 9/8 R)). */
static void quic_finds_losses_by_packets_or_time(void **state)
{
    static const double intervals[] = {4, 12, 30};
    const double d = 100;
    (void)state;
    for (int i = 0; i < 3; i++) {
        double t = intervals[i], after = larger(t + 2 * d, 9 / 8.0 * 2 * d),
               late = smaller(3 * t + 2 * d, after);
        line quic = measure(LL_TRANSPORT_QUIC, LL_DELIVERY_UNORDERED, 1, t, d, 0.005, 36000);
        assert_near(quic.delayed / quic.loss, 1, 0.05);
        assert_near(quic.extra_ms / (quic.loss * late), 1, 0.1);
    }
}

/* ---- congestion ---- */

/* A sender that always has more: its throughput with loss p, bytes of messages a second. */
static double throughput(int kind, int congestion, double p, double d_ms, double seconds)
{
    ll_link_params params = {.loss_pct = 100 * p};
    ll_transport_setup setup = setup_of(kind, LL_DELIVERY_ORDERED);
    setup.congestion = congestion;
    setup.flow[0] = (ll_flow_limits){1000, 1000};
    pipe *tube = pipe_open(setup, &params, d_ms, 3);
    tube->params[LL_SERVER_SIDE].loss_pct = 0;
    tube->plan[LL_SERVER_SIDE] = ll_link_plan_of(&tube->params[LL_SERVER_SIDE], d_ms);
    for (int i = 0; i < (int)(seconds * 200) && tube->sent[0] < PIPE_MESSAGES - 600; i++) {
        for (int k = 0; k < 500 && pipe_send(tube, LL_CLIENT_SIDE, 0, 1000); k++)
            ;
        pipe_run(tube, tube->now + 5 * LL_MS);
    }
    double rate = (double)tube->bytes_handed[0] / ll_to_s(tube->now);
    assert_true(tube->resent[0] > 20);
    pipe_close(tube);
    return rate;
}

/* Mathis: MSS/R sqrt(1.5/p), where the packet has 1,000 bytes and the window grows by the mss of the
 * protocol: the MSS is the geometric mean of both. */
static void reno_has_its_throughput(void **state)
{
    static const double losses[] = {0.005, 0.01, 0.02};
    (void)state;
    for (size_t i = 0; i < sizeof losses / sizeof losses[0]; i += LL_TEST_STRIDE) {
        double want = sqrt(1000 * 1140.0) / 0.1 * sqrt(1.5 / losses[i]);
        double tcp = throughput(LL_TRANSPORT_TCP, LL_CONGESTION_RENO, losses[i], 50, 200);
        double quic = throughput(LL_TRANSPORT_QUIC, LL_CONGESTION_RENO, losses[i], 50, 200);
        assert_near(tcp / want, 1, 0.15);
        assert_near(quic / want, 1, 0.15);
    }
}

/* CUBIC is never below Reno, and above it where losses are rare and the path is long. */
static void cubic_is_not_below_reno(void **state)
{
    (void)state;
    double reno = throughput(LL_TRANSPORT_TCP, LL_CONGESTION_RENO, 0.005, 100, 200);
    double cubic = throughput(LL_TRANSPORT_TCP, LL_CONGESTION_CUBIC, 0.005, 100, 200);
    assert_true(cubic > 1.1 * reno);
    assert_true(throughput(LL_TRANSPORT_TCP, LL_CONGESTION_CUBIC, 0.02, 20, 60) >
                0.9 * throughput(LL_TRANSPORT_TCP, LL_CONGESTION_RENO, 0.02, 20, 60));
}

/* ---- outages ---- */

/* No packet passes from 3 s on for `length_s`, in one direction or both. Messages at 30 Hz both ways:
 * `timeout_s` later the connection has resumed or was opened again. */
static void outage(int kind, int delivery)
{
    static const double lengths[] = {0.1, 0.5, 1.5, 4, 4.9, 5.2, 7, 20, 60};
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i += LL_TEST_STRIDE)
        for (int which = 1; which <= 3; which++) {
            ll_link_params params = {0};
            pipe *p = pipe_open(setup_of(kind, delivery), &params, 60, 5);
            p->env.timeout = SECONDS(5);
            for (int side = 0; side < LL_SIDES; side++) {
                p->params[side].blackout_at_ms = 3000;
                p->params[side].blackout_length_ms = which >> side & 1 ? 1e3 * lengths[i] : 0;
                p->plan[side] = ll_link_plan_of(&p->params[side], 60);
            }
            double end = 3 + lengths[i] + 6;
            for (int k = 0; k < (int)((end + 3) * 30); k++) {
                pipe_send(p, LL_CLIENT_SIDE, k % 3, 60);
                pipe_send(p, LL_SERVER_SIDE, k % 3, 200);
                pipe_run(p, SECONDS((k + 1) / 30.0));
            }
            pipe_run(p, p->now + SECONDS(4));
            for (int side = 0; side < LL_SIDES; side++)
                for (int64_t n = 0; n < p->sent[side]; n++) {
                    const pipe_message *m = &p->message[side][n];
                    assert_true(m->times <= 1);
                    if (m->made >= SECONDS(end)) { /* all is as before */
                        assert_int_equal(m->times, 1);
                        assert_int_equal(m->handed - m->made, 60 * LL_MS);
                    }
                    if (reliable(delivery) && p->ended == 0 && p->refused == 0)
                        assert_int_equal(m->times, 1);
                }
            if (lengths[i] < 2.5)
                assert_int_equal(p->ended, 0);
            if (lengths[i] > 5)
                assert_true(p->ended > 0);
            pipe_close(p);
        }
}

static void connections_survive_outages_or_begin_again(void **state)
{
    (void)state;
    for_each(outage);
}

/* Without a time-out the stream itself resumes: at the next retransmission, at most as long after the outage
 * as the outage was, and a round trip. Nothing is lost. */
static void a_stream_without_time_out_resumes(void **state)
{
    (void)state;
    for (int kind = LL_TRANSPORT_TCP; kind < LL_TRANSPORT_KINDS; kind++) {
        ll_link_params params = {.blackout_at_ms = 3000, .blackout_length_ms = 10000};
        pipe *p = pipe_open(setup_of(kind, LL_DELIVERY_ORDERED), &params, 60, 5);
        for (int k = 0; k < 400; k++) {
            pipe_send(p, LL_CLIENT_SIDE, 0, 60);
            pipe_run(p, SECONDS((k + 1) / 30.0));
        }
        pipe_run(p, SECONDS(60));
        assert_int_equal(p->ended, 0);
        assert_int_equal(p->handed[0], 400 - p->refused);
        assert_true(p->message[0][p->sent[0] - 1].handed < SECONDS(13 + 10 + 1));
        pipe_close(p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(messages_come_once_and_in_order),
        cmocka_unit_test(without_loss_only_headers_differ),
        cmocka_unit_test(headers_have_the_sizes_of_their_protocols),
        cmocka_unit_test(blocking_is_as_theory_says),
        cmocka_unit_test(streams_block_less),
        cmocka_unit_test(the_timer_fires_where_packets_are_rare),
        cmocka_unit_test(quic_finds_losses_by_packets_or_time),
        cmocka_unit_test(reno_has_its_throughput),
        cmocka_unit_test(cubic_is_not_below_reno),
        cmocka_unit_test(connections_survive_outages_or_begin_again),
        cmocka_unit_test(a_stream_without_time_out_resumes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
