#include "experiment/sobol.h"

#include "base/assert.h"

enum { BITS = 32, DEGREE_MAX = 5 };

/* Degree and coefficients of the primitive polynomial, and the first direction numbers. The first dimension
 * is van der Corput's sequence and has none. */
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
