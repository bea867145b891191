/* A shared queue against closed forms: M/D/1, CoDel's times of drops, RED's share of drops. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/bottleneck/bottleneck.h"
#include "link/harness.h"

static ll_bottleneck queue_of(double kbps, int32_t discipline)
{
    ll_bottleneck_params params;
    ll_bottleneck queue;
    ll_param_defaults(&ll_bottleneck_table, &params);
    params.rate_kbps = kbps;
    params.limit_ms = 1250;
    params.discipline = discipline;
    ll_bottleneck_init(&queue, &params, 11, 1000);
    return queue;
}

/* A probe at a time that does not depend on the traffic finds the wait of an M/D/1 queue. */
static void cross_traffic_makes_an_m_d_1_queue(void **state)
{
    (void)state;
    static const double loads[] = {20, 50, 80, 90};
    enum { PROBES = 100000 };
    double *waits = malloc(PROBES * sizeof *waits);
    assert_non_null(waits);
    for (int k = 0; k < 4; k++) {
        ll_bottleneck b = queue_of(12000, LL_DISCIPLINE_TAIL_DROP); /* 1500 B take 1 ms */
        double rho = loads[k] / 100, s = 1;
        b.params.cross_load_pct = loads[k];
        for (int64_t i = 0; i < PROBES; i++) {
            ll_time now = i * 7300 * 1000;
            ll_bottleneck_fate f = ll_bottleneck_enter(&b, now, 0, false); /* takes no time of the queue */
            assert_false(f.dropped);
            waits[i] = ll_to_ms(f.served - now);
        }
        estimate e = estimate_of(waits, PROBES);
        assert_near(e.mean, rho * s / (2 * (1 - rho)), 4.5 * e.error);
        assert_true(e.error < 0.03 * e.mean);
        assert_near((double)b.crossed, rho * PROBES * 7.3, 4.5 * sqrt(rho * PROBES * 7.3)); /* Poisson */
    }
    free(waits);
}

/* At twice the rate: the first drop an interval after the wait came above the target, then as the law has it.
 */
static void codel_drops_at_its_times(void **state)
{
    (void)state;
    static const double want[] = {0, 100, 170.7, 228.4, 278.4, 323.2};
    ll_bottleneck b = queue_of(8000, LL_DISCIPLINE_CODEL); /* 100 B take 0.1 ms */
    double first = 0, above = -1;
    int drops = 0;
    for (int64_t i = 0; drops < 6; i++) {
        ll_time now = i * LL_MS / 20;
        ll_bottleneck_fate f = ll_bottleneck_enter(&b, now, 100, false);
        if (above < 0 && f.served - now >= 5 * LL_MS)
            above = ll_to_ms(f.served);
        if (!f.dropped)
            continue;
        first = drops == 0 ? ll_to_ms(f.served) : first;
        assert_near(ll_to_ms(f.served) - first, want[drops], 0.16); /* a packet, and the rounding above */
        drops++;
    }
    assert_near(first - above, 100, 0.11);
}

/* With ECN the same instants are marks, of who can be marked; the packets stay in the queue. */
static void codel_marks_at_its_times(void **state)
{
    (void)state;
    static const double want[] = {0, 100, 170.7, 228.4, 278.4, 323.2};
    ll_bottleneck b = queue_of(8000, LL_DISCIPLINE_CODEL);
    b.params.ecn = true;
    double first = 0;
    int marks = 0;
    for (int64_t i = 0; marks < 6; i++) {
        ll_time now = i * LL_MS / 20, leaves = b.leaves;
        ll_bottleneck_fate f = ll_bottleneck_enter(&b, now, 100, true);
        assert_true(!f.dropped && b.leaves > leaves);
        if (!f.marked)
            continue;
        first = marks == 0 ? ll_to_ms(f.served) : first;
        assert_near(ll_to_ms(f.served) - first, want[marks], 0.16);
        marks++;
    }
    ll_bottleneck other = queue_of(8000, LL_DISCIPLINE_CODEL);
    other.params.ecn = true;
    int drops = 0;
    for (int64_t i = 0; i < 20000; i++) {
        ll_bottleneck_fate f = ll_bottleneck_enter(&other, i * LL_MS / 20, 100, false);
        assert_false(f.marked);
        drops += f.dropped;
    }
    assert_true(drops > 5);
}

/* A queue that is below the target again and again keeps all its packets, however long it is at its worst. */
static void codel_keeps_bursts(void **state)
{
    (void)state;
    ll_bottleneck b = queue_of(8000, LL_DISCIPLINE_CODEL);
    ll_time longest = 0;
    for (int64_t i = 0; i < 1000; i++) {
        ll_time now = i / 400 * 90 * LL_MS; /* 400 at once are served in 40 ms */
        ll_bottleneck_fate f = ll_bottleneck_enter(&b, now, 100, false);
        assert_false(f.dropped);
        longest = f.leaves - now > longest ? f.leaves - now : longest;
    }
    assert_int_equal(longest, 40 * LL_MS);
}

/* At a constant wait w between the thresholds p = max (w - min) / (2 min), and the packets from one drop to
 * the next are uniform from 1 to 1/p: (1/p + 1) / 2 in the mean. */
static void red_drops_its_share(void **state)
{
    (void)state;
    ll_bottleneck b = queue_of(8000, LL_DISCIPLINE_RED);
    const double wait_ms = 39.9, p = 0.1 * (wait_ms - 20) / 40;
    int64_t drops = 0, entered = 0;
    ll_time now = 0;
    for (int64_t i = 0; i < 300000; i++) {
        now += LL_MS / 10;
        while (b.leaves < now + 40 * LL_MS) { /* each finds 39.9 ms; what is dropped is replaced at once */
            bool dropped = ll_bottleneck_enter(&b, now, 100, false).dropped;
            if (i < 20000)
                continue; /* until the average is there */
            entered++;
            drops += dropped;
        }
    }
    double share = 2 * p / (1 + p);
    assert_near(b.average_ms, wait_ms, 0.1);
    assert_true(entered > 270000);
    assert_near((double)drops / (double)entered, share, 0.02 * share);
}

static void red_has_two_thresholds(void **state)
{
    (void)state;
    ll_bottleneck b = queue_of(8000, LL_DISCIPLINE_RED);
    b.average_ms = 19;
    for (int i = 0; i < 100; i++) /* the wait grows to 10 ms */
        assert_false(ll_bottleneck_enter(&b, 0, 100, false).dropped);
    b.average_ms = 61;
    for (int i = 0; i < 5; i++)
        assert_true(ll_bottleneck_enter(&b, 0, 100, false).dropped);
    ll_bottleneck_enter(&b, 60 * LL_SECOND, 100, false); /* an idle minute is forgotten */
    assert_true(b.average_ms < 1);
}

static void the_limit_drops_under_every_discipline(void **state)
{
    (void)state;
    for (int32_t d = 0; d < LL_DISCIPLINES_END; d++) {
        ll_bottleneck b = queue_of(8000, d);
        b.params.limit_ms = 3;
        int kept = 0;
        for (int i = 0; i < 100; i++)
            kept += !ll_bottleneck_enter(&b, LL_SECOND, 100, false).dropped;
        assert_int_equal(kept, 30);
    }
}

static void the_table_is_sound(void **state)
{
    (void)state;
    assert_string_equal(ll_param_table_valid(&ll_bottleneck_table).text, "");
}

/* No packet passes at a rate near 0, nor does one come at a load near 0: their times were no numbers of ns.
 */
static void rates_and_loads_may_be_next_to_nothing(void **state)
{
    (void)state;
    static const double least[] = {1e-300, 1e-15, 1e-9};
    for (int k = 0; k < 3; k++) {
        ll_bottleneck slow = queue_of(least[k], LL_DISCIPLINE_TAIL_DROP),
                      quiet = queue_of(12000, LL_DISCIPLINE_TAIL_DROP);
        slow.params.cross_load_pct = quiet.params.cross_load_pct = least[k];
        for (ll_time now = 0; now < 3600 * LL_SECOND; now += 100 * LL_SECOND) {
            assert_true(ll_bottleneck_enter(&slow, now, 100, false).dropped);
            assert_true(ll_bottleneck_enter(&quiet, now, 1500, false).leaves == now + LL_MS);
        }
        assert_true(slow.crossed == 0 && quiet.crossed == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cross_traffic_makes_an_m_d_1_queue),
        cmocka_unit_test(rates_and_loads_may_be_next_to_nothing),
        cmocka_unit_test(codel_drops_at_its_times),
        cmocka_unit_test(codel_marks_at_its_times),
        cmocka_unit_test(codel_keeps_bursts),
        cmocka_unit_test(red_drops_its_share),
        cmocka_unit_test(red_has_two_thresholds),
        cmocka_unit_test(the_limit_drops_under_every_discipline),
        cmocka_unit_test(the_table_is_sound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
