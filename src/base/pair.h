/* Arithmetic of two numbers at once: each lane computes the same bits as the function of one number. */
#pragma once

#include "base/detmath.h"

#define LL_INLINE static inline __attribute__((always_inline))

typedef double ll_pair __attribute__((vector_size(16), aligned(8), may_alias));

ll_pair ll_pair_sin(ll_pair x); /* as ll_sin */
ll_pair ll_pair_cos(ll_pair x);
void ll_pair_sincos(ll_pair x, ll_pair *sin, ll_pair *cos);

static inline ll_pair ll_pair_sqrt(ll_pair x)
{
    return (ll_pair){ll_sqrt(x[0]), ll_sqrt(x[1])};
}

static inline ll_pair ll_pair_fabs(ll_pair x)
{
    return (ll_pair){__builtin_fabs(x[0]), __builtin_fabs(x[1])};
}
