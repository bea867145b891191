#include "base/rng.h"

#include "base/mix.h"

/* The seed and the stream choose a start; the counter steps from there. The start is scrambled by half a
 * mixer, which keeps the starts of neighbouring seeds and streams apart; the whole mixer then works on start
 * + counter * step. */
uint64_t ll_rng_u64(uint64_t seed, uint64_t stream, uint64_t counter)
{
    uint64_t start = seed + (stream + 1) * UINT64_C(0xd1e8d69ec377210f); /* + 1: the mixer leaves 0 at 0 */
    start ^= start >> 32;
    start *= UINT64_C(0xd60927fc6f0de0d1);
    start ^= start >> 29;
    return ll_mix(start + counter * LL_MIX_STEP);
}

double ll_rng_unit(uint64_t seed, uint64_t stream, uint64_t counter)
{
    return (double)(ll_rng_u64(seed, stream, counter) >> 11) * 0x1p-53;
}

/* The middle of one of 2^52 equal cells, so that neither 0 nor 1 can come out. */
double ll_rng_normal(uint64_t seed, uint64_t stream, uint64_t counter)
{
    return ll_normal_quantile(((double)(ll_rng_u64(seed, stream, counter) >> 12) + 0.5) * 0x1p-52);
}
