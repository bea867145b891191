/* Sobol' points: sequences that fill the unit cube evenly. Direction numbers of Joe and Kuo
 * (new-joe-kuo-6.21201, SIAM J. Sci. Comput. 30, 2008). */
#pragma once

#include <stdint.h>

enum { LL_SOBOL_DIMENSIONS = 40 };

/* Coordinate of a point in [0, 1), a multiple of 2^-32. `shift` is a digital shift (32 random bits), which
 * keeps the points' evenness; 0 leaves them as published. */
double ll_sobol(int dimension, uint32_t point, uint32_t shift);
