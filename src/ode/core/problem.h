/* The table of problems: a system with its parameters, where it starts, and what is known of its solution. */
#pragma once

#include "ode/core/ode.h"
#include "param/param.h"

enum { LL_ODE_PARAMS_MAX = 512 /* bytes of a problem's own struct */ };

typedef struct ll_ode_problem {
    const char *name;
    const char *help;   /* one sentence */
    const char *source; /* where parameters and reference are published */
    bool stiff;         /* wants an implicit method */

    /* Its struct is handed to every function here and in the system. Members that no row names are derived:
     * `prepare` (NULL: there are none) sets them from the rest. */
    const ll_param_table *params;
    void (*prepare)(void *params);

    /* Fills the system, for as long as `params` stays where it is. */
    void (*system)(const void *params, ll_ode *ode);

    double duration;                              /* s: the span of the reference */
    void (*start)(const void *params, double *y); /* at t = 0 */

    const char *const *components; /* dim names with units: `x_m`, `v_mps`; positions first */

    /* The solution at `t` by formula. false: there is none for these parameters. NULL: for none. */
    bool (*exact)(const void *params, double t, double *y);

    /* The solution at `duration` for the parameters' defaults, to all digits; NULL where `exact` gives it. */
    const double *reference;
    double floor; /* the relative change of that when decimal inputs are rounded to double */

    double (*energy)(const void *params, double t, const double *y); /* J; NULL: none that is conserved */
} ll_ode_problem;

extern const ll_ode_problem *const ll_ode_problems[]; /* NULL-terminated */

const ll_ode_problem *ll_ode_problem_find(const char *name); /* NULL with no such problem */
