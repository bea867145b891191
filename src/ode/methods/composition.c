/* Alternating kicks v += d h a(q, v) and drifts q += c h v: every method here is a list of both.
 *
 * If a depends on v, a kick uses the current velocity; the order is then 1, for any composition. */
#include "ode/core/method_internal.h"

enum { STAGES_MAX = 16 };

typedef struct composition {
    int stages;
    double kick[STAGES_MAX], drift[STAGES_MAX]; /* each stage kicks first; a kick of 0 costs no evaluation */
} composition;

/* If a does not depend on v, a composition that begins and ends with a kick can keep the last
 * acceleration. */
static bool keeps_acceleration(const composition *c, const ll_ode *ode)
{
    return c->drift[c->stages - 1] == 0 && !ode->velocity_dependent;
}

/* One coordinate is the usual case, and too few for a loop in vectors, which starts with a dozen
 * questions. */
static inline void add(double *to, double by, const double *what, int count)
{
    to[0] += by * what[0];
    for (int i = 1; i < count; i++)
        to[i] += by * what[i];
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const composition *c = method->data;
    int half = run->dim / 2;
    const double *y = ll_ode_state_y(run);
    double *q = ll_ode_next(run), *v = q + half, *a = ll_ode_work(run, 0), *kept = ll_ode_work(run, 1),
           t = run->t;
    ll_ode_copy(run->stride, y, q);
    for (int s = 0; s < c->stages; s++) {
        double kick = c->kick[s] * h, drift = c->drift[s] * h;
        if (kick != 0) {
            const double *found = kept;
            if (s > 0 || run->history == 0) {
                ll_ode_a(run, ode, t, q, v, a);
                found = a;
            }
            add(v, kick, found, half);
        }
        add(q, drift, v, half);
        t += drift;
    }
    return 0;
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)h;
    double *a = ll_ode_work(run, 0), *kept = ll_ode_work(run, 1);
    run->history = keeps_acceleration(method->data, ode);
    for (int i = 0; run->history && i < run->dim / 2; i++)
        kept[i] = a[i];
}

static const ll_ode_body body = {.vectors = 2, .attempt = attempt, .accept = accept};

const ll_ode_method ll_ode_semi_implicit_euler = {
    .name = "semi_implicit_euler",
    .help = "Velocity first, then position with the new velocity: the usual method of games, and the listing "
            "of the paper's Figure 1.",
    .source = "R. de Vogelaere, report, 1956; Hairer, Lubich, Wanner, Geometric Numerical Integration, I.1",
    .order = 1,
    .evaluations = 1,
    .symplectic = true,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const composition){1, {1}, {1}}};

const ll_ode_method ll_ode_leapfrog_kdk = {.name = "leapfrog_kdk",
                                           .help = "Half a kick, a drift, half a kick.",
                                           .source = "Hairer, Lubich, Wanner, Acta Numerica 12, 2003",
                                           .order = 2,
                                           .order_velocity = 1,
                                           .evaluations = 1,
                                           .symplectic = true,
                                           .reversible = true,
                                           .needs = LL_ODE_NEEDS_MECHANICAL,
                                           .body = &body,
                                           .data = &(const composition){2, {0.5, 0.5}, {1, 0}}};

const ll_ode_method ll_ode_leapfrog_dkd = {.name = "leapfrog_dkd",
                                           .help = "Half a drift, a kick, half a drift.",
                                           .source = "Hairer, Lubich, Wanner, Acta Numerica 12, 2003",
                                           .order = 2,
                                           .order_velocity = 1,
                                           .evaluations = 1,
                                           .symplectic = true,
                                           .reversible = true,
                                           .needs = LL_ODE_NEEDS_MECHANICAL,
                                           .body = &body,
                                           .data = &(const composition){2, {0, 1}, {0.5, 0.5}}};

const ll_ode_method ll_ode_ruth3 = {
    .name = "ruth3",
    .help = "Ruth's third-order symplectic method.",
    .source = "R. D. Ruth, IEEE Trans. Nucl. Sci. 30, 1983",
    .order = 3,
    .order_velocity = 1,
    .evaluations = 3,
    .symplectic = true,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const composition){3, {7. / 24, 3. / 4, -1. / 24}, {2. / 3, -2. / 3, 1}}};

/* Symmetric composition of drift-kick-drift leapfrogs with the given steps; adjacent half drifts are
 * merged. */
#define W1 1.351207191959657634
#define W0 -1.702414383919315268

const ll_ode_method ll_ode_yoshida4 = {
    .name = "yoshida4",
    .help = "Three leapfrogs, the middle one backwards.",
    .source = "H. Yoshida, Phys. Lett. A 150, 1990",
    .order = 4,
    .order_velocity = 1,
    .evaluations = 3,
    .symplectic = true,
    .reversible = true,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const composition){4, {0, W1, W0, W1}, {W1 / 2, (W1 + W0) / 2, (W0 + W1) / 2, W1 / 2}}};

#define A1 0.784513610477557263819497633866
#define A2 0.235573213359358133684793182978
#define A3 -1.17767998417887100694641568096
#define A4 1.31518632068391121888424972823

const ll_ode_method ll_ode_yoshida6 = {
    .name = "yoshida6",
    .help = "Seven leapfrogs: Yoshida's solution A of order 6.",
    .source = "H. Yoshida, Phys. Lett. A 150, 1990",
    .order = 6,
    .order_velocity = 1,
    .evaluations = 7,
    .symplectic = true,
    .reversible = true,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const composition){8,
                                 {0, A1, A2, A3, A4, A3, A2, A1},
                                 {A1 / 2, (A1 + A2) / 2, (A2 + A3) / 2, (A3 + A4) / 2, (A4 + A3) / 2,
                                  (A3 + A2) / 2, (A2 + A1) / 2, A1 / 2}}};

#define B1 0.74167036435061295344822780
#define B2 -0.40910082580003159399730010
#define B3 0.19075471029623837995387626
#define B4 -0.57386247111608226665638773
#define B5 0.29906418130365592384446354
#define B6 0.33462491824529818378495798
#define B7 0.31529309239676659663205666
#define B8 -0.79688793935291635401978884

const ll_ode_method ll_ode_yoshida8 = {
    .name = "yoshida8",
    .help = "Fifteen leapfrogs: Yoshida's construction of order 8 with the coefficients of Suzuki and Umeno.",
    .source = "M. Suzuki, K. Umeno, Springer Proc. Phys. 76, 1993; Hairer, Lubich, Wanner, Geometric "
              "Numerical Integration, V.3.2",
    .order = 8,
    .order_velocity = 1,
    .evaluations = 15,
    .symplectic = true,
    .reversible = true,
    .needs = LL_ODE_NEEDS_MECHANICAL,
    .body = &body,
    .data = &(const composition){16,
                                 {0, B1, B2, B3, B4, B5, B6, B7, B8, B7, B6, B5, B4, B3, B2, B1},
                                 {B1 / 2, (B1 + B2) / 2, (B2 + B3) / 2, (B3 + B4) / 2, (B4 + B5) / 2,
                                  (B5 + B6) / 2, (B6 + B7) / 2, (B7 + B8) / 2, (B8 + B7) / 2, (B7 + B6) / 2,
                                  (B6 + B5) / 2, (B5 + B4) / 2, (B4 + B3) / 2, (B3 + B2) / 2, (B2 + B1) / 2,
                                  B1 / 2}}};
