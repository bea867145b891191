/* Messages longer than mtu_bytes: their cost, their delay, and their loss. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/harness.h"

#define COUNT 50000
#define LAG 50.0

static char bytes[20000], received[20000];

static ll_link *open_wide(uint64_t seed)
{
    return link_open(60, 60 * (int)sizeof bytes, seed, 4);
}

static void drain(ll_link *link)
{
    ll_time sent, due;
    while (ll_link_receive(link, LL_NEVER - 1, received, (int)sizeof received, &sent, &due) >= 0)
        ;
}

static ll_sending send(ll_link *link, const ll_link_params *params, ll_time now, int size)
{
    drain(link);
    return link_send(link, params, LAG, now, bytes, size);
}

static void assert_share(int64_t count, int64_t of, double share)
{
    assert_near((double)count / (double)of, share, 4 * sqrt(share * (1 - share) / (double)of) + 1e-12);
}

static void so_many_as_it_takes(void **state)
{
    (void)state;
    static const int cases[][3] = {/* size, mtu, fragments */
                                   {1200, 1200, 1},   {1201, 1200, 2}, {2400, 1200, 2},  {2401, 1200, 3},
                                   {11400, 1200, 10}, {64, 64, 1},     {65, 64, 2},      {20000, 64, 313},
                                   {20000, 0, 1},     {0, 64, 1},      {20000, 65507, 1}};
    for (int i = 0; i < 11; i++)
        for (int lossy = 0; lossy < 2; lossy++) {
            ll_link_params params = link_params();
            params.mtu_bytes = cases[i][1];
            params.jitter_ms = lossy;
            ll_link *link = open_wide(1);
            for (int k = 0; k < 3; k++)
                assert_int_equal(send(link, &params, k * STEP, cases[i][0]).fragments, cases[i][2]);
            const ll_link_stats *s = ll_link_get_stats(link);
            int split = cases[i][2] > 1;
            assert_int_equal(s->sent, 3 * cases[i][2]);
            assert_int_equal(ll_link_messages(s), 3);
            assert_int_equal(s->fragments.split, 3 * split);
            assert_int_equal(s->fragments.count, split ? 3 * cases[i][2] : 0);
            assert_int_equal(s->bytes, 3 * cases[i][0]);
            assert_int_equal(ll_link_put_on_way(s), s->sent);
            assert_int_equal(s->delivered + ll_link_in_flight(link), 3);
            assert_true(s->messages_lost == 0 && s->fragments.split_lost == 0 && s->fragments.lost == 0);
            free(link);
        }
}

/* A message is lost with any of its fragments: 1 - (1 - p)^n; with duplicates p (1 - q) replaces p. */
static void lost_with_any_of_them(void **state)
{
    (void)state;
    static const struct {
        int size, packets;
        double loss, duplicate;
    } cases[] = {{9600, 8, 5, 0}, {9599, 8, 5, 0}, {3600, 3, 20, 0}, {2400, 2, 11, 40}, {19200, 16, 3, 70}};
    for (int i = 0; i < 5; i++) {
        ll_link_params params = link_params();
        params.loss_pct = cases[i].loss;
        params.duplicate_pct = cases[i].duplicate;
        ll_link *link = open_wide(7);
        int64_t lost = 0;
        for (int64_t k = 0; k < COUNT; k++) {
            ll_sending s = send(link, &params, k * STEP, cases[i].size);
            assert_false(s.duplicated);
            lost += s.fate == LL_FATE_LOST;
        }
        double p = cases[i].loss / 100 * (1 - cases[i].duplicate / 100);
        const ll_link_stats *s = ll_link_get_stats(link);
        assert_share(lost, COUNT, 1 - pow(1 - p, cases[i].packets));
        assert_share(s->fragments.lost, s->fragments.count, p);
        assert_int_equal(s->messages_lost, lost);
        assert_int_equal(s->fragments.split_lost, lost);
        drain(link);
        assert_int_equal(s->delivered, COUNT - lost); /* once, with any duplicates */
        free(link);
    }
}

/* Of n independent uniform delays the longest is on average at (n - 1) / (n + 1) of the half-width, and its
 * variance is 4 n / ((n + 1)^2 (n + 2)) of the square. */
static void due_with_the_last_of_them(void **state)
{
    (void)state;
    for (int n = 1; n <= 12; n += n < 3 ? 1 : 3) {
        ll_link_params params = link_params();
        params.jitter_ms = 40;
        params.mtu_bytes = 500;
        ll_link *link = open_wide(8);
        double sum = 0;
        for (int64_t k = 0; k < COUNT; k++) {
            ll_sending s = send(link, &params, k * STEP, 500 * n);
            assert_int_equal(s.fate, LL_FATE_DELIVERED);
            sum += ll_to_ms(s.due - k * STEP) - LAG;
        }
        double variance = 4.0 * n / ((n + 1) * (n + 1) * (n + 2)) * 1600;
        assert_near(sum / COUNT, 40.0 * (n - 1) / (n + 1), 4 * sqrt(variance / COUNT));
        const ll_link_stats *s = ll_link_get_stats(link);
        assert_near(s->delay.sum_ms / (double)s->sent, LAG, 4 * sqrt(1600.0 / 3 / (double)s->sent));
        free(link);
    }
}

/* Of a duplicated fragment the first to arrive counts: the mean of the earlier of two is a third of the
 * half-width before the middle. */
static void duplicates_only_change_the_time(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.jitter_ms = 30;
    params.duplicate_pct = 100;
    ll_link *link = open_wide(9);
    double sum = 0, squares = 0; /* later of two, each the earlier of two: mean -1/15, by integration */
    for (int64_t k = 0; k < COUNT; k++) {
        double x = ll_to_ms(send(link, &params, k * STEP, 2400).due - k * STEP) - LAG;
        sum += x;
        squares += x * x;
    }
    double mean = sum / COUNT, error = sqrt((squares / COUNT - mean * mean) / COUNT);
    assert_near(mean, -30.0 / 15, 4 * error);
    drain(link);
    assert_int_equal(ll_link_get_stats(link)->delivered, COUNT);
    free(link);
}

/* Each fragment takes its own headers through the queue: 28 and 4 bytes. */
static void fragments_queue_one_by_one(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.rate_kbps = 80; /* 10 bytes a ms */
    params.limit_ms = 1000;
    params.mtu_bytes = 500;
    ll_link *link = open_wide(1);
    assert_int_equal(send(link, &params, 0, 500).due,
                     ll_ms(LAG + 52.8)); /* one packet has no fragment's header */
    assert_int_equal(send(link, &params, LL_SECOND, 1200).due, LL_SECOND + ll_ms(LAG + 120 + 3 * 3.2));
    assert_int_equal(send(link, &params, LL_SECOND, 10).due, LL_SECOND + ll_ms(LAG + 120 + 3 * 3.2 + 3.8));
    params.packet_overhead_bytes = 0;
    assert_int_equal(send(link, &params, 3 * LL_SECOND, 1001).due,
                     3 * LL_SECOND + ll_ms(LAG + 100.1 + 3 * 0.4));
    free(link);
    /* the fourth of 53.2 ms finds the queue full, and the message is lost with it; the others still take
     * their time */
    params.packet_overhead_bytes = 28;
    params.limit_ms = 200;
    link = open_wide(1);
    ll_sending s = send(link, &params, 0, 2000);
    assert_true(s.fate == LL_FATE_OVERFLOW && s.due == 0 && s.fragments == 4);
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_true(stats->queue_drops == 1 && stats->queue.count == 3 && stats->fragments.lost == 1);
    assert_int_equal(send(link, &params, 0, 10).due, ll_ms(LAG + 3 * 53.2 + 3.8));
    free(link);
}

/* A message takes one slot and its bytes once, in any number of fragments; without room all of it is
 * dropped. */
static void a_message_takes_one_place(void **state)
{
    (void)state;
    for (int lossy = 0; lossy < 2; lossy++) {
        ll_link_params params = link_params();
        params.jitter_ms = lossy;
        ll_link *link = link_open(3, 10000, 1, 1);
        ll_time sent, due;
        for (int i = 0; i < 4; i++)
            assert_int_equal(link_send(link, &params, 10, i, bytes, 3000).fate,
                             i < 3 ? LL_FATE_DELIVERED : LL_FATE_OVERFLOW);
        assert_int_equal(ll_link_in_flight(link), 3);
        const ll_link_stats *s = ll_link_get_stats(link);
        assert_true(s->overflowed == 3 && s->fragments.lost == 3 && s->fragments.split_lost == 1);
        assert_int_equal(ll_link_put_on_way(s), 9);
        for (int i = 0; i < 3; i++)
            assert_int_equal(ll_link_receive(link, LL_SECOND, received, 3000, &sent, &due), 3000);
        assert_int_equal(ll_link_in_flight(link), 0);
        free(link);
    }
}

/* The received bytes are the sent ones, in the order of the last fragments. */
static void the_bytes_are_put_together(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.jitter_ms = 200;
    params.loss_pct = 1;
    params.duplicate_pct = 20;
    params.mtu_bytes = 100;
    ll_link *link = open_wide(3);
    ll_time last = 0, sent, due;
    int64_t got = 0, lost = 0;
    for (int64_t i = 0; i < 5000; i++) {
        int size = 8 + (int)(i * 37 % 2500);
        memset(bytes, (int)(i % 251), sizeof bytes);
        memcpy(bytes, &i, sizeof i);
        ll_sending s = link_send(link, &params, 250, i * STEP, bytes, size);
        lost += s.fragments > 1 && s.fate != LL_FATE_DELIVERED;
        for (int n;
             (n = ll_link_receive(link, i * STEP, received, (int)sizeof received, &sent, &due)) >= 0;) {
            int64_t k;
            memcpy(&k, received, sizeof k);
            assert_int_equal(n, 8 + (int)(k * 37 % 2500));
            for (int b = 8; b < n; b++)
                assert_int_equal((unsigned char)received[b], k % 251);
            assert_true(sent == k * STEP && due >= last);
            last = due;
            got++;
        }
    }
    assert_true(got > 3000 && lost > 300 && ll_link_get_stats(link)->reordered > 1000);
    assert_int_equal(ll_link_get_stats(link)->fragments.split_lost, lost);
    free(link);
}

/* A message's first packet has the draws of a message that is not split, so that other sizes do not change
 * the fates of messages that fit: two encodings of a snapshot have the same losses. */
static void sizes_leave_the_draws_of_others(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.jitter_ms = 30;
    params.loss_pct = 10;
    params.corrupt_pct = 5;
    ll_link *small = open_wide(5), *large = open_wide(5);
    int compared = 0;
    for (int64_t i = 0; i < COUNT; i++) {
        ll_sending a = send(small, &params, i * STEP, 100),
                   b = send(large, &params, i * STEP, i % 4 ? 100 : 5000);
        if (i % 4 != 0) {
            assert_true(a.fate == b.fate && a.due == b.due);
        } else if (a.fate != LL_FATE_DELIVERED) {
            assert_int_equal(a.fate, b.fate);
        } else if (b.fate == LL_FATE_DELIVERED) {
            assert_true(b.due >= a.due);
            compared++;
        }
    }
    assert_true(compared > COUNT / 20);
    free(small);
    free(large);
}

/* Switching a stage on does not change the times of messages that it does not touch. */
static void stages_leave_the_draws_of_fragments(void **state)
{
    (void)state;
    ll_link_params plain = link_params();
    plain.jitter_ms = 45;
    plain.distribution = LL_DISTRIBUTION_PARETO;
    ll_link_params lossy = plain, damaged = plain, doubled = plain;
    lossy.loss_pct = 6;
    damaged.corrupt_pct = 6;
    doubled.duplicate_pct = 30;
    ll_link *links[] = {open_wide(12), open_wide(12), open_wide(12), open_wide(12)};
    const ll_link_params *params[] = {&plain, &lossy, &damaged, &doubled};
    int64_t compared[4] = {0};
    for (int64_t i = 0; i < COUNT / 5; i++) {
        ll_sending s[4];
        for (int k = 0; k < 4; k++)
            s[k] = send(links[k], params[k], i * STEP, 7000);
        for (int k = 1; k < 3; k++)
            if (s[k].fate == LL_FATE_DELIVERED) {
                assert_int_equal(s[k].due, s[0].due);
                compared[k]++;
            }
        assert_true(s[3].due <= s[0].due); /* a copy can only arrive earlier */
        compared[3] += s[3].due == s[0].due;
    }
    for (int k = 1; k < 4; k++)
        assert_true(compared[k] > COUNT / 10);
    for (int k = 0; k < 4; k++)
        free(links[k]);
}

/* Fragments follow each other in a chain as packets do: a burst takes several of one message, so that fewer
 * messages are lost than by independent losses of the same share. */
static void bursts_go_on_from_fragment_to_fragment(void **state)
{
    (void)state;
    const double p = 0.08, corr = 0.7;
    ll_link_params params = link_params();
    params.loss_pct = 100 * p;
    params.loss_corr_pct = 100 * corr;
    ll_link *link = open_wide(6);
    int64_t lost = 0;
    double *x = calloc(COUNT, sizeof *x);
    for (int64_t i = 0; i < COUNT; i++) {
        x[i] = send(link, &params, i * STEP, 6000).fate == LL_FATE_LOST;
        lost += x[i] > 0;
    }
    double none =
        (1 - p) * pow(1 - p * (1 - corr), 4); /* of five: the first, then four after one that came */
    assert_near((double)lost / COUNT, 1 - none, 4 * estimate_of(x, COUNT).error);
    const ll_link_stats *s = ll_link_get_stats(link);
    assert_near((double)s->lost / (double)s->loss_bursts, 1 / ((1 - p) * (1 - corr)), 0.1);
    free(x);
    free(link);
}

/* Corrupted: the message's time is that of the damaged fragment. */
static void damaged_with_any_of_them(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.corrupt_pct = 7;
    ll_link *link = open_wide(2);
    int64_t damaged = 0;
    for (int64_t i = 0; i < COUNT; i++) {
        ll_sending s = send(link, &params, i * STEP, 4700);
        assert_int_equal(s.due, i * STEP + ll_ms(LAG));
        damaged += s.fate == LL_FATE_CORRUPTED;
    }
    assert_share(damaged, COUNT, 1 - pow(0.93, 4));
    assert_share(ll_link_get_stats(link)->corrupted, 4 * COUNT, 0.07);
    free(link);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(so_many_as_it_takes),
        cmocka_unit_test(lost_with_any_of_them),
        cmocka_unit_test(due_with_the_last_of_them),
        cmocka_unit_test(duplicates_only_change_the_time),
        cmocka_unit_test(fragments_queue_one_by_one),
        cmocka_unit_test(a_message_takes_one_place),
        cmocka_unit_test(the_bytes_are_put_together),
        cmocka_unit_test(sizes_leave_the_draws_of_others),
        cmocka_unit_test(stages_leave_the_draws_of_fragments),
        cmocka_unit_test(bursts_go_on_from_fragment_to_fragment),
        cmocka_unit_test(damaged_with_any_of_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
