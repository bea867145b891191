#include "base/hash.h"

#include <string.h>

#include "base/mix.h"

/* Absorbs a word into a lane. Bijective in the lane for a fixed word, and in the word for a fixed lane, so
 * inputs that differ in a single word never collide within a lane. */
static inline uint64_t absorb(uint64_t lane, uint64_t word)
{
    lane = (lane ^ word) * UINT64_C(0x8348d2aa4a86b48d);
    return lane ^ (lane >> 32);
}

static inline uint64_t load(const unsigned char *bytes)
{
    uint64_t word;
    memcpy(&word, bytes, sizeof word);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    word = __builtin_bswap64(word);
#endif
    return word;
}

/* Four lanes, because a multiplication takes as long as issuing four. */
uint64_t ll_hash(uint64_t seed, const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    size_t left = size;
    uint64_t lane[4];
    for (unsigned i = 0; i < 4; i++)
        lane[i] = ll_mix(seed + (i + 1) * LL_MIX_STEP);

    for (; left >= 32; left -= 32, at += 32) {
        lane[0] = absorb(lane[0], load(at));
        lane[1] = absorb(lane[1], load(at + 8));
        lane[2] = absorb(lane[2], load(at + 16));
        lane[3] = absorb(lane[3], load(at + 24));
    }
    for (unsigned i = 0; left >= 8; left -= 8, at += 8, i++)
        lane[i] = absorb(lane[i], load(at));
    unsigned char rest[8] = {0}; /* zeros and no bytes differ by the size, which is absorbed below */
    if (left > 0)
        memcpy(rest, at, left);
    lane[3] = absorb(lane[3], load(rest));

    uint64_t h = (uint64_t)size;
    for (unsigned i = 0; i < 4; i++)
        h = ll_mix((h ^ lane[i]) + LL_MIX_STEP);
    return h;
}

uint64_t ll_hash_u64(uint64_t seed, uint64_t value)
{
    return ll_mix(absorb(ll_mix(seed + LL_MIX_STEP), value) + LL_MIX_STEP);
}
