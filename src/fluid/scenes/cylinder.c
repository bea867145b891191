/* Smoke past a cylinder in a tunnel of 2 m: a vortex street. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fluid/grid/parameters.h"
#include "fluid/scenes/scenes.h"

#define SIDE 2.0
#define SPEED 0.5
#define RADIUS 0.1

typedef struct params {
    int64_t n;
    double re, buoyancy;
} params;

static const ll_param param_rows[] = {
    LL_GRID_CELLS(params, 128),
    {LL_PARAM_ROW("re", REAL, params, re), .min = 1, .max = 1e6, .default_value = 200,
     .help = "Reynolds number of the cylinder's diameter of 0.2 m at 0.5 m/s."},
    {LL_PARAM_ROW("buoyancy_mps2", REAL, params, buoyancy), .min = -10, .max = 10, .unit = "m/s^2",
     .help = "Buoyancy of the smoke."},
};

const ll_param_table ll_fluid_cylinder_params = {.name = "cylinder",
                                                 .help = "Smoke past a cylinder in a tunnel of 2 m.",
                                                 LL_PARAM_ROWS(param_rows, params)};

static const ll_param solver_rows[] = {
    LL_GRID_ROWS(LL_ADVECTION_MACCORMACK, LL_SPLITTING_PROJECTION, LL_PRESSURE_MULTIGRID, 1e-3, 4),
};
const ll_param_table ll_fluid_cylinder_solver = LL_GRID_TABLE("cylinder_solver", solver_rows);

static void configure(const params *p, ll_grid_config *c)
{
    *c = (ll_grid_config){.nx = (int32_t)p->n,
                          .ny = (int32_t)p->n,
                          .h = SIDE / (double)p->n,
                          .sides = {LL_SIDE_IN, LL_SIDE_OUT, LL_SIDE_SLIP, LL_SIDE_SLIP},
                          .viscosity = SPEED * 2 * RADIUS / p->re,
                          .buoyancy = p->buoyancy,
                          .source_x = 0.15,
                          .source_y = SIDE / 2,
                          .source_radius = 0.08,
                          .dyed = 1};
    memcpy(c->params, p, sizeof *p);
}

static ll_status check(const void *given, const void *solver)
{
    ll_grid_config c;
    configure(given, &c);
    return ll_grid_check(&c, solver, false);
}

static void init(void *block, const void *given, const void *solver)
{
    ll_grid_config c;
    configure(given, &c);
    ll_grid_init(block, &c, solver);
    uint8_t *fluid = ll_grid_fluid(block);
    double *u = ll_grid_u(block);
    for (int32_t j = 0; j < c.ny; j++)
        for (int32_t i = 0; i <= c.nx; i++) {
            double x = (i + 0.5) * c.h - 0.5,
                   y = (j + 0.5) * c.h - SIDE / 2 - 0.01; /* slightly off the axis */
            u[ll_grid_at(c.nx, i, j)] = SPEED;
            fluid[ll_grid_at(c.nx, i, j)] = !(x * x + y * y < RADIUS * RADIUS);
        }
    ll_grid_start(block);
}

/* The boundary layer is about the diameter over the square root of Re thick (Prandtl 1904). */
static int notices(const void *block, ll_fluid_notice *out)
{
    params p;
    const ll_grid_config *c = ll_grid_get_config(block);
    memcpy(&p, c->params, sizeof p);
    double across = 2 * RADIUS / c->h, layer = across / sqrt(p.re);
    int count = 0;
    snprintf(out[count++].text, sizeof out->text,
             "The cylinder blocks %.0f %% of the tunnel's width: the flow past it is faster than in a free "
             "stream, and its frequency higher.",
             100 * 2 * RADIUS / SIDE);
    if (layer < 1)
        snprintf(out[count++].text, sizeof out->text,
                 "The boundary layer of the cylinder is about %.2g cells thick at Re %g with %.3g cells "
                 "across it: params.n of %.0f would give it one cell.",
                 layer, p.re, across, (double)p.n / layer);
    return count;
}

const ll_fluid_scene ll_fluid_cylinder = {
    .name = "cylinder",
    .title = "Smoke past a cylinder",
    .help = "A tunnel with a cylinder that sheds vortices alternately. Drag the smoke with the pointer.",
    .source = "von Karman 1911",
    .method = &ll_fluid_grid,
    .params = &ll_fluid_cylinder_params,
    .solver = &ll_fluid_cylinder_solver,
    .duration_s = 30,
    .check = check,
    .size = ll_grid_scene_size,
    .init = init,
    .notices = notices,
};
