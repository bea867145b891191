/* The driven cavity: a box of 1 m whose lid moves at 1 m/s. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fluid/grid/parameters.h"
#include "fluid/scenes/cavity_reference.h"
#include "fluid/scenes/scenes.h"

typedef struct params {
    int64_t n;
    double re;
} params;

static const ll_param param_rows[] = {
    {LL_PARAM_ROW("re", REAL, params, re), .min = 1, .max = 1e5, .default_value = 1000,
     .help = "Reynolds number of the box."},
    LL_GRID_CELLS(params, 64),
};

const ll_param_table ll_fluid_cavity_params = {
    .name = "cavity", .help = "A box of 1 m whose lid moves at 1 m/s.", LL_PARAM_ROWS(param_rows, params)};

static const ll_param solver_rows[] = {
    LL_GRID_ROWS(LL_ADVECTION_CENTRAL, LL_SPLITTING_PROJECTION, LL_PRESSURE_DIRECT, 1e-6, 4),
};
const ll_param_table ll_fluid_cavity_solver = LL_GRID_TABLE("cavity_solver", solver_rows);

static void configure(const params *p, ll_grid_config *c)
{
    *c = (ll_grid_config){.nx = (int32_t)p->n,
                          .ny = (int32_t)p->n,
                          .h = 1 / (double)p->n,
                          .wall_speed = 1,
                          .viscosity = 1 / p->re};
    memcpy(c->params, p, sizeof *p);
}

static ll_status check(const void *given, const void *solver)
{
    ll_grid_config c;
    configure(given, &c);
    return ll_grid_check(&c, solver, true);
}

static void init(void *block, const void *given, const void *solver)
{
    ll_grid_config c;
    configure(given, &c);
    ll_grid_init(block, &c, solver);
    ll_grid_start(block);
}

/* ---- profiles ---- */

/* u (0) along the vertical centre line, v (1) along the horizontal one, at the centre of cell j; beyond a
 * wall, the wall. */
static double node_value(const ll_grid *g, int component, int32_t j)
{
    int32_t n = ll_grid_get_config(g)->nx;
    if (j < 0 || j >= n)
        return component == 0 && j >= n ? ll_grid_get_config(g)->wall_speed : 0;
    return component == 0 ? ll_grid_u(g)[ll_grid_at(n, n / 2, j)] : ll_grid_v(g)[ll_grid_at(n, j, n / 2)];
}

static double node_place(int32_t n, int32_t j)
{
    return j < 0 ? 0 : j >= n ? 1 : (j + 0.5) / n;
}

/* Cubic interpolation of the four nearest values, walls included. */
static double profile_at(const ll_grid *g, int component, double coordinate)
{
    int32_t n = ll_grid_get_config(g)->nx, first = (int32_t)(coordinate * n + 0.5) - 2;
    first = first < -1 ? -1 : first > n - 3 ? n - 3 : first;
    double sum = 0;
    for (int32_t a = first; a < first + 4; a++) {
        double weight = 1;
        for (int32_t b = first; b < first + 4; b++)
            if (b != a)
                weight *= (coordinate - node_place(n, b)) / (node_place(n, a) - node_place(n, b));
        sum += weight * node_value(g, component, a);
    }
    return sum;
}

/* Reference solution of a cavity; NULL: none. */
static const ll_cavity_reference *reference(const ll_grid *g)
{
    params p;
    memcpy(&p, ll_grid_get_config(g)->params, sizeof p);
    for (int i = 0; i < ll_cavity_reference_count; i++)
        if (ll_cavity_references[i].re == p.re)
            return &ll_cavity_references[i];
    return NULL;
}

/* At multiples of 1/128 and at the published points. */
static int profile(const void *block, int index, const char **name, double (*pairs)[2])
{
    static const char *const names[4] = {"u", "v", "u_reference", "v_reference"};
    enum { STEPS = 128 };
    const ll_cavity_reference *known = reference(block);
    if (index > (known ? 3 : 1))
        return 0;
    *name = names[index];
    if (index > 1) {
        int count = known->count[index - 2];
        for (int i = 0; i < count; i++) {
            const ll_cavity_point *point = &known->points[index - 2][i];
            pairs[i][0] = point->coordinate;
            pairs[i][1] = point->value;
        }
        return count;
    }
    for (int i = 0; i <= STEPS; i++) {
        pairs[i][0] = (double)i / STEPS;
        pairs[i][1] = profile_at(block, index, pairs[i][0]);
    }
    return STEPS + 1;
}

#define CAVITY(X)                                                                                            \
    X(number, error_max, NULL, error,                                                                        \
      "largest difference of the velocities along both centre lines from the values extrapolated by "        \
      "Richardson's method",                                                                                 \
      LL_FLUID_FAILED)                                                                                       \
    X(number, ghia_error_max, NULL, from_ghia,                                                               \
      "largest difference of the velocities along both centre lines from the table of Ghia, Ghia and Shin "  \
      "1982",                                                                                                \
      LL_FLUID_FAILED)

const ll_metric_table ll_fluid_cavity_metrics = {
    .path = "",
    .also = LL_FLUID_AGAIN,
    .when = "Only of the scene cavity, at a Reynolds number that has a reference.",
    .help = "Errors against the reference.",
    LL_METRICS_FROM(CAVITY)};

#define PROFILES(X)                                                                                          \
    X(curve, u, "m/s", , "horizontal velocity (to the right) along the vertical centre line", NULL)          \
    X(curve, v, "m/s", , "vertical velocity (upwards) along the horizontal centre line", NULL)

#define REFERENCES(X)                                                                                        \
    X(curve, u_reference, "m/s", ,                                                                           \
      "reference of u: horizontal velocities along the vertical centre line, extrapolated by Richardson's "  \
      "method",                                                                                              \
      NULL)                                                                                                  \
    X(curve, v_reference, "m/s", ,                                                                           \
      "reference of v: vertical velocities along the horizontal centre line, extrapolated by Richardson's "  \
      "method",                                                                                              \
      NULL)

const ll_metric_table ll_fluid_cavity_profiles = {.path = "profiles",
                                                  .also = LL_FLUID_AGAIN,
                                                  .when = "Only of the scene cavity, unless it has diverged.",
                                                  .help =
                                                      "Velocity profiles, as pairs of coordinate and value.",
                                                  LL_METRICS_FROM(PROFILES)};
const ll_metric_table ll_fluid_cavity_references = {
    .path = "profiles",
    .also = LL_FLUID_AGAIN,
    .when = "Only of the scene cavity, at a Reynolds number that has a reference, unless it has diverged.",
    .help = "Reference of the velocity profiles, as pairs of coordinate and value.",
    LL_METRICS_FROM(REFERENCES)};

static int numbers(const void *block, ll_fluid_number *out)
{
    double error = 0, from_ghia = 0;
    const ll_cavity_reference *known = reference(block);
    if (!known)
        return 0;
    for (int component = 0; component < 2; component++)
        for (int i = 0; i < known->count[component]; i++) {
            const ll_cavity_point *point = &known->points[component][i];
            double value = profile_at(block, component, point->coordinate);
            double a = fabs(value - point->value), b = fabs(value - point->ghia);
            error = a > error ? a : error;
            from_ghia = b > from_ghia ? b : from_ghia;
        }
    return LL_FLUID_TELL(out, CAVITY);
}

/* Boundary layers along the walls are about 1 / sqrt(Re) thick (Prandtl 1904). */
static int notices(const void *block, ll_fluid_notice *out)
{
    const ll_grid_config *c = ll_grid_get_config(block);
    params p;
    memcpy(&p, c->params, sizeof p);
    double layer = (double)p.n / sqrt(p.re);
    int count = 0;
    if (layer < 1)
        snprintf(out[count++].text, sizeof out->text,
                 "The boundary layers at the walls are about %.2g cells thick at Re %g with params.n %lld: "
                 "not resolved; params.n of %.0f would give them one cell.",
                 layer, p.re, (long long)p.n, sqrt(p.re));
    if (p.re > 8000)
        snprintf(
            out[count++].text, sizeof out->text,
            "Above Re 8,000 the flow in the cavity does not become steady: there is no reference solution.");
    return count;
}

const ll_fluid_scene ll_fluid_cavity = {
    .name = "cavity",
    .title = "Driven cavity",
    .help =
        "A box with a moving lid: the steady state of Re 100 and 1000 is known to 1e-4, of Re 400 to 0.006.",
    .source = "Ghia, Ghia and Shin 1982; cavity_reference.h",
    .method = &ll_fluid_grid,
    .params = &ll_fluid_cavity_params,
    .solver = &ll_fluid_cavity_solver,
    .duration_s = 40,
    .check = check,
    .size = ll_grid_scene_size,
    .init = init,
    .numbers = numbers,
    .metrics = &ll_fluid_cavity_metrics,
    .profile = profile,
    .notices = notices,
};
