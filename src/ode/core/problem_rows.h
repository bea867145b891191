/* The rows of the table of problems: one file each. */
#pragma once

#include "base/detmath.h"
#include "ode/core/field.h"
#include "ode/core/problem.h"

extern const ll_ode_problem ll_ode_free_fall, ll_ode_jerk, ll_ode_forced, ll_ode_oscillator, ll_ode_damped,
    ll_ode_drag_vertical, ll_ode_drag_2d, ll_ode_lorentz, ll_ode_pendulum, ll_ode_kepler, ll_ode_henon_heiles,
    ll_ode_double_pendulum, ll_ode_elastic_pendulum, ll_ode_stiff_pendulum, ll_ode_spring_chain,
    ll_ode_arenstorf, ll_ode_pleiades, ll_ode_figure_eight, ll_ode_tennis_racket, ll_ode_euler_top,
    ll_ode_brusselator, ll_ode_lotka_volterra, ll_ode_van_der_pol, ll_ode_robertson, ll_ode_hires,
    ll_ode_oregonator, ll_ode_prothero_robinson, ll_ode_bouncing_ball, ll_ode_penalty_floor, ll_ode_coulomb,
    ll_ode_coulomb_naive;

/* Parameters of the problems. */
extern const ll_param_table ll_ode_free_fall_table, ll_ode_jerk_table, ll_ode_forced_table,
    ll_ode_oscillator_table, ll_ode_damped_table, ll_ode_drag_vertical_table, ll_ode_drag_2d_table,
    ll_ode_lorentz_table, ll_ode_pendulum_table, ll_ode_kepler_table, ll_ode_henon_heiles_table,
    ll_ode_double_pendulum_table, ll_ode_elastic_pendulum_table, ll_ode_stiff_pendulum_table,
    ll_ode_spring_chain_table, ll_ode_arenstorf_table, ll_ode_pleiades_table, ll_ode_figure_eight_table,
    ll_ode_tennis_racket_table, ll_ode_euler_top_table, ll_ode_brusselator_table, ll_ode_lotka_volterra_table,
    ll_ode_van_der_pol_table, ll_ode_robertson_table, ll_ode_hires_table, ll_ode_oregonator_table,
    ll_ode_prothero_robinson_table, ll_ode_bouncing_ball_table, ll_ode_penalty_floor_table,
    ll_ode_coulomb_table, ll_ode_coulomb_naive_table;

/* A row of a problem's parameters. */
#define LL_ODE_PARAM(type_, member_, unit_, min_, max_, standard_, help_)                                    \
    {                                                                                                        \
        .name = #member_, .type = LL_PARAM_REAL, .offset = offsetof(type_, member_), .min = (min_),          \
        .max = (max_), .default_value = (standard_), .unit = (unit_), .live = true, .help = (help_)          \
    }

#define LL_ODE_TABLE(table_, name_, help_, rows_, type_)                                                     \
    const ll_param_table table_ = {.name = (name_),                                                          \
                                   .help = (help_),                                                          \
                                   .rows = (rows_),                                                          \
                                   .count = sizeof(rows_) / sizeof(rows_)[0],                                \
                                   .size = sizeof(type_)}
