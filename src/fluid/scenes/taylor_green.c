/* Taylor-Green vortices, advected by a mean flow: an exact solution with viscosity. Without the mean flow
 * central differences are exact and would not test advection. */
#include <math.h>
#include <string.h>

#include "base/detmath.h"
#include "fluid/grid/parameters.h"
#include "fluid/scenes/scenes.h"

#define PI 3.14159265358979323846

typedef struct params {
    int64_t n;
    double viscosity, mean_x, mean_y;
} params;

static const ll_param param_rows[] = {
    LL_GRID_CELLS(params, 64),
    {LL_PARAM_ROW("viscosity_m2ps", REAL, params, viscosity), .max = 1, .default_value = 0.01,
     .unit = "m^2/s", .help = "Kinematic viscosity."},
    {LL_PARAM_ROW("mean_x_mps", REAL, params, mean_x), .min = -10, .max = 10, .default_value = 1,
     .unit = "m/s", .help = "Mean flow to the right."},
    {LL_PARAM_ROW("mean_y_mps", REAL, params, mean_y), .min = -10, .max = 10, .default_value = 1,
     .unit = "m/s", .help = "Mean flow upwards."},
};

const ll_param_table ll_fluid_taylor_green_params = {
    .name = "taylor_green", .help = "Vortices of 2 pi m in a mean flow.", LL_PARAM_ROWS(param_rows, params)};

static const ll_param solver_rows[] = {
    LL_GRID_ROWS(LL_ADVECTION_CENTRAL, LL_SPLITTING_PROJECTION, LL_PRESSURE_DIRECT, 1e-6, 1),
};
const ll_param_table ll_fluid_taylor_green_solver = LL_GRID_TABLE("taylor_green_solver", solver_rows);

static void configure(const params *p, ll_grid_config *c)
{
    *c = (ll_grid_config){.nx = (int32_t)p->n,
                          .ny = (int32_t)p->n,
                          .h = 2 * PI / (double)p->n,
                          .sides = {LL_SIDE_PERIODIC, LL_SIDE_PERIODIC, LL_SIDE_PERIODIC, LL_SIDE_PERIODIC},
                          .viscosity = p->viscosity};
    memcpy(c->params, p, sizeof *p);
}

static ll_status check(const void *given, const void *solver)
{
    ll_grid_config c;
    configure(given, &c);
    return ll_grid_check(&c, solver, true);
}

/* Exact velocities at a point, without the mean. */
static double exact_u(double x, double y, double decay)
{
    return -decay * ll_cos(x) * ll_sin(y);
}

static double exact_v(double x, double y, double decay)
{
    return decay * ll_sin(x) * ll_cos(y);
}

static void init(void *block, const void *given, const void *solver)
{
    ll_grid_config c;
    const params *p = given;
    configure(p, &c);
    ll_grid_init(block, &c, solver);
    double *u = ll_grid_u(block), *v = ll_grid_v(block);
    for (int32_t j = 0; j < c.ny; j++)
        for (int32_t i = 0; i < c.nx; i++) {
            int64_t k = ll_grid_at(c.nx, i, j);
            u[k] = p->mean_x + exact_u(i * c.h, (j + 0.5) * c.h, 1);
            v[k] = p->mean_y + exact_v((i + 0.5) * c.h, j * c.h, 1);
        }
    ll_grid_start(block);
}

/* Root mean square error relative to the exact vortices. */
static double error_l2(const ll_grid *g, const params *p, double decay)
{
    const ll_grid_config *c = ll_grid_get_config(g);
    const double *u = ll_grid_u(g), *v = ll_grid_v(g);
    double t = ll_grid_time(g), sum = 0, all = 0;
    for (int32_t j = 0; j < c->ny; j++)
        for (int32_t i = 0; i < c->nx; i++) {
            int64_t k = ll_grid_at(c->nx, i, j);
            double x = i * c->h - p->mean_x * t, y = j * c->h - p->mean_y * t, half = 0.5 * c->h;
            double a = exact_u(x, y + half, decay), b = exact_v(x + half, y, decay);
            double du = u[k] - p->mean_x - a, dv = v[k] - p->mean_y - b;
            sum += du * du + dv * dv;
            all += a * a + b * b;
        }
    return ll_sqrt(sum / all);
}

#define TAYLOR_GREEN(X)                                                                                      \
    X(number, error_l2, NULL, error_l2(g, &p, decay),                                                        \
      "error of the velocities against the exact solution: root mean square, relative to that of the "       \
      "solution",                                                                                            \
      LL_FLUID_FAILED)                                                                                       \
    X(signed_number, decay_error, NULL, energy / (first * decay * decay) - 1,                                \
      "error of the vortices' kinetic energy against the exact solution, relative", LL_FLUID_FAILED)         \
    X(signed_number, numerical_viscosity_m2ps, "m^2/s",                                                      \
      t > 0 ? -ll_detmath_log(energy / first) / (4 * t) - p.viscosity : 0,                                   \
      "numerical viscosity: viscosity that explains the decay of the energy, less that of the fluid",        \
      LL_FLUID_FAILED)

const ll_metric_table ll_fluid_taylor_green_metrics = {.path = "",
                                                       .also = LL_FLUID_AGAIN,
                                                       .when = "Only of the scene taylor_green.",
                                                       .help = "Errors against the exact solution.",
                                                       LL_METRICS_FROM(TAYLOR_GREEN)};

/* The energy of the vortices decays with exp(-4 nu t); faster decay shows the method's numerical
 * viscosity. */
static int numbers(const void *block, ll_fluid_number *out)
{
    const ll_grid *g = block;
    const ll_grid_config *c = ll_grid_get_config(g);
    params p;
    memcpy(&p, c->params, sizeof p);
    double t = ll_grid_time(g), decay = ll_exp(-2 * p.viscosity * t);
    double energy = ll_grid_energy(g, p.mean_x, p.mean_y), first = PI * PI;
    return LL_FLUID_TELL(out, TAYLOR_GREEN);
}

const ll_fluid_scene ll_fluid_taylor_green = {
    .name = "taylor_green",
    .title = "Taylor-Green vortices",
    .help = "Vortices that decay in a mean flow: shows the numerical viscosity of a method.",
    .source = "Taylor and Green 1937",
    .method = &ll_fluid_grid,
    .params = &ll_fluid_taylor_green_params,
    .solver = &ll_fluid_taylor_green_solver,
    .duration_s = 5,
    .check = check,
    .size = ll_grid_scene_size,
    .init = init,
    .numbers = numbers,
    .metrics = &ll_fluid_taylor_green_metrics,
};
