/* Where the fields lie in the block. */
#include "fluid/grid/grid.h"
#include "fluid/grid/state.h"

int32_t *ll_grid_first_donors(const ll_grid *g)
{
    return (int32_t *)ll_grid_field(g, LL_FIELDS);
}

uint8_t *ll_grid_fluid(const ll_grid *g)
{
    return (uint8_t *)(ll_grid_first_donors(g) + (int64_t)g->stride * g->rows);
}

double *ll_grid_u(const ll_grid *g)
{
    return ll_grid_field(g, LL_FIELD_U);
}

double *ll_grid_v(const ll_grid *g)
{
    return ll_grid_field(g, LL_FIELD_V);
}

double *ll_grid_dye(const ll_grid *g)
{
    return ll_grid_field(g, LL_FIELD_DYE);
}
