/* What the libraries of the benchmark `integrators` have in common: a task, and methods that do it. */
#pragma once

#include "ode/core/ode.h"

enum { SOLVER_STEPS_MAX = 100000 /* a run that takes more has failed */ };

/* From `start` at t = 0 to `duration`, with a local error below absolute + relative |y|. */
typedef struct task {
    ll_ode ode;
    double start[LL_ODE_DIM_MAX];
    double duration, relative, absolute;
    double first_step; /* for libraries that do not find one */
} task;

typedef struct counts {
    int64_t steps, evaluations,
        jacobians; /* evaluations for a Jacobian by differences are in `evaluations` */
} counts;

typedef struct solver {
    const char *library, *method;
    bool newton;      /* implicit, with a Jacobian */
    const void *kind; /* the library's own word for it */

    /* Everything that can be made beforehand. `t` stays where it is. NULL: the method cannot do it. */
    void *(*open)(const struct solver *by, const task *t);

    /* The whole way, again and again the same: what is timed. false: not to the end. */
    bool (*run)(void *state, double *y);

    counts (*count)(const void *state); /* of the last run */
    void (*close)(void *state);
} solver;

/* Each fills `list` from `count` on and returns the new count. */
enum { SOLVERS_MAX = 64 };
int laglab_solvers(solver *list, int count);
int gsl_solvers(solver *list, int count);
int sundials_solvers(solver *list, int count);
int odeint_solvers(solver *list, int count);
