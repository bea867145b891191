/* The loss models against the theory of Markov chains: 1,000,000 packets, three times the standard error.
 *
 * Successive losses are correlated, so the errors are those of the means of batches (harness.h); the
 * correlation is gone after about 100 packets, a batch has 10,000. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/harness.h"
#include "link/stages/stage.h"

#define COUNT 1000000

typedef struct series {
    double lost[COUNT], first[COUNT]; /* of a run: 1 or 0 */
} series;

static series *run(const ll_link_params *params, ll_link_stats *stats)
{
    ll_link *link = link_open(100, 2000, 2, 3);
    ll_sending *sendings = link_send_many(link, params, 100, COUNT);
    series *s = calloc(1, sizeof *s);
    for (int64_t i = 0; i < COUNT; i++) {
        s->lost[i] = sendings[i].fate == LL_FATE_LOST;
        s->first[i] = s->lost[i] > 0 && (i == 0 || s->lost[i - 1] <= 0);
    }
    *stats = *ll_link_get_stats(link);
    free(sendings);
    free(link);
    return s;
}

/* A ratio of two means: its error is that of one minus the ratio times the other. */
static estimate ratio_of(const double *a, const double *b)
{
    double top = estimate_of(a, COUNT).mean, bottom = estimate_of(b, COUNT).mean;
    double *rest = malloc(COUNT * sizeof *rest);
    for (int64_t i = 0; i < COUNT; i++)
        rest[i] = a[i] - top / bottom * b[i];
    double error = estimate_of(rest, COUNT).error / bottom;
    free(rest);
    return (estimate){top / bottom, error};
}

static void assert_losses(const ll_link_params *params, double rate, double burst)
{
    ll_link_stats stats;
    series *s = run(params, &stats);
    estimate lost = estimate_of(s->lost, COUNT), length = ratio_of(s->lost, s->first);
    assert_near(lost.mean, rate, 3 * lost.error);
    assert_near(length.mean, burst, 3 * length.error);
    assert_near((double)stats.lost / COUNT, lost.mean, 1e-12);
    assert_near((double)stats.lost / (double)stats.loss_bursts, length.mean, 1e-12 * burst);
    assert_int_equal(stats.lost_in_blackouts, 0);
    assert_true(lost.error < 0.05 * rate && length.error < 0.05 * burst); /* the test covers the case */
    free(s);
}

/* Rate p; after a loss the next is lost by p + corr (1 - p). */
static void random_losses(void **state)
{
    (void)state;
    static const double cases[][2] = {{1, 0}, {1, 50}, {10, 0}, {10, 25}, {20, 90}, {60, 70}};
    for (int i = 0; i < 6; i++) {
        ll_link_params params = link_params();
        params.loss_pct = cases[i][0];
        params.loss_corr_pct = cases[i][1];
        double p = cases[i][0] / 100, corr = cases[i][1] / 100;
        assert_losses(&params, p, 1 / ((1 - p) * (1 - corr)));
    }
}

/* The chain's own correlation is the configured one: between packets one, two and three apart it is
 * corr^k. */
static void random_losses_have_their_correlation(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.loss_pct = 20;
    params.loss_corr_pct = 60;
    ll_link_stats stats;
    series *s = run(&params, &stats);
    double *products = calloc(COUNT, sizeof *products), want = 1;
    for (int k = 1; k <= 3; k++) {
        want *= 0.6;
        for (int64_t i = 0; i + k < COUNT; i++)
            products[i] = (s->lost[i] - 0.2) * (s->lost[i + k] - 0.2) / (0.2 * 0.8);
        estimate e = estimate_of(products, COUNT);
        assert_near(e.mean, want, 3 * e.error);
    }
    free(products);
    free(s);
}

/* pi_bad = p / (p + r), loss = (1 - pi_bad) (1 - k) + pi_bad (1 - h). A run of losses begins as often as a
 * loss does not follow one; the rate at which both of two are lost follows from the state at entry and its
 * successor. */
static void gilbert_elliott_losses(void **state)
{
    (void)state;
    static const double cases[][4] = {{1, 20, 100, 0}, {5, 5, 100, 0},   {2, 10, 50, 0},
                                      {3, 30, 80, 1},  {10, 90, 100, 0}, {0.5, 40, 100, 10}};
    for (int i = 0; i < 6; i++) {
        ll_link_params params = link_params();
        params.loss_model = LL_LOSS_GEMODEL;
        params.ge_p_pct = cases[i][0];
        params.ge_r_pct = cases[i][1];
        params.ge_1h_pct = cases[i][2];
        params.ge_1k_pct = cases[i][3];
        double p = cases[i][0] / 100, r = cases[i][1] / 100, h = cases[i][2] / 100, k = cases[i][3] / 100;
        double bad = p / (p + r), loss = (1 - bad) * k + bad * h;
        double both = (1 - bad) * k * ((1 - p) * k + p * h) + bad * h * ((1 - r) * h + r * k);
        if (cases[i][2] == 100 && cases[i][3] == 0)
            assert_near(loss / (loss - both), 1 / r, 1e-12);
        assert_losses(&params, loss, loss / (loss - both));
    }
}

/* As long as p and 1-k are 0 nothing is lost, and the defaults of r and 1-h are those of netem for small p.
 */
static void gilbert_elliott_defaults(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.loss_model = LL_LOSS_GEMODEL;
    ll_link_stats stats;
    free(run(&params, &stats));
    assert_int_equal(stats.lost, 0);
    params.ge_p_pct = 1;
    assert_losses(&params, 0.01 / 1.01, 1);
}

/* The transition is drawn before the loss, the loss belongs to the state before the transition: with p = r =
 * 1 and only the bad state lossy every second packet is lost, the first not. */
static void the_state_at_entry_decides(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.loss_model = LL_LOSS_GEMODEL;
    params.ge_p_pct = params.ge_r_pct = params.ge_1h_pct = 100;
    ll_link *link = link_open(100, 2000, 2, 3);
    ll_sending *s = link_send_many(link, &params, 100, 100);
    for (int i = 0; i < 100; i++)
        assert_int_equal(s[i].fate, i % 2 ? LL_FATE_LOST : LL_FATE_DELIVERED);
    free(s);
    free(link);
}

/* pi1 p13 = pi3 p31, pi4 = pi1 p14, pi2 p23 = pi3 p32; runs begin from 1 to 3, 1 to 4 and 2 to 3. */
static void four_state_losses(void **state)
{
    (void)state;
    static const double cases[][5] = {
        {5, 95, 0, 100, 0}, {2, 20, 0, 100, 0}, {1, 10, 30, 40, 0}, {1, 10, 30, 40, 3}, {4, 50, 50, 10, 96}};
    for (int i = 0; i < 5; i++) {
        const double *c = cases[i];
        ll_link_params params = link_params();
        params.loss_model = LL_LOSS_STATE;
        params.p13_pct = c[0];
        params.p31_pct = c[1];
        params.p32_pct = c[2];
        params.p23_pct = c[3];
        params.p14_pct = c[4];
        double of3 = c[0] / c[1], of2 = of3 * c[2] / c[3], of4 = c[4] / 100; /* over pi1 */
        double pi1 = 1 / (1 + of2 + of3 + of4);
        double loss = pi1 * (of3 + of4), begin = pi1 * (c[0] + c[4] + of2 * c[3]) / 100;
        assert_losses(&params, loss, loss / begin);
    }
}

/* A model that starts, or restarts after another one or none was used, is in its first state. */
static void models_restart_in_their_first_state(void **state)
{
    (void)state;
    ll_link_params trap = link_params(), others[2] = {link_params(), link_params()};
    trap.loss_model = LL_LOSS_GEMODEL;
    trap.ge_p_pct = 100; /* bad from the second packet on, permanently */
    trap.ge_r_pct = 0;
    others[0].loss_model = LL_LOSS_STATE;
    ll_link *link = link_open(100, 2000, 2, 3);
    for (int round = 0; round < 2; round++) {
        assert_int_equal(link_send(link, &trap, 100, 0, "", 0).fate, LL_FATE_DELIVERED);
        assert_int_equal(link_send(link, &trap, 100, 0, "", 0).fate, LL_FATE_LOST);
        assert_int_equal(link_send(link, &trap, 100, 0, "", 0).fate, LL_FATE_LOST);
        assert_int_equal(link_send(link, &others[round], 100, 0, "", 0).fate, LL_FATE_DELIVERED);
    }
    assert_int_equal(link_send(link, &trap, 100, 0, "", 0).fate, LL_FATE_DELIVERED);
    free(link);
}

/* All packets are lost in a blackout, and counted apart from the model's losses; see test_delay.c for
 * windows. */
static void blackouts_lose_everything(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.loss_pct = 10;
    params.blackout_at_ms = 500;
    params.blackout_every_ms = 2000;
    params.blackout_length_ms = 250;
    ll_link *link = link_open(100, 2000, 2, 3);
    ll_sending *s = link_send_many(link, &params, 100, 60000);
    int64_t within = 0, others = 0;
    for (int64_t i = 0; i < 60000; i++) {
        ll_time since = i * STEP - 500 * LL_MS;
        bool dark = since >= 0 && since % (2000 * LL_MS) < 250 * LL_MS;
        within += dark;
        others += !dark && s[i].fate == LL_FATE_LOST;
        if (dark)
            assert_int_equal(s[i].fate, LL_FATE_LOST);
    }
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_int_equal(within, 60000 / 8); /* 15 of 120 packets */
    assert_int_equal(stats->lost_in_blackouts, within);
    assert_int_equal(stats->lost, within + others);
    assert_near((double)others, 52500 * 0.1, 3 * sqrt(52500 * 0.1 * 0.9));
    free(s);
    free(link);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_losses),
        cmocka_unit_test(random_losses_have_their_correlation),
        cmocka_unit_test(gilbert_elliott_losses),
        cmocka_unit_test(gilbert_elliott_defaults),
        cmocka_unit_test(the_state_at_entry_decides),
        cmocka_unit_test(four_state_losses),
        cmocka_unit_test(models_restart_in_their_first_state),
        cmocka_unit_test(blackouts_lose_everything),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
