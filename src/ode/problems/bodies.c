/* Bodies that attract each other in the plane: the Pleiades (seven, with close encounters), and the
 * figure-eight orbit of three. The order of the positions is x1 ... xn, y1 ... yn. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double gravity;
} params;

static const ll_param rows[] = {LL_ODE_PARAM(params, gravity, NULL, 0, 100, 1, "Gravitational constant.")};
LL_ODE_TABLE(ll_ode_pleiades_table, "pleiades", "Parameters of the seven bodies.", rows, params);
LL_ODE_TABLE(ll_ode_figure_eight_table, "figure_eight", "Parameters of the three bodies.", rows, params);

/* The acceleration of n bodies. */
#define ATTRACTION(name, n, mass)                                                                            \
    LL_ODE_ACCELERATION(name, 4 * (n), {                                                                     \
        double gravity = ((const params *)p)->gravity;                                                       \
        for (int i = 0; i < 2 * (n); i++)                                                                    \
            a[i] = 0 * q[i];                                                                                 \
        for (int i = 1; i < (n); i++) {                                                                      \
            real x = q[i], y = q[(n) + i], ax = 0 * x, ay = 0 * y;                                           \
            for (int j = 0; j < i; j++) {                                                                    \
                real dx = q[j] - x, dy = q[(n) + j] - y, r2 = dx * dx + dy * dy;                             \
                real w = gravity / (r2 * ll_real_sqrt(r2));                                                  \
                dx *= w;                                                                                     \
                dy *= w;                                                                                     \
                ax += (mass)[j] * dx;                                                                        \
                ay += (mass)[j] * dy;                                                                        \
                a[j] -= (mass)[i] * dx;                                                                      \
                a[(n) + j] -= (mass)[i] * dy;                                                                \
            }                                                                                                \
            a[i] += ax;                                                                                      \
            a[(n) + i] += ay;                                                                                \
        }                                                                                                    \
    })

static double energy_of(int n, const double *mass, double gravity, const double *y)
{
    const double *q = y, *v = y + 2 * n;
    double sum = 0;
    for (int i = 0; i < n; i++) {
        sum += mass[i] * (v[i] * v[i] + v[n + i] * v[n + i]) / 2;
        for (int j = i + 1; j < n; j++) {
            double dx = q[j] - q[i], dy = q[n + j] - q[n + i];
            sum -= gravity * mass[i] * mass[j] / ll_sqrt(dx * dx + dy * dy);
        }
    }
    return sum;
}

/* ---- Taylor coefficients ---- */

/* Two of the pairs of bodies, one in each lane: x and y from the first body of a pair to the second, u their
 * squares' sum, w = u^(-3/2). */
typedef struct pairs {
    ll_term x[LL_SERIES_TERMS], y[LL_SERIES_TERMS], u[LL_SERIES_TERMS], w[LL_SERIES_TERMS], over;
} pairs;

/* From coefficient k of x and y: that of w x and w y. */
static inline __attribute__((always_inline)) void attract(pairs *p, int k, ll_term *ax, ll_term *ay)
{
    if (k == 0) {
        p->u[0] = p->x[0] * p->x[0] + p->y[0] * p->y[0];
        p->over = 1 / p->u[0];
        p->w[0] = p->over / (ll_term){ll_sqrt(p->u[0][0]), ll_sqrt(p->u[0][1])};
        *ax = p->w[0] * p->x[0];
        *ay = p->w[0] * p->y[0];
        return;
    }
    ll_term squares = {0}, power = {0}, sum_x = {0}, sum_y = {0};
    for (int j = 1; j < k; j++) {
        int i = k - j;
        squares += p->x[j] * p->x[i] + p->y[j] * p->y[i];
        power += ll_series_power_factor(-1.5, j, k) * (p->u[j] * p->w[i]);
        sum_x += p->w[j] * p->x[i];
        sum_y += p->w[j] * p->y[i];
    }
    p->u[k] = squares + 2 * (p->x[0] * p->x[k] + p->y[0] * p->y[k]);
    power += ll_series_power_factor(-1.5, k, k) * (p->u[k] * p->w[0]);
    p->w[k] = power * (p->over * ll_series_inverse[k]);
    *ax = sum_x + ll_series_ends(p->w, p->x, k);
    *ay = sum_y + ll_series_ends(p->w, p->y, k);
}

enum { BODIES_MAX = 7, LANES_MAX = BODIES_MAX * (BODIES_MAX - 1) / 2 + 1 };

/* Of n bodies; with an odd number of pairs the last one stands in both lanes. */
static inline __attribute__((always_inline)) void bodies_series(int n, const double *mass, double gravity,
                                                                int order, double *row)
{
    int count = n * (n - 1) / 2, first[LANES_MAX], second[LANES_MAX];
    pairs pair[LANES_MAX / 2];
    for (int i = 1, lane = 0; i < n; i++)
        for (int j = 0; j < i; j++, lane++) {
            first[lane] = first[count] = i;
            second[lane] = second[count] = j;
        }
    for (int k = 0; k < order; k++, row += 4 * n) {
        double a[2 * BODIES_MAX] = {0}, *next = row + 4 * n;
        for (int l = 0; l < count; l += 2) {
            pairs *p = &pair[l / 2];
            int i0 = first[l], j0 = second[l], i1 = first[l + 1], j1 = second[l + 1];
            p->x[k] = (ll_term){row[j0] - row[i0], row[j1] - row[i1]};
            p->y[k] = (ll_term){row[n + j0] - row[n + i0], row[n + j1] - row[n + i1]};
            ll_term ax, ay;
            attract(p, k, &ax, &ay);
            for (int lane = 0; lane < 2 && l + lane < count; lane++) {
                int i = first[l + lane], j = second[l + lane];
                a[i] += mass[j] * ax[lane];
                a[n + i] += mass[j] * ay[lane];
                a[j] -= mass[i] * ax[lane];
                a[n + j] -= mass[i] * ay[lane];
            }
        }
        for (int i = 0; i < 2 * n; i++) {
            next[i] = row[2 * n + i] * ll_series_inverse[k + 1];
            next[2 * n + i] = gravity * a[i] * ll_series_inverse[k + 1];
        }
    }
}

/* ---- Pleiades ---- */

static const double seven_masses[] = {1, 2, 3, 4, 5, 6, 7};

ATTRACTION(seven_acceleration, 7, seven_masses)

static const struct ll_ode_kernels seven_kernels = {LL_ODE_KERNELS(seven_acceleration),
                                                    .leapfrog = seven_acceleration_leapfrog};

static void seven_series(const void *p, double t, int order, double *row)
{
    (void)t;
    bodies_series(7, seven_masses, ((const params *)p)->gravity, order, row);
}

static void seven_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 28,
                    .autonomous = true,
                    .params = p,
                    .acceleration = seven_acceleration,
                    .series = seven_series,
                    .kernels = &seven_kernels};
}

static void seven_start(const void *p, double *y)
{
    static const double start[28] = {3, 3, -1, -3, 2, -2,   2,    3, -3, 2, 0,     0, -4, 4,
                                     0, 0, 0,  0,  0, 1.75, -1.5, 0, 0,  0, -1.25, 1, 0,  0};
    (void)p;
    for (int i = 0; i < 28; i++)
        y[i] = start[i];
}

static double seven_energy(const void *p, double t, const double *y)
{
    (void)t;
    return energy_of(7, seven_masses, ((const params *)p)->gravity, y);
}

static const double seven_reference[] = {
    0.370613914397051290,  3.23728409205723309,   -3.22255903241832335,  0.659709145577530836,
    0.342558170715657979,  1.56217210140063102,   -0.700309292221249539, -3.94343758551739206,
    -3.27138097397254993,  5.22508184345654419,   -2.59061243497746951,  1.19821369339227464,
    -0.242968234493582341, 1.09144924042897975,   3.41700380631431475,   1.35458450162550122,
    -2.59006559781077542,  2.02505373471424111,   -1.15581510016044909,  -0.807298817022302173,
    0.595239635420871877,  -3.74124496123400847,  0.377345968575062904,  0.938685886955107889,
    0.366792222720056987,  -0.347404635380849437, 2.34491544818093692,   -1.94702043426329190};

static const char *const seven_components[] = {
    "x1_m",    "x2_m",    "x3_m",    "x4_m",    "x5_m",    "x6_m",    "x7_m",
    "y1_m",    "y2_m",    "y3_m",    "y4_m",    "y5_m",    "y6_m",    "y7_m",
    "vx1_mps", "vx2_mps", "vx3_mps", "vx4_mps", "vx5_mps", "vx6_mps", "vx7_mps",
    "vy1_mps", "vy2_mps", "vy3_mps", "vy4_mps", "vy5_mps", "vy6_mps", "vy7_mps"};

const ll_ode_problem ll_ode_pleiades = {.name = "pleiades",
                                        .help = "Seven bodies with close encounters.",
                                        .source = "Hairer, Norsett and Wanner I, section II.10",
                                        .params = &ll_ode_pleiades_table,
                                        .system = seven_system,
                                        .duration = 3,
                                        .start = seven_start,
                                        .components = seven_components,
                                        .reference = seven_reference,
                                        .floor = 1e-14,
                                        .energy = seven_energy};

/* ---- figure of eight ---- */

static const double three_masses[] = {1, 1, 1};

ATTRACTION(three_acceleration, 3, three_masses)

static const struct ll_ode_kernels three_kernels = {LL_ODE_KERNELS(three_acceleration),
                                                    .leapfrog = three_acceleration_leapfrog};

static void three_series(const void *p, double t, int order, double *row)
{
    (void)t;
    bodies_series(3, three_masses, ((const params *)p)->gravity, order, row);
}

static void three_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 12,
                    .autonomous = true,
                    .params = p,
                    .acceleration = three_acceleration,
                    .series = three_series,
                    .kernels = &three_kernels};
}

static void three_start(const void *p, double *y)
{
    static const double start[12] = {0.97000436,  -0.97000436, 0,           -0.24308753,
                                     0.24308753,  0,           0.466203685, 0.466203685,
                                     -0.93240737, 0.43236573,  0.43236573,  -0.86473146};
    (void)p;
    for (int i = 0; i < 12; i++)
        y[i] = start[i];
}

static double three_energy(const void *p, double t, const double *y)
{
    (void)t;
    return energy_of(3, three_masses, ((const params *)p)->gravity, y);
}

static const double three_reference[] = {0.970004344431125317,  -0.970004374486295608, 3.00551702911370721e-8,
                                         -0.243087543456793790, 0.243087515537224619,  2.79195691706713038e-8,
                                         0.466203723963919193,  0.466203646795362357,  -0.932407370759281550,
                                         0.432365720512007769,  0.432365739916925725,  -0.864731460428933494};

static const char *const three_components[] = {"x1_m",    "x2_m",    "x3_m",    "y1_m",
                                               "y2_m",    "y3_m",    "vx1_mps", "vx2_mps",
                                               "vx3_mps", "vy1_mps", "vy2_mps", "vy3_mps"};

const ll_ode_problem ll_ode_figure_eight = {.name = "figure_eight",
                                            .help = "Three bodies on a common figure-eight orbit.",
                                            .source = "Chenciner and Montgomery 2000; binary128 reference",
                                            .params = &ll_ode_figure_eight_table,
                                            .system = three_system,
                                            .duration = 6.32591398,
                                            .start = three_start,
                                            .components = three_components,
                                            .reference = three_reference,
                                            .floor = 1e-14,
                                            .energy = three_energy};
