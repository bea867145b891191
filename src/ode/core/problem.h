/* The table of problems: a system with its parameters, its initial state, and its solution. */
#pragma once

#include "ode/core/ode.h"
#include "param/param.h"

enum { LL_ODE_PARAMS_MAX = 512 /* bytes of a problem's own struct */ };

typedef struct ll_ode_problem {
    const char *name;
    const char *help;   /* one sentence */
    const char *source; /* publication of parameters and reference */
    bool stiff;         /* needs an implicit method */

    /* The struct is passed to every function here and in the system. Members without a row are derived:
     * `prepare` (NULL: there are none) sets them from the others. */
    const ll_param_table *params;
    void (*prepare)(void *params);

    /* Fills the system, which refers to `params`. */
    void (*system)(const void *params, ll_ode *ode);

    double duration;                              /* s: time of the reference */
    void (*start)(const void *params, double *y); /* at t = 0 */

    const char *const *components; /* dim names with units: `x_m`, `v_mps`; positions first */

    /* Closed-form solution at `t`. False: none for these parameters. NULL: none. */
    bool (*exact)(const void *params, double t, double *y);

    /* Solution at `duration` for the default parameters, to all digits; NULL if `exact` gives it. */
    const double *reference;
    double floor; /* its relative change when decimal inputs are rounded to double */

    double (*energy)(const void *params, double t, const double *y); /* J; NULL: no conserved energy */
} ll_ode_problem;

extern const ll_ode_problem *const ll_ode_problems[]; /* NULL-terminated */

const ll_ode_problem *ll_ode_problem_find(const char *name); /* NULL if there is no such problem */
