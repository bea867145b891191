/* The table of integrators: one row per method. */
#pragma once

#include "base/status.h"
#include "ode/core/ode.h"

/* Requirements of a method on a system. */
enum {
    LL_ODE_NEEDS_MECHANICAL = 1, /* positions and velocities */
    LL_ODE_NEEDS_MAGNETIC = 2,   /* the parts of a magnetic force */
    LL_ODE_NEEDS_POSITIONS = 4,  /* an acceleration independent of v */
    LL_ODE_NEEDS_TAYLOR = 8,     /* Taylor coefficients of its solutions */
};

struct ll_ode_run;
struct ll_ode_body;

typedef struct ll_ode_method {
    const char *name;
    const char *help;   /* one sentence */
    const char *source; /* where it is published */
    int order;          /* order of convergence, for smooth problems with forces independent of v */
    int order_velocity; /* the same for forces that depend on v; 0: equal */
    double evaluations; /* of f or a per step; 0 if it varies (implicit methods, extrapolation) */
    bool symplectic;
    bool reversible; /* a step of -dt undoes one of dt, except for rounding */
    bool a_stable;
    bool adaptive; /* chooses its steps by a tolerance; all others have a dt */
    unsigned needs;

    const struct ll_ode_body *body; /* how it steps: method_internal.h */
    const void *data;               /* coefficients, for implementations shared by several methods */
} ll_ode_method;

extern const ll_ode_method *const ll_ode_methods[]; /* NULL-terminated */

const ll_ode_method *ll_ode_method_find(const char *name); /* NULL if there is no such method */

/* Order of convergence on this system. */
int ll_ode_order(const ll_ode_method *method, const ll_ode *ode);

/* Whether the method can integrate the system; the error says what is missing. */
ll_status ll_ode_method_fits(const ll_ode_method *method, const ll_ode *ode);
