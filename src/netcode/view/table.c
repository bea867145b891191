#include "netcode/view/view.h"

#include <stddef.h>

const ll_interpolation *const ll_interpolations[] = {&ll_interpolation_linear, &ll_interpolation_hermite,
                                                     NULL};
const ll_interpolation_delay *const ll_interpolation_delays[] = {&ll_interpolation_delay_ratio,
                                                                 &ll_interpolation_delay_adaptive, NULL};
const ll_time_scale *const ll_time_scales[] = {&ll_time_scale_proportional, &ll_time_scale_catch_up, NULL};

/* In the order of their tables; a test compares both. */
const char *const ll_interpolation_names[] = {"linear", "hermite", NULL};
const char *const ll_interpolation_delay_names[] = {"ratio", "adaptive", NULL};
const char *const ll_time_scale_names[] = {"proportional", "catch_up", NULL};
