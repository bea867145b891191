#include "experiment/statistics/sample.h"

#include <stdbool.h>

#include "base/assert.h"
#include "base/rng.h"
#include "experiment/statistics/sobol.h"

enum { STRATA = 0x5742, ROUNDS = 6 }; /* first stream of random numbers; rounds of the permutation */

int64_t ll_sample_points(const ll_sample_request *o)
{
    return o->method == LL_SAMPLE_SALTELLI ? o->count * (o->dimensions + 2) : o->count;
}

/* A permutation of 0..n-1: a Feistel network over the smallest even number of bits for n, repeated until the
 * result is in range (Black and Rogaway, CT-RSA 2002). */
static int64_t permuted(uint64_t seed, uint64_t stream, int64_t at, int64_t n)
{
    int half = 1;
    LL_ASSERT(at >= 0 && at < n);
    while ((int64_t)1 << (2 * half) < n)
        half++;
    uint64_t mask = ((uint64_t)1 << half) - 1, x = (uint64_t)at;
    do {
        uint64_t left = x >> half, right = x & mask;
        for (uint64_t r = 0; r < ROUNDS; r++) {
            uint64_t next = left ^ (ll_rng_u64(seed, stream, r << 32 | right) & mask);
            left = right;
            right = next;
        }
        x = left << half | right;
    } while (x >= (uint64_t)n);
    return (int64_t)x;
}

static double sobol(const ll_sample_request *o, int dimension, int64_t point)
{
    return ll_sobol(dimension, (uint32_t)point,
                    (uint32_t)(ll_rng_u64(o->seed, (uint64_t)dimension, 0) >> 32));
}

double ll_sample_coordinate(const ll_sample_request *o, int dimension, int64_t point)
{
    uint64_t stream = (uint64_t)dimension;
    LL_ASSERT(o->method != LL_SAMPLE_NONE && dimension < o->dimensions);
    if (o->method == LL_SAMPLE_RANDOM)
        return ll_rng_unit(o->seed, stream, (uint64_t)point);
    if (o->method == LL_SAMPLE_SOBOL)
        return sobol(o, dimension, point);
    if (o->method == LL_SAMPLE_LHS) {
        double place = ll_rng_unit(o->seed, stream, (uint64_t)point);
        double u = ((double)permuted(o->seed, STRATA + stream, point, o->count) + place) / (double)o->count;
        return u < 1 ? u : 1 - 0x1p-53;
    }
    int64_t row = point % (o->dimensions + 2);
    bool of_b = row == 1 || row == dimension + 2;
    return sobol(o, of_b ? o->dimensions + dimension : dimension, point / (o->dimensions + 2));
}
