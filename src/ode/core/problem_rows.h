/* The table of problems, and what its rows are made of. */
#pragma once

#include "base/detmath.h"
#include "ode/core/field.h"
#include "ode/core/problem.h"

/* A row is the name of a problem ll_ode_NAME, with parameters ll_ode_NAME_table. They are chosen by their
 * place in this list. */
/* clang-format off */
#define LL_ODE_PROBLEMS(ROW) \
    ROW(free_fall) ROW(jerk) ROW(forced) ROW(oscillator) ROW(damped) \
    ROW(drag_vertical) ROW(drag_2d) ROW(lorentz) ROW(pendulum) ROW(kepler) \
    ROW(henon_heiles) ROW(double_pendulum) ROW(elastic_pendulum) ROW(stiff_pendulum) ROW(spring_chain) \
    ROW(arenstorf) ROW(pleiades) ROW(figure_eight) ROW(tennis_racket) ROW(euler_top) \
    ROW(brusselator) ROW(lotka_volterra) ROW(van_der_pol) ROW(robertson) ROW(hires) \
    ROW(oregonator) ROW(prothero_robinson) ROW(bouncing_ball) ROW(penalty_floor) ROW(coulomb) \
    ROW(coulomb_naive)
/* clang-format on */

#define LL_ODE_DECLARE(NAME)                                                                                 \
    extern const ll_ode_problem ll_ode_##NAME;                                                               \
    extern const ll_param_table ll_ode_##NAME##_table;
LL_ODE_PROBLEMS(LL_ODE_DECLARE)
#undef LL_ODE_DECLARE

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
