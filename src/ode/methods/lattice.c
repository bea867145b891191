/* Leapfrog in fixed point, Q32.32: positions and velocities are integer multiples of 2^-32, and a kick adds a
 * rounded function of the position only. So every step can be undone to the last bit, unlike in floating
 * point (D. Levesque, L. Verlet, J. Stat. Phys. 72, 1993). */
#include "ode/core/method_internal.h"

static const double unit = 0x1p-32,
                    limit = 0x1p20; /* a double represents every multiple of the unit below the limit */

/* Nearest integer, ties to even, for |x| < 2^51; odd: -x gives the negative. */
static int64_t nearest(double x)
{
    const double shift = 0x1.8p52;
    return (int64_t)((x + shift) - shift);
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method;
    int half = run->dim / 2;
    const double *y = ll_ode_state_y(run);
    double *q = ll_ode_next(run), *v = q + half, *a = ll_ode_work(run, 0);
    for (int i = 0; i < run->dim; i++) {
        if (!(y[i] < limit && y[i] > -limit))
            q[i] = (double)__builtin_inff();
        else
            q[i] = (double)nearest(y[i] / unit) * unit;
    }
    for (int part = 0; part < 2; part++) {
        ll_ode_a(run, ode, run->t + part * h, q, v, a);
        for (int i = 0; i < half; i++) {
            v[i] += (double)nearest(h / 2 * a[i] / unit) * unit;
            if (part == 0)
                q[i] += (double)nearest(h * v[i] / unit) * unit;
        }
    }
    return 0;
}

static const ll_ode_body body = {.vectors = 1, .attempt = attempt};

const ll_ode_method ll_ode_verlet_lattice = {
    .name = "verlet_lattice",
    .help = "Leapfrog in fixed point, Q32.32: reversible to the last bit. For values below 1,048,576.",
    .source = "D. Levesque, L. Verlet, J. Stat. Phys. 72, 1993",
    .order = 2,
    .order_velocity = 1,
    .evaluations = 2,
    .symplectic = true,
    .reversible = true,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body};
