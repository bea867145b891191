/* Implicit methods of one stage: z = base + theta h f(z), solved by Newton's iteration to rounding. */
#include "ode/internal.h"
#include "ode/linear.h"

typedef struct stage {
    double theta;
    double node;    /* z is at t + node h */
    bool trapezoid; /* base = y + (1 - theta) h f(y), otherwise y */
    bool midpoint;  /* y+ = 2 z - y, otherwise z */
} stage;

enum { BASE, Z, F, CHANGE, SCRATCH, VECTORS = SCRATCH + 2 };

static size_t extra(int dim)
{
    size_t n = (size_t)dim;
    return 2 * n * n + (n + 1) / 2; /* Jacobian, its factorisation, row exchanges */
}

static double largest(const double *x, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++) {
        double size = x[i] < 0 ? -x[i] : x[i];
        most = size <= most ? most : size; /* NaN comes through */
    }
    return most;
}

/* Factorises I - w J at z. */
static bool factorise(ll_ode_run *run, const ll_ode *ode, double t, double w, double *jacobian, double *lu,
                      int32_t *pivot)
{
    int n = run->dim;
    ll_ode_jacobian_at(run, ode, t, ll_ode_work(run, Z), ll_ode_work(run, F), jacobian,
                       ll_ode_work(run, SCRATCH));
    for (int i = 0; i < n * n; i++)
        lu[i] = (i % (n + 1) == 0) - w * jacobian[i];
    run->counters.factorisations++;
    return ll_lu_factorise(n, lu, pivot);
}

/* Ends when a change is at rounding level: below 1e-15 of z, or no longer falling once below 1e-9. The
 * Jacobian is made anew at z whenever a change falls by less than ten times. */
static bool newton(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double t, double w)
{
    enum { ITERATIONS = 50 };
    int n = run->dim;
    double *base = ll_ode_work(run, BASE), *z = ll_ode_work(run, Z), *f = ll_ode_work(run, F);
    double *change = ll_ode_work(run, CHANGE), last = 0;
    double *jacobian = ll_ode_extra(run, method), *lu = jacobian + n * n;
    int32_t *pivot = (int32_t *)(lu + n * n);
    bool fresh = true;
    for (int i = 0; i < ITERATIONS; i++) {
        ll_ode_f(run, ode, t, z, f);
        if (fresh && !factorise(run, ode, t, w, jacobian, lu, pivot))
            return false;
        for (int j = 0; j < n; j++)
            change[j] = base[j] + w * f[j] - z[j];
        ll_lu_solve(n, lu, pivot, change);
        run->counters.solves++;
        for (int j = 0; j < n; j++)
            z[j] += change[j];
        double size = largest(change, n), whole = largest(z, n);
        if (!(size - size == 0))
            return false;
        if (size <= 1e-15 * whole || (i > 0 && size >= last / 2 && size <= 1e-9 * whole))
            return true;
        fresh = i > 0 && size > last / 10;
        last = size;
    }
    return false;
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const stage *s = method->data;
    int n = run->dim;
    const double *y = ll_ode_state_y(run);
    double *base = ll_ode_work(run, BASE), *z = ll_ode_work(run, Z), *f = ll_ode_work(run, F);
    double *next = ll_ode_next(run);
    if (s->trapezoid)
        ll_ode_f(run, ode, run->t, y, f);
    for (int i = 0; i < n; i++) {
        base[i] = s->trapezoid ? y[i] + (1 - s->theta) * h * f[i] : y[i];
        z[i] = y[i];
    }
    if (!newton(run, method, ode, run->t + s->node * h, s->theta * h))
        return (double)__builtin_nanf("");
    for (int i = 0; i < n; i++)
        next[i] = s->midpoint ? 2 * z[i] - y[i] : z[i];
    return 0;
}

static const ll_ode_body body = {.vectors = VECTORS, .extra = extra, .attempt = attempt};

const ll_ode_method ll_ode_implicit_euler = {
    .name = "implicit_euler",
    .help = "Both advance by the slopes at the end of the step, found by Newton's iteration: stable at any "
            "step, and it damps.",
    .source = "Hairer, Wanner, Solving Ordinary Differential Equations II, IV.1",
    .order = 1,
    .a_stable = true,
    .body = &body,
    .data = &(const stage){.theta = 1, .node = 1}};

const ll_ode_method ll_ode_implicit_midpoint = {
    .name = "implicit_midpoint",
    .help = "The slope at the mean of both ends: stable at any step, and it keeps quadratic invariants.",
    .source = "Hairer, Lubich, Wanner, Geometric Numerical Integration, II.1",
    .order = 2,
    .symplectic = true,
    .reversible = true,
    .a_stable = true,
    .body = &body,
    .data = &(const stage){.theta = 0.5, .node = 0.5, .midpoint = true}};

const ll_ode_method ll_ode_trapezoid = {.name = "trapezoid",
                                        .help = "The mean of the slopes at both ends.",
                                        .source = "G. Dahlquist, BIT 3, 1963",
                                        .order = 2,
                                        .reversible = true,
                                        .a_stable = true,
                                        .body = &body,
                                        .data = &(const stage){.theta = 0.5, .node = 1, .trapezoid = true}};
