#include <math.h>

#include "fluid/grid/state.h"

double ll_grid_divergence(const ll_grid *g)
{
    const double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V);
    const uint8_t *fluid = ll_grid_fluid(g);
    int64_t s = g->stride;
    double most = 0;
    for (int32_t j = 0; j < g->config.ny; j++)
        for (int64_t k = ll_grid_k(g, 0, j), end = ll_grid_k(g, g->config.nx, j); k < end; k++) {
            double out = fabs((u[k + 1] - u[k]) + (v[k + s] - v[k]));
            most = fluid[k] && out > most ? out : most;
        }
    return most / g->config.h;
}

/* A face on a wall has half a cell on its side. */
static double squares(const ll_grid *g, ll_grid_place place, const double *f, double mean)
{
    int32_t nx = g->config.nx, ny = g->config.ny;
    double sum = 0;
    int64_t step = place == LL_PLACE_U ? 1 : g->stride;
    for (int32_t j = 0; j < ny; j++)
        for (int32_t i = 0; i < nx; i++) {
            int64_t k = ll_grid_k(g, i, j);
            double a = f[k] - mean, b = f[k + step] - mean;
            sum += 0.5 * (a * a + b * b);
        }
    return sum;
}

double ll_grid_energy(const ll_grid *g, double mean_x, double mean_y)
{
    double sum = squares(g, LL_PLACE_U, ll_grid_u(g), mean_x) + squares(g, LL_PLACE_V, ll_grid_v(g), mean_y);
    return 0.5 * sum * g->config.h * g->config.h;
}

static double momentum(const ll_grid *g, ll_grid_place place, const double *f)
{
    int64_t step = place == LL_PLACE_U ? 1 : g->stride;
    double sum = 0;
    for (int32_t j = 0; j < g->config.ny; j++)
        for (int64_t k = ll_grid_k(g, 0, j), end = ll_grid_k(g, g->config.nx, j); k < end; k++)
            sum += 0.5 * (f[k] + f[k + step]);
    return sum * g->config.h * g->config.h;
}

static double dye_range(const ll_grid *g, double *least, double *most)
{
    const double *dye = ll_grid_dye(g);
    double sum = 0;
    *least = *most = dye[ll_grid_k(g, 0, 0)];
    for (int32_t j = 0; j < g->config.ny; j++)
        for (int64_t k = ll_grid_k(g, 0, j), end = ll_grid_k(g, g->config.nx, j); k < end; k++) {
            sum += dye[k];
            *least = dye[k] < *least ? dye[k] : *least;
            *most = dye[k] > *most ? dye[k] : *most;
        }
    return sum * g->config.h * g->config.h;
}

double ll_grid_mass(const ll_grid *g)
{
    double least, most;
    return dye_range(g, &least, &most);
}

/* Cell visits of the pressure solver: a cost that is the same on every machine. */
static double visits(const ll_grid *g)
{
    return (double)g->sweeps * ll_pressure_solvers[g->solver.pressure]->passes * (double)g->config.nx *
           (double)g->config.ny;
}

#define GRID_TRACED(X)                                                                                       \
    X(number, divergence_max, "1/s", ll_grid_divergence(g),                                                  \
      "largest magnitude of the divergence of a cell after the last pressure solve", LL_FLUID_FAILED)        \
    X(number, residual, NULL, g->last_residual,                                                              \
      "residual of the last pressure solve, relative to its largest source", LL_FLUID_FAILED)                \
    X(count, sweeps, NULL, g->last_sweeps, "sweeps of the last pressure solve", LL_FLUID_FAILED)             \
    X(number, energy, "m^4/s^2", ll_grid_energy(g, 0, 0), "kinetic energy of the fluid per unit of density", \
      LL_FLUID_FAILED)                                                                                       \
    X(signed_number, momentum_x, "m^3/s", momentum(g, LL_PLACE_U, ll_grid_u(g)),                             \
      "horizontal momentum of the fluid per unit of density", LL_FLUID_FAILED)                               \
    X(signed_number, momentum_y, "m^3/s", momentum(g, LL_PLACE_V, ll_grid_v(g)),                             \
      "vertical momentum of the fluid per unit of density", LL_FLUID_FAILED)                                 \
    X(number, mass, "m^2", mass, "amount of dye: its value integrated over the area", LL_FLUID_FAILED)       \
    X(signed_number, mass_change, NULL, g->mass_start > 0 ? mass / g->mass_start - 1 : 0,                    \
      "change of the amount of dye since the start, relative to the start", LL_FLUID_FAILED)

#define GRID(X)                                                                                              \
    GRID_TRACED(X)                                                                                           \
    X(signed_number, dye_min, NULL, least, "smallest value of the dye; below 0 is an error",                 \
      LL_FLUID_FAILED)                                                                                       \
    X(number, dye_max, NULL, most, "largest value of the dye", LL_FLUID_FAILED)                              \
    X(number, cfl, NULL, g->last_cfl,                                                                        \
      "CFL number: cells that the fastest part of the fluid moves in a substep", LL_FLUID_FAILED)            \
    X(count, substeps, NULL, g->last_substeps, "substeps of the last step", LL_FLUID_FAILED)                 \
    X(number, sweeps_mean, NULL, g->solves > 0 ? (double)g->sweeps / (double)g->solves : 0,                  \
      "mean number of sweeps of a pressure solve", LL_FLUID_FAILED)                                          \
    X(count, steps, NULL, g->steps, "steps so far", LL_FLUID_FAILED)                                         \
    X(count, bytes, "B", g->size, "memory of the grid", LL_FLUID_FAILED)                                     \
    X(count, cell_visits, NULL, visits(g),                                                                   \
      "cell visits of all sweeps of the pressure solver so far: a cost that is the same on every machine",   \
      LL_FLUID_FAILED)

const ll_metric_table ll_grid_metrics = {.path = "",
                                         .also = LL_FLUID_AGAIN,
                                         .when = "Only of the method grid.",
                                         .help = "Measures of a fluid on a grid, now.",
                                         LL_METRICS_FROM(GRID)};

const ll_metric_table ll_grid_traced = {.path = "",
                                        .when = "Only of the method grid.",
                                        .help = "Measures that are also columns of the trace.",
                                        LL_METRICS_FROM(GRID_TRACED)};

int ll_grid_numbers(const void *block, ll_fluid_number *out)
{
    const ll_grid *g = block;
    double least, most, mass = dye_range(g, &least, &most);
    return LL_FLUID_TELL(out, GRID);
}
