/* Averages of the link, against closed forms: 100,000 packets, four times the standard error. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/harness.h"

#define COUNT 100000

typedef struct tally {
    int64_t lost, duplicated; /* by their draws: copies have their own unless the loss took one of two */
    int64_t arrived[3];       /* packets by number of arrivals */
    double n, mean, variance, copy_mean, least, most;
    double original_mean; /* of those that were duplicated */
} tally;

/* Sends COUNT packets and collects their delays in ms, as the sendings report them. */
static tally run(const ll_link_params *params, double lag_ms, uint64_t seed)
{
    ll_link *link = link_open(60, 4000, seed, 3);
    tally t = {.least = 1e9};
    double sum = 0, squares = 0, copies = 0, originals = 0;
    ll_time sent, due;
    for (int64_t i = 0; i < COUNT; i++) {
        ll_time now = i * STEP;
        ll_sending s = packet_send(link, params, lag_ms, now, i);
        bool first = s.fate == LL_FATE_DELIVERED, second = s.duplicated && s.copy_fate == LL_FATE_DELIVERED;
        t.lost += !first + (s.duplicated && !second);
        t.duplicated += s.duplicated;
        t.arrived[first + second]++;
        if (s.fate == LL_FATE_DELIVERED) {
            double delay = ll_to_ms(s.due - now);
            sum += delay;
            squares += delay * delay;
            t.n++;
            t.least = smaller(t.least, delay);
            t.most = larger(t.most, delay);
            if (second) {
                originals += delay;
                copies += ll_to_ms(s.copy_due - now);
            }
        }
        while (packet_receive(link, now, &sent, &due) >= 0)
            ;
    }
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_int_equal(stats->overflowed, 0);
    assert_int_equal(stats->sent, COUNT);
    assert_int_equal(stats->lost, t.lost);
    assert_int_equal(stats->duplicated, t.duplicated);
    assert_int_equal(stats->delivered + ll_link_in_flight(link), COUNT - t.lost + t.duplicated);
    if (t.duplicated == 0) {
        assert_near(stats->delay.sum_ms, sum, 1e-9 * sum + 1e-3);
        assert_near(stats->delay.sum_squares, squares, 1e-9 * squares + 1e-3);
        assert_near(stats->delay.min_ms, t.least, 1e-6);
        assert_near(stats->delay.max_ms, t.most, 1e-6);
    }
    t.mean = sum / t.n;
    t.variance = squares / t.n - t.mean * t.mean;
    t.copy_mean = t.arrived[2] > 0 ? copies / (double)t.arrived[2] : 0;
    t.original_mean = t.arrived[2] > 0 ? originals / (double)t.arrived[2] : 0;
    free(link);
    return t;
}

static void without_impairments_the_delay_is_exact(void **state)
{
    (void)state;
    ll_link_params params = {.delay_ms = 12.5};
    tally t = run(&params, 100, 1);
    assert_true(t.least == 112.5 && t.most == 112.5 && t.n == COUNT && t.duplicated == 0);
}

static void uniform_jitter_has_its_moments(void **state)
{
    (void)state;
    static const double widths[] = {1, 20, 245};
    for (int i = 0; i < 3; i++) {
        ll_link_params params = {.delay_ms = 55, .jitter_ms = widths[i]};
        tally t = run(&params, 200, 1);
        double variance = widths[i] * widths[i] / 3;
        assert_true(t.least >= 255 - widths[i] && t.most < 255 + widths[i]);
        assert_true(t.least < 255 - 0.999 * widths[i] && t.most > 255 + 0.999 * widths[i]);
        assert_near(t.mean, 255, 4 * sqrt(variance / COUNT));
        assert_near(t.variance, variance, 4 * variance * sqrt(0.8 / COUNT)); /* kurtosis 1.8 */
    }
}

static void normal_jitter_has_its_moments(void **state)
{
    (void)state;
    ll_link_params params = {.jitter_ms = 30, .distribution = LL_DISTRIBUTION_NORMAL};
    tally t = run(&params, 300, 1);
    assert_near(t.mean, 300, 4 * 30 / sqrt(COUNT));
    assert_near(t.variance, 900, 4 * 900 * sqrt(2.0 / COUNT));
    assert_true(t.least < 300 - 3.5 * 30 && t.most > 300 + 3.5 * 30);
}

/* A delay below zero counts as zero: half of the draws, and the mean of the other half is jitter / sqrt(2
 * pi). */
static void delays_are_not_negative(void **state)
{
    (void)state;
    ll_link_params params = {.jitter_ms = 50, .distribution = LL_DISTRIBUTION_NORMAL};
    tally t = run(&params, 0, 1);
    double mean = 50 / sqrt(2 * acos(-1)), variance = 2500.0 / 2 - mean * mean;
    assert_true(t.least == 0);
    assert_near(t.mean, mean, 4 * sqrt(variance / COUNT));
}

static void assert_rate(int64_t count, double of, double rate)
{
    assert_near((double)count, of * rate, 4 * sqrt(of * rate * (1 - rate)));
}

static void loss_and_duplicates_have_their_rates(void **state)
{
    (void)state;
    static const double percents[] = {0, 1, 20, 99, 100};
    for (int i = 0; i < 5; i++) {
        double rate = percents[i] / 100;
        ll_link_params params = {.loss_pct = percents[i]};
        assert_rate(run(&params, 100, 5).lost, COUNT, rate);
        params = (ll_link_params){.duplicate_pct = percents[i]};
        assert_rate(run(&params, 100, 6).duplicated, COUNT, rate);
    }
    /* copies are delayed by draws of their own */
    ll_link_params params = {.jitter_ms = 40, .loss_pct = 30, .duplicate_pct = 20};
    tally t = run(&params, 100, 7);
    assert_rate(t.duplicated, COUNT, 0.2);
    double variance = 1600.0 / 3;
    assert_near(t.copy_mean, 100, 4 * sqrt(variance / (double)t.arrived[2]));
    /* fate and delay are independent */
    assert_near(t.mean, 100, 4 * sqrt(variance / t.n));
    assert_near(t.original_mean, 100, 4 * sqrt(variance / (double)t.arrived[2]));
}

/* netem duplicates first, and one loss takes one of two: neither arrives by p (1 - q), both by q (1 - p)^2.
 * So a duplicate replaces the packet that the loss takes. */
static void a_loss_takes_one_of_two(void **state)
{
    (void)state;
    static const double cases[][2] = {{30, 50}, {20, 40}, {5, 90}, {65, 15}, {100, 35}, {40, 100}};
    for (int i = 0; i < 6; i++) {
        double p = cases[i][0] / 100, q = cases[i][1] / 100;
        ll_link_params params = {.loss_pct = cases[i][0], .duplicate_pct = cases[i][1]};
        tally t = run(&params, 100, 11);
        assert_rate(t.arrived[0], COUNT, p * (1 - q));
        assert_rate(t.arrived[2], COUNT, q * (1 - p) * (1 - p));
    }
}

/* The reported share of losses is compared with the configured one: of all draws the share that took a
 * packet. */
static void the_share_of_losses_is_that_of_their_draws(void **state)
{
    (void)state;
    ll_link_params params = {.loss_pct = 25, .duplicate_pct = 60};
    ll_link *link = link_open(60, 4000, 3, 3);
    free(link_send_many(link, &params, 100, COUNT));
    const ll_link_stats *s = ll_link_get_stats(link);
    double draws = COUNT * (1 + 0.6 * 0.75); /* a copy has one where its original was not lost */
    assert_near(ll_link_loss_pct(s), 25, 400 * sqrt(0.25 * 0.75 / draws));
    assert_rate(s->rescued, COUNT, 0.25 * 0.6);
    assert_rate(s->lost_copies, COUNT * 0.6, 0.75 * 0.25);
    assert_rate(s->messages_lost, COUNT, 0.25 * 0.4);
    assert_int_equal(ll_link_messages(s), COUNT);
    assert_near((double)(s->lost - s->lost_copies) / (double)s->loss_bursts, 1 / 0.75, 0.01);
    assert_int_equal(s->delivered, ll_link_put_on_way(s));
    free(link);
}

/* In a blackout both are gone. */
static void a_blackout_takes_both(void **state)
{
    (void)state;
    ll_link_params params = {.loss_pct = 30, .duplicate_pct = 70, .blackout_length_ms = 1e7};
    ll_link *link = link_open(60, 4000, 3, 3);
    ll_sending *s = link_send_many(link, &params, 100, 1000);
    for (int i = 0; i < 1000; i++)
        assert_true(s[i].fate == LL_FATE_LOST && !s[i].rescued &&
                    (!s[i].duplicated || s[i].copy_fate == LL_FATE_LOST));
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_true(stats->duplicated > 600 && stats->lost == 1000 + stats->duplicated);
    assert_int_equal(stats->lost_in_blackouts, stats->lost);
    assert_int_equal(stats->loss_bursts, 1);
    assert_int_equal(ll_link_put_on_way(stats), 0);
    assert_true(ll_link_loss_pct(stats) == 100);
    free(s);
    free(link);
}

/* Lag one of the fates: a packet's fate is independent of that of the next. */
static void losses_do_not_come_in_bursts(void **state)
{
    (void)state;
    ll_link *link = link_open(100, 10000, 1, 3);
    ll_link_params params = {.loss_pct = 10};
    ll_time sent, due;
    int64_t pairs = 0;
    bool before = false;
    for (int64_t i = 0; i < COUNT; i++) {
        bool lost = packet_send(link, &params, 0, i * STEP, i).fate == LL_FATE_LOST;
        pairs += lost && before;
        before = lost;
        while (packet_receive(link, i * STEP, &sent, &due) >= 0)
            ;
    }
    assert_rate(pairs, COUNT, 0.01);
    free(link);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_impairments_the_delay_is_exact),
        cmocka_unit_test(uniform_jitter_has_its_moments),
        cmocka_unit_test(normal_jitter_has_its_moments),
        cmocka_unit_test(delays_are_not_negative),
        cmocka_unit_test(loss_and_duplicates_have_their_rates),
        cmocka_unit_test(a_loss_takes_one_of_two),
        cmocka_unit_test(the_share_of_losses_is_that_of_their_draws),
        cmocka_unit_test(a_blackout_takes_both),
        cmocka_unit_test(losses_do_not_come_in_bursts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
