/* A ball on a floor made of a stiff spring: the penalty method of games. */
#include "ode/core/problem_rows.h"
#include "ode/problems/special.h"

typedef struct params {
    double g, k, h;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, g, "m/s2", 0.01, 1000, 10, "Gravity."),
    LL_ODE_PARAM(params, k, "N/m", 1, 1e9, 1e5, "Stiffness of the floor; the mass is 1 kg."),
    LL_ODE_PARAM(params, h, "m", 1e-3, 1e4, 1, "Initial height."),
};
LL_ODE_TABLE(ll_ode_penalty_floor_table, "penalty_floor", "Parameters of the floor.", rows, params);

static void acceleration(const void *p, double t, const double *q, const double *v, double *a)
{
    (void)t, (void)v;
    const params *c = p;
    a[0] = -c->g - (q[0] < 0 ? c->k * q[0] : 0);
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2, .autonomous = true, .params = p, .acceleration = acceleration};
}

static void start(const void *p, double *y)
{
    y[0] = ((const params *)p)->h;
    y[1] = 0;
}

/* A period is a fall, a contact of over half an oscillation, and a rise. */
static bool exact(const void *p, double t, double *y)
{
    const params *c = p;
    double w = ll_sqrt(c->k), fall = ll_sqrt(2 * c->h / c->g), v = c->g * fall;
    double contact = 2 / w * (3.14159265358979323846 - ll_ode_atan(v * w / c->g)),
           period = 2 * fall + contact;
    t -= period * (double)(long long)(t / period);
    if (t > fall && t < fall + contact) {
        double s = t - fall, sag = c->g / c->k;
        y[0] = -sag + sag * ll_cos(w * s) - v / w * ll_sin(w * s);
        y[1] = -sag * w * ll_sin(w * s) - v * ll_cos(w * s);
        return true;
    }
    double from_apex = t <= fall ? t : t - period;
    y[0] = c->h - c->g * from_apex * from_apex / 2;
    y[1] = -c->g * from_apex;
    return true;
}

static double energy(const void *p, double t, const double *y)
{
    (void)t;
    const params *c = p;
    return y[1] * y[1] / 2 + c->g * y[0] + (y[0] < 0 ? c->k * y[0] * y[0] / 2 : 0);
}

static const char *const components[] = {"y_m", "v_mps"};

const ll_ode_problem ll_ode_penalty_floor = {.name = "penalty_floor",
                                             .help = "A ball on a floor made of a stiff spring.",
                                             .source = "closed form",
                                             .params = &ll_ode_penalty_floor_table,
                                             .system = system_of,
                                             .duration = 0.9,
                                             .start = start,
                                             .components = components,
                                             .exact = exact,
                                             .energy = energy};
