#include "experiment/statistics/sobol.h"

#include "base/assert.h"

enum { BITS = 32, DEGREE_MAX = 8 };

/* Degree and coefficients of the primitive polynomial, and the first direction numbers. The first dimension
 * is van der Corput's sequence and needs none. */
static const struct polynomial {
    int degree;
    uint32_t coefficients, start[DEGREE_MAX];
} polynomials[LL_SOBOL_DIMENSIONS] = {
    {0, 0, {0}},
    {1, 0, {1}},
    {2, 1, {1, 3}},
    {3, 1, {1, 3, 1}},
    {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}},
    {4, 4, {1, 3, 5, 13}},
    {5, 2, {1, 1, 5, 5, 17}},
    {5, 4, {1, 1, 5, 5, 5}},
    {5, 7, {1, 1, 7, 11, 19}},
    {5, 11, {1, 1, 5, 1, 1}},
    {5, 13, {1, 1, 1, 3, 11}},
    {5, 14, {1, 3, 5, 5, 31}},
    {6, 1, {1, 3, 3, 9, 7, 49}},
    {6, 13, {1, 1, 1, 15, 21, 21}},
    {6, 16, {1, 3, 1, 13, 27, 49}},
    {6, 19, {1, 1, 1, 15, 7, 5}},
    {6, 22, {1, 3, 1, 15, 13, 25}},
    {6, 25, {1, 1, 5, 5, 19, 61}},
    {7, 1, {1, 3, 7, 11, 23, 15, 103}},
    {7, 4, {1, 3, 7, 13, 13, 15, 69}},
    {7, 7, {1, 1, 3, 13, 7, 35, 63}},
    {7, 8, {1, 3, 5, 9, 1, 25, 53}},
    {7, 14, {1, 3, 1, 13, 9, 35, 107}},
    {7, 19, {1, 3, 1, 5, 27, 61, 31}},
    {7, 21, {1, 1, 5, 11, 19, 41, 61}},
    {7, 28, {1, 3, 5, 3, 3, 13, 69}},
    {7, 31, {1, 1, 7, 13, 1, 19, 1}},
    {7, 32, {1, 3, 7, 5, 13, 19, 59}},
    {7, 37, {1, 1, 3, 9, 25, 29, 41}},
    {7, 41, {1, 3, 5, 13, 23, 1, 55}},
    {7, 42, {1, 3, 7, 3, 13, 59, 17}},
    {7, 50, {1, 3, 1, 3, 5, 53, 69}},
    {7, 55, {1, 1, 5, 5, 23, 33, 13}},
    {7, 56, {1, 1, 7, 7, 1, 61, 123}},
    {7, 59, {1, 1, 7, 9, 13, 61, 49}},
    {7, 62, {1, 3, 3, 5, 3, 55, 33}},
    {8, 14, {1, 3, 1, 15, 31, 13, 49, 245}},
    {8, 21, {1, 3, 5, 15, 31, 59, 63, 97}},
    {8, 22, {1, 3, 1, 11, 11, 11, 77, 249}},
};

static void directions(const struct polynomial *p, uint32_t v[BITS])
{
    for (int i = 0; i < BITS; i++) {
        if (p->degree == 0) {
            v[i] = 1u << (BITS - 1 - i);
        } else if (i < p->degree) {
            v[i] = p->start[i] << (BITS - 1 - i);
        } else {
            v[i] = v[i - p->degree] ^ (v[i - p->degree] >> p->degree);
            for (int k = 1; k < p->degree; k++)
                if (p->coefficients >> (p->degree - 1 - k) & 1)
                    v[i] ^= v[i - k];
        }
    }
}

double ll_sobol(int dimension, uint32_t point, uint32_t shift)
{
    uint32_t v[BITS], x = shift;
    LL_ASSERT(dimension >= 0 && dimension < LL_SOBOL_DIMENSIONS);
    directions(&polynomials[dimension], v);
    for (int i = 0; point >> i != 0; i++) {
        if (point >> i & 1)
            x ^= v[i];
        if (i == BITS - 1)
            break;
    }
    return x * 0x1p-32;
}
