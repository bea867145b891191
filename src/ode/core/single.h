/* Effects of single precision: accumulated clocks, and positions far from the origin. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* A clock in single precision after `ticks` additions of `dt`, s; and with compensated summation (W. Kahan,
 * Comm. ACM 8, 1965). */
float ll_single_clock(float dt, int64_t ticks);
float ll_single_clock_compensated(float dt, int64_t ticks);

/* Adds `dt` to the clock `t`; `lost`: Kahan's compensation, NULL: none. */
void ll_single_clock_add(float *t, float *lost, float dt);

/* Time at which such a clock stops: dt is less than half the spacing of its numbers. dt > 0. */
float ll_single_clock_stall(float dt);

/* Distance from |x| to the next number. */
float ll_single_spacing(float x);

/* Least speed that moves a body at x by steps of dt: below it every step is rounded away. */
double ll_single_least_speed(float x, double dt);

/* Distance that a body falls from rest at `origin` under gravity 10, by semi-implicit Euler in single
 * precision. */
double ll_single_fall(float origin, float dt, int64_t steps);

/* An oscillator of 1 Hz and amplitude 1 about `origin`, by leapfrog in single precision, with absolute
 * positions. Returns the energy after `steps` over the initial one. */
double ll_single_oscillator_energy(float origin, float dt, int64_t steps);
