/* Velocities along the centre lines of the driven cavity.
 *
 * `value` is Richardson's extrapolation of steady solutions of order 2 on 128, 256 and 512 cells, accurate to
 * 1e-4. `ghia` is the printed table of Ghia, Ghia and Shin 1982, which is off by up to 0.0093 at Re 100 and
 * 0.0184 at Re 1000: only for comparisons to 0.02. At Re 400 there is only the printed table, off by up to
 * 0.0062; v at x = 0.9063 is omitted, since it is misprinted by 0.15. */
#pragma once

typedef struct ll_cavity_point {
    double coordinate; /* y of u at x = 0.5, x of v at y = 0.5 */
    double value, ghia;
} ll_cavity_point;

typedef struct ll_cavity_reference {
    double re;
    const ll_cavity_point *points[2]; /* u, v */
    int count[2];
} ll_cavity_reference;

extern const ll_cavity_reference ll_cavity_references[];
extern const int ll_cavity_reference_count;
