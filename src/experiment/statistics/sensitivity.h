/* Sobol' indices: the part of a metric's variance that is due to one axis.
 *
 * first: due to the axis alone, V(E(f | x)) / V(f); by Saltelli et al. (Comput. Phys. Commun. 181, 2010), the
 * mean of f(B) (f(A with B's axis) - f(A)). total: due to the axis and its interactions, E(V(f | the others))
 * / V(f); by Jansen (Comput. Phys. Commun. 117, 1999), half the mean of (f(A) - f(A with B's axis))^2. V is
 * the variance of f over A and B. Intervals are percentiles of LL_SENSITIVITY_RESAMPLES resamples of the base
 * samples (Archer, Saltelli and Sobol', J. Stat. Comput. Simul. 58, 1997). */
#pragma once

#include <stdint.h>

#include "base/status.h"

enum { LL_SENSITIVITY_RESAMPLES = 999, LL_SENSITIVITY_MIN = 16 };

typedef struct ll_sensitivity {
    double first, first_low, first_high; /* NaN: unknown */
    double total, total_low, total_high;
    int64_t samples; /* base samples whose points all have the metric */
} ll_sensitivity;

/* `values`: for each of `count` base samples the points A, B, and A with each of the `dimensions` of B; a NaN
 * excludes its base sample. Fills one result per dimension. Intervals need LL_SENSITIVITY_MIN base samples;
 * for constant f the indices are unknown. */
ll_status ll_sensitivity_of(const double *values, int64_t count, int dimensions, ll_sensitivity *indices);
