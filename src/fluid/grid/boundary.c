/* The ring around the box: values of a field beyond walls, inflow, outflow and periodic sides. */
#include <string.h>

#include "fluid/grid/state.h"

ll_grid_span ll_grid_span_of(const ll_grid *g, ll_grid_place place)
{
    ll_grid_span s = {0, g->config.nx, 0, g->config.ny};
    if (place == LL_PLACE_U && !ll_grid_periodic_x(g))
        s.i0 = 1;
    if (place == LL_PLACE_V && !ll_grid_periodic_y(g))
        s.j0 = 1;
    return s;
}

/* Value beyond a side from the one within: a velocity along a wall has the wall's in the middle. */
static double beyond(const ll_grid *g, int side, ll_grid_place place, double within)
{
    bool upright = side == LL_LEFT || side == LL_RIGHT;
    bool along = place == (upright ? LL_PLACE_V : LL_PLACE_U);
    int32_t kind = g->config.sides[side];
    if (along && kind == LL_SIDE_WALL)
        return (side == LL_ABOVE ? 2 * g->config.wall_speed : 0) - within;
    if (place == LL_PLACE_CELL && kind == LL_SIDE_IN)
        return 0; /* inflow has no dye */
    return within;
}

static void columns(const ll_grid *g, ll_grid_place place, double *f)
{
    int32_t nx = g->config.nx;
    for (int32_t j = -1; j <= g->config.ny + 1; j++) {
        double *row = f + ll_grid_k(g, 0, j);
        if (ll_grid_periodic_x(g)) {
            row[-1] = row[nx - 1];
            row[nx] = row[0];
            row[nx + 1] = row[1];
            continue;
        }
        int32_t last = place == LL_PLACE_U ? nx : nx - 1;
        row[-1] = beyond(g, LL_LEFT, place, row[0]);
        row[last + 1] = beyond(g, LL_RIGHT, place, row[last]);
    }
}

static void rows(const ll_grid *g, ll_grid_place place, double *f)
{
    int32_t ny = g->config.ny, last = place == LL_PLACE_V ? ny : ny - 1;
    int64_t s = g->stride;
    if (ll_grid_periodic_y(g)) {
        memcpy(f, f + ny * s, (size_t)s * sizeof *f);
        memcpy(f + (ny + 1) * s, f + s, 2 * (size_t)s * sizeof *f);
        return;
    }
    double *low = f + s, *high = f + (last + 1) * s;
    for (int64_t i = 0; i < s; i++) {
        low[i - s] = beyond(g, LL_BELOW, place, low[i]);
        high[i + s] = beyond(g, LL_ABOVE, place, high[i]);
    }
}

void ll_grid_bounds(const ll_grid *g, ll_grid_place place, double *field)
{
    columns(g, place, field);
    rows(g, place, field);
}

void ll_grid_close(const ll_grid *g, double *u, double *v)
{
    if (g->empty)
        return;
    ll_grid_span a = ll_grid_span_of(g, LL_PLACE_U), b = ll_grid_span_of(g, LL_PLACE_V);
    const double *ox = ll_grid_field(g, LL_FIELD_OPEN_X), *oy = ll_grid_field(g, LL_FIELD_OPEN_Y);
    for (int32_t j = a.j0; j < a.j1; j++)
        for (int64_t k = ll_grid_k(g, a.i0, j), end = ll_grid_k(g, a.i1, j); k < end; k++)
            u[k] *= ox[k];
    for (int32_t j = b.j0; j < b.j1; j++)
        for (int64_t k = ll_grid_k(g, b.i0, j), end = ll_grid_k(g, b.i1, j); k < end; k++)
            v[k] *= oy[k];
}
