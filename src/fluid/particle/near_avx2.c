/* The build compiles this file alone for AVX2; neighbours.c asks the CPU before it calls into it. */
#include "fluid/particle/state.h"

#if defined(__x86_64__)
#include <immintrin.h>

/* Moves the lanes of each mask to the front; bytes of a shuffle. */
#define LANE(i) 4 * (i), 4 * (i) + 1, 4 * (i) + 2, 4 * (i) + 3
static const _Alignas(16) uint8_t front[16][16] = {
    {LANE(0), LANE(1), LANE(2), LANE(3)}, {LANE(0), LANE(1), LANE(2), LANE(3)},
    {LANE(1), LANE(0), LANE(2), LANE(3)}, {LANE(0), LANE(1), LANE(2), LANE(3)},
    {LANE(2), LANE(0), LANE(1), LANE(3)}, {LANE(0), LANE(2), LANE(1), LANE(3)},
    {LANE(1), LANE(2), LANE(0), LANE(3)}, {LANE(0), LANE(1), LANE(2), LANE(3)},
    {LANE(3), LANE(0), LANE(1), LANE(2)}, {LANE(0), LANE(3), LANE(1), LANE(2)},
    {LANE(1), LANE(3), LANE(0), LANE(2)}, {LANE(0), LANE(1), LANE(3), LANE(2)},
    {LANE(2), LANE(3), LANE(0), LANE(1)}, {LANE(0), LANE(2), LANE(3), LANE(1)},
    {LANE(1), LANE(2), LANE(3), LANE(0)}, {LANE(0), LANE(1), LANE(2), LANE(3)}};

int32_t ll_particle_near_avx2(const double *x, const double *y, int32_t a, int32_t begin, int32_t end,
                              double reach2, int32_t *pair)
{
    __m256d xa = _mm256_set1_pd(x[a]), ya = _mm256_set1_pd(y[a]), most = _mm256_set1_pd(reach2);
    __m128i index = _mm_add_epi32(_mm_set1_epi32(begin), _mm_setr_epi32(0, 1, 2, 3));
    int32_t count = 0;
    for (int32_t b = begin; b < end; b += LL_PARTICLE_NEAR_LANES) {
        __m256d ex = _mm256_sub_pd(xa, _mm256_loadu_pd(x + b));
        __m256d ey = _mm256_sub_pd(ya, _mm256_loadu_pd(y + b));
        __m256d square = _mm256_add_pd(_mm256_mul_pd(ex, ex), _mm256_mul_pd(ey, ey));
        unsigned near = (unsigned)_mm256_movemask_pd(_mm256_cmp_pd(square, most, _CMP_LT_OQ));
        if (end - b < LL_PARTICLE_NEAR_LANES)
            near &= (1u << (end - b)) - 1;
        __m128i to = _mm_load_si128((const __m128i *)(const void *)front[near]);
        _mm_storeu_si128((__m128i *)(void *)(pair + count), _mm_shuffle_epi8(index, to));
        count += __builtin_popcount(near);
        index = _mm_add_epi32(index, _mm_set1_epi32(LL_PARTICLE_NEAR_LANES));
    }
    return count;
}

#endif
