/* The grid as a method of fluid.h. */
#include <math.h>
#include <string.h>

#include "base/detmath.h"
#include "fluid/grid/parameters.h"
#include "fluid/grid/state.h"

const char *const ll_splitting_names[LL_SPLITTINGS + 1] = {"projection", "reflection", NULL};

size_t ll_grid_scene_size(const void *params, const void *solver)
{
    int64_t n;
    (void)solver;
    memcpy(&n, params, sizeof n);
    return ll_grid_size((int32_t)n, (int32_t)n);
}

/* ---- layers ---- */

static double dye(const ll_grid *g, int64_t k)
{
    return ll_grid_dye(g)[k];
}

static double speed(const ll_grid *g, int64_t k)
{
    const double *u = ll_grid_u(g), *v = ll_grid_v(g);
    double a = 0.5 * (u[k] + u[k + 1]), b = 0.5 * (v[k] + v[k + g->stride]);
    return ll_sqrt(a * a + b * b);
}

static double vorticity(const ll_grid *g, int64_t k)
{
    const double *u = ll_grid_u(g), *v = ll_grid_v(g);
    int64_t s = g->stride;
    double across = (v[k + 1] + v[k + 1 + s]) - (v[k - 1] + v[k - 1 + s]);
    double along = (u[k + s] + u[k + 1 + s]) - (u[k - s] + u[k + 1 - s]);
    return 0.25 * (across - along) / g->config.h;
}

static double pressure(const ll_grid *g, int64_t k)
{
    return ll_grid_field(g, LL_FIELD_PRESSURE)[k];
}

static double divergence(const ll_grid *g, int64_t k)
{
    const double *u = ll_grid_u(g), *v = ll_grid_v(g);
    return ((u[k + 1] - u[k]) + (v[k + g->stride] - v[k])) / g->config.h;
}

static const char *const value_columns[] = {"value", NULL};

#define FIELD(name_, help_)                                                                                  \
    {                                                                                                        \
        .name = name_, .help = help_, .shape = LL_FLUID_FIELD, .columns = value_columns                      \
    }

static const ll_fluid_layer layers[] = {
    FIELD("dye", "Dye or smoke, from 0 to 1."),
    FIELD("speed", "m/s"),
    FIELD("vorticity", "1/s"),
    FIELD("pressure", "Times the step and over a cell: m/s."),
    FIELD("divergence", "Divergence that the projection left: 1/s."),
};

static double (*const values[])(const ll_grid *, int64_t k) = {dye, speed, vorticity, pressure, divergence};

static void layer_size(const void *block, int layer, int32_t *width, int32_t *height)
{
    const ll_grid *g = block;
    (void)layer;
    *width = g->config.nx;
    *height = g->config.ny;
}

static void layer_values(const void *block, int layer, float *out)
{
    const ll_grid *g = block;
    for (int32_t j = 0; j < g->config.ny; j++)
        for (int64_t k = ll_grid_k(g, 0, j), end = ll_grid_k(g, g->config.nx, j); k < end; k++)
            *out++ = ll_grid_fluid(g)[k] ? (float)values[layer](g, k) : NAN;
}

/* ---- the rest ---- */

static ll_status step(void *block, double dt, const ll_fluid_run *run)
{
    return ll_grid_step(block, dt, run);
}

static void set_solver(void *block, const void *solver)
{
    ll_grid_set_solver(block, solver);
}

static void drag_force(void *block, const ll_drag_force *what)
{
    ((ll_grid *)block)->drag_force = *what;
}

static void extent(const void *block, double *x0, double *y0, double *x1, double *y1)
{
    const ll_grid_config *c = &((const ll_grid *)block)->config;
    *x0 = c->x;
    *y0 = c->y;
    *x1 = c->x + c->h * c->nx;
    *y1 = c->y + c->h * c->ny;
}

const ll_fluid_method ll_fluid_grid = {
    .name = "grid",
    .help = "Navier-Stokes equations on a staggered grid.",
    .layers = layers,
    .layer_count = sizeof layers / sizeof layers[0],
    .step = step,
    .set_solver = set_solver,
    .drag_force = drag_force,
    .numbers = ll_grid_numbers,
    .metrics = &ll_grid_metrics,
    .traced = &ll_grid_traced,
    .extent = extent,
    .layer_size = layer_size,
    .layer_values = layer_values,
};
