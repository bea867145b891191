/* Loops of methods that a system has compiled with its own f. */
#pragma once

#include "ode/core/embedded.h"
#include "ode/core/extrapolation.h"

struct ll_ode_kernels {
    ll_ode_rows *midpoint, *leapfrog;     /* of extrapolation; NULL: none */
    ll_ode_stages *dop853, *seven_stages; /* of embedded methods; NULL: none */
};
