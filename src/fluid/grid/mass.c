/* Conservation of the dye's mass. Tracing back loses or gains some, and clamping more: in a gap of few cells
 * it cuts values below 0, and nothing above 1 compensates. The difference is spread over values whose donors
 * leave room, in proportion to that room: no new extremes (a global fixer within local bounds: Priestley,
 * Mon. Weather Rev. 121 (1993); Bermejo and Conde, Mon. Weather Rev. 130 (2002)). */
#include "fluid/grid/state.h"

#include "base/assert.h"
#include "fluid/grid/trace.h"

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

static void room_rows(void *context, ll_share rows, int part)
{
    const ll_grid_advect *a = context;
    const ll_grid_tracing *by = ll_grid_tracing_here();
    int32_t first = ll_grid_span_of(a->g, a->place).j0;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        by->room(a, first + j, a->spare[0], a->spare[1]);
}

/* Sums over all values, in the order of the cells: by one thread. */
typedef struct balance {
    double lack;    /* missing mass relative to the sum before */
    double room[2]; /* upwards and downwards */
} balance;

static balance weigh(const ll_grid_advect *a, ll_grid_span span)
{
    const double *up = a->spare[0], *down = a->spare[1];
    balance b = {.lack = -outflow(a)};
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int64_t k = ll_grid_k(a->g, span.i0, j), end = ll_grid_k(a->g, span.i1, j); k < end; k++) {
            b.lack += a->in[k] - a->out[k];
            b.room[0] += up[k];
            b.room[1] += down[k];
        }
    return b;
}

typedef struct spreading {
    const ll_grid_advect *a;
    ll_grid_span span;
    const double *room;
    double share;
} spreading;

static void spread_rows(void *context, ll_share rows, int part)
{
    const spreading *s = context;
    const ll_grid *g = s->a->g;
    double *out = s->a->out;
    (void)part;
    for (int32_t j = s->span.j0 + rows.begin; j < s->span.j0 + rows.end; j++)
        for (int64_t k = ll_grid_k(g, s->span.i0, j), end = ll_grid_k(g, s->span.i1, j); k < end; k++)
            out[k] += s->share * s->room[k];
}

void ll_grid_keep_mass(const ll_grid_advect *a)
{
    ll_grid_span span = ll_grid_span_of(a->g, a->place);
    ll_grid_advect same = *a;
    ll_rows_run(a->team, span.j1 - span.j0, a->g->config.nx, room_rows, &same);
    balance b = weigh(a, span);
    int way = b.lack < 0; /* 0: upwards */
    if (!(b.room[way] > 0))
        return;
    double share = b.lack / b.room[way];
    LL_VALIDATE(!(share * b.lack < 0)); /* towards the missing mass */
    share = share > WHOLE ? WHOLE : share < -WHOLE ? -WHOLE : share;
    spreading s = {a, span, a->spare[way], share};
    ll_rows_run(a->team, span.j1 - span.j0, a->g->config.nx, spread_rows, &s);
}
