/* DOP853: Dormand and Prince's method of order 8 with an error estimate of orders 5 and 3 and dense output of
 * order 7 (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.5, II.10). */
#include <string.h>

#include "ode/internal.h"

enum {
    STAGES = 12,
    ALL_STAGES = 16,
    TERMS = 7
}; /* stage 13 is f at the end; 14 to 16 are for dense output */

static const double c[] = {0.0,
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

static const double a[] = {
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

static const double e5[] = {0.013120044994194880733,
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

static const double e3[] = {-0.18980075407240761571,
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

enum { K, POINT = K + ALL_STAGES, TERM, ERROR = TERM + TERMS, VECTORS = ERROR + 3 };

/* out = base + h (a[0] k_0 + a[1] k_1 + ...). The coefficients are constants here, so that those of 0 cost
 * nothing. */
static inline __attribute__((always_inline)) void combine(int stride, const double *base, const double *k,
                                                          const double *weight, int count, double h,
                                                          double *out)
{
    for (int i = 0; i < stride; i += 2) {
        ll_pair sum = weight[0] * ll_pair_at(k + i);
#pragma GCC unroll 16
        for (int j = 1; j < count; j++)
            if (weight[j] != 0)
                sum += weight[j] * ll_pair_at(k + j * stride + i);
        ll_pair_put(out + i, ll_pair_at(base + i) + h * sum);
    }
}

/* Stage s (0 the first): its state, then its slope. */
static inline __attribute__((always_inline)) void stage(ll_ode_run *run, const ll_ode *ode, int s, double t,
                                                        double h, const double *y)
{
    double *k = ll_ode_work(run, K), *point = ll_ode_work(run, POINT);
    combine(run->stride, y, k, a + s * (s - 1) / 2, s, h, point);
    ll_ode_eval(ode, t + c[s] * h, point, k + s * run->stride);
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method;
    const double *y = ll_ode_state_y(run);
    double *k = ll_ode_work(run, K), *error = ll_ode_work(run, ERROR), t = run->t;
    int stride = run->stride;
    if (run->history == 0)
        ll_ode_f(run, ode, t, y, k);
    else if (run->history == 2)
        memcpy(k, k + STAGES * stride, (size_t)stride * sizeof *k);
    run->history = 1;
#pragma GCC unroll 12
    for (int s = 1; s < STAGES; s++)
        stage(run, ode, s, t, h, y);
    run->counters.evaluations += STAGES - 1;
    combine(stride, y, k, a + STAGES * (STAGES - 1) / 2, STAGES, h, ll_ode_next(run));
    const double *zero = error + 2 * stride;
    combine(stride, zero, k, e5, STAGES, h, error);
    combine(stride, zero, k, e3, STAGES, h, error + stride);
    double error5 = ll_ode_norm2(run, error), error3 = ll_ode_norm2(run, error + stride);
    return error5 == 0 ? 0 : error5 * error5 / (error5 + 0.01 * error3);
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method, (void)h;
    ll_ode_f(run, ode, run->t, ll_ode_state_y(run), ll_ode_work(run, K + STAGES));
    run->history = 2;
}

static void prepare(ll_ode_run *run, const ll_ode *ode)
{
    int stride = run->stride;
    double h = run->t - run->t_last, *k = ll_ode_work(run, K), *term = ll_ode_work(run, TERM);
    const double *y0 = ll_ode_next(run), *y1 = ll_ode_end(run);
#pragma GCC unroll 3
    for (int s = STAGES + 1; s < ALL_STAGES; s++)
        stage(run, ode, s, run->t_last, h, y0);
    for (int i = 0; i < run->dim; i++) {
        double change = y1[i] - y0[i];
        term[i] = change;
        term[stride + i] = h * k[i] - change;
        term[2 * stride + i] = 2 * change - h * (k[i] + k[STAGES * stride + i]);
    }
    for (int j = 0; j < 4; j++)
        combine(stride, ll_ode_work(run, ERROR + 2), k, d[j], ALL_STAGES, h, term + (3 + j) * stride);
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
    .help = "Dormand-Prince of order 8 with dense output: for smooth problems to many digits.",
    .source = "E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.5",
    .order = 8,
    .evaluations = 12,
    .adaptive = true,
    .body = &body};
