/* Distributions with the quantiles for intervals. Pure functions; the same bits on all machines. Checked in
 * tests/experiment/statistics/test_distributions.c against SciPy and closed forms; relative errors below
 * 1e-9. */
#pragma once

/* Regularised incomplete beta and gamma functions: I_x(a, b) for x in [0, 1], P(a, x) for x >= 0; a, b >
 * 0. */
double ll_beta_cdf(double x, double a, double b);
double ll_gamma_cdf(double x, double a);

/* Their inverses: the x at which the function is p, 0 < p < 1. */
double ll_beta_quantile(double p, double a, double b);
double ll_gamma_quantile(double p, double a);

/* Student's t with `freedom` > 0 degrees of freedom: the value that is exceeded with probability `tail`,
 * which is above 0 and at most 1/2. */
double ll_t_quantile(double tail, double freedom);
