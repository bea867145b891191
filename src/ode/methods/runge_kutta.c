/* Explicit Runge-Kutta methods, with fixed step and embedded pairs: one stepper, one tableau each. */
#include "ode/core/method_internal.h"

enum { STAGES_MAX = LL_SEVEN };

/* out = y + h (a[0] k_0 + a[1] k_1 + ...). */
static void combine(const ll_ode_run *run, const double *y, const double *k, const double *a, int count,
                    double h, double *out)
{
    int stride = run->stride;
    for (int i = 0; i < stride; i += 2) {
        ll_pair sum = a[0] * ll_pair_at(k + i);
        for (int j = 1; j < count; j++)
            sum += a[j] * ll_pair_at(k + j * stride + i);
        ll_pair_put(out + i, ll_pair_at(y + i) + h * sum);
    }
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const ll_ode_tableau *t = method->data;
    const double *y = ll_ode_state_y(run), *a = t->a;
    double *k = ll_ode_work(run, 0), *next = ll_ode_next(run);
    if (run->history == 0)
        ll_ode_f(run, ode, run->t, y, k);
    else if (run->history == 2)
        ll_ode_copy(run->stride, k + (t->stages - 1) * run->stride, k);
    run->history = 1;
    if (t->stages == LL_SEVEN && ode->kernels != NULL && ode->kernels->seven_stages != NULL) {
        ll_ode_trial trial = ll_ode_trial_of(run, h, k);
        trial.tableau = t;
        run->counters.evaluations += LL_SEVEN - 1;
        return ode->kernels->seven_stages(ode->params, &trial);
    }
    for (int s = 1; s < t->stages; s++) {
        combine(run, y, k, a, s, h, next);
        ll_ode_f(run, ode, run->t + t->c[s] * h, next, k + s * run->stride);
        a += s;
    }
    if (t->b != NULL)
        combine(run, y, k, t->b, t->stages, h, next);
    if (t->e == NULL)
        return 0;
    double *error = ll_ode_work(run, STAGES_MAX), *zero = ll_ode_work(run, STAGES_MAX + 1);
    combine(run, zero, k, t->e, t->stages, h, error);
    return ll_ode_norm2(run, error);
}

/* The last stage of an FSAL pair is the first of the next step. */
static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)ode, (void)h;
    run->history = ((const ll_ode_tableau *)method->data)->b == NULL ? 2 : 0;
}

static void dense(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double theta, double *y)
{
    (void)ode;
    const ll_ode_tableau *t = method->data;
    const double *y0 = ll_ode_next(run), *k = ll_ode_work(run, 0);
    double weight[STAGES_MAX], h = run->t - run->t_last;
    for (int s = 0; s < t->stages; s++) {
        weight[s] = 0;
        for (int d = t->degree - 1; d >= 0; d--)
            weight[s] = (weight[s] + t->p[s * t->degree + d]) * theta;
    }
    for (int i = 0; i < run->dim; i++) {
        double sum = 0;
        for (int s = 0; s < t->stages; s++)
            sum += weight[s] * k[s * run->stride + i];
        y[i] = y0[i] + h * sum;
    }
}

static const ll_ode_body fixed = {.vectors = STAGES_MAX, .attempt = attempt, .accept = accept};
static const ll_ode_body embedded_3 = {
    .vectors = STAGES_MAX + 2, .attempt = attempt, .accept = accept, .error_order = 3};
static const ll_ode_body embedded_5 = {
    .vectors = STAGES_MAX + 2, .attempt = attempt, .accept = accept, .dense = dense, .error_order = 5};

const ll_ode_method ll_ode_explicit_euler = {
    .name = "explicit_euler",
    .help = "Position and velocity both advance by the slopes at the start of the step.",
    .source = "L. Euler, Institutionum calculi integralis I, 1768",
    .order = 1,
    .evaluations = 1,
    .body = &fixed,
    .data = &(const ll_ode_tableau){
        .stages = 1, .c = (const double[]){0}, .a = (const double[]){0}, .b = (const double[]){1}}};

const ll_ode_method ll_ode_rk2 = {.name = "rk2",
                                  .help = "Explicit midpoint: the slope at half a step of explicit Euler.",
                                  .source = "C. Runge, Math. Ann. 46, 1895",
                                  .order = 2,
                                  .evaluations = 2,
                                  .body = &fixed,
                                  .data = &(const ll_ode_tableau){.stages = 2,
                                                                  .c = (const double[]){0, 1. / 2},
                                                                  .a = (const double[]){1. / 2},
                                                                  .b = (const double[]){0, 1}}};

const ll_ode_method ll_ode_ralston = {.name = "ralston",
                                      .help = "The two-stage method with the least error bound per step.",
                                      .source = "A. Ralston, Math. Comp. 16, 1962",
                                      .order = 2,
                                      .evaluations = 2,
                                      .body = &fixed,
                                      .data = &(const ll_ode_tableau){.stages = 2,
                                                                      .c = (const double[]){0, 2. / 3},
                                                                      .a = (const double[]){2. / 3},
                                                                      .b = (const double[]){1. / 4, 3. / 4}}};

const ll_ode_method ll_ode_rk3 = {.name = "rk3",
                                  .help = "Kutta's third-order method.",
                                  .source = "W. Kutta, Z. Math. Phys. 46, 1901",
                                  .order = 3,
                                  .evaluations = 3,
                                  .body = &fixed,
                                  .data =
                                      &(const ll_ode_tableau){.stages = 3,
                                                              .c = (const double[]){0, 1. / 2, 1},
                                                              .a = (const double[]){1. / 2, -1, 2},
                                                              .b = (const double[]){1. / 6, 2. / 3, 1. / 6}}};

const ll_ode_method ll_ode_rk4 = {
    .name = "rk4",
    .help = "The classical four-stage method.",
    .source = "W. Kutta, Z. Math. Phys. 46, 1901",
    .order = 4,
    .evaluations = 4,
    .body = &fixed,
    .data = &(const ll_ode_tableau){.stages = 4,
                                    .c = (const double[]){0, 1. / 2, 1. / 2, 1},
                                    .a = (const double[]){1. / 2, 0, 1. / 2, 0, 0, 1},
                                    .b = (const double[]){1. / 6, 1. / 3, 1. / 3, 1. / 6}}};

const ll_ode_method ll_ode_bs32 = {
    .name = "bs32",
    .help = "Bogacki-Shampine 3(2): an adaptive pair for low accuracy.",
    .source = "P. Bogacki, L. F. Shampine, Appl. Math. Lett. 2, 1989",
    .order = 3,
    .evaluations = 3,
    .adaptive = true,
    .body = &embedded_3,
    .data = &(const ll_ode_tableau){.stages = 4,
                                    .c = (const double[]){0, 1. / 2, 3. / 4, 1},
                                    .a = (const double[]){1. / 2, 0, 3. / 4, 2. / 9, 1. / 3, 4. / 9},
                                    .e = (const double[]){-5. / 72, 1. / 12, 1. / 9, -1. / 8}}};

/* Dense output of order 4 by L. F. Shampine, Math. Comp. 46, 1986. */
static const double dopri5_p[] = {1,
                                  -8048581381. / 2820520608,
                                  8663915743. / 2820520608,
                                  -12715105075. / 11282082432, /* k1 */
                                  0,
                                  0,
                                  0,
                                  0, /* k2 */
                                  0,
                                  131558114200. / 32700410799,
                                  -68118460800. / 10900136933,
                                  87487479700. / 32700410799, /* k3 */
                                  0,
                                  -1754552775. / 470086768,
                                  14199869525. / 1410260304,
                                  -10690763975. / 1880347072, /* k4 */
                                  0,
                                  127303824393. / 49829197408,
                                  -318862633887. / 49829197408,
                                  701980252875. / 199316789632, /* k5 */
                                  0,
                                  -282668133. / 205662961,
                                  2019193451. / 616988883,
                                  -1453857185. / 822651844, /* k6 */
                                  0,
                                  40617522. / 29380423,
                                  -110615467. / 29380423,
                                  69997945. / 29380423}; /* k7 */

const ll_ode_method ll_ode_dopri5 = {
    .name = "dopri5",
    .help = "Dormand-Prince 5(4): the usual adaptive method.",
    .source = "J. R. Dormand, P. J. Prince, J. Comp. Appl. Math. 6, 1980",
    .order = 5,
    .evaluations = 6,
    .adaptive = true,
    .body = &embedded_5,
    .data = &(const ll_ode_tableau){.stages = 7,
                                    .c = (const double[]){0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1, 1},
                                    .a = (const double[]){1. / 5,                  /* 2 */
                                                          3. / 40,        9. / 40, /* 3 */
                                                          44. / 45,       -56. / 15,
                                                          32. / 9, /* 4 */
                                                          19372. / 6561,  -25360. / 2187,
                                                          64448. / 6561,  -212. / 729, /* 5 */
                                                          9017. / 3168,   -355. / 33,
                                                          46732. / 5247,  49. / 176,
                                                          -5103. / 18656, /* 6 */
                                                          35. / 384,      0,
                                                          500. / 1113,    125. / 192,
                                                          -2187. / 6784,  11. / 84}, /* 7 */
                                    .e = (const double[]){71. / 57600, 0, -71. / 16695, 71. / 1920,
                                                          -17253. / 339200, 22. / 525, -1. / 40},
                                    .p = dopri5_p,
                                    .degree = 4}};

/* Tsitouras's interpolant, expanded into polynomials of theta. */
static const double tsit5_p[] = {1,
                                 -2.763706197274825911,
                                 2.913255461821912744,
                                 -1.053088497729021600, /* k1 */
                                 0,
                                 0.1317,
                                 -0.2234,
                                 0.1017, /* k2 */
                                 0,
                                 3.930296236894751529,
                                 -5.941033872131504735,
                                 2.490627285651252793, /* k3 */
                                 0,
                                 -12.41107716693367698,
                                 30.33818863028232160,
                                 -16.54810288924490272, /* k4 */
                                 0,
                                 37.50931341651103920,
                                 -88.17890489476640110,
                                 47.37952196281928122, /* k5 */
                                 0,
                                 -27.89652628919728781,
                                 65.09189467479367153,
                                 -34.87065786149660974, /* k6 */
                                 0,
                                 1.5,
                                 -4,
                                 2.5}; /* k7 */

const ll_ode_method ll_ode_tsit5 = {
    .name = "tsit5",
    .help = "Tsitouras 5(4): like dopri5 with a smaller error.",
    .source = "C. Tsitouras, Comput. Math. Appl. 62, 2011",
    .order = 5,
    .evaluations = 6,
    .adaptive = true,
    .body = &embedded_5,
    .data = &(const ll_ode_tableau){
        .stages = 7,
        .c = (const double[]){0, 0.161, 0.327, 0.9, 0.9800255409045096857, 1, 1},
        .a = (const double[]){0.161, /* 2 */
                              -0.00848065549235698854,
                              0.3354806554923569885, /* 3 */
                              2.897153057105493432,
                              -6.359448489975074843, /* 4 */
                              4.362295432869581411,  /* */
                              5.325864828439256604,
                              -11.74888356406282788, /* 5 */
                              7.495539342889836208,
                              -0.09249506636175524925, /* */
                              5.861455442946420029,
                              -12.92096931784710929, /* 6 */
                              8.159367898576158643,
                              -0.07158497328140099722, /* */
                              -0.02826905039406838291, /* */
                              0.09646076681806522952,
                              0.01, /* 7 */
                              0.4798896504144995748,
                              1.379008574103741893, /* */
                              -3.290069515436080680,
                              2.324710524099773982}, /* */
        .e = (const double[]){-0.001780011052225771443, -0.0008164344596567469032, 0.007880878010261996010,
                              -0.1447110071732629075, 0.5823571654525552250, -0.4580821059291869467, 1. / 66},
        .p = tsit5_p,
        .degree = 4}};
