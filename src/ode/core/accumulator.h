/* Fixed steps under a variable frame time: frame time is accumulated and spent in whole steps; the rest
 * stays for the next frame (G. Fiedler, Fix Your Timestep!, 2004). In whole nanoseconds, so that nothing is
 * lost. */
#pragma once

#include "base/vtime.h"

typedef struct ll_accumulator {
    ll_time step; /* > 0 */
    ll_time rest; /* accumulated: 0 to less than a step */
    int64_t
        most; /* limit of steps per frame; excess steps are dropped, or a slow machine would never catch up */
    int64_t dropped; /* steps so far */
} ll_accumulator;

/* Number of steps in a frame of `frame` >= 0. */
static inline int64_t ll_accumulator_add(ll_accumulator *a, ll_time frame)
{
    a->rest += frame;
    int64_t steps = a->rest / a->step;
    a->rest -= steps * a->step;
    if (steps > a->most) {
        a->dropped += steps - a->most;
        steps = a->most;
    }
    return steps;
}
