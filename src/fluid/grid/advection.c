/* Tracing the flow back in time, and the table of schemes. */
#include "fluid/grid/state.h"

#include "base/assert.h"

/* Positions and velocities in cells. */
typedef struct vec {
    double x, y;
} vec;

typedef struct tracer {
    const double *u, *v;
    int64_t stride;
    double nx, ny;
    bool periodic_x, periodic_y;
    int64_t order;
    double scale; /* dt / h */
} tracer;

/* Clamps into the box: nothing is known outside. */
static double inside(double x, double n, bool periodic)
{
    if (periodic) {
        if (x < 0 || x >= n) {
            x -= n * (double)(int64_t)(x / n);
            x = x < 0 ? x + n : x;
        }
        return x;
    }
    return x < 0 ? 0 : x > n ? n : x;
}

/* Bilinear interpolation; (x, y) relative to the value of cell (0, 0), at least -1. */
static double between(const double *f, int64_t stride, double x, double y, int64_t *first)
{
    LL_VALIDATE(!(x < -1) && !(y < -1)); /* within the ring around the cells */
    int64_t i = (int64_t)(x + 1), j = (int64_t)(y + 1), k = j * stride + i;
    double a = x + 1 - (double)i, b = y + 1 - (double)j;
    *first = k;
    double low = f[k] + a * (f[k + 1] - f[k]);
    double high = f[k + stride] + a * (f[k + stride + 1] - f[k + stride]);
    return low + b * (high - low);
}

static vec velocity(const tracer *t, vec at)
{
    int64_t ignored;
    double x = inside(at.x, t->nx, t->periodic_x), y = inside(at.y, t->ny, t->periodic_y);
    return (vec){between(t->u, t->stride, x, y - 0.5, &ignored),
                 between(t->v, t->stride, x - 0.5, y, &ignored)};
}

/* Euler, midpoint, or Ralston's method of order 3; `now` is the velocity at the end. */
static vec origin(const tracer *t, vec at, vec now)
{
    double s = t->scale;
    if (t->order == 1)
        return (vec){at.x - s * now.x, at.y - s * now.y};
    vec half = velocity(t, (vec){at.x - 0.5 * s * now.x, at.y - 0.5 * s * now.y});
    if (t->order == 2)
        return (vec){at.x - s * half.x, at.y - s * half.y};
    vec late = velocity(t, (vec){at.x - 0.75 * s * half.x, at.y - 0.75 * s * half.y});
    return (vec){at.x - s * (2 * now.x + 3 * half.x + 4 * late.x) / 9,
                 at.y - s * (2 * now.y + 3 * half.y + 4 * late.y) / 9};
}

static vec velocity_here(const tracer *t, ll_grid_place place, int64_t k)
{
    const double *u = t->u + k, *v = t->v + k;
    int64_t s = t->stride;
    if (place == LL_PLACE_U)
        return (vec){u[0], 0.25 * (v[-1] + v[0] + v[s - 1] + v[s])};
    if (place == LL_PLACE_V)
        return (vec){0.25 * (u[-s] + u[1 - s] + u[0] + u[1]), v[0]};
    return (vec){0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[s])};
}

/* Velocities through walls are unchanged. */
static void keep_walls(const ll_grid *g, ll_grid_place place, const double *in, double *out)
{
    int32_t nx = g->config.nx, ny = g->config.ny;
    if (place == LL_PLACE_U && !ll_grid_periodic_x(g))
        for (int32_t j = 0; j < ny; j++) {
            out[ll_grid_k(g, 0, j)] = in[ll_grid_k(g, 0, j)];
            out[ll_grid_k(g, nx, j)] = in[ll_grid_k(g, nx, j)];
        }
    if (place == LL_PLACE_V && !ll_grid_periodic_y(g))
        for (int32_t i = 0; i < nx; i++) {
            out[ll_grid_k(g, i, 0)] = in[ll_grid_k(g, i, 0)];
            out[ll_grid_k(g, i, ny)] = in[ll_grid_k(g, i, ny)];
        }
}

void ll_grid_trace(const ll_grid_advect *a, const double *in, double *out, double dt, int32_t *donors)
{
    const ll_grid *g = a->g;
    tracer t = {.u = ll_grid_field(g, LL_FIELD_U),
                .v = ll_grid_field(g, LL_FIELD_V),
                .stride = g->stride,
                .nx = g->config.nx,
                .ny = g->config.ny,
                .periodic_x = ll_grid_periodic_x(g),
                .periodic_y = ll_grid_periodic_y(g),
                .order = g->solver.backtrace,
                .scale = dt / g->config.h};
    ll_grid_span span = ll_grid_span_of(g, a->place);
    double shift_x = a->place == LL_PLACE_U ? 0 : 0.5, shift_y = a->place == LL_PLACE_V ? 0 : 0.5;
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int32_t i = span.i0; i < span.i1; i++) {
            int64_t k = ll_grid_k(g, i, j), first;
            vec from = origin(&t, (vec){i + shift_x, j + shift_y}, velocity_here(&t, a->place, k));
            from.x = inside(from.x, t.nx, t.periodic_x) - shift_x;
            from.y = inside(from.y, t.ny, t.periodic_y) - shift_y;
            out[k] = between(in, t.stride, from.x, from.y, &first);
            if (donors)
                donors[k] = (int32_t)first;
        }
    keep_walls(g, a->place, in, out);
}

void ll_grid_clamp(const ll_grid_advect *a)
{
    ll_grid_span span = ll_grid_span_of(a->g, a->place);
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int64_t k = ll_grid_k(a->g, span.i0, j), end = ll_grid_k(a->g, span.i1, j); k < end; k++) {
            ll_grid_range r = ll_grid_donors(a, k);
            a->out[k] = a->out[k] < r.low ? r.low : a->out[k] > r.high ? r.high : a->out[k];
        }
}
