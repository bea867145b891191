/* Latencies of changes of the controls, against values computed by hand. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "netcode/metrics/changes.h"

typedef struct desk {
    ll_changes changes;
    ll_input_history input_history;
    ll_histogram latency[LL_LATENCIES];
} desk;

static desk *new_desk(uint32_t others)
{
    desk *d = calloc(1, sizeof *d);
    for (int i = 0; i < LL_LATENCIES; i++)
        ll_histogram_init(&d->latency[i], 0.1);
    ll_input_history_resync(&d->input_history);
    d->changes.others = others;
    return d;
}

static void make(desk *d, uint32_t seq, int64_t tick, double x, uint32_t buttons, int ms)
{
    ll_action a = {.axis = {(float)x, 0}, .buttons = buttons};
    ll_input_history_made(&d->input_history, seq, tick);
    ll_changes_made(&d->changes, d->latency, &(ll_made_input){&a, seq, true, tick, ms * LL_MS});
}

static void come(desk *d, uint32_t seq, ll_input_history_flag mark)
{
    ll_input_history_received(&d->input_history, seq, mark);
}

static void step(desk *d, int64_t tick)
{
    ll_input_history_stepped(&d->input_history, tick);
    ll_changes_decide(&d->changes, d->latency, &d->input_history);
}

static void show(desk *d, uint32_t seq, int64_t tick, int ms)
{
    ll_included included = {.seq = seq, .tick = tick, .sure_tick = tick};
    ll_changes_shown(&d->changes, d->latency, &included, ms * LL_MS);
}

static void see(desk *d, int other, int64_t tick, int ms)
{
    ll_changes_seen(&d->changes, d->latency, &d->input_history, other, tick, ms * LL_MS);
}

static ll_summary of(const desk *d, ll_latency which)
{
    return ll_histogram_summary(&d->latency[which]);
}

/* Inputs 1 to 8 for ticks 11 to 18; changes are 1 (from neutral), 4 (the axis) and 6 (a button). */
static void only_changes_are_measured(void **state)
{
    (void)state;
    desk *d = new_desk(2);
    for (uint32_t seq = 1; seq <= 8; seq++) {
        make(d, seq, 10 + seq, seq < 4 ? 1 : -1, seq >= 6, (int)seq * 10);
        come(d, seq, LL_INPUT_HISTORY_IN_TIME);
    }
    assert_int_equal(d->changes.made, 3);
    show(d, 1, 0, 10); /* predicted at once */
    show(d, 5, 0, 55);
    assert_int_equal(of(d, LL_LATENCY_FELT).count, 0); /* not known yet whether they are applied */
    step(d, 14);
    assert_int_equal(of(d, LL_LATENCY_FELT).count, 2); /* 10 - 10, 55 - 40 */
    assert_true(of(d, LL_LATENCY_FELT).max == 15 && of(d, LL_LATENCY_FELT).mean == 7.5);
    see(d, 1, 13, 100); /* tick 11, not 14 */
    assert_true(of(d, LL_LATENCY_SEEN).count == 1 && of(d, LL_LATENCY_SEEN).mean == 90);
    show(d, 8, 13, 105);
    assert_true(of(d, LL_LATENCY_SURE).count == 1 && of(d, LL_LATENCY_SURE).mean == 95);
    step(d, 18);
    show(d, 8, 18, 150); /* 150 - 40, 150 - 60; and 6 was felt at 105 */
    assert_true(of(d, LL_LATENCY_SURE).count == 3 && of(d, LL_LATENCY_SURE).max == 110);
    assert_true(of(d, LL_LATENCY_FELT).count == 3 && of(d, LL_LATENCY_FELT).max == 45);
    assert_true(ll_changes_waiting(&d->changes));
    see(d, 1, 18, 170); /* 170 - 40, 170 - 60 */
    assert_true(of(d, LL_LATENCY_SEEN).count == 3 && of(d, LL_LATENCY_SEEN).max == 130);
    assert_false(ll_changes_waiting(&d->changes));
    free(d);
}

/* Predicted displays do not count where the input is refused, late or lost. */
static void inputs_that_are_never_applied_are_infinite(void **state)
{
    (void)state;
    desk *d = new_desk(6); /* two other screens */
    for (uint32_t seq = 1; seq <= 4; seq++) {
        make(d, seq, seq, seq, 0, (int)seq);
        show(d, seq, 0, (int)seq);
    }
    come(d, 1, LL_INPUT_HISTORY_IN_TIME);
    come(d, 2, LL_INPUT_HISTORY_REFUSED);
    step(d, 4); /* 3 and 4 have not arrived */
    assert_int_equal(of(d, LL_LATENCY_FELT).count, 4);
    assert_int_equal(of(d, LL_LATENCY_FELT).never, 3);
    assert_true(of(d, LL_LATENCY_FELT).mean == 0 && isinf(of(d, LL_LATENCY_FELT).p50));
    assert_int_equal(of(d, LL_LATENCY_SEEN).never, 6);
    assert_int_equal(d->changes.lost[LL_LATENCY_SEEN], 6);
    come(d, 3, LL_INPUT_HISTORY_LATE);
    step(d, 5);
    assert_int_equal(d->input_history.count[LL_INPUT_CAME_LATE], 1);
    assert_int_equal(d->input_history.count[LL_INPUT_WAS_LOST], 1);
    assert_int_equal(d->input_history.count[LL_INPUT_WAS_REFUSED], 1);
    assert_int_equal(d->input_history.count[LL_INPUT_WAS_APPLIED], 1);
    assert_int_equal(of(d, LL_LATENCY_FELT).count, 4); /* the result of a change is given once */
    free(d);
}

static void a_new_epoch_discards_open_inputs(void **state)
{
    (void)state;
    desk *d = new_desk(0);
    make(d, 1, 1, 1, 0, 0);
    make(d, 2, 2, -1, 0, 10);
    come(d, 1, LL_INPUT_HISTORY_IN_TIME);
    step(d, 1);
    ll_input_history_never(&d->input_history, 1, 2);
    ll_changes_decide(&d->changes, d->latency, &d->input_history);
    ll_input_history_resync(&d->input_history);
    ll_changes_resync(&d->changes);
    assert_true(ll_input_history_made_count(&d->input_history) == 2 &&
                d->input_history.count[LL_INPUT_WAS_LOST] == 1);
    make(d, 1, 2, 0, 0, 20); /* neutral: no change */
    make(d, 2, 3, -1, 0, 30);
    assert_int_equal(d->changes.made, 3);
    show(d, 2, 0, 30); /* predicted: the new one, not the old with that number */
    assert_int_equal(of(d, LL_LATENCY_FELT).count, 1);
    show(d, 2, 1, 45); /* the one that was applied before */
    assert_true(of(d, LL_LATENCY_FELT).count == 2 && of(d, LL_LATENCY_FELT).mean == 45);
    free(d);
}

/* Where inputs are applied on arrival, an input is lost when no packet with it is on its way or will be
 * sent. */
static void drained_inputs_are_lost_when_nothing_is_on_its_way(void **state)
{
    (void)state;
    desk *d = new_desk(0);
    for (uint32_t seq = 1; seq <= 4; seq++)
        make(d, seq, LL_NEVER, seq, 0, 0);
    ll_input_history_sent(&d->input_history, 1, 2, 50 * LL_MS);
    come(d, 2, LL_INPUT_HISTORY_IN_TIME);
    ll_input_history_applied(&d->input_history, 1, 4,
                             40 * LL_MS); /* 2 arrived; 1 may; 3 was never sent; 4 will be sent again */
    assert_int_equal(ll_input_history_find(&d->input_history, 1)->result, LL_INPUT_IS_OPEN);
    assert_int_equal(ll_input_history_find(&d->input_history, 2)->result, LL_INPUT_WAS_APPLIED);
    assert_int_equal(ll_input_history_find(&d->input_history, 3)->result, LL_INPUT_WAS_LOST);
    assert_int_equal(ll_input_history_find(&d->input_history, 4)->result, LL_INPUT_IS_OPEN);
    ll_input_history_applied(&d->input_history, 2, 4, 50 * LL_MS);
    assert_int_equal(ll_input_history_find(&d->input_history, 1)->result, LL_INPUT_WAS_LOST);
    come(d, 1, LL_INPUT_HISTORY_IN_TIME); /* it was sent again after all */
    ll_input_history_applied(&d->input_history, 3, 4, 60 * LL_MS);
    assert_int_equal(ll_input_history_find(&d->input_history, 1)->result, LL_INPUT_WAS_APPLIED);
    assert_true(ll_input_history_includes(&d->input_history, 1, 3) &&
                !ll_input_history_includes(&d->input_history, 1, 2));
    free(d);
}

/* More changes than are kept: those that were applied and never shown are infinite, and not lost. */
static void changes_beyond_the_ring_are_given_up(void **state)
{
    (void)state;
    desk *d = new_desk(0);
    for (uint32_t seq = 1; seq <= LL_CHANGES_RING + 3; seq++) {
        make(d, seq, seq, seq & 1 ? 1 : -1, 0, 0);
        come(d, seq, LL_INPUT_HISTORY_IN_TIME);
        step(d, seq);
    }
    assert_true(of(d, LL_LATENCY_FELT).never == 3 && d->changes.lost[LL_LATENCY_FELT] == 0);
    show(d, 0, LL_CHANGES_RING + 3, 7);
    assert_int_equal(of(d, LL_LATENCY_FELT).count, LL_CHANGES_RING + 3);
    assert_false(ll_changes_waiting(&d->changes));
    free(d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_changes_are_measured),
        cmocka_unit_test(inputs_that_are_never_applied_are_infinite),
        cmocka_unit_test(a_new_epoch_discards_open_inputs),
        cmocka_unit_test(drained_inputs_are_lost_when_nothing_is_on_its_way),
        cmocka_unit_test(changes_beyond_the_ring_are_given_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
