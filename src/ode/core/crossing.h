/* Zero crossings within a step, and the jumps that follow. */
#pragma once

#include "ode/core/run.h"

/* Looks for events in an attempted step of `*h`. If there is one, repeats the attempt up to the first, sets
 * `*h` to that shorter step, and run->event and run->event_t to the event and its time. */
bool ll_ode_event_locate(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double *h);

/* Applies the jump of run->event to the current state. */
void ll_ode_event_jump(ll_ode_run *run, const ll_ode *ode);
