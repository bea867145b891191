/* A shape that rotates with the box's solid rotation, once a second: after a turn it should be unchanged. */
#include <math.h>
#include <string.h>

#include "base/detmath.h"
#include "fluid/grid/parameters.h"
#include "fluid/scenes/scenes.h"

#define PI 3.14159265358979323846

typedef struct params {
    int64_t n;
    int32_t shape, reserved;
} params;

static const char *const shape_names[] = {"slotted_disc", "gaussian", NULL};

static const ll_param param_rows[] = {
    LL_GRID_CELLS(params, 128),
    {LL_PARAM_ROW("shape", CHOICE, params, shape), .choices = shape_names,
     .help = "Zalesak's disc, whose edges show overshoot, or a smooth hill, which shows order."},
};

const ll_param_table ll_fluid_rotation_params = {.name = "rotation",
                                                 .help =
                                                     "A shape that rotates once a second in a box of 1 m.",
                                                 LL_PARAM_ROWS(param_rows, params)};

static const ll_param solver_rows[] = {
    LL_GRID_ROWS(LL_ADVECTION_MACCORMACK, LL_SPLITTING_PROJECTION, LL_PRESSURE_MULTIGRID, 1e-3, 1.6),
};
const ll_param_table ll_fluid_rotation_solver = LL_GRID_TABLE("rotation_solver", solver_rows);

static void configure(const params *p, ll_grid_config *c)
{
    *c = (ll_grid_config){.nx = (int32_t)p->n,
                          .ny = (int32_t)p->n,
                          .h = 1 / (double)p->n,
                          .sides = {LL_SIDE_SLIP, LL_SIDE_SLIP, LL_SIDE_SLIP, LL_SIDE_SLIP},
                          .dyed = 1,
                          .frozen = 1};
    memcpy(c->params, p, sizeof *p);
}

static ll_status check(const void *given, const void *solver)
{
    ll_grid_config c;
    configure(given, &c);
    return ll_grid_check(&c, solver, true);
}

static double slotted_disc(double x, double y)
{
    y -= 0.25; /* relative to the box's centre */
    return x * x + y * y < 0.15 * 0.15 && !(fabs(x) < 0.025 && y < 0.1);
}

static double gaussian(double x, double y)
{
    y -= 0.25;
    return ll_exp(-(x * x + y * y) / (2 * 0.08 * 0.08));
}

static double (*const shapes[])(double x, double y) = {slotted_disc, gaussian};

/* The shape at (x, y) relative to the centre after `turns` counter-clockwise. */
static double turned(const params *p, double x, double y, double turns)
{
    double angle = 2 * PI * (turns - (double)(int64_t)turns), c = ll_cos(angle), s = ll_sin(angle);
    return shapes[p->shape](c * x + s * y, c * y - s * x);
}

static void init(void *block, const void *given, const void *solver)
{
    ll_grid_config c;
    const params *p = given;
    configure(p, &c);
    ll_grid_init(block, &c, solver);
    double *u = ll_grid_u(block), *v = ll_grid_v(block), *dye = ll_grid_dye(block);
    for (int32_t j = 0; j <= c.ny; j++)
        for (int32_t i = 0; i <= c.nx; i++) {
            int64_t k = ll_grid_at(c.nx, i, j);
            u[k] = -2 * PI * ((j + 0.5) * c.h - 0.5);
            v[k] = 2 * PI * ((i + 0.5) * c.h - 0.5);
            if (i < c.nx && j < c.ny)
                dye[k] = turned(p, (i + 0.5) * c.h - 0.5, (j + 0.5) * c.h - 0.5, 0);
        }
    ll_grid_start(block);
}

#define ROTATION(X)                                                                                          \
    X(number, error_l1, "m^2", sum * c->h * c->h,                                                            \
      "error of the dye: absolute difference from the initial dye after the exact rotation, integrated "     \
      "over the area",                                                                                       \
      LL_FLUID_FAILED)

const ll_metric_table ll_fluid_rotation_metrics = {.path = "",
                                                   .also = LL_FLUID_AGAIN,
                                                   .when = "Only of the scene rotation.",
                                                   .help = "Errors against the exact solution.",
                                                   LL_METRICS_FROM(ROTATION)};

static int numbers(const void *block, ll_fluid_number *out)
{
    const ll_grid *g = block;
    const ll_grid_config *c = ll_grid_get_config(g);
    params p;
    memcpy(&p, c->params, sizeof p);
    const double *dye = ll_grid_dye(g);
    double sum = 0;
    for (int32_t j = 0; j < c->ny; j++)
        for (int32_t i = 0; i < c->nx; i++) {
            double x = (i + 0.5) * c->h - 0.5, y = (j + 0.5) * c->h - 0.5;
            sum += fabs(dye[ll_grid_at(c->nx, i, j)] - turned(&p, x, y, ll_grid_time(g)));
        }
    return LL_FLUID_TELL(out, ROTATION);
}

const ll_fluid_scene ll_fluid_rotation = {
    .name = "rotation",
    .title = "Solid rotation",
    .help =
        "A slotted disc, or a smooth hill, that rotates with the box: shows how advection changes a shape.",
    .source = "Zalesak 1979",
    .method = &ll_fluid_grid,
    .params = &ll_fluid_rotation_params,
    .solver = &ll_fluid_rotation_solver,
    .duration_s = 1,
    .check = check,
    .size = ll_grid_scene_size,
    .init = init,
    .numbers = numbers,
    .metrics = &ll_fluid_rotation_metrics,
};
