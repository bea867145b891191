/* The table of methods: a row is the name of a constant ll_ode_NAME that a file of this room defines. They
 * are listed, and chosen between, in this order. */
#pragma once

#include "ode/core/method.h"

/* clang-format off */
#define LL_ODE_METHODS(ROW) \
    ROW(explicit_euler) \
    ROW(semi_implicit_euler) \
    ROW(implicit_euler) \
    ROW(implicit_midpoint) \
    ROW(trapezoid) \
    ROW(stormer_verlet) \
    ROW(verlet_as_printed) \
    ROW(verlet_time_corrected) \
    ROW(verlet_improved) \
    ROW(verlet_lattice) \
    ROW(velocity_verlet) \
    ROW(velocity_verlet_predicted) \
    ROW(leapfrog_kdk) \
    ROW(leapfrog_dkd) \
    ROW(boris) \
    ROW(ruth3) \
    ROW(yoshida4) \
    ROW(yoshida6) \
    ROW(yoshida8) \
    ROW(rk2) \
    ROW(ralston) \
    ROW(rk3) \
    ROW(rk4) \
    ROW(ab2) \
    ROW(ab3) \
    ROW(ab4) \
    ROW(bs32) \
    ROW(dopri5) \
    ROW(tsit5) \
    ROW(dop853) \
    ROW(extrapolated_midpoint) \
    ROW(extrapolated_leapfrog) \
    ROW(rodas4) \
    ROW(rodas5p) \
    ROW(radau5) \
    ROW(radau9) \
    ROW(radau13) \
    ROW(taylor)
/* clang-format on */

#define LL_ODE_DECLARE(NAME) extern const ll_ode_method ll_ode_##NAME;
LL_ODE_METHODS(LL_ODE_DECLARE)
#undef LL_ODE_DECLARE
