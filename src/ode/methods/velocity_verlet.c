/* Velocity Verlet: q+ = q + h v + h^2 a / 2, v+ = v + h (a + a+) / 2. A force independent of v is evaluated
 * once per step: a+ is kept for the next one. A force that depends on v is evaluated twice, and the methods
 * differ in the velocity for a+. */
#include "ode/core/method_internal.h"

typedef struct variant {
    double predict; /* a+ sees v + predict h a */
} variant;

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    double predict = ((const variant *)method->data)->predict * h;
    int half = run->dim / 2;
    const double *q = ll_ode_state_y(run), *v = q + half;
    double *a = ll_ode_work(run, 0), *after = a + half, *next = ll_ode_next(run), *v_next = next + half;
    if (run->history == 0)
        ll_ode_a(run, ode, run->t, q, v, a);
    run->history = 1;
    for (int i = 0; i < half; i++) {
        next[i] = q[i] + h * v[i] + h * h / 2 * a[i];
        v_next[i] = v[i] + predict * a[i];
    }
    ll_ode_a(run, ode, run->t + h, next, v_next, after);
    for (int i = 0; i < half; i++)
        v_next[i] = v[i] + h / 2 * (a[i] + after[i]);
    return 0;
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method, (void)h;
    int half = run->dim / 2;
    double *a = ll_ode_work(run, 0);
    for (int i = 0; i < half; i++)
        a[i] = a[half + i];
    run->history = !ode->velocity_dependent;
}

static const ll_ode_body body = {.vectors = 1, .attempt = attempt, .accept = accept};

const ll_ode_method ll_ode_velocity_verlet = {
    .name = "velocity_verlet",
    .help = "Position by the last acceleration, velocity by the mean of both; a force sees the old velocity.",
    .source = "W. C. Swope, H. C. Andersen, P. H. Berens, K. R. Wilson, J. Chem. Phys. 76, 1982",
    .order = 2,
    .order_velocity = 1,
    .evaluations = 1,
    .symplectic = true,
    .reversible = true,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const variant){0}};

const ll_ode_method ll_ode_velocity_verlet_predicted = {
    .name = "velocity_verlet_predicted",
    .help = "Velocity Verlet whose force sees the velocity v + a dt: of order 2 with drag too.",
    .source = "R. D. Groot, P. B. Warren, J. Chem. Phys. 107, 1997",
    .order = 2,
    .evaluations = 1,
    .symplectic = true,
    .reversible = true,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const variant){1}};
