/* Adams-Bashforth: y+ = y + h (b[0] f + b[1] f- + ...): the integral over the step of the polynomial through
 * earlier slopes (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, III.5). If earlier
 * steps had other lengths, the weights are computed from these, so that the order holds. At the start and
 * after an event, rk4 makes the missing slopes. */
#include <string.h>

#include "ode/core/method_internal.h"

enum { STEPS_MAX = 4 };

/* 1 / sqrt(3), a node of Gauss's rule, which is exact up to the third degree */
#define NODE 0.57735026918962576

typedef struct coefficients {
    int steps;
    double b[STEPS_MAX];
} coefficients;

static void rk4(ll_ode_run *run, const ll_ode *ode, double h, const double *k1)
{
    const double *y = ll_ode_state_y(run);
    double *next = ll_ode_next(run), *k = ll_ode_work(run, STEPS_MAX), *sum = ll_ode_work(run, STEPS_MAX + 1);
    static const double node[] = {0.5, 0.5, 1}, weight[] = {2, 2, 1};
    for (int i = 0; i < run->dim; i++)
        k[i] = sum[i] = k1[i];
    for (int s = 0; s < 3; s++) {
        for (int i = 0; i < run->dim; i++)
            next[i] = y[i] + node[s] * h * k[i];
        ll_ode_f(run, ode, run->t + node[s] * h, next, k);
        for (int i = 0; i < run->dim; i++)
            sum[i] += weight[s] * k[i];
    }
    for (int i = 0; i < run->dim; i++)
        next[i] = y[i] + h / 6 * sum[i];
}

static size_t extra(int dim)
{
    (void)dim;
    return STEPS_MAX; /* lengths of the last steps, latest first */
}

/* The polynomial that is 1 at node j of `count` and 0 at the others. */
static double lagrange(const double *places, int count, int j, double at)
{
    double value = 1;
    for (int i = 0; i < count; i++)
        if (i != j)
            value *= (at - places[i]) / (places[j] - places[i]);
    return value;
}

/* Weights of the slopes for a step of `h` after steps of lengths `past`. */
static void weights(const coefficients *c, const double *past, double h, double *b)
{
    double places[STEPS_MAX] = {0};
    bool even = true;
    for (int j = 1; j < c->steps; j++) {
        places[j] = places[j - 1] - past[j - 1];
        even &= past[j - 1] == h;
    }
    for (int j = 0; j < c->steps; j++)
        b[j] = even ? c->b[j]
                    : 0.5 * (lagrange(places, c->steps, j, 0.5 * h * (1 - NODE)) +
                             lagrange(places, c->steps, j, 0.5 * h * (1 + NODE)));
}

/* Work vector j holds f of j steps ago; `history` counts the valid ones besides f itself. */
static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const coefficients *c = method->data;
    const double *y = ll_ode_state_y(run);
    double *f = ll_ode_work(run, 0), *next = ll_ode_next(run), b[STEPS_MAX];
    ll_ode_f(run, ode, run->t, y, f);
    if (run->partial || run->history < c->steps - 1) {
        rk4(run, ode, h, f);
        return 0;
    }
    weights(c, ll_ode_extra(run, method), h, b);
    for (int i = 0; i < run->dim; i++) {
        double sum = 0;
        for (int j = 0; j < c->steps; j++)
            sum += b[j] * f[j * run->stride + i];
        next[i] = y[i] + h * sum;
    }
    return 0;
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)ode;
    const coefficients *c = method->data;
    double *f = ll_ode_work(run, 0), *past = ll_ode_extra(run, method);
    memmove(f + run->stride, f, (size_t)((c->steps - 1) * run->stride) * sizeof *f);
    memmove(past + 1, past, (STEPS_MAX - 1) * sizeof *past);
    past[0] = h;
    if (run->partial || run->event >= 0) /* slopes before a jump are not valid after it */
        run->history = 0;
    else if (run->history < c->steps - 1)
        run->history++;
}

static const ll_ode_body body = {
    .vectors = STEPS_MAX + 2, .extra = extra, .attempt = attempt, .accept = accept};

const ll_ode_method ll_ode_ab2 = {.name = "ab2",
                                  .help = "Two-step Adams-Bashforth; starts with one step of rk4.",
                                  .source = "F. Bashforth, J. C. Adams, Theories of Capillary Action, 1883",
                                  .order = 2,
                                  .evaluations = 1,
                                  .body = &body,
                                  .data = &(const coefficients){2, {3. / 2, -1. / 2}}};

const ll_ode_method ll_ode_ab3 = {.name = "ab3",
                                  .help = "Three-step Adams-Bashforth; starts with two steps of rk4.",
                                  .source = "F. Bashforth, J. C. Adams, Theories of Capillary Action, 1883",
                                  .order = 3,
                                  .evaluations = 1,
                                  .body = &body,
                                  .data = &(const coefficients){3, {23. / 12, -16. / 12, 5. / 12}}};

const ll_ode_method ll_ode_ab4 = {.name = "ab4",
                                  .help = "Four-step Adams-Bashforth; starts with three steps of rk4.",
                                  .source = "F. Bashforth, J. C. Adams, Theories of Capillary Action, 1883",
                                  .order = 4,
                                  .evaluations = 1,
                                  .body = &body,
                                  .data =
                                      &(const coefficients){4, {55. / 24, -59. / 24, 37. / 24, -9. / 24}}};
