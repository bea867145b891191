/* Double pendulum in angles: an acceleration that depends on velocities, and chaos. Unit masses and
 * lengths. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

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

/* Terms of sin and cos of an angle z: k sin_k = sum of j z_j cos_(k-j), k cos_k = -(sum of j z_j
 * sin_(k-j)). */
typedef struct terms {
    ll_term q[LL_SERIES_TERMS], v[LL_SERIES_TERMS];             /* both angles, both speeds */
    ll_term steep[LL_SERIES_TERMS];                             /* j q_j */
    ll_term sin[LL_SERIES_TERMS], cos[LL_SERIES_TERMS];         /* of both angles */
    ll_term steep_d[LL_SERIES_TERMS], sin_cos[LL_SERIES_TERMS]; /* of the difference, twice; (s, c) */
    ll_term s[LL_SERIES_TERMS], c[LL_SERIES_TERMS];             /* twice the same */
    ll_term v2[LL_SERIES_TERMS];                                /* squares of the speeds */
    ll_term force[LL_SERIES_TERMS];                             /* (f2, f1) */
    ll_term determinant[LL_SERIES_TERMS];                       /* 2 - c^2, twice */
    ll_term a[LL_SERIES_TERMS];
} terms;

static void begin(terms *x, double g)
{
    for (int i = 0; i < 2; i++) {
        double sine, cosine;
        ll_sincos(x->q[0][i], &sine, &cosine);
        x->sin[0][i] = sine;
        x->cos[0][i] = cosine;
    }
    double s, c;
    ll_sincos(x->q[0][0] - x->q[0][1], &s, &c);
    x->sin_cos[0] = (ll_term){s, c};
    x->s[0] = ll_term_of(s);
    x->c[0] = ll_term_of(c);
    x->v2[0] = x->v[0] * x->v[0];
    x->force[0] = (ll_term){s, -s} * x->v2[0] - (ll_term){g, 2 * g} * ll_term_swapped(x->sin[0]);
    x->determinant[0] = ll_term_of(2 - c * c);
    x->a[0] = ((ll_term){1, 2} * ll_term_swapped(x->force[0]) - x->c[0] * x->force[0]) / x->determinant[0];
}

static void add_term(terms *x, double g, int k)
{
    ll_term sum_d = {0}, sum_sin = {0}, sum_cos = {0}, sum_v2 = {0}, sum_sv2 = {0}, sum_c2 = {0},
            sum_cf = {0}, sum_da = {0};
    x->steep[k] = k * x->q[k];
    x->steep_d[k] = ll_term_of(x->steep[k][0] - x->steep[k][1]);
    for (int j = 1; j < k; j++) {
        int i = k - j;
        sum_d += x->steep_d[j] * x->sin_cos[i];
        sum_sin += x->steep[j] * x->cos[i];
        sum_cos += x->steep[j] * x->sin[i];
        sum_v2 += x->v[j] * x->v[i];
        sum_sv2 += x->s[j] * x->v2[i];
        sum_c2 += x->c[j] * x->c[i];
        sum_cf += x->c[j] * x->force[i];
        sum_da += x->determinant[j] * x->a[i];
    }
    double over = ll_series_inverse[k];
    sum_d = (sum_d + x->steep_d[k] * x->sin_cos[0]) * over;
    x->sin_cos[k] = (ll_term){sum_d[1], -sum_d[0]};
    x->s[k] = ll_term_of(sum_d[1]);
    x->c[k] = ll_term_of(-sum_d[0]);
    x->sin[k] = (sum_sin + x->steep[k] * x->cos[0]) * over;
    x->cos[k] = (sum_cos + x->steep[k] * x->sin[0]) * -over;
    x->v2[k] = sum_v2 + 2 * (x->v[0] * x->v[k]);
    ll_term sv2 = sum_sv2 + ll_series_ends(x->s, x->v2, k);
    x->force[k] = sv2 * (ll_term){1, -1} - (ll_term){g, 2 * g} * ll_term_swapped(x->sin[k]);
    x->determinant[k] = -(sum_c2 + 2 * (x->c[0] * x->c[k]));
    ll_term above =
        (ll_term){1, 2} * ll_term_swapped(x->force[k]) - (sum_cf + ll_series_ends(x->c, x->force, k));
    x->a[k] = (above - sum_da - x->determinant[k] * x->a[0]) / x->determinant[0];
}

static void series(const void *p, double t, int order, double *row)
{
    (void)t;
    double g = ((const params *)p)->g;
    terms x;
    ll_series_take_plane(row, x.q, x.v);
    begin(&x, g);
    ll_series_move(x.q, x.v, x.a[0], 0);
    for (int k = 1; k < order; k++) {
        add_term(&x, g, k);
        ll_series_move(x.q, x.v, x.a[k], k);
    }
    ll_series_put_plane(row, x.q, x.v, order);
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 4,
                    .autonomous = true,
                    .velocity_dependent = true,
                    .params = p,
                    .acceleration = acceleration,
                    .series = series,
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
