/* Taylor coefficients of a solution, by recurrences: y_k = y^(k)(t) / k!.
 *
 * Of y' = f(y), coefficient k of f gives coefficient k + 1 of y, so that all coefficients of a step follow
 * one after the other (R. E. Moore, Interval Analysis, 1966; A. Jorba, M. Zou, Exp. Math. 14, 2005, section
 * 2). A product has the coefficients sum over j of a_j b_(k-j); quotients, powers, sines and cosines have
 * sums of the same form, by their derivatives. A problem writes its sums over 0 < j < k in one loop, in which
 * they are independent, and adds the terms of j = 0 and j = k afterwards, each needing the result before it.
 *
 * A term has two lanes: two components, two angles, sine and cosine, or twice the same number. */
#pragma once

#include "base/pair.h"
#include "ode/core/ode.h"

enum { LL_SERIES_ORDER = 24, LL_SERIES_TERMS = LL_SERIES_ORDER + 1 };

typedef double ll_term __attribute__((vector_size(16), may_alias));

static const double ll_series_inverse[LL_SERIES_TERMS] = {
    0,       1,       1. / 2,  1. / 3,  1. / 4,  1. / 5,  1. / 6,  1. / 7,  1. / 8,
    1. / 9,  1. / 10, 1. / 11, 1. / 12, 1. / 13, 1. / 14, 1. / 15, 1. / 16, 1. / 17,
    1. / 18, 1. / 19, 1. / 20, 1. / 21, 1. / 22, 1. / 23, 1. / 24};

LL_INLINE ll_term ll_term_of(double x)
{
    return (ll_term){x, x};
}

LL_INLINE ll_term ll_term_swapped(ll_term x)
{
    return (ll_term){x[1], x[0]};
}

/* The terms j = 0 and j = k > 0 of coefficient k of a product. */
LL_INLINE ll_term ll_series_ends(const ll_term *a, const ll_term *b, int k)
{
    return a[0] * b[k] + a[k] * b[0];
}

/* In u^p = w, w_k = sum over 0 < j <= k of ((p + 1) j - k) u_j w_(k-j) / (k u_0): the factor of u_j
 * w_(k-j). */
LL_INLINE double ll_series_power_factor(double p, int j, int k)
{
    return (p + 1) * j - k;
}

/* Coefficient k + 1 of positions q and velocities v, from coefficient k of the acceleration. */
LL_INLINE void ll_series_move(ll_term *q, ll_term *v, ll_term a, int k)
{
    q[k + 1] = v[k] * ll_series_inverse[k + 1];
    v[k + 1] = a * ll_series_inverse[k + 1];
}

/* Two positions and two velocities: between the rows of a system of four components and their series. */
LL_INLINE void ll_series_take_plane(const double *series, ll_term *q, ll_term *v)
{
    q[0] = (ll_term){series[0], series[1]};
    v[0] = (ll_term){series[2], series[3]};
}

LL_INLINE void ll_series_put_plane(double *series, const ll_term *q, const ll_term *v, int order)
{
    for (int k = 1; k <= order; k++) {
        double *row = series + 4 * k;
        row[0] = q[k][0], row[1] = q[k][1];
        row[2] = v[k][0], row[3] = v[k][1];
    }
}
