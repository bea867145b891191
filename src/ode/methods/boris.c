/* Boris: half a drift, half of the electric kick, a rotation about b, the other halves. The rotation keeps
 * |v|. */
#include "ode/core/method_internal.h"

static void cross(const double *v, const double *b, double *out)
{
    out[0] = v[1] * b[2] - v[2] * b[1];
    out[1] = v[2] * b[0] - v[0] * b[2];
    out[2] = v[0] * b[1] - v[1] * b[0];
}

/* By the angle 2 atan(|b| h / 2): v+ = v- + (v- + v- x s) x 2 s / (1 + s^2), s = b h / 2. */
static void rotate(double *v, const double *b, double h)
{
    double s[3] = {b[0] * h / 2, b[1] * h / 2, b[2] * h / 2}, turn[3], middle[3];
    double weight = 2 / (1 + s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    cross(v, s, turn);
    for (int i = 0; i < 3; i++)
        middle[i] = v[i] + turn[i];
    cross(middle, s, turn);
    for (int i = 0; i < 3; i++)
        v[i] += weight * turn[i];
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method;
    int half = run->dim / 2;
    const double *y = ll_ode_state_y(run);
    double *q = ll_ode_next(run), e[3] = {0}, b[3], v[3] = {0};
    for (int i = 0; i < half; i++) {
        v[i] = y[half + i];
        q[i] = y[i] + h / 2 * v[i];
    }
    run->counters.evaluations++;
    ode->magnetic(ode->params, run->t + h / 2, q, e, b);
    if (half == 2)
        b[0] = b[1] = 0;
    for (int i = 0; i < half; i++)
        v[i] += h / 2 * e[i];
    rotate(v, b, h);
    for (int i = 0; i < half; i++) {
        v[i] += h / 2 * e[i];
        q[i] += h / 2 * v[i];
        q[half + i] = v[i];
    }
    return 0;
}

static const ll_ode_body body = {.attempt = attempt};

const ll_ode_method ll_ode_boris = {
    .name = "boris",
    .help = "A rotation about the magnetic field between two halves of the electric kick.",
    .source = "J. P. Boris, Proc. 4th Conf. Numer. Simul. Plasmas, 1970",
    .order = 2,
    .evaluations = 1,
    .reversible = true,
    .needs = LL_ODE_NEEDS_MECHANICAL | LL_ODE_NEEDS_MAGNETIC,
    .body = &body};
