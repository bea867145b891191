/* Functions for closed forms; accurate to a few ulp, the same bits everywhere. */
#pragma once

double ll_ode_atan(double x);
double ll_ode_asin(double x); /* |x| <= 1 */
double ll_ode_tanh(double x);
double ll_ode_atanh(double x);    /* |x| < 1 */
double ll_ode_log_cosh(double x); /* log(cosh x), without overflow */

/* Jacobi's elliptic functions of modulus k in [0, 1). */
typedef struct ll_ode_elliptic {
    double sn, cn, dn;
} ll_ode_elliptic;

ll_ode_elliptic ll_ode_jacobi(double u, double k);
