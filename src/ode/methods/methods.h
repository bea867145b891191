/* The rows of the table of methods. */
#pragma once

#include "ode/core/method.h"

extern const ll_ode_method ll_ode_explicit_euler, ll_ode_semi_implicit_euler, ll_ode_implicit_euler,
    ll_ode_implicit_midpoint, ll_ode_trapezoid, ll_ode_stormer_verlet, ll_ode_verlet_as_printed,
    ll_ode_verlet_time_corrected, ll_ode_verlet_improved, ll_ode_verlet_lattice, ll_ode_velocity_verlet,
    ll_ode_velocity_verlet_predicted, ll_ode_leapfrog_kdk, ll_ode_leapfrog_dkd, ll_ode_boris, ll_ode_ruth3,
    ll_ode_yoshida4, ll_ode_yoshida6, ll_ode_yoshida8, ll_ode_rk2, ll_ode_ralston, ll_ode_rk3, ll_ode_rk4,
    ll_ode_ab2, ll_ode_ab3, ll_ode_ab4, ll_ode_bs32, ll_ode_dopri5, ll_ode_tsit5, ll_ode_dop853,
    ll_ode_rodas4, ll_ode_rodas5p, ll_ode_radau5, ll_ode_radau9, ll_ode_radau13, ll_ode_extrapolated_midpoint,
    ll_ode_extrapolated_leapfrog;
