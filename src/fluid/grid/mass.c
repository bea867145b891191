/* Conservation of the dye's mass. Tracing back loses or gains some, and clamping more: in a gap of few cells
 * it cuts values below 0, and nothing above 1 compensates. The difference is spread over values whose donors
 * leave room, in proportion to that room: no new extremes (a global fixer within local bounds: Priestley,
 * Mon. Weather Rev. 121 (1993); Bermejo and Conde, Mon. Weather Rev. 130 (2002)). */
#include "fluid/grid/state.h"

#include "base/assert.h"

/* Largest share of its room that a value uses: keeps rounding within the bounds. */
#define WHOLE (1 - 1e-15)

/* What leaves through a face at the box's side, in cell values: the `cells` next to it, counted inwards from
 * `f`. Inflow has the ring's values. */
static double leaving(const double *f, int64_t inwards, int32_t count, double cells)
{
    double sum = 0;
    if (cells < 0)
        return cells * f[-inwards];
    for (; cells > 1 && count > 1; cells--, count--, f += inwards)
        sum += *f;
    return sum + cells * *f;
}

static double outflow(const ll_grid_advect *a)
{
    const ll_grid *g = a->g;
    const double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V), *in = a->in;
    int32_t nx = g->config.nx, ny = g->config.ny;
    int64_t s = g->stride;
    double sum = 0, scale = a->dt / g->config.h;
    for (int32_t j = 0; !ll_grid_periodic_x(g) && j < ny; j++) {
        int64_t left = ll_grid_k(g, 0, j), right = ll_grid_k(g, nx, j);
        sum +=
            leaving(in + left, 1, nx, -scale * u[left]) + leaving(in + right - 1, -1, nx, scale * u[right]);
    }
    for (int32_t i = 0; !ll_grid_periodic_y(g) && i < nx; i++) {
        int64_t low = ll_grid_k(g, i, 0), high = ll_grid_k(g, i, ny);
        sum += leaving(in + low, s, ny, -scale * v[low]) + leaving(in + high - s, -s, ny, scale * v[high]);
    }
    return sum;
}

/* Room of each value, upwards and downwards, and the sums of both. Obstacles do not change. */
static void find_room(const ll_grid_advect *a, ll_grid_span span, double all[2])
{
    const uint8_t *fluid = ll_grid_fluid(a->g);
    double *up = a->spare[0], *down = a->spare[1];
    all[0] = all[1] = 0;
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int64_t k = ll_grid_k(a->g, span.i0, j), end = ll_grid_k(a->g, span.i1, j); k < end; k++) {
            ll_grid_range r = ll_grid_donors(a, k);
            double above = fluid[k] ? r.high - a->out[k] : 0, below = fluid[k] ? a->out[k] - r.low : 0;
            all[0] += up[k] = above > 0 ? above : 0;
            all[1] += down[k] = below > 0 ? below : 0;
        }
}

/* Missing mass relative to the sum before. */
static double find_lack(const ll_grid_advect *a, ll_grid_span span)
{
    double lack = -outflow(a);
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int64_t k = ll_grid_k(a->g, span.i0, j), end = ll_grid_k(a->g, span.i1, j); k < end; k++)
            lack += a->in[k] - a->out[k];
    return lack;
}

void ll_grid_keep_mass(const ll_grid_advect *a)
{
    ll_grid_span span = ll_grid_span_of(a->g, a->place);
    double all[2], lack = find_lack(a, span);
    find_room(a, span, all);
    int way = lack < 0; /* 0: upwards */
    const double *room = a->spare[way];
    if (!(all[way] > 0))
        return;
    double share = lack / all[way];
    LL_VALIDATE(!(share * lack < 0)); /* towards the missing mass */
    share = share > WHOLE ? WHOLE : share < -WHOLE ? -WHOLE : share;
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int64_t k = ll_grid_k(a->g, span.i0, j), end = ll_grid_k(a->g, span.i1, j); k < end; k++)
            a->out[k] += share * room[k];
}
