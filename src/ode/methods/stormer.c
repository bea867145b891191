/* Stormer's recurrence of positions and its variants: q+ = q + p (q - q-) + w a.
 *
 * The first step, and one up to an event, starts from the velocity: q+ = q + h v + h^2 a / 2. The reported
 * velocity, (q+ - q) / h + h a+ / 2, is the central difference if the force is independent of v. The
 * acceleration sees the backward difference (q+ - q) / h, and is of first order if it depends on v. */
#include "ode/core/method_internal.h"

typedef struct recurrence {
    /* p and w of a step of `h` after one of `last`. */
    void (*weights)(double h, double last, double *p, double *w);
    bool backward; /* the reported velocity is the backward difference too */
} recurrence;

/* Work vectors: the last position, the acceleration now (first half) and after the step (second half), the
 * length of the last step. */
static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const recurrence *r = method->data;
    int half = run->dim / 2;
    const double *q = ll_ode_state_y(run), *v = q + half, *before = ll_ode_work(run, 0);
    double *a = ll_ode_work(run, 1), *after = a + half, *next = ll_ode_next(run), *v_next = next + half;
    if (run->history == 0)
        ll_ode_a(run, ode, run->t, q, v, a);
    if (run->history < 2 || run->partial) {
        run->history = run->history == 2 ? 2 : 1;
        for (int i = 0; i < half; i++)
            next[i] = q[i] + h * v[i] + h * h / 2 * a[i];
    } else {
        double p, w;
        r->weights(h, *ll_ode_work(run, 2), &p, &w);
        for (int i = 0; i < half; i++)
            next[i] = q[i] + p * (q[i] - before[i]) + w * a[i];
    }
    for (int i = 0; i < half; i++)
        v_next[i] = (next[i] - q[i]) / h;
    ll_ode_a(run, ode, run->t + h, next, v_next, after);
    for (int i = 0; i < half && !r->backward; i++)
        v_next[i] += h / 2 * after[i];
    return 0;
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method, (void)ode;
    int half = run->dim / 2;
    const double *last = ll_ode_next(run);
    double *before = ll_ode_work(run, 0), *a = ll_ode_work(run, 1);
    for (int i = 0; i < half; i++) {
        before[i] = last[i];
        a[i] = a[half + i];
    }
    *ll_ode_work(run, 2) = h;
    run->history = run->partial ? 1 : 2;
}

static const ll_ode_body body = {.vectors = 3, .attempt = attempt, .accept = accept};

static void constant_step(double h, double last, double *p, double *w)
{
    (void)last;
    *p = 1;
    *w = h * h;
}

static void half_of_it(double h, double last, double *p, double *w)
{
    (void)last;
    *p = 1;
    *w = h * h / 2;
}

static void ratio(double h, double last, double *p, double *w)
{
    *p = h / last;
    *w = h * h;
}

static void ratio_and_mean(double h, double last, double *p, double *w)
{
    *p = h / last;
    *w = h * (h + last) / 2;
}

const ll_ode_method ll_ode_stormer_verlet = {
    .name = "stormer_verlet",
    .help = "Positions from the last two: s+ = 2 s - s- + a dt^2. Needs a constant step.",
    .source = "C. Stormer, Arch. Sci. Phys. Nat. 24, 1907; L. Verlet, Phys. Rev. 159, 1967",
    .order = 2,
    .order_velocity = 1,
    .evaluations = 1,
    .symplectic = true,
    .reversible = true,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const recurrence){.weights = constant_step}};

const ll_ode_method ll_ode_verlet_as_printed = {
    .name = "verlet_as_printed",
    .help = "The paper's recurrence, s+ = 2 s - s- + a dt^2 / 2, which has half the acceleration.",
    .source = "The paper, section on Verlet integration; an error: stormer_verlet is right",
    .order = 0,
    .evaluations = 1,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const recurrence){.weights = half_of_it, .backward = true}};

const ll_ode_method ll_ode_verlet_time_corrected = {
    .name = "verlet_time_corrected",
    .help = "Stormer-Verlet for a variable step: the last displacement scaled by the ratio of the steps.",
    .source = "J. Dummer, A Simple Time-Corrected Verlet Integration Method, 2005",
    .order = 2,
    .order_velocity = 1,
    .evaluations = 1,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const recurrence){.weights = ratio}};

const ll_ode_method ll_ode_verlet_improved = {
    .name = "verlet_improved",
    .help =
        "As verlet_time_corrected, with the acceleration over the mean of both steps: exact for a constant "
        "force.",
    .source = "Second-order divided difference over unequal steps",
    .order = 2,
    .order_velocity = 1,
    .evaluations = 1,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const recurrence){.weights = ratio_and_mean}};
