/* Vectors of 1, 2 or 4 doubles, by LL_WIDE. Each operation is one IEEE operation per lane, so that every
 * width computes the same bits. */
#pragma once

#include "rigid/body/world_state.h"

#if LL_WIDE == 4
#include <immintrin.h>
typedef __m256d vd;
#define v_load _mm256_loadu_pd
#define v_store _mm256_storeu_pd
#define v_all _mm256_set1_pd
#define v_max _mm256_max_pd
#define v_min _mm256_min_pd

/* a > b ? x : y */
static inline vd v_choose(vd a, vd b, vd x, vd y)
{
    return _mm256_blendv_pd(y, x, _mm256_cmp_pd(a, b, _CMP_GT_OQ));
}

/* a > b ? 0 : y */
static inline vd v_unless(vd a, vd b, vd y)
{
    return _mm256_andnot_pd(_mm256_cmp_pd(a, b, _CMP_GT_OQ), y);
}

static inline void v_transpose(vd r[4])
{
    vd t0 = _mm256_unpacklo_pd(r[0], r[1]), t1 = _mm256_unpackhi_pd(r[0], r[1]);
    vd t2 = _mm256_unpacklo_pd(r[2], r[3]), t3 = _mm256_unpackhi_pd(r[2], r[3]);
    r[0] = _mm256_permute2f128_pd(t0, t2, 0x20);
    r[1] = _mm256_permute2f128_pd(t1, t3, 0x20);
    r[2] = _mm256_permute2f128_pd(t0, t2, 0x31);
    r[3] = _mm256_permute2f128_pd(t1, t3, 0x31);
}

/* Four doubles of each body, from the first or the fifth on. */
static inline void v_gather(const ll_solver_body *m, const int32_t *index, int from, vd out[4])
{
    for (int i = 0; i < 4; i++)
        out[i] = v_load((const double *)&m[index[i]] + from);
    v_transpose(out);
}

/* The first four doubles of each body; the fourth is unchanged. */
static inline void v_scatter(ll_solver_body *m, const int32_t *index, const vd in[4])
{
    vd r[4] = {in[0], in[1], in[2], in[3]};
    v_transpose(r);
    for (int i = 0; i < 4; i++)
        v_store((double *)&m[index[i]], r[i]);
}

#elif LL_WIDE == 2
#include <emmintrin.h>
typedef __m128d vd;
/* Aligned, which the arithmetic of SSE2 requires of operands in memory: wide contacts and solver bodies
 * are. */
#define v_load _mm_load_pd
#define v_store _mm_store_pd
#define v_all _mm_set1_pd
#define v_max _mm_max_pd
#define v_min _mm_min_pd

static inline vd v_choose(vd a, vd b, vd x, vd y)
{
    vd mask = _mm_cmpgt_pd(a, b);
    return _mm_or_pd(_mm_and_pd(mask, x), _mm_andnot_pd(mask, y));
}

/* a > b ? 0 : y */
static inline vd v_unless(vd a, vd b, vd y)
{
    return _mm_andnot_pd(_mm_cmpgt_pd(a, b), y);
}

static inline void v_gather(const ll_solver_body *m, const int32_t *index, int from, vd out[4])
{
    const double *a = (const double *)&m[index[0]] + from, *b = (const double *)&m[index[1]] + from;
    for (int i = 0; i < 4; i += 2) {
        vd x = v_load(a + i), y = v_load(b + i);
        out[i] = _mm_unpacklo_pd(x, y);
        out[i + 1] = _mm_unpackhi_pd(x, y);
    }
}

static inline void v_scatter(ll_solver_body *m, const int32_t *index, const vd in[4])
{
    double *a = (double *)&m[index[0]], *b = (double *)&m[index[1]];
    for (int i = 0; i < 4; i += 2) {
        v_store(a + i, _mm_unpacklo_pd(in[i], in[i + 1]));
        v_store(b + i, _mm_unpackhi_pd(in[i], in[i + 1]));
    }
}

#else
typedef double vd;
#define v_load(p) (*(p))
#define v_store(p, x) (*(p) = (x))
#define v_all(x) (x)
#define v_max(a, b) ((a) > (b) ? (a) : (b))
#define v_min(a, b) ((a) < (b) ? (a) : (b))
#define v_choose(a, b, x, y) ((a) > (b) ? (x) : (y))
#define v_unless(a, b, y) ((a) > (b) ? 0 : (y))

static inline void v_gather(const ll_solver_body *m, const int32_t *index, int from, vd out[4])
{
    for (int i = 0; i < 4; i++)
        out[i] = ((const double *)&m[*index])[from + i];
}

static inline void v_scatter(ll_solver_body *m, const int32_t *index, const vd in[4])
{
    for (int i = 0; i < 4; i++)
        ((double *)&m[*index])[i] = in[i];
}
#endif
