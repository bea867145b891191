#include "base/rng.h"

/* Centre of one of 2^52 equal cells, so that 0 and 1 are impossible. */
double ll_rng_normal(uint64_t seed, uint64_t stream, uint64_t counter)
{
    return ll_normal_quantile(((double)(ll_rng_u64(seed, stream, counter) >> 12) + 0.5) * 0x1p-52);
}
