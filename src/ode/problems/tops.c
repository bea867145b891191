/* Euler's equations of a rotating body: the flipping tennis racket, and a driven top. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct racket {
    double i1, i2, i3, tilt;
} racket;

static const ll_param racket_rows[] = {
    LL_ODE_PARAM(racket, i1, "kg m2", 0.01, 100, 1, "Least moment of inertia."),
    LL_ODE_PARAM(racket, i2, "kg m2", 0.01, 100, 2, "Middle moment of inertia."),
    LL_ODE_PARAM(racket, i3, "kg m2", 0.01, 100, 3, "Largest moment of inertia."),
    LL_ODE_PARAM(racket, tilt, "rad/s", -1, 1, 1.0 / 128,
                 "Initial angular velocity about the first axis; 1 rad/s about the second."),
};
LL_ODE_TABLE(ll_ode_tennis_racket_table, "tennis_racket", "Parameters of the racket.", racket_rows, racket);

LL_ODE_RHS(racket_f, 3, {
    const racket *c = p;
    real w1 = y[0], w2 = y[1], w3 = y[2];
    dy[0] = (c->i2 - c->i3) / c->i1 * w2 * w3;
    dy[1] = (c->i3 - c->i1) / c->i2 * w3 * w1;
    dy[2] = (c->i1 - c->i2) / c->i3 * w1 * w2;
})

static const struct ll_ode_kernels racket_kernels = {LL_ODE_KERNELS(racket_f)};

/* The products (w2 w3, w1 w3) and w1 w2: coefficient k, from (w2, w1), w3 twice, and (w1, w2). */
static inline __attribute__((always_inline)) ll_term products(const ll_term *pair, const ll_term *third,
                                                              int k, double *last)
{
    ll_term with_third = {0}, cross = {0};
    for (int j = 0; j <= k; j++)
        with_third += pair[j] * third[k - j];
    for (int j = 0; 2 * j < k; j++)
        cross += pair[j] * ll_term_swapped(pair[k - j]);
    *last = cross[0] + cross[1] + (k % 2 == 0 ? pair[k / 2][0] * pair[k / 2][1] : 0);
    return with_third;
}

static void racket_series(const void *p, double t, int order, double *row)
{
    (void)t;
    const racket *c = p;
    ll_term pair[LL_SERIES_TERMS], third[LL_SERIES_TERMS];
    ll_term factor = {(c->i3 - c->i1) / c->i2, (c->i2 - c->i3) / c->i1};
    double factor3 = (c->i1 - c->i2) / c->i3, cross;
    for (int k = 0; k < order; k++, row += 4) {
        pair[k] = (ll_term){row[1], row[0]};
        third[k] = ll_term_of(row[2]);
        ll_term slope = factor * ll_term_swapped(products(pair, third, k, &cross)) * ll_series_inverse[k + 1];
        row[4] = slope[1];
        row[5] = slope[0];
        row[6] = factor3 * cross * ll_series_inverse[k + 1];
    }
}

static void racket_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 3,
                    .autonomous = true,
                    .params = p,
                    .f = racket_f,
                    .series = racket_series,
                    .kernels = &racket_kernels};
}

static void racket_start(const void *p, double *w)
{
    w[0] = ((const racket *)p)->tilt;
    w[1] = 1;
    w[2] = 0;
}

static double racket_energy(const void *p, double t, const double *w)
{
    (void)t;
    const racket *c = p;
    return (c->i1 * w[0] * w[0] + c->i2 * w[1] * w[1] + c->i3 * w[2] * w[2]) / 2;
}

static const double racket_reference[] = {0.194034852772687332, 0.981025744344016464, -0.111935232663459526};
static const char *const racket_components[] = {"omega1_radps", "omega2_radps", "omega3_radps"};

const ll_ode_problem ll_ode_tennis_racket = {.name = "tennis_racket",
                                             .help = "A body that rotates about its middle axis flips.",
                                             .source = "Euler's equations; binary128 reference",
                                             .params = &ll_ode_tennis_racket_table,
                                             .system = racket_system,
                                             .duration = 50,
                                             .start = racket_start,
                                             .components = racket_components,
                                             .reference = racket_reference,
                                             .floor = 1e-14,
                                             .energy = racket_energy};

typedef struct top {
    double drive;
} top;

static const ll_param top_rows[] = {
    LL_ODE_PARAM(top, drive, "rad/s2", 0, 10, 0.25, "Amplitude of the drive.")};
LL_ODE_TABLE(ll_ode_euler_top_table, "euler_top", "Parameters of the top.", top_rows, top);

LL_ODE_RHS(top_f, 3, {
    real s = ll_real_sin(t), w1 = y[0], w2 = y[1], w3 = y[2];
    dy[0] = -2 * w2 * w3;
    dy[1] = 1.25 * w1 * w3;
    dy[2] = -0.5 * w1 * w2 + ((const top *)p)->drive * s * s;
})

static const struct ll_ode_kernels top_kernels = {LL_ODE_KERNELS(top_f)};

/* sin^2 t = (1 - cos 2 t) / 2. */
static void top_series(const void *p, double t, int order, double *row)
{
    double drive = ((const top *)p)->drive, sine, cosine, cross;
    ll_term pair[LL_SERIES_TERMS], third[LL_SERIES_TERMS];
    ll_sincos(2 * t, &sine, &cosine);
    for (int k = 0; k < order; k++, row += 4) {
        double over = ll_series_inverse[k + 1], force = drive / 2 * ((k == 0) - cosine), turned = cosine;
        pair[k] = (ll_term){row[1], row[0]};
        third[k] = ll_term_of(row[2]);
        ll_term slope = (ll_term){-2, 1.25} * products(pair, third, k, &cross) * over;
        row[4] = slope[0];
        row[5] = slope[1];
        row[6] = (force - 0.5 * cross) * over;
        cosine = -2 * sine * over;
        sine = 2 * turned * over;
    }
}

static void top_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 3, .params = p, .f = top_f, .series = top_series, .kernels = &top_kernels};
}

static void top_start(const void *p, double *w)
{
    (void)p;
    w[0] = 1;
    w[1] = 0;
    w[2] = 0.9;
}

static const double top_reference[] = {-0.668862422980134302, -0.587698402204068395, 2.01077739307361082};

const ll_ode_problem ll_ode_euler_top = {.name = "euler_top",
                                         .help = "A rotating body under a periodic drive.",
                                         .source = "SciMLBenchmarks, rigid body; binary128 reference",
                                         .params = &ll_ode_euler_top_table,
                                         .system = top_system,
                                         .duration = 10,
                                         .start = top_start,
                                         .components = racket_components,
                                         .reference = top_reference,
                                         .floor = 1e-15};
