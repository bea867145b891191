/* Rosenbrock methods: linearly implicit, one factorisation per step and no iteration. In the form without
 * products with the Jacobian (Hairer, Wanner, Solving Ordinary Differential Equations II, IV.7):
 *   (I / (gamma h) - J) u_i = f(t + c_i h, y + sum a_ij u_j) + sum (g_ij / h) u_j + d_i h df/dt.
 * The last two stages are at the embedded and at the final solution; their difference is the error. */
#include <float.h>
#include <string.h>

#include "ode/core/linear.h"
#include "ode/core/method_internal.h"

enum { STAGES_MAX = 8 };

typedef struct rosenbrock {
    int stages;
    double gamma;
    const double *a, *g; /* rows of the later stages: 1, 2, 3... numbers each */
    const double *c, *d; /* `stages` */
    const double *p;     /* dense output: `terms` rows of `stages` weights */
    int terms;
} rosenbrock;

enum { F0, FT, POINT, SCRATCH, U = SCRATCH + 2, ERROR = U + STAGES_MAX, VECTORS };

static size_t extra(int dim)
{
    size_t n = (size_t)dim;
    return 2 * n * n + (n + 1) / 2; /* Jacobian, factorisation, row exchanges */
}

/* df/dt by a forward difference; 0 in an autonomous system. */
static void time_derivative(ll_ode_run *run, const ll_ode *ode)
{
    const double *y = ll_ode_state_y(run), *f0 = ll_ode_work(run, F0);
    double *ft = ll_ode_work(run, FT), size = run->t < 0 ? -run->t : run->t;
    if (ode->autonomous)
        return;
    double later = run->t + ll_sqrt(DBL_EPSILON * (size > 1e-5 ? size : 1e-5));
    ll_ode_f(run, ode, later, y, ft);
    for (int i = 0; i < run->dim; i++)
        ft[i] = (ft[i] - f0[i]) / (later - run->t);
}

static void add(double *out, double weight, const double *x, int n)
{
    for (int i = 0; i < n; i++)
        out[i] += weight * x[i];
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const rosenbrock *r = method->data;
    int n = run->dim, stride = run->stride;
    const double *y = ll_ode_state_y(run), *a = r->a, *g = r->g;
    double *f0 = ll_ode_work(run, F0), *u = ll_ode_work(run, U), *point = ll_ode_work(run, POINT);
    double *jacobian = ll_ode_extra(run, method), *lu = jacobian + n * n;
    int32_t *pivot = (int32_t *)(lu + n * n);
    if (run->history == 0) {
        ll_ode_f(run, ode, run->t, y, f0);
        ll_ode_jacobian_at(run, ode, run->t, y, f0, jacobian, ll_ode_work(run, SCRATCH));
        time_derivative(run, ode);
        run->history = 1;
    }
    for (int i = 0; i < n * n; i++)
        lu[i] = (i % (n + 1) == 0 ? 1 / (r->gamma * h) : 0) - jacobian[i];
    run->counters.factorisations++;
    if (!ll_lu_factorise(n, lu, pivot))
        return (double)__builtin_inff();
    for (int s = 0; s < r->stages; s++) {
        double *stage = u + s * stride;
        memcpy(point, y, (size_t)n * sizeof *y);
        for (int j = 0; j < s; j++)
            add(point, a[j], u + j * stride, n);
        if (s == 0)
            memcpy(stage, f0, (size_t)n * sizeof *f0);
        else
            ll_ode_f(run, ode, run->t + r->c[s] * h, point, stage);
        for (int j = 0; j < s; j++)
            add(stage, g[j] / h, u + j * stride, n);
        if (!ode->autonomous)
            add(stage, r->d[s] * h, ll_ode_work(run, FT), n);
        ll_lu_solve(n, lu, pivot, stage);
        a += s;
        g += s;
    }
    run->counters.solves += r->stages;
    double *next = ll_ode_next(run);
    const double *error = u + (r->stages - 1) * stride;
    for (int i = 0; i < n; i++)
        next[i] = point[i] + error[i];
    return ll_ode_norm2(run, error);
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)method, (void)ode, (void)h;
    run->history = 0;
}

/* (1 - theta) (y0 + theta (k0 + theta (k1 + theta k2))) + theta y1. */
static void dense(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double theta, double *y)
{
    (void)ode;
    const rosenbrock *r = method->data;
    const double *y0 = ll_ode_next(run), *y1 = ll_ode_end(run), *u = ll_ode_work(run, U);
    for (int i = 0; i < run->dim; i++) {
        double sum = 0;
        for (int k = r->terms - 1; k >= 0; k--) {
            for (int s = 0; s < r->stages; s++)
                sum += r->p[k * r->stages + s] * u[s * run->stride + i];
            sum *= theta;
        }
        y[i] = (1 - theta) * (y0[i] + sum) + theta * y1[i];
    }
}

static const ll_ode_body body_4 = {.vectors = VECTORS,
                                   .extra = extra,
                                   .attempt = attempt,
                                   .accept = accept,
                                   .dense = dense,
                                   .error_order = 4};
static const ll_ode_body body_5 = {.vectors = VECTORS,
                                   .extra = extra,
                                   .attempt = attempt,
                                   .accept = accept,
                                   .dense = dense,
                                   .error_order = 5};

const ll_ode_method ll_ode_rodas4 = {
    .name = "rodas4",
    .help = "Rosenbrock 4(3) of six stages, L-stable: for stiff problems to four or five digits.",
    .source = "E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.7 and VI.4",
    .order = 4,
    .evaluations = 6,
    .a_stable = true,
    .adaptive = true,
    .body = &body_4,
    .data = &(const rosenbrock){
        .stages = 6,
        .gamma = 0.25,
        .a = (const double[]){1.544000000000000,                                           /* 2 */
                              0.9466785280815826, 0.2557011698983284,                      /* 3 */
                              3.314825187068521, 2.896124015972201, 0.9986419139977817,    /* 4 */
                              1.221224509226641, 6.019134481288629, 12.53708332932087,     /* 5 */
                              -0.6878860361058950,                                         /* */
                              1.221224509226641, 6.019134481288629, 12.53708332932087,     /* 6 */
                              -0.6878860361058950, 1},                                     /* */
        .g = (const double[]){-5.668800000000000,                                          /* 2 */
                              -2.430093356833875, -0.2063599157091915,                     /* 3 */
                              -0.1073529058151375, -9.594562251023355, -20.47028614809616, /* 4 */
                              7.496443313967647, -10.24680431464352, -33.99990352819905,   /* 5 */
                              11.70890893206160,                                           /* */
                              8.083246795921522, -7.981132988064893, -31.52159432874371,   /* 6 */
                              16.31930543123136, -6.058818238834054},                      /* */
        .c = (const double[]){0, 0.386, 0.21, 0.63, 1, 1},
        .d = (const double[]){0.25, -0.1043, 0.1035, -0.0362, 0, 0},
        .p = (const double[]){10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823,
                              1.025137723295662, 0, -0.6762803392801253, 6.087714651680015, 16.43084320892478,
                              24.76722511418386, -6.594389125716872, 0},
        .terms = 2}};

const ll_ode_method ll_ode_rodas5p = {
    .name = "rodas5p",
    .help = "Rosenbrock 5(4) of eight stages, L-stable: for stiff problems to eight digits.",
    .source = "G. Steinebach, BIT 63, 2023",
    .order = 5,
    .evaluations = 8,
    .a_stable = true,
    .adaptive = true,
    .body = &body_5,
    .data = &(const rosenbrock){
        .stages = 8,
        .gamma = 0.21193756319429014,
        .a = (const double[]){3, /* 2 */
                              2.849394379747939,
                              0.45842242204463923, /* 3 */
                              -6.954028509809101,
                              2.489845061869568,
                              -10.358996098473584, /* 4 */
                              2.8029986275628964,
                              0.5072464736228206,
                              -0.3988312541770524,  /* 5 */
                              -0.04721187230404641, /* */
                              -7.502846399306121,
                              2.561846144803919,
                              -11.627539656261098, /* 6 */
                              -0.18268767659942256,
                              0.030198172008377946, /* */
                              -7.502846399306121,
                              2.561846144803919,
                              -11.627539656261098, /* 7 */
                              -0.18268767659942256,
                              0.030198172008377946,
                              1, /* */
                              -7.502846399306121,
                              2.561846144803919,
                              -11.627539656261098, /* 8 */
                              -0.18268767659942256,
                              0.030198172008377946,
                              1,
                              1},                                                            /* */
        .g = (const double[]){-14.155112264123755,                                           /* 2 */
                              -17.97296035885952,  -2.859693295451294,                       /* 3 */
                              147.12150275711716,  -1.41221402718213,   71.68940251302358,   /* 4 */
                              165.43517024871676,  -0.4592823456491126, 42.90938336958603,   /* 5 */
                              -5.961986721573306,                                            /* */
                              24.854864614690072,  -3.0009227002832186, 47.4931110020768,    /* 6 */
                              5.5814197821558125,  -0.6610691825249471,                      /* */
                              30.91273214028599,   -3.1208243349937974, 77.79954646070892,   /* 7 */
                              34.28646028294783,   -19.097331116725623, -28.087943162872662, /* */
                              37.80277123390563,   -3.2571969029072276, 112.26918849496327,  /* 8 */
                              66.9347231244047,    -40.06618937091002,  -54.66780262877968,  /* */
                              -9.48861652309627},                                            /* */
        .c = (const double[]){0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716,
                              0.4288403609558664, 1, 1, 1},
        .d = (const double[]){0.21193756319429014, -0.42387512638858027, -0.3384627126235924,
                              1.8046452872882734, 2.325825639765069, 0, 0, 0},
        .p = (const double[]){25.948786856663858,  -2.5579724845846235,  10.433815404888879,
                              -2.3679251022685204, 0.524948541321073,    1.1241088310450404,
                              0.4272876194431874,  -0.17202221070155493, -9.91568850695171,
                              -0.9689944594115154, 3.0438037242978453,   -24.495224566215796,
                              20.176138334709044,  15.98066361424651,    -6.789040303419874,
                              -6.710236069923372,  11.419903575922262,   2.8879645146136994,
                              72.92137995996029,   80.12511834622643,    -52.072871366152654,
                              -59.78993625266729,  -0.15582684282751913, 4.883087185713722},
        .terms = 3}};
