/* Embedded explicit Runge-Kutta methods: stages and error estimate in one function.
 *
 * The functions stand here, inline, for a problem to have them compiled with its own f within and its number
 * of components known (ode/core/field.h): where a state has few components, calls and the way through memory
 * cost more than the arithmetic. */
#pragma once

#include "ode/core/ode.h"

/* The coefficients of an explicit Runge-Kutta method. */
typedef struct ll_ode_tableau {
    int stages;
    const double *c; /* `stages` */
    const double *a; /* rows of the later stages: 1, 2, 3... numbers each */
    const double *b; /* `stages`; NULL: the last stage is at the end of the step (FSAL) */
    const double *e; /* error: `stages` weights of the difference from the embedded solution; NULL: none */
    const double
        *p; /* dense output: `stages` rows of `degree` coefficients of theta, theta^2...; NULL: none */
    int degree;
} ll_ode_tableau;

/* A step of `h` from (t, y). */
typedef struct ll_ode_trial {
    const ll_ode_tableau *tableau; /* NULL for methods without one */
    double t, h;
    double absolute, relative; /* tolerances */
    const double *y;
    double *k;    /* slopes, `stride` doubles each; the caller fills in the first */
    double *next; /* state after the step */
    int stride;
} ll_ode_trial;

/* Fills `k` and `next`. Returns the mean square of the estimated error relative to the tolerance. */
typedef double ll_ode_stages(const void *params, const ll_ode_trial *trial);

enum { LL_SEVEN = 7, LL_DOP853_STAGES = 12 };

/* out = base + h (weight[0] k_0 + weight[1] k_1 + ...); base NULL: 0. With `sparse`, constant weights of 0
 * cost nothing. */
LL_INLINE void ll_ode_combine(int dim, int stride, const double *base, const double *k, const double *weight,
                              bool sparse, int count, double h, double *out)
{
    for (int i = 0; i < dim; i++) {
        double sum = weight[0] * k[i];
#pragma GCC unroll 16
        for (int j = 1; j < count; j++)
            if (!sparse || weight[j] != 0)
                sum += weight[j] * k[j * stride + i];
        out[i] = base != NULL ? base[i] + h * sum : h * sum;
    }
}

/* Mean over the components of (e / (absolute + relative max(|y|, |next|)))^2. */
LL_INLINE double ll_ode_mean_square(int dim, const double *e, const double *y, const double *next,
                                    double absolute, double relative)
{
    double sum[2] = {0, 0};
    for (int i = 0; i < dim; i++) {
        double a = __builtin_fabs(y[i]), b = __builtin_fabs(next[i]);
        double ratio = e[i] / (absolute + relative * (a > b ? a : b));
        sum[i % 2] += ratio * ratio;
    }
    return (sum[0] + sum[1]) * (1.0 / dim);
}

/* DOP853: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.5. Rows of `a`:
 * stages from the second on, then the result, then three stages for dense output. */
static const double ll_dop853_c[] = {0.0,
                                     0.052600151958767731879,
                                     0.078900227938151597818,
                                     0.11835034190722739673,
                                     0.28164965809277260327,
                                     0.33333333333333333333,
                                     0.25,
                                     0.30769230769230769231,
                                     0.65128205128205128205,
                                     0.6,
                                     0.85714285714285714286,
                                     1.0,
                                     1.0,
                                     0.1,
                                     0.2,
                                     0.77777777777777777778};

static const double ll_dop853_a[] = {
    0.052600151958767731879, /* 2 */
    0.019725056984537899454,
    0.059175170953613698363, /* 3 */
    0.029587585476806849182,
    0,
    0.088762756430420547545, /* 4 */
    0.2413651341592666855,
    0,
    -0.88454947932828608534,
    0.92483400326179200312, /* 5 */
    0.037037037037037037037,
    0,
    0,
    0.17082860872947387128,
    0.12546768756682242502, /* 6 */
    0.037109375,
    0,
    0,
    0.17025221101954403931,
    0.060216538980455960685,
    -0.017578125, /* 7 */
    0.037092000118504792711,
    0,
    0,
    0.17038392571223999381,
    0.10726203044637328465,
    -0.015319437748624401753,
    0.0082737891638140228876, /* 8 */
    0.62411095871607571711,
    0,
    0,
    -3.3608926294469412941,
    -0.86821934684172600682,
    27.592099699446708305,
    20.154067550477893409,
    -43.489884181069958848, /* 9 */
    0.47766253643826436589,
    0,
    0,
    -2.4881146199716676419,
    -0.59029082683684299637,
    21.230051448181194235,
    15.279233632882423583,
    -33.288210968984862919,
    -0.020331201708508626136, /* 10 */
    -0.93714243008598732572,
    0,
    0,
    5.1863724288440637083,
    1.0914373489967295782,
    -8.1497870107469261251,
    -18.520065659996959864,
    22.739487099350504282,
    2.4936055526796523899,
    -3.0467644718982195004, /* 11 */
    2.2733101475165382079,
    0,
    0,
    -10.534495466737250198,
    -2.0008720582248624991,
    -17.958931863118798917,
    27.948884529419960051,
    -2.8589982771350236947,
    -8.8728569335306295443,
    12.360567175794303065,
    0.64339274601576353036, /* 12 */
    0.054293734116568762238,
    0,
    0,
    0,
    0,
    4.4503128927524088814,
    1.891517899314500383,
    -5.8012039600105847815,
    0.31116436695781989441,
    -0.15216094966251607856,
    0.20136540080403034837,
    0.044710615727772590518, /* 13 */
    0.056167502283047952339,
    0,
    0,
    0,
    0,
    0,
    0.25350021021662481109,
    -0.24623903747080248992,
    -0.12419142326381636047,
    0.15329179827876569731,
    0.0082010522956346898849,
    0.0075678976605456997614,
    -0.008298, /* 14 */
    0.031834648163502140506,
    0,
    0,
    0,
    0,
    0.028300909672366775529,
    0.053541988307438567622,
    -0.054923748571390988465,
    0,
    0,
    -0.00010834732869724932286,
    0.00038257109083565841295,
    -0.0003404650086874045608,
    0.14131244367463250028, /* 15 */
    -0.42889630158379192341,
    0,
    0,
    0,
    0,
    -4.6976214153611638431,
    7.6834211960625990418,
    4.0689898183971100797,
    0.35672718745528110927,
    0,
    0,
    0,
    -0.0013990241651590146213,
    2.947514789152772339,
    -9.1509584721798700108, /* 16 */
};

static const double ll_dop853_e5[] = {0.013120044994194880733,
                                      0,
                                      0,
                                      0,
                                      0,
                                      -1.2251564463762044407,
                                      -0.49575894965725019152,
                                      1.664377182454986537,
                                      -0.35032884874997368169,
                                      0.33417911871301747903,
                                      0.081923206485115712466,
                                      -0.022355307863886295259};

static const double ll_dop853_e3[] = {-0.18980075407240761571,
                                      0,
                                      0,
                                      0,
                                      0,
                                      4.4503128927524088814,
                                      1.891517899314500383,
                                      -5.8012039600105847815,
                                      -0.42268232132379196293,
                                      -0.15216094966251607856,
                                      0.20136540080403034837,
                                      0.022651792198360825812};

LL_INLINE double ll_ode_dop853_stages(int dim, ll_ode_rhs *f, const void *params, const ll_ode_trial *s,
                                      double *k, int stride)
{
    double point[LL_ODE_DIM_MAX], next[LL_ODE_DIM_MAX], error[LL_ODE_DIM_MAX];
#pragma GCC unroll 12
    for (int j = 1; j < LL_DOP853_STAGES; j++) {
        ll_ode_combine(dim, stride, s->y, k, ll_dop853_a + j * (j - 1) / 2, true, j, s->h, point);
        f(params, s->t + ll_dop853_c[j] * s->h, point, k + j * stride);
    }
    ll_ode_combine(dim, stride, s->y, k, ll_dop853_a + LL_DOP853_STAGES * (LL_DOP853_STAGES - 1) / 2, true,
                   LL_DOP853_STAGES, s->h, next);
    ll_ode_combine(dim, stride, NULL, k, ll_dop853_e5, true, LL_DOP853_STAGES, s->h, error);
    double error5 = ll_ode_mean_square(dim, error, s->y, next, s->absolute, s->relative);
    ll_ode_combine(dim, stride, NULL, k, ll_dop853_e3, true, LL_DOP853_STAGES, s->h, error);
    double error3 = ll_ode_mean_square(dim, error, s->y, next, s->absolute, s->relative);
    memcpy(s->next, next, (size_t)dim * sizeof *next);
    return error5 == 0 ? 0 : error5 * error5 / (error5 + 0.01 * error3);
}

/* Embedded pair of seven stages; the last is at the end of the step. */
LL_INLINE double ll_ode_seven_stages(int dim, ll_ode_rhs *f, const void *params, const ll_ode_trial *s,
                                     double *k, int stride)
{
    double next[LL_ODE_DIM_MAX], error[LL_ODE_DIM_MAX];
    const double *a = s->tableau->a, *c = s->tableau->c;
#pragma GCC unroll 7
    for (int j = 1; j < LL_SEVEN; j++) {
        ll_ode_combine(dim, stride, s->y, k, a + j * (j - 1) / 2, false, j, s->h, next);
        f(params, s->t + c[j] * s->h, next, k + j * stride);
    }
    ll_ode_combine(dim, stride, NULL, k, s->tableau->e, false, LL_SEVEN, s->h, error);
    memcpy(s->next, next, (size_t)dim * sizeof *next);
    return ll_ode_mean_square(dim, error, s->y, next, s->absolute, s->relative);
}

/* The same with local arrays, for a constant `dim`; copies the slopes out at the end. */
#define LL_ODE_OWN_STAGES(stages, count, dim, f, params, trial)                                              \
    double k[(count) * (dim)];                                                                               \
    for (int i = 0; i < (dim); i++)                                                                          \
        k[i] = (trial)->k[i];                                                                                \
    double error = stages((dim), f, params, trial, k, (dim));                                                \
    for (int j = 1; j < (count); j++)                                                                        \
        for (int i = 0; i < (dim); i++)                                                                      \
            (trial)->k[j * (trial)->stride + i] = k[j * (dim) + i];                                          \
    return error
