#include <stdlib.h>

#include "integrators/solver.h"
#include "ode/core/run.h"

typedef struct state {
    const task *task;
    const ll_ode_method *method;
    ll_ode_control control;
    ll_ode_run *run;
} state;

static void *open_run(const solver *by, const task *t)
{
    const ll_ode_method *method = by->kind;
    ll_status fits = ll_ode_method_fits(method, &t->ode);
    if (ll_failed(&fits))
        return NULL;
    state *s = malloc(sizeof *s);
    *s = (state){.task = t,
                 .method = method,
                 .control = {.t_end = t->duration,
                             .tolerance = t->relative,
                             .absolute = t->absolute,
                             .max_steps = SOLVER_STEPS_MAX},
                 .run = malloc(ll_ode_run_size(method, &t->ode))};
    return s;
}

static bool run(void *state_, double *y)
{
    state *s = state_;
    const task *t = s->task;
    ll_status status = ll_ode_start(s->run, s->method, &t->ode, &s->control, t->start);
    if (ll_failed(&status) || ll_ode_advance(s->run, s->method, &t->ode, t->duration) == LL_ODE_DIVERGED)
        return false;
    memcpy(y, ll_ode_y(s->run), (size_t)t->ode.dim * sizeof *y);
    return true;
}

static counts count_run(const void *state_)
{
    const ll_ode_counters *c = &((const state *)state_)->run->counters;
    return (counts){.steps = c->steps, .evaluations = c->evaluations, .jacobians = c->jacobians};
}

static void close_run(void *state_)
{
    state *s = state_;
    free(s->run);
    free(s);
}

/* All methods of the table that choose their steps by a tolerance. */
int laglab_solvers(solver *list, int count)
{
    for (int i = 0; ll_ode_methods[i] != NULL; i++)
        if (ll_ode_methods[i]->adaptive)
            list[count++] = (solver){.library = "laglab",
                                     .method = ll_ode_methods[i]->name,
                                     .newton = ll_ode_methods[i]->a_stable,
                                     .kind = ll_ode_methods[i],
                                     .open = open_run,
                                     .run = run,
                                     .count = count_run,
                                     .close = close_run};
    return count;
}
