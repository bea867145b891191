/* Effects of single precision: accumulated clocks, and positions far from the origin. */
#pragma once

/* Adds `dt` to the clock `t`; `lost`: compensation (W. Kahan, Comm. ACM 8, 1965), NULL: none. */
void ll_single_clock_add(float *t, float *lost, float dt);

/* Distance from |x| to the next number. */
float ll_single_spacing(float x);
