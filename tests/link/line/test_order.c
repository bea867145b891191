#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/harness.h"

static void packets_come_by_due_time_then_by_sending(void **state)
{
    (void)state;
    ll_link *link = link_open(64, 10000, 1, 1);
    static const double lags[] = {50, 10, 30, 10, 50, 0, 30, 10};
    static const int64_t want[] = {5, 1, 3, 7, 2, 6, 0, 4};
    ll_link_params params = {0};
    ll_time sent, due;
    for (int64_t i = 0; i < 8; i++)
        packet_send(link, &params, lags[i], LL_SECOND, i);
    assert_int_equal(ll_link_in_flight(link), 8);
    assert_int_equal(ll_link_next_due(link), LL_SECOND);
    assert_int_equal(packet_receive(link, LL_SECOND - 1, &sent, &due), -1);
    for (int i = 0; i < 8; i++) {
        assert_int_equal(packet_receive(link, 2 * LL_SECOND, &sent, &due), want[i]);
        assert_int_equal(sent, LL_SECOND);
        assert_int_equal(due, LL_SECOND + ll_ms(lags[want[i]]));
    }
    assert_int_equal(ll_link_next_due(link), LL_NEVER);
    assert_int_equal(packet_receive(link, LL_NEVER - 1, &sent, &due), -1);
    assert_int_equal(ll_link_get_stats(link)->reordered, 6); /* all but 5 and 7 */
    free(link);
}

/* Far from the end of the queue too. */
static void equal_due_times_keep_the_order_of_sending(void **state)
{
    (void)state;
    ll_link *link = link_open(200, 20000, 1, 1);
    ll_link_params params = {0};
    ll_time sent, due;
    for (int64_t i = 0; i < 120; i++)
        packet_send(link, &params, i < 40 ? 100 : i < 80 ? 50 : 70, 0, i);
    for (int64_t i = 0; i < 120; i++)
        assert_int_equal(packet_receive(link, LL_SECOND, &sent, &due), (i + 40) % 120);
    free(link);
}

static void a_packet_is_due_at_its_nanosecond(void **state)
{
    (void)state;
    ll_link *link = link_open(4, 1000, 1, 1);
    ll_link_params params = {.delay_ms = 0.000001};
    ll_time sent, due;
    packet_send(link, &params, 20, 1000, 0);
    assert_int_equal(packet_receive(link, 20001000, &sent, &due), -1);
    assert_int_equal(packet_receive(link, 20001001, &sent, &due), 0);
    free(link);
}

/* Against a plain model: a list of all packets, searched for the earliest. Bursts, pauses and every
 * impairment. */
static void deliveries_agree_with_a_model(void **state)
{
    (void)state;
    enum { COUNT = 20000 };
    static struct {
        ll_time due;
        int64_t number;
    } model[2 * COUNT];
    int in_model = 0;
    int64_t reordered = 0, highest = -1;
    ll_link *link = link_open(400, 40000, 9, 1);
    ll_link_params params = {.jitter_ms = 300, .loss_pct = 5, .duplicate_pct = 20};
    ll_time now = 0, sent, due;
    for (int64_t i = 0; i < COUNT; i++) {
        now += i % 500 < 250 ? STEP : STEP / 10;
        ll_sending s = packet_send(link, &params, 150, now, i);
        if (s.fate == LL_FATE_DELIVERED)
            model[in_model].due = s.due, model[in_model++].number = i;
        if (s.duplicated && s.copy_fate == LL_FATE_DELIVERED)
            model[in_model].due = s.copy_due, model[in_model++].number = i;
        for (;;) {
            int best = -1;
            for (int k = 0; k < in_model; k++)
                if (model[k].due <= now && (best < 0 || model[k].due < model[best].due))
                    best = k;
            int64_t got = packet_receive(link, now, &sent, &due);
            if (best < 0) {
                assert_int_equal(got, -1);
                break;
            }
            assert_int_equal(got, model[best].number);
            assert_int_equal(due, model[best].due);
            reordered += got < highest;
            highest = got > highest ? got : highest;
            memmove(&model[best], &model[best + 1], (size_t)(in_model - best - 1) * sizeof model[0]);
            in_model--;
        }
        assert_int_equal(ll_link_in_flight(link), in_model);
    }
    assert_int_equal(ll_link_get_stats(link)->reordered, reordered);
    assert_true(reordered > COUNT / 4); /* the test covers the case */
    assert_int_equal(ll_link_get_stats(link)->overflowed, 0);
    free(link);
}

static void fifo_never_reorders(void **state)
{
    (void)state;
    ll_link *link = link_open(400, 40000, 4, 1);
    ll_link_params params = {.jitter_ms = 300,
                             .loss_pct = 5,
                             .duplicate_pct = 10,
                             .distribution = LL_DISTRIBUTION_NORMAL,
                             .order = LL_ORDER_FIFO};
    ll_link_params free_order = params;
    free_order.order = LL_ORDER_FREE;
    ll_link *twin = link_open(400, 40000, 4, 1); /* the same draws without an order */
    ll_time sent, due, latest = 0, last = 0;
    int64_t before = -1, held = 0;
    for (int64_t i = 0; i < 50000; i++) {
        ll_time now = i * STEP;
        ll_sending s = packet_send(link, &params, 150, now, i),
                   drawn = packet_send(twin, &free_order, 150, now, i);
        if (s.fate == LL_FATE_DELIVERED) { /* due = max(due, the latest due so far) */
            ll_time want = drawn.due > latest ? drawn.due : latest;
            assert_int_equal(s.due, want);
            held += s.due > drawn.due;
            latest = s.due;
        }
        if (s.duplicated && s.copy_fate == LL_FATE_DELIVERED)
            latest = s.copy_due;
        int64_t number;
        while ((number = packet_receive(link, now, &sent, &due)) >= 0) {
            assert_true(number >= before && due >= last);
            before = number;
            last = due;
        }
        while (packet_receive(twin, now, &sent, &due) >= 0)
            ;
    }
    assert_int_equal(ll_link_get_stats(link)->reordered, 0);
    assert_true(ll_link_get_stats(twin)->reordered > 10000 && held > 10000);
    free(link);
    free(twin);
}

/* Packets sent without an order are not overtaken either. */
static void fifo_holds_behind_packets_of_free_order(void **state)
{
    (void)state;
    ll_link *link = link_open(16, 5000, 1, 1);
    ll_link_params free_order = {0}, fifo = {.order = LL_ORDER_FIFO};
    packet_send(link, &free_order, 900, 0, 0);
    packet_send(link, &free_order, 10, 0, 1);
    assert_int_equal(packet_send(link, &fifo, 20, 0, 2).due, 900 * LL_MS);
    assert_int_equal(packet_send(link, &free_order, 20, 0, 3).due, 20 * LL_MS);
    assert_int_equal(packet_send(link, &fifo, 20, 0, 4).due, 900 * LL_MS);
    free(link);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packets_come_by_due_time_then_by_sending),
        cmocka_unit_test(equal_due_times_keep_the_order_of_sending),
        cmocka_unit_test(a_packet_is_due_at_its_nanosecond),
        cmocka_unit_test(deliveries_agree_with_a_model),
        cmocka_unit_test(fifo_never_reorders),
        cmocka_unit_test(fifo_holds_behind_packets_of_free_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
