/* Elementary functions whose results are the same bits everywhere.
 *
 * libm's differ between versions and machines, so simulated state must not use them. These use only + - * /
 * and sqrt, which IEEE 754 fixes. tests/base/test_detmath.c measures their errors against long double: at
 * most 1 ulp for exp and log, 1 ulp for sin and cos with |x| <= 1e6 away from their zeros, 2.5 ulp for
 * atan2. */
#pragma once

double ll_sin(double x); /* |x| <= 1e6; beyond, the error grows with |x| */
double ll_cos(double x);
void ll_sincos(double x, double *sin, double *cos); /* both at the cost of one */
double ll_exp(double x);                            /* 0 below -745, infinite above 709.8 */
double ll_detmath_log(double x);                    /* x > 0; NaN otherwise (-inf for 0) */
double ll_atan2(double y, double x);                /* in [-pi, pi]; 0 at the origin; both finite */

static inline double ll_abs(double x)
{
    return x < 0 ? -x : x;
}

/* IEEE 754 requires correct rounding. */
static inline double ll_sqrt(double x)
{
    return __builtin_sqrt(x);
}
