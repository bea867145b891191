#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <stdlib.h>

#include "integrators/solver.h"

typedef struct state {
    const task *task;
    gsl_odeiv2_system system;
    gsl_odeiv2_driver *driver;
    counts counts;
} state;

static int f(double t, const double y[], double dy[], void *state_)
{
    state *s = state_;
    s->counts.evaluations++;
    ll_ode_eval(&s->task->ode, t, y, dy);
    return GSL_SUCCESS;
}

/* The derivative by t of the few systems that have one is taken by a difference. */
static void time_derivative(state *s, double t, const double y[], double *dfdt)
{
    int dim = s->task->ode.dim;
    double h = 1e-7 * s->task->duration, before[LL_ODE_DIM_MAX];
    f(t, y, before, s);
    f(t + h, y, dfdt, s);
    for (int i = 0; i < dim; i++)
        dfdt[i] = (dfdt[i] - before[i]) / h;
}

static int jacobian(double t, const double y[], double *dfdy, double dfdt[], void *state_)
{
    state *s = state_;
    const ll_ode *ode = &s->task->ode;
    s->counts.jacobians++;
    ode->jacobian(ode->params, t, y, dfdy);
    if (ode->autonomous)
        memset(dfdt, 0, (size_t)ode->dim * sizeof *dfdt);
    else
        time_derivative(s, t, y, dfdt);
    return GSL_SUCCESS;
}

static void *open_driver(const solver *by, const task *t)
{
    const gsl_odeiv2_step_type *const *type = by->kind;
    state *s = malloc(sizeof *s);
    *s = (state){.task = t,
                 .system = {.function = f,
                            .jacobian = t->ode.jacobian != NULL ? jacobian : NULL,
                            .dimension = (size_t)t->ode.dim,
                            .params = s}};
    gsl_set_error_handler_off();
    s->driver = gsl_odeiv2_driver_alloc_y_new(&s->system, *type, t->first_step, t->absolute, t->relative);
    gsl_odeiv2_driver_set_nmax(s->driver, SOLVER_STEPS_MAX);
    return s;
}

static bool run(void *state_, double *y)
{
    state *s = state_;
    double t = 0;
    s->counts = (counts){0};
    memcpy(y, s->task->start, (size_t)s->task->ode.dim * sizeof *y);
    gsl_odeiv2_driver_reset_hstart(s->driver, s->task->first_step);
    return gsl_odeiv2_driver_apply(s->driver, &t, s->task->duration, y) == GSL_SUCCESS;
}

static counts count_run(const void *state_)
{
    const state *s = state_;
    counts c = s->counts;
    c.steps = (int64_t)s->driver->n;
    return c;
}

static void close_driver(void *state_)
{
    state *s = state_;
    gsl_odeiv2_driver_free(s->driver);
    free(s);
}

int gsl_solvers(solver *list, int count)
{
    static const struct {
        const char *method;
        const gsl_odeiv2_step_type *const *type;
        bool newton;
    } methods[] = {{"rkf45", &gsl_odeiv2_step_rkf45, false}, {"rkck", &gsl_odeiv2_step_rkck, false},
                   {"rk8pd", &gsl_odeiv2_step_rk8pd, false}, {"msadams", &gsl_odeiv2_step_msadams, false},
                   {"msbdf", &gsl_odeiv2_step_msbdf, true},  {"bsimp", &gsl_odeiv2_step_bsimp, true}};
    for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++)
        list[count++] = (solver){.library = "GSL",
                                 .method = methods[i].method,
                                 .newton = methods[i].newton,
                                 .kind = methods[i].type,
                                 .open = open_driver,
                                 .run = run,
                                 .count = count_run,
                                 .close = close_driver};
    return count;
}
