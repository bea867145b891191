/* Radau IIA collocation with s = 3, 5 or 7 stages, of order 2 s - 1: stiffly accurate and L-stable.
 *
 * The stages' increments Z are found by a simplified Newton iteration. A change of basis Z = T W turns its
 * system of s n unknowns into one real system of n unknowns and (s - 1) / 2 complex ones (E. Hairer, G.
 * Wanner, Solving Ordinary Differential Equations II, IV.8, and J. Comput. Appl. Math. 111, 1999). The
 * Jacobian and its factorisations are kept while the iteration converges fast and the step size stays. */
#include <string.h>

#include "ode/core/linear.h"
#include "ode/core/method_internal.h"

enum { STAGES_MAX = 7, PAIRS_MAX = 3, ITERATIONS = 10 };

typedef struct radau {
    int stages;
    double c[STAGES_MAX];
    double real, alpha[PAIRS_MAX], beta[PAIRS_MAX]; /* eigenvalues of the inverse of the method's matrix */
    double t[STAGES_MAX * STAGES_MAX], t_inverse[STAGES_MAX * STAGES_MAX]; /* `stages` x `stages` */
    double e[STAGES_MAX]; /* embedded minus final solution = h f0 / real + sum of e[i] Z_i */
} radau;

/* Kept between steps; stored before the matrices. */
typedef struct memory {
    double tolerance;  /* tolerance of the step */
    double h_factored; /* step size of the factorisations; 0: none */
    double h_last, error_last;
    double h_kept;     /* step size of the polynomial in OLD; 0: none */
    double rate;       /* convergence rate of the last iteration */
    double current;    /* 1: the Jacobian belongs to this step */
    double iterations; /* in the last attempt; 0: it failed */
    double rejected;   /* 1: the last attempt was rejected */
} memory;

enum { MEMORY = sizeof(memory) / sizeof(double) };

/* Work vectors. */
enum {
    F0,
    SCALE,
    ERROR,
    SCRATCH,
    POINT = SCRATCH + 2,
    Z,
    W = Z + STAGES_MAX,
    F = W + STAGES_MAX,
    OLD = F + STAGES_MAX,
    VECTORS = OLD + STAGES_MAX
};

static size_t extra(int dim)
{
    size_t n = (size_t)dim, exchanges = (n * (1 + PAIRS_MAX) + 1) / 2;
    return MEMORY + n * n * (2 + 2 * PAIRS_MAX) + exchanges; /* J, a real and PAIRS_MAX complex systems */
}

static memory *memory_of(ll_ode_run *run, const ll_ode_method *method)
{
    return (memory *)ll_ode_extra(run, method);
}

static double *jacobian_of(ll_ode_run *run, const ll_ode_method *method)
{
    return ll_ode_extra(run, method) + MEMORY;
}

/* The real system, and both parts of pair p. */
static double *system_of(ll_ode_run *run, const ll_ode_method *method, int number)
{
    return jacobian_of(run, method) + (1 + number) * run->dim * run->dim;
}

static int32_t *exchanges_of(ll_ode_run *run, const ll_ode_method *method, int number)
{
    return (int32_t *)system_of(run, method, 1 + 2 * PAIRS_MAX) + number * run->dim;
}

/* (real / h) I - J, and (alpha + i beta) / h I - J of each pair. */
static bool factorise(ll_ode_run *run, const ll_ode_method *method, double h)
{
    const radau *r = method->data;
    int n = run->dim;
    const double *jacobian = jacobian_of(run, method);
    double *real = system_of(run, method, 0);
    for (int i = 0; i < n * n; i++)
        real[i] = (i % (n + 1) == 0 ? r->real / h : 0) - jacobian[i];
    run->counters.factorisations += 1 + r->stages / 2;
    if (!ll_lu_factorise(n, real, exchanges_of(run, method, 0)))
        return false;
    for (int p = 0; p < r->stages / 2; p++) {
        double *re = system_of(run, method, 1 + 2 * p), *im = system_of(run, method, 2 + 2 * p);
        for (int i = 0; i < n * n; i++) {
            bool diagonal = i % (n + 1) == 0;
            re[i] = (diagonal ? r->alpha[p] / h : 0) - jacobian[i];
            im[i] = diagonal ? r->beta[p] / h : 0;
        }
        if (!ll_lu_factorise_complex(n, re, im, exchanges_of(run, method, 1 + p)))
            return false;
    }
    return true;
}

/* Weights of Z at the fraction `theta` of their step: the polynomial through 0 at 0 and Z_j at c_j. */
static void lagrange(const radau *r, double theta, double *weight)
{
    for (int j = 0; j < r->stages; j++) {
        weight[j] = theta / r->c[j];
        for (int k = 0; k < r->stages; k++)
            if (k != j)
                weight[j] *= (theta - r->c[k]) / (r->c[j] - r->c[k]);
    }
}

/* Starts from the extrapolated polynomial of the last step, or from zero. */
static void guess(ll_ode_run *run, const ll_ode_method *method, double h)
{
    const radau *r = method->data;
    const memory *m = memory_of(run, method);
    int s = r->stages, stride = run->stride;
    double *z = ll_ode_work(run, Z), *w = ll_ode_work(run, W);
    const double *old = ll_ode_work(run, OLD);
    if (m->h_kept == 0) {
        memset(z, 0, (size_t)(s * stride) * sizeof *z);
        memset(w, 0, (size_t)(s * stride) * sizeof *w);
        return;
    }
    for (int i = 0; i < s; i++) {
        double weight[STAGES_MAX];
        lagrange(r, 1 + r->c[i] * h / m->h_kept, weight);
        weight[s - 1] -= 1;
        for (int k = 0; k < stride; k++) {
            double sum = 0;
            for (int j = 0; j < s; j++)
                sum += weight[j] * old[j * stride + k];
            z[i * stride + k] = sum;
        }
    }
    for (int i = 0; i < s; i++)
        for (int k = 0; k < stride; k++) {
            double sum = 0;
            for (int j = 0; j < s; j++)
                sum += r->t_inverse[i * s + j] * z[j * stride + k];
            w[i * stride + k] = sum;
        }
}

/* One update of W and Z. Returns its norm relative to the tolerance. */
static double iterate(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const radau *r = method->data;
    int n = run->dim, s = r->stages, stride = run->stride;
    const double *y = ll_ode_state_y(run), *scale = ll_ode_work(run, SCALE);
    double *z = ll_ode_work(run, Z), *w = ll_ode_work(run, W), *f = ll_ode_work(run, F);
    double *point = ll_ode_work(run, POINT), change[STAGES_MAX][LL_ODE_DIM_MAX], sum = 0;
    for (int i = 0; i < s; i++) {
        for (int k = 0; k < n; k++)
            point[k] = y[k] + z[i * stride + k];
        ll_ode_f(run, ode, run->t + r->c[i] * h, point, f + i * stride);
    }
    for (int i = 0; i < s; i++)
        for (int k = 0; k < n; k++) {
            double total = 0;
            for (int j = 0; j < s; j++)
                total += r->t_inverse[i * s + j] * f[j * stride + k];
            change[i][k] = total;
        }
    for (int k = 0; k < n; k++)
        change[0][k] -= r->real / h * w[k];
    ll_lu_solve(n, system_of(run, method, 0), exchanges_of(run, method, 0), change[0]);
    for (int p = 0; p < s / 2; p++) {
        double *x = change[1 + 2 * p], *x_im = change[2 + 2 * p], a = r->alpha[p] / h, b = r->beta[p] / h;
        const double *u = w + (1 + 2 * p) * stride, *v = u + stride;
        for (int k = 0; k < n; k++) {
            x[k] -= a * u[k] - b * v[k];
            x_im[k] -= b * u[k] + a * v[k];
        }
        ll_lu_solve_complex(n, system_of(run, method, 1 + 2 * p), system_of(run, method, 2 + 2 * p),
                            exchanges_of(run, method, 1 + p), x, x_im);
    }
    run->counters.solves += 1 + s / 2;
    for (int i = 0; i < s; i++)
        for (int k = 0; k < n; k++) {
            double part = change[i][k] * scale[k];
            sum += part * part;
            w[i * stride + k] += change[i][k];
        }
    for (int i = 0; i < s; i++)
        for (int k = 0; k < n; k++) {
            double total = 0;
            for (int j = 0; j < s; j++)
                total += r->t[i * s + j] * w[j * stride + k];
            z[i * stride + k] = total;
        }
    return ll_sqrt(sum / (n * s));
}

/* Iterates until the remaining change is small against the step's tolerance. */
static bool newton(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    memory *m = memory_of(run, method);
    double target = m->tolerance > 1e-3 ? 0.03 : ll_sqrt(m->tolerance);
    target = target > 1e-14 / m->tolerance ? target : 1e-14 / m->tolerance;
    double last = 0, ratio = 0;
    m->iterations = 0;
    for (int i = 1; i <= ITERATIONS; i++) {
        double size = iterate(run, method, ode, h);
        if (!(size - size == 0))
            return false;
        if (i > 1) {
            double now = size / last;
            ratio = i == 2 ? now : ll_sqrt(now * ratio);
            if (ratio >= 0.99)
                return false;
        }
        double left = i > 1 ? ratio / (1 - ratio) * size : size;
        if (left <= target || size == 0) {
            m->rate = ratio;
            m->iterations = i;
            return true;
        }
        if (i > 1 && left * ll_ode_power(ratio + 1e-30, ITERATIONS - 1 - i) > target * 10)
            return false; /* it would take too many iterations */
        last = size;
    }
    return false;
}

/* Embedded minus final solution, filtered by (real / h) I - J so that stiff components do not dominate it.
 * `again`: filter twice, for first and rejected steps. */
static double estimate(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h, bool again)
{
    const radau *r = method->data;
    int n = run->dim;
    const double *f0 = ll_ode_work(run, F0), *z = ll_ode_work(run, Z), *scale = ll_ode_work(run, SCALE);
    const double *y = ll_ode_state_y(run);
    double *error = ll_ode_work(run, ERROR), *sum = ll_ode_work(run, SCRATCH),
           *point = ll_ode_work(run, POINT);
    for (int k = 0; k < n; k++) {
        double total = 0;
        for (int i = 0; i < r->stages; i++)
            total += r->e[i] * z[i * run->stride + k];
        sum[k] = r->real / h * total;
        error[k] = f0[k] + sum[k];
    }
    for (int pass = 0;; pass++) {
        ll_lu_solve(n, system_of(run, method, 0), exchanges_of(run, method, 0), error);
        double norm = 0;
        for (int k = 0; k < n; k++) {
            double part = error[k] * scale[k];
            norm += part * part;
        }
        norm /= n;
        if (norm < 1 || !again || pass == 1)
            return norm > 1e-20 ? norm : 1e-20;
        for (int k = 0; k < n; k++)
            point[k] = y[k] + error[k];
        ll_ode_f(run, ode, run->t, point, error);
        for (int k = 0; k < n; k++)
            error[k] += sum[k];
    }
}

static double attempt(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    const radau *r = method->data;
    memory *m = memory_of(run, method);
    int n = run->dim;
    const double *y = ll_ode_state_y(run);
    double *f0 = ll_ode_work(run, F0), *scale = ll_ode_work(run, SCALE), *next = ll_ode_next(run);
    double power = (r->stages + 1) / (2. * r->stages), share = run->control.absolute / run->control.tolerance;
    if (run->history ==
        0) { /* the estimate has only order s + 1: a larger tolerance achieves the wanted one */
        *m = (memory){.tolerance = 0.1 * ll_ode_power(run->control.tolerance, power)};
        run->history = 1;
    }
    if (run->history == 1) {
        ll_ode_f(run, ode, run->t, y, f0);
        for (int i = 0; i < n; i++)
            scale[i] = 1 / (m->tolerance * (share + (y[i] < 0 ? -y[i] : y[i])));
        run->history = 2;
    }
    if (m->h_factored == 0 || (m->rate > 1e-3 && m->current == 0)) {
        ll_ode_jacobian_at(run, ode, run->t, y, f0, jacobian_of(run, method), ll_ode_work(run, SCRATCH));
        m->current = 1;
        m->h_factored = 0;
    }
    if (m->h_factored != h && !factorise(run, method, h))
        return (double)__builtin_inff();
    m->h_factored = h;
    guess(run, method, h);
    if (!newton(run, method, ode, h)) {
        m->rate = 1; /* a Jacobian of another step is not reused */
        return (double)__builtin_inff();
    }
    const double *last = ll_ode_work(run, Z) + (r->stages - 1) * run->stride;
    for (int i = 0; i < n; i++)
        next[i] = y[i] + last[i];
    return estimate(run, method, ode, h, m->h_last == 0 || m->rejected == 1);
}

/* After a failed iteration half the step; otherwise by the error, by the iterations needed, and by the trend
 * of the last two steps (K. Gustafsson, ACM Trans. Math. Softw. 20, 1994). A step that would grow by less
 * than a fifth is kept, and with it the factorisations. */
static double propose(ll_ode_run *run, const ll_ode_method *method, double h, double error)
{
    memory *m = memory_of(run, method);
    double power = 1. / (((const radau *)method->data)->stages + 1);
    bool was_rejected = m->rejected == 1;
    m->rejected = !(error <= 1);
    if (m->iterations == 0)
        return h / 2;
    double safety = 0.9 * (1 + 2 * ITERATIONS) / (m->iterations + 2 * ITERATIONS);
    double factor = safety * ll_ode_power(error, -power / 2);
    if (error <= 1) {
        if (m->h_last != 0) {
            double trend = 0.9 * h / m->h_last * ll_ode_power(m->error_last / (error * error), power / 2);
            factor = trend < factor ? trend : factor;
        }
        m->h_last = h;
        m->error_last = error > 1e-4 ? error : 1e-4;
        if (was_rejected && factor > 1)
            factor = 1;
        if (m->rate <= 1e-3 && factor >= 1 && factor <= 1.2)
            factor = 1;
    }
    return h * (factor < 0.2 ? 0.2 : factor > 8 ? 8 : factor);
}

static void accept(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double h)
{
    (void)ode;
    memory *m = memory_of(run, method);
    int stages = ((const radau *)method->data)->stages;
    memcpy(ll_ode_work(run, OLD), ll_ode_work(run, Z), (size_t)(stages * run->stride) * sizeof(double));
    m->h_kept = h;
    m->current = 0;
    run->history = 1;
}

/* Collocation polynomial. */
static void dense(ll_ode_run *run, const ll_ode_method *method, const ll_ode *ode, double theta, double *y)
{
    (void)ode;
    const radau *r = method->data;
    const double *y0 = ll_ode_next(run), *z = ll_ode_work(run, OLD);
    double weight[STAGES_MAX];
    lagrange(r, theta, weight);
    for (int i = 0; i < run->dim; i++) {
        double sum = 0;
        for (int j = 0; j < r->stages; j++)
            sum += weight[j] * z[j * run->stride + i];
        y[i] = y0[i] + sum;
    }
}

static const ll_ode_body body = {.vectors = VECTORS,
                                 .extra = extra,
                                 .attempt = attempt,
                                 .accept = accept,
                                 .propose = propose,
                                 .dense = dense,
                                 .error_order = 4};

static const radau radau5 = {
    .stages = 3,
    .c = {0.15505102572168219018, 0.64494897427831780982, 1.0},
    .real = 3.6378342527444957322,
    .alpha = {2.6810828736277521339},
    .beta = {3.0504301992474105694},
    .t = {0.094438762488975241487, -0.14125529502095420843, -0.030029194105147424492, 0.25021312296533331138,
          0.204129352293799932, 0.3829421127572619378, 1.0, 1.0, 0.0},
    .t_inverse = {4.1787185915519047273, 0.32768282076106238708, 0.52337644549944954804,
                  -4.1787185915519047273, -0.32768282076106238708, 0.47662355450055045196,
                  -0.50287263494578687595, 2.5719269498556054292, -0.59603920482822492497},
    .e = {-2.7623054547485993983, 0.37993559825272887787, -0.091629609865225789249}};

static const radau radau9 = {
    .stages = 5,
    .c = {0.057104196114517682193, 0.27684301363812382768, 0.58359043236891682006, 0.86024013565621944785,
          1.0},
    .real = 6.2867047517292766452,
    .alpha = {5.7009532986717894192, 3.6556943254635722582},
    .beta = {3.2102656003085498884, 6.543736899360077294},
    .t = {0.013576867344947943248,
          -0.011478515255229514708,
          -0.014019858892875410281,
          -0.01024204781790882707,
          0.047673877290295723863,
          0.0016179004017190874764,
          -0.0076688307491801628852,
          0.024708578426518526813,
          0.050172864517371058163,
          -0.094331819181611436981,
          0.079157853347447207645,
          0.019398463998828950911,
          0.081800353703751170836,
          -0.23053953404341794672,
          0.10270304538012589979,
          0.41225608268046145198,
          0.40760117128019906662,
          0.19968242788680252594,
          0.37789390224886124954,
          0.46674413033249435929,
          1.0,
          1.0,
          0.0,
          1.0,
          0.0},
    .t_inverse = {27.697693775684088409,   12.783337911304406015,   3.2084893867134298598,
                  -0.95149041224891622127, 0.74155049602598960335,  -33.041880213519000008,
                  -17.376953479063567019,  -0.17212906325400556115, -0.099169777982542642588,
                  0.53122811583830666718,  -8.6114439798752919777,  9.6999914095288082313,
                  1.9147286396968742849,   2.4186920060849400264,   -1.0474634879353374187,
                  5.3441864378349115989,   4.5936155677591610045,   -3.0363603234594242986,
                  1.0506601902314588639,   -0.27277861186429627054, 3.7480598074398048601,
                  -3.9849657363438846673,  -1.0444156416080187929,  1.1840985681379484872,
                  -0.4499177701567803689},
    .e = {-4.4189977167963817226, 0.57923485225667005447, -0.19923756095346800874, 0.094167483691945488975,
          -0.031813168885493824096}};

static const radau radau13 = {
    .stages = 7,
    .c = {0.029316427159784891972, 0.14807859966848429185, 0.3369846902811542991, 0.55867151877155013208,
          0.76923386203005450092, 0.92694567131974111485, 1.0},
    .real = 8.9368327884052163373,
    .alpha = {8.5118348251029457231, 7.1410552191876401058, 4.3786935615068060025},
    .beta = {3.28101362432505883, 6.6230459226392759706, 10.169693283795011627},
    .t = {0.0024435843048706115407,
          -0.0012386461879528740564,
          -0.0027606174805438524995,
          -0.0040551614523310238982,
          0.0044272327532682854797,
          0.021567551351320773387,
          0.0087835679251441444073,
          -0.0018153396483193171605,
          -0.000066666353393963381818,
          0.0031854748251662098487,
          0.0084155682765595892372,
          -0.0040319495702245494923,
          -0.038131648134411546694,
          -0.021525560594006875524,
          0.0046053393311618748042,
          -0.0023521809829433383405,
          0.00041690777252975626914,
          -0.0085604310616034320602,
          -0.0069232126650239089241,
          0.057396508939381715398,
          0.058850529208426791056,
          0.017870023342853069058,
          0.0031150711523461752527,
          0.025116604913438821928,
          -0.037371242302384457419,
          0.0082390072985077194045,
          -0.038214693596968350485,
          -0.16573681127294385124,
          0.12818100807728391008,
          0.10171773248171514681,
          0.09504502035604622821,
          0.0053667613791817700943,
          0.19321111610126201443,
          -0.24917421246526368633,
          0.27356330579866232121,
          0.5200651497488246866,
          0.52175194527476528529,
          0.12807194463554389441,
          0.52657422645844926291,
          0.27553439498962581419,
          0.53158464908362842921,
          0.48632283661757289406,
          1.0,
          1.0,
          0.0,
          1.0,
          0.0,
          1.0,
          0.0},
    .t_inverse =
        {227.51530596268068904,   166.64802246760974611,   43.265145884526215054,   3.6230900613410161325,
         3.5726748329387980313,   -2.7435563656033673145,  1.4514535402547503515,   -299.18624802825209668,
         -243.04074536874479118,  -48.777104078037869212,  -2.0386719057419344053,  1.6735602398610849443,
         -1.0873740320571061645,  0.90193824929609937384,  -93.076502897435305912,  23.881631056281144277,
         39.278880730813843827,   14.38891568549108007,    -3.5104383993993612211,  4.8632848855661807012,
         -2.2464827295912399164,  74.678332235022699772,   87.408588979900816402,   4.024158737379997877,
         -3.7148063151583641866,  -3.4300939859823173507,  2.6966048097653123789,   -0.93869274360754619336,
         58.356528851906577242,   -10.068773957800180963,  -30.366388842566671208,  -1.020020865184865985,
         -0.11241750037842496213, 1.8906408310003776228,   -0.97164863938314822822, -3.0073901694512921317,
         -11.015866078765771329,  1.4877994561316562815,   2.1303881595592824594,   -1.8161410868175656248,
         1.1343255878951611001,   -0.41469904594330353199, -8.4419631883210846818,  -0.65052527405751500282,
         6.9406707303698764788,   -3.2050475255978984316,  1.0712809435464785898,   -0.35485074912162218797,
         0.091985491327865541544},
    .e = {-6.084307291132809522, 0.78327794309200064814, -0.26359014963822842841, 0.12669914419515418858,
          -0.072384852898517405594, 0.043363616009258237872, -0.015985209328576439419}};

const ll_ode_method ll_ode_radau5 = {
    .name = "radau5",
    .help = "Radau IIA of three stages: implicit, for stiff problems.",
    .source = "E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.8",
    .order = 5,
    .a_stable = true,
    .adaptive = true,
    .body = &body,
    .data = &radau5};

const ll_ode_method ll_ode_radau9 = {.name = "radau9",
                                     .help = "Radau IIA of five stages: for stiff problems, to ten digits.",
                                     .source = "E. Hairer, G. Wanner, J. Comput. Appl. Math. 111, 1999",
                                     .order = 9,
                                     .a_stable = true,
                                     .adaptive = true,
                                     .body = &body,
                                     .data = &radau9};

const ll_ode_method ll_ode_radau13 = {.name = "radau13",
                                      .help = "Radau IIA of seven stages: for stiff problems, to all digits.",
                                      .source = "E. Hairer, G. Wanner, J. Comput. Appl. Math. 111, 1999",
                                      .order = 13,
                                      .a_stable = true,
                                      .adaptive = true,
                                      .body = &body,
                                      .data = &radau13};
