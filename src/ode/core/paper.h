/* The listing of the paper's Figure 1, in single precision as printed: it makes the lines of Figures 2 and 3.
 *
 * It updates the velocity first, so it is semi-implicit Euler. The order of its lines, the accumulated float
 * clock and its comparison with a double are the listing's: any other order omits or adds a line. */
#pragma once

#include <stddef.h>

typedef struct ll_ode_listing {
    float t, velocity, displacement;
    float dt, acceleration;
} ll_ode_listing;

/* Writes the current line with its newline into `line` and makes a step. False when t has passed
 * `duration`. */
int ll_ode_listing_next(ll_ode_listing *listing, double duration, char *line, size_t size);
