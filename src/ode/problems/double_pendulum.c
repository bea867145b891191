/* Double pendulum in angles: an acceleration that depends on velocities, and chaos. Unit masses and
 * lengths. */
#include "ode/core/problem_rows.h"

typedef struct params {
    double g, theta1, theta2;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, g, "m/s2", 0.01, 1000, 10, "Gravity."),
    LL_ODE_PARAM(params, theta1, "rad", -3.15, 3.15, 2, "Initial upper angle, at rest; 0 hangs down."),
    LL_ODE_PARAM(params, theta2, "rad", -3.15, 3.15, 2, "Initial lower angle."),
};
LL_ODE_TABLE(ll_ode_double_pendulum_table, "double_pendulum", "Parameters of the double pendulum.", rows,
             params);

/* Lagrange's equations: 2 a1 + c a2 = -s w2^2 - 2 g sin th1, c a1 + a2 = s w1^2 - g sin th2, with c and s of
 * the difference of the angles. */
LL_ODE_ACCELERATION(acceleration, 4, {
    double g = ((const params *)p)->g;
    real x = q[0], y = q[1], d = x - y, s, c;
    ll_real_sincos(d, &s, &c);
    real f1 = -s * v[1] * v[1] - 2 * g * ll_real_sin(x), f2 = s * v[0] * v[0] - g * ll_real_sin(y);
    real determinant = 2 - c * c;
    a[0] = (f1 - c * f2) / determinant;
    a[1] = (2 * f2 - c * f1) / determinant;
})

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration)};

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 4,
                    .autonomous = true,
                    .velocity_dependent = true,
                    .params = p,
                    .acceleration = acceleration,
                    .kernels = &kernels};
}

static void start(const void *p, double *y)
{
    const params *c = p;
    y[0] = c->theta1;
    y[1] = c->theta2;
    y[2] = y[3] = 0;
}

static double energy(const void *p, double t, const double *y)
{
    (void)t;
    double g = ((const params *)p)->g;
    return y[2] * y[2] + y[3] * y[3] / 2 + ll_cos(y[0] - y[1]) * y[2] * y[3] - 2 * g * ll_cos(y[0]) -
           g * ll_cos(y[1]);
}

static const double reference[] = {-1.50603586835282372, -4.31058980967322825, -1.98117844326947505,
                                   -5.79165359773206454};
static const char *const components[] = {"theta1_rad", "theta2_rad", "omega1_radps", "omega2_radps"};

const ll_ode_problem ll_ode_double_pendulum = {.name = "double_pendulum",
                                               .help = "Two pendulums in a row: chaos.",
                                               .source = "binary128 reference",
                                               .params = &ll_ode_double_pendulum_table,
                                               .system = system_of,
                                               .duration = 5,
                                               .start = start,
                                               .components = components,
                                               .reference = reference,
                                               .floor = 1e-14,
                                               .energy = energy};
