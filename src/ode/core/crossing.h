/* Zero crossings within a step: finding them, and the jumps that follow. */
#pragma once

#include "ode/core/run.h"

/* After an attempt of a step of `*h`: whether an event lies within it. Then the attempt is made anew up to
 * the first one, `*h` is that shorter step, and run->event and run->event_t tell which and when. */
bool ll_ode_event_locate(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double *h);

/* Serves run->event on the state, which stands at it. */
void ll_ode_event_jump(ll_ode_run *run, const ll_ode *ode);
