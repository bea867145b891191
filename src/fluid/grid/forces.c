/* Viscosity, buoyancy, vorticity confinement, pointer drag, and the outflow. */
#include <math.h>
#include <string.h>

#include "base/detmath.h"
#include "fluid/grid/state.h"

/* ---- viscosity ---- */

/* (1 - a lap) f = wanted, for the cells of one colour. */
typedef struct diffusion {
    const ll_grid *g;
    double *f;
    const double *wanted;
    double a;
    ll_grid_span span;
    int32_t colour;
} diffusion;

static void diffuse_rows(void *context, ll_share rows, int part)
{
    const diffusion *d = context;
    const ll_grid *g = d->g;
    const double *wanted = d->wanted;
    double *f = d->f, a = d->a, share = 1 / (1 + 4 * a);
    int64_t s = g->stride;
    (void)part;
    for (int32_t j = d->span.j0 + rows.begin; j < d->span.j0 + rows.end; j++)
        for (int64_t k = ll_grid_k(g, d->span.i0 + ((j + d->colour) & 1), j),
                     end = ll_grid_k(g, d->span.i1, j);
             k < end; k += 2)
            f[k] = share * (wanted[k] + a * ((f[k - 1] + f[k + 1]) + (f[k - s] + f[k + s])));
}

/* One red-black Gauss-Seidel sweep. */
static void diffuse_sweep(const ll_grid *g, ll_grid_place place, double *f, const double *wanted, double a,
                          ll_team *team)
{
    ll_grid_span span = ll_grid_span_of(g, place);
    for (int32_t colour = 0; colour < 2; colour++) {
        ll_grid_bounds(g, place, f);
        ll_rows_run(team, span.j1 - span.j0, g->config.nx, diffuse_rows,
                    &(diffusion){g, f, wanted, a, span, colour});
    }
}

/* Implicit Euler: no step is too long. 20 sweeps as in Stam's method, or as many as reduce the error by
 * 1e-6. */
void ll_grid_diffuse(ll_grid *g, double dt, ll_team *team)
{
    double a = g->config.viscosity * g->solver.viscosity_scale * dt / (g->config.h * g->config.h);
    double shrink = 4 * a / (1 + 4 * a), left = 1;
    size_t bytes = (size_t)g->stride * (size_t)g->rows * sizeof(double);
    if (a == 0)
        return;
    double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V);
    double *wanted_u = ll_grid_field(g, LL_FIELD_E), *wanted_v = ll_grid_field(g, LL_FIELD_F);
    memcpy(wanted_u, u, bytes);
    memcpy(wanted_v, v, bytes);
    for (int sweep = 0; sweep < 20 && left > 1e-6; sweep++, left *= shrink * shrink) {
        diffuse_sweep(g, LL_PLACE_U, u, wanted_u, a, team);
        diffuse_sweep(g, LL_PLACE_V, v, wanted_v, a, team);
        ll_grid_close(g, u, v);
    }
    ll_grid_bounds(g, LL_PLACE_U, u);
    ll_grid_bounds(g, LL_PLACE_V, v);
}

/* ---- forces ---- */

static void add_buoyancy(const ll_grid *g, double *v, double dt)
{
    ll_grid_span span = ll_grid_span_of(g, LL_PLACE_V);
    const double *dye = ll_grid_field(g, LL_FIELD_DYE);
    double half = 0.5 * dt * g->config.buoyancy;
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int64_t k = ll_grid_k(g, span.i0, j), end = ll_grid_k(g, span.i1, j); k < end; k++)
            v[k] += half * (dye[k - g->stride] + dye[k]);
}

/* Vorticity times 2 h. */
static double vorticity(const double *u, const double *v, int64_t k, int64_t s)
{
    double across = (v[k + 1] + v[k + 1 + s]) - (v[k - 1] + v[k - 1 + s]);
    double along = (u[k + s] + u[k + 1 + s]) - (u[k - s] + u[k + 1 - s]);
    return 0.5 * (across - along);
}

/* Fedkiw et al. 2001: a force around each vortex, in cells at least two from the sides. */
static void add_confinement(const ll_grid *g, double *du, double *dv, double dt)
{
    const double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V);
    const uint8_t *fluid = ll_grid_fluid(g);
    int64_t s = g->stride;
    double scale =
        0.5 * dt * g->solver.vorticity_confinement * 0.5; /* eps h N x w; half to each of two faces */
    for (int32_t j = 2; j < g->config.ny - 2; j++)
        for (int32_t i = 2; i < g->config.nx - 2; i++) {
            int64_t k = ll_grid_k(g, i, j);
            if (!fluid[k])
                continue;
            double w = vorticity(u, v, k, s);
            double gx = fabs(vorticity(u, v, k + 1, s)) - fabs(vorticity(u, v, k - 1, s));
            double gy = fabs(vorticity(u, v, k + s, s)) - fabs(vorticity(u, v, k - s, s));
            double length = ll_sqrt(gx * gx + gy * gy) + 1e-12;
            double fx = scale * w * gy / length, fy = -scale * w * gx / length;
            du[k] += fx;
            du[k + 1] += fx;
            dv[k] += fy;
            dv[k + s] += fy;
        }
}

void ll_grid_add_forces(const ll_grid *g, double *du, double *dv, double dt)
{
    if (g->config.buoyancy != 0)
        add_buoyancy(g, dv, dt);
    if (g->solver.vorticity_confinement > 0)
        add_confinement(g, du, dv, dt);
}

static void draw_along(const ll_grid *g, ll_grid_place place, double *f, double velocity)
{
    const ll_drag_force *drag_force = &g->drag_force;
    ll_grid_span span = ll_grid_span_of(g, place);
    double sx = place == LL_PLACE_U ? 0 : 0.5, sy = place == LL_PLACE_V ? 0 : 0.5, h = g->config.h;
    for (int32_t j = span.j0; j < span.j1; j++)
        for (int32_t i = span.i0; i < span.i1; i++) {
            double x = g->config.x + h * (i + sx) - drag_force->x,
                   y = g->config.y + h * (j + sy) - drag_force->y;
            double share = 1 - (x * x + y * y) / (drag_force->radius * drag_force->radius);
            int64_t k = ll_grid_k(g, i, j);
            if (share > 0)
                f[k] += share * (velocity - f[k]);
        }
    ll_grid_bounds(g, place, f);
}

static void feed_dye(const ll_grid *g)
{
    const ll_grid_config *c = &g->config;
    double *dye = ll_grid_field(g, LL_FIELD_DYE);
    for (int32_t j = 0; j < c->ny; j++)
        for (int32_t i = 0; i < c->nx; i++) {
            double x = c->x + c->h * (i + 0.5) - c->source_x, y = c->y + c->h * (j + 0.5) - c->source_y;
            if (x * x + y * y < c->source_radius * c->source_radius)
                dye[ll_grid_k(g, i, j)] = 1;
        }
}

void ll_grid_drive(ll_grid *g)
{
    double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V);
    if (g->config.dyed && g->config.source_radius > 0)
        feed_dye(g);
    if (g->drag_force.radius > 0 && !g->config.frozen) {
        draw_along(g, LL_PLACE_U, u, g->drag_force.velocity_x);
        draw_along(g, LL_PLACE_V, v, g->drag_force.velocity_y);
        ll_grid_close(g, u, v);
    }
}

/* ---- outflow ---- */

/* Advects the outflow by the mean inflow speed, then scales it so that outflow equals inflow. =ca7e09d */
void ll_grid_outflow(ll_grid *g, double dt)
{
    if (g->config.sides[LL_RIGHT] != LL_SIDE_OUT)
        return;
    double *u = ll_grid_field(g, LL_FIELD_U), in = 0, out = 0;
    int32_t nx = g->config.nx, ny = g->config.ny;
    for (int32_t j = 0; j < ny; j++)
        in += u[ll_grid_k(g, 0, j)];
    double c = in / ny * dt / g->config.h;
    c = c > 1 ? 1 : c;
    for (int32_t j = 0; j < ny; j++) {
        int64_t k = ll_grid_k(g, nx, j);
        u[k] += c * (u[k - 1] - u[k]);
        out += u[k];
    }
    for (int32_t j = 0; j < ny; j++)
        u[ll_grid_k(g, nx, j)] += (in - out) / ny;
    ll_grid_bounds(g, LL_PLACE_U, u);
}
