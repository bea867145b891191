/* Duplicates, reordering and corruption: rates and correlations over 1,000,000 packets within three times the
 * standard error, and the fate of each packet. Errors of correlated series are those of the means of batches
 * (harness.h). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/harness.h"

#define COUNT 1000000

typedef bool happened(const ll_sending *s);

static bool is_duplicated(const ll_sending *s)
{
    return s->duplicated;
}

static bool is_reordered(const ll_sending *s)
{
    return s->reordered;
}

static bool is_corrupted(const ll_sending *s)
{
    return s->fate == LL_FATE_CORRUPTED;
}

static void assert_chain(const ll_link_params *params, happened *happens, double rate, double corr)
{
    ll_link *link = link_open(200, 4000, 2, 3);
    ll_sending *s = link_send_many(link, params, 100, COUNT);
    double *x = calloc(COUNT, sizeof *x);
    for (int64_t i = 0; i < COUNT; i++)
        x[i] = happens(&s[i]);
    estimate e = estimate_of(x, COUNT);
    assert_near(e.mean, rate, 3 * e.error);
    for (int64_t i = 0; i + 1 < COUNT; i++)
        x[i] = (happens(&s[i]) - rate) * (happens(&s[i + 1]) - rate) / (rate * (1 - rate));
    e = estimate_of(x, COUNT);
    assert_near(e.mean, corr, 3 * e.error);
    free(x);
    free(s);
    free(link);
}

static void rates_and_correlations(void **state)
{
    (void)state;
    static const double cases[][2] = {{2, 0}, {10, 0}, {10, 40}, {50, 80}};
    for (int i = 0; i < 4; i++) {
        double percent = cases[i][0], corr = cases[i][1];
        ll_link_params params = link_params();
        params.duplicate_pct = percent;
        params.duplicate_corr_pct = corr;
        assert_chain(&params, is_duplicated, percent / 100, corr / 100);
        params = link_params();
        params.delay_ms = 10;
        params.reorder_pct = percent;
        params.reorder_corr_pct = corr;
        assert_chain(&params, is_reordered, percent / 100, corr / 100);
        params = link_params();
        params.corrupt_pct = percent;
        params.corrupt_corr_pct = corr;
        assert_chain(&params, is_corrupted, percent / 100, corr / 100);
    }
}

/* `reorder 100% gap 5` of tc-netem(8): every 5th packet (5th, 10th, ...) is sent at once, the others are
 * delayed. */
static void a_gap_picks_every_nth(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.delay_ms = 10;
    params.reorder_pct = 100;
    params.reorder_gap = 5;
    ll_link *link = link_open(100, 2000, 2, 3);
    ll_sending *s = link_send_many(link, &params, 30, 100);
    for (int i = 0; i < 100; i++) {
        assert_int_equal(s[i].reordered, i % 5 == 4);
        assert_int_equal(s[i].due - i * STEP, (i % 5 == 4 ? 30 : 40) * LL_MS);
    }
    assert_int_equal(ll_link_get_stats(link)->reordered_ahead, 20);
    free(s);
    free(link);
}

/* Between two reordered packets are gap - 1 packets that cannot be, then a geometric number of tries: mean
 * gap - 1 + 1 / p. */
static void a_gap_and_a_share(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.delay_ms = 10;
    params.reorder_pct = 25;
    params.reorder_gap = 4;
    ll_link *link = link_open(100, 2000, 2, 3);
    ll_sending *s = link_send_many(link, &params, 30, COUNT);
    int64_t last = -1, picked = 0, least = COUNT;
    for (int64_t i = 0; i < COUNT; i++) {
        if (!s[i].reordered)
            continue;
        least = i - last < least ? i - last : least;
        last = i;
        picked++;
    }
    double mean = 4 - 1 + 4, variance = 0.75 / (0.25 * 0.25); /* of the distance */
    assert_int_equal(least, 4);
    assert_near((double)(last + 1) / (double)picked, mean, 3 * sqrt(variance / (double)picked));
    free(s);
    free(link);
}

/* A reordered packet takes 5 ms instead of 85, a difference of 5.1 steps: it overtakes four. */
static void reordered_packets_overtake(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.delay_ms = 80;
    params.reorder_pct = 100;
    params.reorder_gap = 10;
    ll_link *link = link_open(100, 9000, 2, 3);
    int64_t order[60], n = 0;
    ll_time sent, due;
    for (int64_t i = 0; i < 60; i++) {
        packet_send(link, &params, 5, i * STEP, i);
        for (int64_t number; (number = packet_receive(link, i * STEP, &sent, &due)) >= 0;)
            order[n++] = number;
    }
    static const int64_t want[] = {0, 1, 2, 3, 4, 9, 5, 6, 7, 8, 10, 11, 12, 13, 14, 19, 15};
    for (int i = 0; i < 17; i++)
        assert_int_equal(order[i], want[i]);
    assert_int_equal(ll_link_get_stats(link)->reordered_ahead, 6);
    assert_int_equal(ll_link_get_stats(link)->reordered, 5 * 4); /* the last has yet to overtake */
    free(link);
}

/* A corrupted packet takes its time but is not delivered; its copy is corrupted or not independently. */
static void corrupted_packets_do_not_arrive(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.duplicate_pct = 100;
    params.corrupt_pct = 30;
    params.jitter_ms = 5;
    ll_link *link = link_open(200, 40000, 2, 3);
    int64_t handed_over = 0, arrive = 0, both = 0, corrupted = 0;
    ll_time sent, due;
    for (int64_t i = 0; i < COUNT / 10; i++) {
        ll_sending s = packet_send(link, &params, 50, i * STEP, i);
        assert_true(s.due >= i * STEP + 45 * LL_MS && s.due < i * STEP + 55 * LL_MS);
        arrive += (s.fate == LL_FATE_DELIVERED) + (s.copy_fate == LL_FATE_DELIVERED);
        corrupted += (s.fate == LL_FATE_CORRUPTED) + (s.copy_fate == LL_FATE_CORRUPTED);
        both += s.fate == LL_FATE_CORRUPTED && s.copy_fate == LL_FATE_CORRUPTED;
        while (packet_receive(link, i * STEP, &sent, &due) >= 0)
            handed_over++;
    }
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_int_equal(handed_over + ll_link_in_flight(link), arrive);
    assert_int_equal(stats->delivered, handed_over);
    assert_int_equal(stats->corrupted, corrupted);
    assert_int_equal(ll_link_put_on_way(stats), arrive);
    double n = COUNT / 10.0;
    assert_near((double)both / n, 0.09, 3 * sqrt(0.09 * 0.91 / n));
    free(link);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rates_and_correlations),
        cmocka_unit_test(a_gap_picks_every_nth),
        cmocka_unit_test(a_gap_and_a_share),
        cmocka_unit_test(reordered_packets_overtake),
        cmocka_unit_test(corrupted_packets_do_not_arrive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
