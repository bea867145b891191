/* The listing of the paper's Figure 1, in single precision as it was run: its lines are those of Figures 2
 * and 3.
 *
 * It updates the velocity first, so it is semi-implicit Euler. The order of the lines, the float clock that
 * is added up and its comparison with a double are the listing's, and count: another order misses or adds a
 * line. */
#pragma once

#include <stddef.h>

typedef struct ll_ode_listing {
    float t, velocity, displacement;
    float dt, acceleration;
} ll_ode_listing;

/* Writes the present line into `line`, with its newline, and goes one step on; false when t has passed
 * `duration`. */
int ll_ode_listing_next(ll_ode_listing *listing, double duration, char *line, size_t size);
