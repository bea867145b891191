/* Points sampled from axes: a coordinate in [0, 1) for each dimension, a pure function of its arguments.
 *
 * random: independent. sobol: a Sobol' sequence, digitally shifted. lhs: a Latin hypercube (McKay, Beckman
 * and Conover, Technometrics 21, 1979): in each dimension every n-th part of the range has one of n points,
 * at a random position. saltelli: rows for sensitivity indices (Saltelli et al., Comput. Phys. Commun. 181,
 * 2010): with d dimensions, d + 2 points for each of `count` base samples: A, B, and A with one dimension of
 * B at a time; A and B are halves of a Sobol' sequence of 2 d dimensions. */
#pragma once

#include <stdint.h>

typedef enum ll_sampling {
    LL_SAMPLE_NONE,
    LL_SAMPLE_RANDOM,
    LL_SAMPLE_SOBOL,
    LL_SAMPLE_LHS,
    LL_SAMPLE_SALTELLI,
} ll_sampling;

typedef struct ll_sample_request {
    ll_sampling method;
    int dimensions;
    int64_t count;
    uint64_t seed;
} ll_sample_request;

/* Number of points. */
int64_t ll_sample_points(const ll_sample_request *request);

double ll_sample_coordinate(const ll_sample_request *request, int dimension, int64_t point);
