#include "experiment/statistics/distributions.h"

#include <math.h>

#include "base/assert.h"
#include "base/detmath.h"

#define TINY 1e-300
#define EXACT 1e-16 /* relative change at which a series or a search has converged */

enum { TERMS_MAX = 20000, HALVINGS_MAX = 1200 };

/* Lanczos' approximation with g = 7 and nine terms (Godfrey's coefficients): relative error about 1e-15. */
static double log_gamma(double x)
{
    static const double c[] = {0.99999999999980993,  676.5203681218851,     -1259.1392167224028,
                               771.32342877765313,   -176.61502916214059,   12.507343278686905,
                               -0.13857109526572012, 9.9843695780195716e-6, 1.5056327351493116e-7};
    double sum = c[0], t = x + 6.5;
    for (int i = 1; i < 9; i++)
        sum += c[i] / (x - 1 + i);
    return 0.91893853320467274 + (x - 0.5) * ll_detmath_log(t) - t + ll_detmath_log(sum);
}

static double away_from_0(double x)
{
    return fabs(x) < TINY ? TINY : x;
}

/* The continued fraction of the incomplete beta function, by Lentz' method (Press et al., Numerical Recipes,
 * 6.4). It converges fast for x below (a + 1) / (a + b + 2). */
static double beta_fraction(double x, double a, double b)
{
    double c = 1, d = 1 / away_from_0(1 - (a + b) * x / (a + 1)), f = d;
    for (int k = 1; k < TERMS_MAX; k++) {
        double m = k, before = f;
        double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / away_from_0(1 + even * d);
        c = away_from_0(1 + even / c);
        f *= d * c;
        d = 1 / away_from_0(1 + odd * d);
        c = away_from_0(1 + odd / c);
        f *= d * c;
        if (fabs(f - before) <= EXACT * fabs(f))
            break;
    }
    return f;
}

double ll_beta_cdf(double x, double a, double b)
{
    LL_ASSERT(a > 0 && b > 0);
    if (!(x > 0))
        return 0;
    if (x >= 1)
        return 1;
    double front = ll_exp(log_gamma(a + b) - log_gamma(a) - log_gamma(b) + a * ll_detmath_log(x) +
                          b * ll_detmath_log(1 - x));
    if (x < (a + 1) / (a + b + 2))
        return front * beta_fraction(x, a, b) / a;
    return 1 - front * beta_fraction(1 - x, b, a) / b;
}

/* Series below a + 1, continued fraction above (Numerical Recipes, 6.2). */
double ll_gamma_cdf(double x, double a)
{
    LL_ASSERT(a > 0);
    if (!(x > 0))
        return 0;
    double front = ll_exp(a * ll_detmath_log(x) - x - log_gamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (int k = 1; k < TERMS_MAX && term > EXACT * sum; k++) {
            term *= x / (a + k);
            sum += term;
        }
        return front * sum;
    }
    double b = x + 1 - a, c = 1 / TINY, d = 1 / b, f = d;
    for (int k = 1; k < TERMS_MAX; k++) {
        double step = -k * (k - a), before = f;
        b += 2;
        d = 1 / away_from_0(step * d + b);
        c = away_from_0(b + step / c);
        f *= d * c;
        if (fabs(f - before) <= EXACT * fabs(f))
            break;
    }
    return 1 - front * f;
}

/* Bisects an interval with the quantile until no number is between its ends. */
#define HALVE(below, low, high)                                                                              \
    for (int k = 0; k < HALVINGS_MAX && (high) - (low) > EXACT * (high); k++) {                              \
        double middle = ((low) + (high)) / 2;                                                                \
        if (middle <= (low) || middle >= (high))                                                             \
            break;                                                                                           \
        if (below)                                                                                           \
            (low) = middle;                                                                                  \
        else                                                                                                 \
            (high) = middle;                                                                                 \
    }

double ll_beta_quantile(double p, double a, double b)
{
    double low = 0, high = 1;
    LL_ASSERT(p > 0 && p < 1);
    HALVE(ll_beta_cdf(middle, a, b) < p, low, high)
    return (low + high) / 2;
}

double ll_gamma_quantile(double p, double a)
{
    double low = 0, high = a + 1;
    LL_ASSERT(p > 0 && p < 1);
    while (ll_gamma_cdf(high, a) < p)
        high *= 2;
    HALVE(ll_gamma_cdf(middle, a) < p, low, high)
    return (low + high) / 2;
}

/* P(|t| > t0) = I_x(freedom / 2, 1 / 2) with x = freedom / (freedom + t0^2). */
double ll_t_quantile(double tail, double freedom)
{
    LL_ASSERT(tail > 0 && tail <= 0.5 && freedom > 0);
    if (tail == 0.5)
        return 0;
    double x = ll_beta_quantile(2 * tail, freedom / 2, 0.5);
    return sqrt(freedom * (1 - x) / x);
}
