/* Dry friction: a block slides to a stop. `coulomb` locates the stop; the force of `coulomb_naive` only uses
 * the sign of the velocity, and chatters at rest. */
#include "ode/core/problem_rows.h"

typedef struct params {
    double mu_g, v0;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, mu_g, "m/s2", 1e-3, 1000, 2, "Deceleration by friction."),
    LL_ODE_PARAM(params, v0, "m/s", 0, 1000, 3, "Initial speed."),
};
LL_ODE_TABLE(ll_ode_coulomb_table, "coulomb", "Parameters of the sliding block.", rows, params);
LL_ODE_TABLE(ll_ode_coulomb_naive_table, "coulomb_naive", "Parameters of the sliding block.", rows, params);

static void acceleration(const void *p, double t, const double *q, const double *v, double *a)
{
    (void)t, (void)q;
    double mu_g = ((const params *)p)->mu_g;
    a[0] = v[0] > 0 ? -mu_g : v[0] < 0 ? mu_g : 0;
}

static double speed(const void *p, double t, const double *y)
{
    (void)p, (void)t;
    return y[1];
}

static ll_ode_action hold(const void *p, double t, double *y)
{
    (void)p, (void)t;
    y[1] = 0;
    return LL_ODE_REST;
}

static const ll_ode_event stop = {.name = "stop", .direction = -1, .g = speed, .jump = hold};

static void naive_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){
        .dim = 2, .autonomous = true, .velocity_dependent = true, .params = p, .acceleration = acceleration};
}

static void system_of(const void *p, ll_ode *ode)
{
    naive_system(p, ode);
    ode->events = &stop;
    ode->event_count = 1;
}

static void start(const void *p, double *y)
{
    y[0] = 0;
    y[1] = ((const params *)p)->v0;
}

static bool exact(const void *p, double t, double *y)
{
    const params *c = p;
    double end = c->v0 / c->mu_g, s = t < end ? t : end;
    y[0] = (c->v0 - c->mu_g * s / 2) * s;
    y[1] = t < end ? c->v0 - c->mu_g * t : 0;
    return true;
}

static const char *const components[] = {"x_m", "v_mps"};

const ll_ode_problem ll_ode_coulomb = {.name = "coulomb",
                                       .help =
                                           "A block slides to a stop by dry friction; the stop is located.",
                                       .source = "closed form",
                                       .params = &ll_ode_coulomb_table,
                                       .system = system_of,
                                       .duration = 5,
                                       .start = start,
                                       .components = components,
                                       .exact = exact};

const ll_ode_problem ll_ode_coulomb_naive = {
    .name = "coulomb_naive",
    .help = "The same with a force from the sign of the velocity: it chatters.",
    .source = "closed form",
    .params = &ll_ode_coulomb_naive_table,
    .system = naive_system,
    .duration = 5,
    .start = start,
    .components = components,
    .exact = exact};
