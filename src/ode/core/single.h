/* What single precision does to clocks that add up their step, and far from the origin. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* A clock in single precision after `ticks` additions of `dt`, s; and with Kahan's compensation (W. Kahan,
 * Comm. ACM 8, 1965). */
float ll_single_clock(float dt, int64_t ticks);
float ll_single_clock_compensated(float dt, int64_t ticks);

/* Adds `dt` to the clock `t`; `lost`: what Kahan's compensation has kept, NULL: without. */
void ll_single_clock_add(float *t, float *lost, float dt);

/* The time at which such a clock stops: dt is less than half the spacing of its numbers. dt > 0. */
float ll_single_clock_stall(float dt);

/* The distance to the next number after |x|. */
float ll_single_spacing(float x);

/* The least speed that moves a body at x by steps of dt: slower, and every step is rounded away. */
double ll_single_least_speed(float x, double dt);

/* How far a body falls from rest at `origin` under gravity 10, by semi-implicit Euler in single precision. */
double ll_single_fall(float origin, float dt, int64_t steps);

/* An oscillator of 1 Hz and an amplitude of 1 about `origin`, by leapfrog in single precision, its place kept
 * as it is and not relative to the origin. Returns the energy after `steps` over that at the start. */
double ll_single_oscillator_energy(float origin, float dt, int64_t steps);
