/* DOP853: Dormand and Prince's method of order 8 with an error estimate of orders 5 and 3 and dense output of
 * order 7 (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.5, II.10). */
#include "ode/core/method_internal.h"

enum { ALL_STAGES = 16, TERMS = 7 };

static const double d[4][16] = {
    {-8.4289382761090128651, 0, 0, 0, 0, 0.56671495351937776963, -3.0689499459498916913,
     2.3846676565120698288, 2.1170345824450282767, -0.87139158377797299207, 2.2404374302607882759,
     0.63157877876946881816, -0.088990336451333310821, 18.148505520854727257, -9.1946323924783554,
     -4.4360363875948939664},
    {10.427508642579134603, 0, 0, 0, 0, 242.28349177525818288, 165.20045171727028199, -374.5467547226902028,
     -22.113666853125306036, 7.733432668472263839, -30.674084731089398182, -9.332130526430227873,
     15.697238121770843886, -31.139403219565177677, -9.3529243588444783866, 35.816841486394083752},
    {19.985053242002433821, 0, 0, 0, 0, -387.03730874935176555, -189.17813819516756883, 527.80815920542364901,
     -11.573902539959630126, 6.881232694696300017, -1.0006050966910838403, 0.77771377980534432093,
     -2.7782057523535084066, -60.196695231264120758, 84.320405506677161018, 11.992291136182789328},
    {-25.693933462703749003, 0, 0, 0, 0, -154.18974869023643374, -231.52937917604549568,
     357.63911791061412378, 93.405324183624310004, -37.458323136451633157, 104.09964950896230045,
     29.840293426660503123, -43.533456590011143754, 96.324553959188282948, -39.177261675615439165,
     -149.72683625798562581}};

enum { K, POINT = K + ALL_STAGES, TERM, VECTORS = TERM + TERMS };

static void general_f(const void *system, double t, const double *y, double *dy)
{
    ll_ode_eval(system, t, y, dy);
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method;
    double *k = ll_ode_work(run, K);
    if (run->history == 0)
        ll_ode_f(run, ode, run->t, ll_ode_state_y(run), k);
    else if (run->history == 2)
        ll_ode_copy(run->stride, k + LL_DOP853_STAGES * run->stride, k);
    run->history = 1;
    run->counters.evaluations += LL_DOP853_STAGES - 1;
    ll_ode_trial trial = ll_ode_trial_of(run, h, k);
    if (ode->kernels != NULL && ode->kernels->dop853 != NULL)
        return ode->kernels->dop853(ode->params, &trial);
    return ll_ode_dop853_stages(run->dim, general_f, ode, &trial, k, run->stride);
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method, (void)h;
    ll_ode_f(run, ode, run->t, ll_ode_state_y(run), ll_ode_work(run, K + LL_DOP853_STAGES));
    run->history = 2;
}

/* Stages 14 to 16; 13 is f at the end. */
static void prepare(ll_ode_run *run, const ll_ode *ode)
{
    int dim = run->dim, stride = run->stride;
    double h = run->t - run->t_last, *k = ll_ode_work(run, K), *term = ll_ode_work(run, TERM);
    double *point = ll_ode_work(run, POINT);
    const double *y0 = ll_ode_next(run), *y1 = ll_ode_end(run);
#pragma GCC unroll 3
    for (int s = LL_DOP853_STAGES + 1; s < ALL_STAGES; s++) {
        ll_ode_combine(dim, stride, y0, k, ll_dop853_a + s * (s - 1) / 2, true, s, h, point);
        ll_ode_eval(ode, run->t_last + ll_dop853_c[s] * h, point, k + s * stride);
    }
    for (int i = 0; i < dim; i++) {
        double change = y1[i] - y0[i];
        term[i] = change;
        term[stride + i] = h * k[i] - change;
        term[2 * stride + i] = 2 * change - h * (k[i] + k[LL_DOP853_STAGES * stride + i]);
    }
    for (int j = 0; j < 4; j++)
        ll_ode_combine(dim, stride, NULL, k, d[j], true, ALL_STAGES, h, term + (3 + j) * stride);
    run->dense = 1;
}

static void dense(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double theta, double *y)
{
    (void)method;
    if (!run->dense)
        prepare(run, ode);
    const double *y0 = ll_ode_next(run), *term = ll_ode_work(run, TERM);
    for (int i = 0; i < run->dim; i++) {
        double sum = 0;
        for (int j = TERMS - 1; j >= 0; j--)
            sum = (sum + term[j * run->stride + i]) * (j % 2 == 0 ? theta : 1 - theta);
        y[i] = y0[i] + sum;
    }
}

static const ll_ode_body body = {
    .vectors = VECTORS, .attempt = attempt, .accept = accept, .dense = dense, .error_order = 8};

const ll_ode_method ll_ode_dop853 = {
    .name = "dop853",
    .help = "Dormand-Prince of order 8 with dense output: for smooth problems and high accuracy.",
    .source = "E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.5",
    .order = 8,
    .evaluations = 12,
    .adaptive = true,
    .body = &body};
