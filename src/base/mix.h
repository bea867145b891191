/* The bit mixer under hash.c and rng.c. */
#pragma once

#include <stdint.h>

/* Odd constant near 2^64 / golden ratio: consecutive multiples of it are far apart. */
#define LL_MIX_STEP UINT64_C(0x9e3779b97f4a7c15)

/* Bijection of 64 bits in which every input bit flips every output bit with probability 1/2. Shifts and
 * multipliers are the best of 1500 random ones by the chi-squared of all 64 x 64 such probabilities over
 * multiples of LL_MIX_STEP; tests/base/test_rng.c measures them. */
static inline uint64_t ll_mix(uint64_t x)
{
    x ^= x >> 33;
    x *= UINT64_C(0xaa78f731403321bb);
    x ^= x >> 26;
    x *= UINT64_C(0xee9daf582aec48ad);
    x ^= x >> 30;
    return x;
}
