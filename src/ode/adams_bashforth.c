/* Adams-Bashforth: y+ = y + h (b[0] f + b[1] f- + ...). The past that is missing at the start, and a step of
 * another length, is made by rk4. */
#include <string.h>

#include "ode/internal.h"

enum { STEPS_MAX = 4 };

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

/* Work vector j holds f of j steps ago; history counts how many of them are there besides f itself. */
static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const coefficients *c = method->data;
    const double *y = ll_ode_state_y(run);
    double *f = ll_ode_work(run, 0), *next = ll_ode_next(run);
    ll_ode_f(run, ode, run->t, y, f);
    if (run->partial || run->history < c->steps - 1) {
        rk4(run, ode, h, f);
        return 0;
    }
    for (int i = 0; i < run->dim; i++) {
        double sum = 0;
        for (int j = 0; j < c->steps; j++)
            sum += c->b[j] * f[j * run->stride + i];
        next[i] = y[i] + h * sum;
    }
    return 0;
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)ode, (void)h;
    const coefficients *c = method->data;
    double *f = ll_ode_work(run, 0);
    memmove(f + run->stride, f, (size_t)((c->steps - 1) * run->stride) * sizeof *f);
    if (run->partial)
        run->history = 0;
    else if (run->history < c->steps - 1)
        run->history++;
}

static const ll_ode_body body = {.vectors = STEPS_MAX + 2, .attempt = attempt, .accept = accept};

const ll_ode_method ll_ode_ab2 = {.name = "ab2",
                                  .help = "Adams-Bashforth of two steps; its first is made by rk4.",
                                  .source = "F. Bashforth, J. C. Adams, Theories of Capillary Action, 1883",
                                  .order = 2,
                                  .evaluations = 1,
                                  .body = &body,
                                  .data = &(const coefficients){2, {3. / 2, -1. / 2}}};

const ll_ode_method ll_ode_ab3 = {.name = "ab3",
                                  .help = "Adams-Bashforth of three steps; its first two are made by rk4.",
                                  .source = "F. Bashforth, J. C. Adams, Theories of Capillary Action, 1883",
                                  .order = 3,
                                  .evaluations = 1,
                                  .body = &body,
                                  .data = &(const coefficients){3, {23. / 12, -16. / 12, 5. / 12}}};

const ll_ode_method ll_ode_ab4 = {.name = "ab4",
                                  .help = "Adams-Bashforth of four steps; its first three are made by rk4.",
                                  .source = "F. Bashforth, J. C. Adams, Theories of Capillary Action, 1883",
                                  .order = 4,
                                  .evaluations = 1,
                                  .body = &body,
                                  .data =
                                      &(const coefficients){4, {55. / 24, -59. / 24, 37. / 24, -9. / 24}}};
