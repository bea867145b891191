/* Distributions of delays: each against closed forms and quadrature, 1,000,000 packets, three times the
 * standard error. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "link/harness.h"
#include "link/stages/stage.h"

#define COUNT 1000000
#define MIDDLE 200 /* ms, so that no delay is below zero */
#define JITTER 20.0

static double phi(double z)
{
    return exp(-z * z / 2) / sqrt(2 * acos(-1));
}

static double cdf(double z)
{
    return erfc(-z / sqrt(2)) / 2;
}

/* The variates as defined in the header, from libm; z is the normal deviate that is cut off at 4. */
static double share_below(double z)
{
    return (cdf(z) - cdf(-4)) / (1 - 2 * cdf(-4));
}

static double normal(double z)
{
    return z / sqrt(1 - 8 * phi(4) / (1 - 2 * cdf(-4)));
}

static double pareto(double z)
{
    double c = 0.999, mean = 1.5 * 0.99 / c, square = 3 * 0.9 / c;
    return (pow(1 - c * share_below(z), -1.0 / 3) - mean) / sqrt(square - mean * mean);
}

static double uniform(double z)
{
    return 2 * share_below(z) - 1;
}

static double blend(double z)
{
    return (normal(z) + 3 * pareto(z)) / 4;
}

/* Simpson's rule over the deviate; errors are below 1e-9. */
static double expectation(double (*variate)(double), int power)
{
    const int steps = 20000;
    double sum = 0, h = 8.0 / steps;
    for (int i = 0; i <= steps; i++) {
        double z = -4 + i * h, weight = i == 0 || i == steps ? 1 : i % 2 ? 4 : 2;
        sum += weight * pow(variate(z), power) * phi(z);
    }
    return sum * h / 3 / (1 - 2 * cdf(-4));
}

static double paretonormal(double z)
{
    static double sd;
    if (sd == 0)
        sd = sqrt(expectation(blend, 2));
    return blend(z) / sd;
}

/* In the order of the models. Correlations are off by as much as the files of the models state. */
static const struct {
    double (*variate)(double z);
    double variance;
    double corr_error; /* of deviate_corr */
} references[] = {
    {uniform, 1.0 / 3, 1e-9},
    {normal, 1, 1.1e-5},
    {pareto, 1, 1.4e-4},
    {paretonormal, 1, 1e-5},
};
_Static_assert(sizeof references / sizeof references[0] == LL_DISTRIBUTIONS, "a reference of each model");

static void variates_are_those_of_the_header(void **state)
{
    (void)state;
    for (int d = 0; d < LL_DISTRIBUTIONS; d++) {
        const ll_delay_model *model = &ll_delay_models[d];
        assert_near(expectation(references[d].variate, 1), 0, 1e-9);
        assert_near(expectation(references[d].variate, 2), references[d].variance, 1e-9);
        double before = -1e9;
        for (int i = -4000; i <= 4000; i++) {
            double z = i / 1000.0, u = share_below(z), got = model->variate(u);
            double slope = 1e-13 * (1 + pow(1 - 0.999 * u, -4.0 / 3)); /* of the rounding of u */
            assert_near(got, references[d].variate(z), slope + 1e-16 / (phi(z) + 1e-300));
            assert_true(got >= before && got <= model->max * (1 + 1e-12));
            before = got;
        }
        assert_near(model->variate(1), model->max, 1e-9);
    }
}

/* The delays of a link; the caller frees. */
static double *delays_of(const ll_link_params *params)
{
    ll_link *link = link_open(100, 2000, 12, 3);
    ll_sending *sendings = link_send_many(link, params, 0, COUNT);
    double *delays = malloc(COUNT * sizeof *delays);
    for (int64_t i = 0; i < COUNT; i++)
        delays[i] = ll_to_ms(sendings[i].due - i * STEP);
    const ll_link_stats *stats = ll_link_get_stats(link);
    assert_int_equal(stats->overflowed, 0);
    assert_int_equal(stats->delay.pairs, COUNT - 1);
    free(sendings);
    free(link);
    return delays;
}

static void delays_have_their_moments(void **state)
{
    (void)state;
    for (int d = 0; d < LL_DISTRIBUTIONS; d++) {
        ll_link_params params = link_params();
        params.delay_ms = MIDDLE;
        params.jitter_ms = JITTER;
        params.distribution = d;
        double *delays = delays_of(&params), mean = 0, variance = 0, most = 0;
        for (int64_t i = 0; i < COUNT; i++) {
            double x = (delays[i] - MIDDLE) / JITTER;
            mean += x / COUNT;
            variance += x * x / COUNT;
            most = larger(most, x);
        }
        double fourth = expectation(references[d].variate, 4), want = references[d].variance;
        assert_near(mean, 0, 3 * sqrt(want / COUNT));
        assert_near(variance, want, 3 * sqrt((fourth - want * want) / COUNT));
        assert_true(most <= ll_delay_models[d].max + 1e-6 && most > 0.95 * ll_delay_models[d].max);
        assert_near(ll_link_delay_max_ms(&params, 0), MIDDLE + JITTER * ll_delay_models[d].max, 1e-9);
        free(delays);
    }
}

/* Against the means of batches, see estimate_of; the fit of pareto adds 1.4e-4. */
static void assert_correlated(const ll_link_params *params, double corr)
{
    double variance = references[params->distribution].variance * JITTER * JITTER;
    double *delays = delays_of(params), *series = malloc(COUNT * sizeof *series);
    for (int64_t i = 0; i < COUNT; i++)
        series[i] = delays[i] - MIDDLE;
    estimate mean = estimate_of(series, COUNT);
    assert_near(mean.mean, 0, 3 * mean.error);
    for (int64_t i = 0; i < COUNT; i++)
        series[i] = (delays[i] - MIDDLE) * (delays[i] - MIDDLE) / variance;
    estimate square = estimate_of(series, COUNT);
    assert_near(square.mean, 1, 3 * square.error);
    for (int64_t i = 0; i + 1 < COUNT; i++)
        series[i] = (delays[i] - MIDDLE) * (delays[i + 1] - MIDDLE) / variance;
    estimate product = estimate_of(series, COUNT);
    assert_near(product.mean, corr, 3 * product.error + 1.4e-4);
    assert_true(square.error < 0.1 && product.error < 0.1); /* the test covers the case */
    free(series);
    free(delays);
}

static void correlation_leaves_mean_and_variance(void **state)
{
    (void)state;
    static const double corrs[] = {5, 25, 50, 90};
    for (int d = 0; d < LL_DISTRIBUTIONS; d++)
        for (int c = 0; c < 4; c++) {
            ll_link_params params = link_params();
            params.delay_ms = MIDDLE;
            params.jitter_ms = JITTER;
            params.distribution = d;
            params.delay_corr_pct = corrs[c];
            assert_correlated(&params, corrs[c] / 100);
        }
}

/* Variates of deviates with correlation rho have the correlation sum of c_k^2 rho^k over the variance, c_k
 * their coefficients in normalised Hermite polynomials (Mehler's formula). What TERMS leave of the variance
 * counts with the next power. */
enum { TERMS = 40 };

static double correlation_by_series(const ll_delay_model *model, double variance, double rho)
{
    const int steps = 20000;
    double c[TERMS] = {0}, h = 18.0 / steps;
    for (int i = 0; i <= steps; i++) {
        double z = -9 + i * h, weight = i == 0 || i == steps ? 1 : i % 2 ? 4 : 2;
        double x = model->variate(cdf(z)) * phi(z) * weight * h / 3, below = 0, he = 1;
        for (int k = 0; k < TERMS; k++) {
            c[k] += x * he;
            double next = (z * he - sqrt(k) * below) / sqrt(k + 1);
            below = he;
            he = next;
        }
    }
    double sum = 0, left = variance, power = 1;
    for (int k = 1; k < TERMS; k++) {
        power *= rho;
        sum += c[k] * c[k] * power;
        left -= c[k] * c[k];
    }
    return (sum + left * power * rho) / variance;
}

static void deviates_are_correlated_as_variates_need(void **state)
{
    (void)state;
    for (int d = 0; d < LL_DISTRIBUTIONS; d++)
        for (double corr = 0.05; corr < 0.96; corr += 0.1) {
            double rho = ll_delay_models[d].deviate_corr(corr);
            double got = correlation_by_series(&ll_delay_models[d], references[d].variance, rho);
            assert_near(got, corr, references[d].corr_error);
        }
}

static void the_statistics_report_the_correlation(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.delay_ms = MIDDLE;
    params.jitter_ms = JITTER;
    params.delay_corr_pct = 70;
    params.loss_pct = 10; /* pairs are those of two that were sent one after the other */
    ll_link *link = link_open(100, 2000, 12, 3);
    ll_sending *s = link_send_many(link, &params, 0, COUNT);
    double steps = 0, sum = 0, squares = 0;
    int64_t pairs = 0, n = 0;
    for (int64_t i = 0; i < COUNT; i++) {
        double x = ll_to_ms(s[i].due - i * STEP);
        if (s[i].fate != LL_FATE_DELIVERED)
            continue;
        sum += x;
        squares += x * x;
        n++;
        if (i > 0 && s[i - 1].fate == LL_FATE_DELIVERED) {
            double step = x - ll_to_ms(s[i - 1].due - (i - 1) * STEP);
            steps += step * step;
            pairs++;
        }
    }
    double mean = sum / (double)n, variance = squares / (double)n - mean * mean;
    assert_int_equal(ll_link_get_stats(link)->delay.pairs, pairs);
    double told = ll_link_delay_correlation(ll_link_get_stats(link));
    assert_near(told, 1 - steps / (double)pairs / (2 * variance), 1e-6);
    assert_near(told, 0.7, 0.003);
    free(s);
    free(link);
}

static void a_plain_link_has_no_correlation(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.delay_ms = MIDDLE;
    ll_link *link = link_open(100, 2000, 12, 3);
    assert_true(ll_link_delay_correlation(ll_link_get_stats(link)) == 0);
    free(link_send_many(link, &params, 0, 1000));
    assert_true(ll_link_delay_correlation(ll_link_get_stats(link)) == 0);
    free(link);
}

/* Within a spike it is added, before and after it not; the window's start belongs to it, its end does not. */
static void spikes_have_their_windows(void **state)
{
    (void)state;
    ll_link_params params = link_params();
    params.spike_at_ms = 1000;
    params.spike_length_ms = 50;
    params.spike_add_ms = 300;
    static const struct {
        double every, ms;
        bool within;
    } cases[] = {{0, 999.999, false}, {0, 1000, true},    {0, 1049.999, true}, {0, 1050, false},
                 {0, 2000, false},    {400, 999, false},  {400, 1049, true},   {400, 1399.999, false},
                 {400, 1400, true},   {400, 1450, false}, {400, 401001, true}, {50, 1e6, true},
                 {50, 999, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_link *link = link_open(10, 1000, 1, 1);
        params.spike_every_ms = cases[i].every;
        ll_time now = ll_ms(cases[i].ms);
        double delay = ll_to_ms(link_send(link, &params, 20, now, "", 0).due - now);
        assert_true(delay == (cases[i].within ? 320 : 20));
        free(link);
    }
    assert_true(ll_link_delay_max_ms(&params, 20) == 320);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(variates_are_those_of_the_header),
        cmocka_unit_test(delays_have_their_moments),
        cmocka_unit_test(correlation_leaves_mean_and_variance),
        cmocka_unit_test(deviates_are_correlated_as_variates_need),
        cmocka_unit_test(the_statistics_report_the_correlation),
        cmocka_unit_test(a_plain_link_has_no_correlation),
        cmocka_unit_test(spikes_have_their_windows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
