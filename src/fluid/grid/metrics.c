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

int ll_grid_numbers(const void *block, ll_fluid_number *out)
{
    const ll_grid *g = block;
    double least, most, mass = dye_range(g, &least, &most);
    const ll_fluid_number all[] = {
        {"divergence_max", ll_grid_divergence(g)}, /* 1/s */
        {"residual", g->last_residual},
        {"sweeps", (double)g->last_sweeps},
        {"energy", ll_grid_energy(g, 0, 0)},
        {"momentum_x", momentum(g, LL_PLACE_U, ll_grid_u(g))},
        {"momentum_y", momentum(g, LL_PLACE_V, ll_grid_v(g))},
        {"mass", mass},
        {"mass_change", g->mass_start > 0 ? mass / g->mass_start - 1 : 0},
        {"dye_min", least},
        {"dye_max", most},
        {"cfl", g->last_cfl},
        {"substeps", (double)g->last_substeps},
        {"sweeps_mean", g->solves > 0 ? (double)g->sweeps / (double)g->solves : 0},
        {"steps", (double)g->steps},
        {"bytes", (double)g->size},
        {"cell_visits", visits(g)},
    };
    int count = sizeof all / sizeof all[0];
    for (int i = 0; i < count; i++)
        out[i] = all[i];
    return count;
}
