/* Implicit one-stage methods: z = base + theta h f(z), solved by Newton's iteration to rounding.
 *
 * Such equations may have several solutions, or none. The wanted one is connected to y as the step grows from
 * 0. So the iteration is damped: it follows its path and does not jump (P. Deuflhard, Newton Methods for
 * Nonlinear Problems, 2004, 3.3: restricted natural monotonicity test). If that fails, the solution is
 * followed from y through growing fractions of the step. At a kink of f both may fail; then the iteration is
 * tried undamped. A result is checked: from y, where det(I - w J) is 1, it cannot have passed a turning point
 * if the determinant is positive. If no solution is found, the step fails. */
#include "base/detmath.h"
#include "ode/core/linear.h"
#include "ode/core/method_internal.h"

typedef struct stage {
    double theta;
    double node;    /* z is at t + node h */
    bool trapezoid; /* base = y + (1 - theta) h f(y), else y */
    bool midpoint;  /* y+ = 2 z - y, else z */
} stage;

enum { BASE, PART, Z, KEPT, F, CHANGE, TRIAL, TRIAL_F, NEXT_CHANGE, WEIGHT, SCRATCH, VECTORS = SCRATCH + 2 };

static size_t extra(int dim)
{
    size_t n = (size_t)dim;
    return 2 * n * n + (n + 1) / 2; /* Jacobian, its factorisation, row exchanges */
}

/* The equation z = base + w f(t, z). */
typedef struct equation {
    ll_ode_run *run;
    const ll_ode *ode;
    double t, w;
    const double *base;
    double *z, *f, *jacobian, *lu;
    int32_t *pivot;
    double whole; /* largest component at the start of the step */
} equation;

static double largest(const double *x, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++) {
        double size = ll_abs(x[i]);
        most = size <= most ? most : size; /* keeps NaN */
    }
    return most;
}

/* A component counts relative to its own magnitude, so that small ones matter too. Near 0, SMALL of the
 * largest component and of the terms of its sum is the limit: below that there is only rounding. */
#define SMALL 1e-6

static void weigh(equation *e)
{
    int n = e->run->dim;
    double *weight = ll_ode_work(e->run, WEIGHT);
    for (int i = 0; i < n; i++) {
        double sum = e->whole;
        for (int j = 0; j < n; j++)
            sum += ll_abs(e->w * e->jacobian[i * n + j] * e->z[j]);
        weight[i] = ll_abs(e->z[i]) + ll_abs(e->base[i]) + SMALL * sum;
    }
}

static double size_of(const equation *e, const double *change)
{
    const double *weight = ll_ode_work(e->run, WEIGHT);
    double most = 0;
    for (int i = 0; i < e->run->dim; i++) {
        double size = ll_abs(change[i]) / (weight[i] > 0 ? weight[i] : 1);
        most = size <= most ? most : size; /* keeps NaN */
    }
    return most;
}

/* Factorises I - w J at z, where f is known. */
static bool factorise(equation *e)
{
    int n = e->run->dim;
    ll_ode_jacobian_at(e->run, e->ode, e->t, e->z, e->f, e->jacobian, ll_ode_work(e->run, SCRATCH));
    weigh(e);
    for (int i = 0; i < n * n; i++)
        e->lu[i] = (i % (n + 1) == 0) - e->w * e->jacobian[i];
    e->run->counters.factorisations++;
    return ll_lu_factorise(n, e->lu, e->pivot);
}

/* Newton's change at z, or at another point with the same matrix. */
static double change_at(equation *e, const double *z, const double *f, double *change)
{
    int n = e->run->dim;
    for (int i = 0; i < n; i++)
        change[i] = e->base[i] + e->w * f[i] - z[i];
    ll_lu_solve(n, e->lu, e->pivot, change);
    e->run->counters.solves++;
    return size_of(e, change);
}

typedef enum progress { WORSE, SLOW, FAST } progress;

/* Tries the fraction `part` of the change. Moves z if the remaining change has decreased enough, and sets
 * `*size` to it. */
static progress move(equation *e, double part, double *size)
{
    int n = e->run->dim, stride = e->run->stride;
    double *trial = ll_ode_work(e->run, TRIAL), *f = ll_ode_work(e->run, TRIAL_F);
    double *change = ll_ode_work(e->run, CHANGE), *next = ll_ode_work(e->run, NEXT_CHANGE);
    for (int i = 0; i < n; i++)
        trial[i] = e->z[i] + part * change[i];
    ll_ode_f(e->run, e->ode, e->t, trial, f);
    double left = change_at(e, trial, f, next);
    if (!(left <= (1 - part / 4) * *size))
        return WORSE;
    ll_ode_copy(stride, trial, e->z);
    ll_ode_copy(stride, f, e->f);
    ll_ode_copy(stride, next, change);
    progress made = part == 1 && left <= 0.1 * *size ? FAST : SLOW;
    *size = left;
    return made;
}

/* Iterates from z, where `e->f` is f, to the solution. Ends when the change is at rounding level: below
 * 1e-15, or not decreasing below 1e-9. Keeps the matrix as long as the changes decrease fast. */
static bool iterate(equation *e)
{
    enum { ITERATIONS = 100 };
    const double least = 1e-4;
    double part = 1, size = 0;
    bool known = false, stale = false; /* of the matrix: it exists; it belongs to an earlier z */
    for (int i = 0; i < ITERATIONS; i++) {
        if (!known) {
            if (!factorise(e))
                return false;
            size = change_at(e, e->z, e->f, ll_ode_work(e->run, CHANGE));
            known = true;
            stale = false;
        }
        if (!(size - size == 0) || part < least)
            return false;
        progress made = size <= 1e-15 ? WORSE : move(e, part, &size);
        if (made == WORSE && size <= 1e-9)
            return ll_lu_positive(e->run->dim, e->lu, e->pivot);
        if (made == WORSE && stale)
            known = false;
        else if (made == WORSE)
            part /= 2;
        else if (made == SLOW)
            known = false, part = part < 0.5 ? 2 * part : 1;
        else
            stale = true;
    }
    return false;
}

/* Solves for growing fractions of the step from y on, each from the last solution. */
static bool follow(const equation *whole, const double *y)
{
    const double least = 1. / 256;
    ll_ode_run *run = whole->run;
    equation e = *whole;
    double *base = ll_ode_work(run, PART), *kept = ll_ode_work(run, KEPT), done = 0, more = 0.25;
    e.base = base;
    ll_ode_copy(run->stride, y, kept);
    while (done < 1 && more >= least) {
        double to = done + more < 1 ? done + more : 1;
        for (int i = 0; i < run->dim; i++)
            base[i] = y[i] + to * (whole->base[i] - y[i]);
        e.w = to * whole->w;
        ll_ode_copy(run->stride, kept, e.z);
        ll_ode_f(run, e.ode, e.t, e.z, e.f);
        if (iterate(&e)) {
            ll_ode_copy(run->stride, e.z, kept);
            done = to;
        } else {
            more /= 2;
        }
    }
    return done == 1;
}

/* Undamped, from y, with a new matrix each time: at a kink of f, such as a floor of springs, the matrix of
 * one side is useless on the other. No matrix on the way may be beyond a turning point. */
static bool hop(equation *e, const double *y)
{
    enum { ITERATIONS = 50 };
    double *change = ll_ode_work(e->run, CHANGE), last = 0;
    ll_ode_copy(e->run->stride, y, e->z);
    for (int i = 0; i < ITERATIONS; i++) {
        ll_ode_f(e->run, e->ode, e->t, e->z, e->f);
        if (!factorise(e) || !ll_lu_positive(e->run->dim, e->lu, e->pivot))
            return false;
        double size = change_at(e, e->z, e->f, change);
        if (!(size - size == 0))
            return false;
        for (int j = 0; j < e->run->dim; j++)
            e->z[j] += change[j];
        if (size <= 1e-15 || (i > 0 && size >= last / 2 && size <= 1e-9))
            return true;
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
    double *next = ll_ode_next(run), *jacobian = ll_ode_extra(run, method);
    if (s->trapezoid)
        ll_ode_f(run, ode, run->t, y, f);
    for (int i = 0; i < n; i++) {
        base[i] = s->trapezoid ? y[i] + (1 - s->theta) * h * f[i] : y[i];
        z[i] = y[i];
    }
    equation e = {.run = run,
                  .ode = ode,
                  .t = run->t + s->node * h,
                  .w = s->theta * h,
                  .base = base,
                  .z = z,
                  .f = f,
                  .jacobian = jacobian,
                  .lu = jacobian + n * n,
                  .pivot = (int32_t *)(jacobian + 2 * n * n),
                  .whole = largest(y, n)};
    ll_ode_f(run, ode, e.t, z, f);
    if (!iterate(&e) && !follow(&e, y) && !hop(&e, y))
        return (double)__builtin_nanf("");
    for (int i = 0; i < n; i++)
        next[i] = s->midpoint ? 2 * z[i] - y[i] : z[i];
    return 0;
}

static const ll_ode_body body = {.vectors = VECTORS, .extra = extra, .attempt = attempt};

const ll_ode_method ll_ode_implicit_euler = {
    .name = "implicit_euler",
    .help = "Both advance by the slopes at the end of the step, found by Newton's iteration: stable at any "
            "step, with damping.",
    .source = "Hairer, Wanner, Solving Ordinary Differential Equations II, IV.1",
    .order = 1,
    .a_stable = true,
    .body = &body,
    .data = &(const stage){.theta = 1, .node = 1}};

const ll_ode_method ll_ode_implicit_midpoint = {
    .name = "implicit_midpoint",
    .help = "The slope at the mean of both ends: stable at any step; conserves quadratic invariants.",
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
