#include "fluid/grid/grid.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/assert.h"
#include "fluid/grid/state.h"

/* ---- layout: header, fields, donors, fluid, the pressure solver's work ---- */

static int32_t stride_of(int32_t nx)
{
    return (nx + 4) & ~1;
}

size_t ll_grid_size(int32_t nx, int32_t ny)
{
    size_t cells = (size_t)stride_of(nx) * (size_t)(ny + 3);
    size_t size = sizeof(ll_grid) + cells * (LL_FIELDS * sizeof(double) + sizeof(int32_t));
    return (size + ((cells + 7) & ~(size_t)7) + ll_pressure_work_size(nx, ny) + 7) & ~(size_t)7;
}

const ll_grid_config *ll_grid_get_config(const ll_grid *g)
{
    return &g->config;
}

double ll_grid_time(const ll_grid *g)
{
    return g->time;
}

/* ---- making ---- */

ll_status ll_grid_check(const ll_grid_config *c, const ll_grid_solver *solver, bool empty)
{
    char what[64];
    if (c->nx % 2 != 0)
        return ll_field_error(LL_BAD_INPUT, "params.n", "params.n: must be even; got %d", c->nx);
    snprintf(what, sizeof what, "a grid of %d x %d cells", c->nx, c->ny);
    LL_TRY(ll_fluid_check_bytes("params.n", what, (int64_t)ll_grid_size(c->nx, c->ny)));
    ll_status status = ll_pressure_fits((ll_pressure_kind)solver->pressure, c->nx, c->ny,
                                        c->sides[LL_LEFT] == LL_SIDE_PERIODIC,
                                        c->sides[LL_BELOW] == LL_SIDE_PERIODIC, empty);
    if (ll_failed(&status))
        return ll_field_error(LL_BAD_INPUT, "solver.pressure", "solver.pressure: %s", status.text);
    return status;
}

void ll_grid_init(void *block, const ll_grid_config *config, const ll_grid_solver *solver)
{
    ll_grid *g = block;
    size_t size = ll_grid_size(config->nx, config->ny);
    memset(block, 0, size);
    g->config = *config;
    g->solver = *solver;
    g->size = (int64_t)size;
    LL_ASSERT(config->nx > 0 && config->nx % 2 == 0 && config->ny > 0 && config->h > 0);
    g->stride = stride_of(config->nx);
    g->rows = config->ny + 3;
    memset(ll_grid_fluid(g), 1, (size_t)g->stride * (size_t)g->rows);
}

static void prepare_pressure(const ll_grid *g)
{
    ll_poisson p;
    ll_grid_poisson(g, &p);
    ll_pressure_prepare((ll_pressure_kind)g->solver.pressure, &p);
}

void ll_grid_start(ll_grid *g)
{
    ll_poisson p;
    ll_grid_poisson(g, &p);
    ll_poisson_open(&p, ll_grid_fluid(g), ll_grid_field(g, LL_FIELD_OPEN_X),
                    ll_grid_field(g, LL_FIELD_OPEN_Y), ll_grid_field(g, LL_FIELD_INVERSE));
    g->empty = p.empty;
    prepare_pressure(g);
    ll_grid_close(g, ll_grid_u(g), ll_grid_v(g));
    ll_grid_bounds(g, LL_PLACE_U, ll_grid_u(g));
    ll_grid_bounds(g, LL_PLACE_V, ll_grid_v(g));
    ll_grid_bounds(g, LL_PLACE_CELL, ll_grid_dye(g));
    g->mass_start = ll_grid_mass(g);
}

void ll_grid_set_solver(ll_grid *g, const ll_grid_solver *solver)
{
    bool other = solver->pressure != g->solver.pressure;
    g->solver = *solver;
    if (other)
        prepare_pressure(g);
}

/* ---- step limits ---- */

typedef struct fastest {
    double speed; /* |u| + |v|, m/s */
    int32_t i, j;
    bool finite;
} fastest;

typedef struct fastest_search {
    const ll_grid *g;
    fastest of[LL_TEAM_PARTS_MAX];
} fastest_search;

/* The fastest cell of some rows, or the first that is not finite. */
static fastest fastest_of(const ll_grid *g, ll_share rows)
{
    const double *u = ll_grid_field(g, LL_FIELD_U), *v = ll_grid_field(g, LL_FIELD_V);
    const double *dye = ll_grid_field(g, LL_FIELD_DYE);
    int64_t s = g->stride;
    fastest f = {.finite = true};
    for (int32_t j = rows.begin; j < rows.end; j++)
        for (int32_t i = 0; i < g->config.nx; i++) {
            int64_t k = ll_grid_k(g, i, j);
            double a = fabs(u[k]), b = fabs(u[k + 1]), c = fabs(v[k]), d = fabs(v[k + s]);
            double speed = (a > b ? a : b) + (c > d ? c : d), sum = (a + b) + (c + d) + dye[k];
            if (sum - sum != 0)
                return (fastest){.i = i, .j = j};
            if (speed > f.speed)
                f = (fastest){speed, i, j, true};
        }
    return f;
}

static void fastest_rows(void *context, ll_share rows, int part)
{
    fastest_search *s = context;
    s->of[part] = fastest_of(s->g, rows);
}

/* Parts hold rows in their order: the first of equal cells, as by one thread. */
static fastest find_fastest(const ll_grid *g, ll_team *team)
{
    fastest_search s = {.g = g};
    int parts = ll_rows_run(team, g->config.ny, g->config.nx, fastest_rows, &s);
    fastest f = s.of[0];
    for (int i = 1; i < parts && f.finite; i++)
        if (!s.of[i].finite || s.of[i].speed > f.speed)
            f = s.of[i];
    return f;
}

static ll_status not_finite(const ll_grid *g, const fastest *f)
{
    return ll_error(LL_DIVERGED, "step %lld: cell (%d, %d) is not finite", (long long)g->steps, f->i, f->j);
}

static bool central(const ll_grid *g)
{
    return !ll_advections[g->solver.advection];
}

/* Largest motion per step, in cells. */
static double cfl_limit(const ll_grid *g)
{
    double limit = g->solver.cfl, most = g->config.dyed ? LL_CENTRAL_DYE_CFL : LL_CENTRAL_CFL;
    return central(g) && limit > most ? most : limit;
}

enum { SUBSTEPS_MAX = 1000 };
#define TOLERATED 1.1 /* the limits of central keep this distance from instability */

/* Number of substeps of `dt`; LL_DIVERGED if more than the method or the limit allows. */
static ll_status divide(ll_grid *g, double dt, const fastest *f, int64_t *count)
{
    double h = g->config.h, cfl = f->speed * dt / h;
    double nu = central(g) ? g->config.viscosity * g->solver.viscosity_scale : 0;
    double diffusion = nu * dt / (h * h) / LL_CENTRAL_DIFFUSION, advection = cfl / cfl_limit(g);
    double wanted = advection > diffusion ? advection : diffusion;
    if (wanted > SUBSTEPS_MAX)
        return ll_error(LL_DIVERGED,
                        "step %lld: cell (%d, %d) moves by %.3g cells, which needs more than %d substeps",
                        (long long)g->steps, f->i, f->j, cfl, SUBSTEPS_MAX);
    *count = g->solver.substeps > 0 ? g->solver.substeps : (int64_t)ceil(wanted);
    *count = *count < 1 ? 1 : *count;
    g->last_cfl = cfl / (double)*count;
    double share = g->last_cfl / LL_CENTRAL_CFL, spread = diffusion / (double)*count;
    if (central(g) && (share > TOLERATED || spread > TOLERATED))
        return ll_error(LL_DIVERGED,
                        "step %lld: cell (%d, %d): a substep has CFL number %.3g, central allows %.3g; or "
                        "viscosity exceeds its limit by a factor of %.2g",
                        (long long)g->steps, f->i, f->j, g->last_cfl, LL_CENTRAL_CFL, spread);
    return ll_ok();
}

/* ---- steps ---- */

static void carry(ll_grid *g, ll_grid_place place, ll_grid_field_kind in, ll_grid_field_kind out, double dt,
                  ll_team *team)
{
    ll_grid_advect a = {.g = g,
                        .place = place,
                        .in = ll_grid_field(g, in),
                        .out = ll_grid_field(g, out),
                        .spare = {ll_grid_field(g, LL_FIELD_E), ll_grid_field(g, LL_FIELD_F)},
                        .donors = ll_grid_first_donors(g),
                        .dt = dt,
                        .team = team};
    ll_advections[g->solver.advection](&a);
    if (place == LL_PLACE_CELL && g->solver.conserve_mass)
        ll_grid_keep_mass(&a);
    ll_grid_bounds(g, place, a.out);
}

typedef struct copying {
    double *to;
    const double *from;
    int64_t stride;
} copying;

static void copy_rows(void *context, ll_share rows, int part)
{
    const copying *c = context;
    (void)part;
    memcpy(c->to + rows.begin * c->stride, c->from + rows.begin * c->stride,
           (size_t)(rows.end - rows.begin) * (size_t)c->stride * sizeof(double));
}

static void copy(ll_grid *g, ll_grid_field_kind to, ll_grid_field_kind from, ll_team *team)
{
    ll_rows_run(team, g->rows, g->stride, copy_rows,
                &(copying){ll_grid_field(g, to), ll_grid_field(g, from), g->stride});
}

/* Advects (u, v) of two fields and the dye by the current velocities, and replaces these. */
static void advect(ll_grid *g, ll_grid_field_kind u, ll_grid_field_kind v, double dt, ll_team *team)
{
    if (!g->config.frozen) {
        carry(g, LL_PLACE_U, u, LL_FIELD_A, dt, team);
        carry(g, LL_PLACE_V, v, LL_FIELD_B, dt, team);
    }
    if (g->config.dyed) {
        carry(g, LL_PLACE_CELL, LL_FIELD_DYE, LL_FIELD_C, dt, team);
        copy(g, LL_FIELD_DYE, LL_FIELD_C, team);
    }
    if (g->config.frozen)
        return;
    copy(g, LL_FIELD_U, LL_FIELD_A, team);
    copy(g, LL_FIELD_V, LL_FIELD_B, team);
    ll_grid_add_forces(g, ll_grid_u(g), ll_grid_v(g), dt);
    ll_grid_diffuse(g, dt, team);
}

/* After half a step, adds the part that the projection removed a second time, with the opposite sign: the
 * next projection removes it again, and its error cancels (Zehnder, Narain and Thomaszewski 2018). */
static void reflect(ll_grid *g, const ll_fluid_run *run)
{
    static const ll_grid_field_kind before[2] = {LL_FIELD_C, LL_FIELD_D}, now[2] = {LL_FIELD_U, LL_FIELD_V};
    copy(g, LL_FIELD_C, LL_FIELD_U, run->team);
    copy(g, LL_FIELD_D, LL_FIELD_V, run->team);
    ll_grid_project(g, run);
    for (int f = 0; f < 2; f++) {
        double *old = ll_grid_field(g, before[f]), *projected = ll_grid_field(g, now[f]);
        for (int64_t k = 0; k < (int64_t)g->stride * g->rows; k++)
            old[k] = 2 * projected[k] - old[k];
    }
}

static void substep(ll_grid *g, double dt, const ll_fluid_run *run)
{
    ll_grid_drive(g);
    if (!g->config.frozen)
        ll_grid_outflow(g, dt);
    if (central(g)) {
        ll_grid_step_central(g, dt, run);
        return;
    }
    bool reflected = g->solver.splitting == LL_SPLITTING_REFLECTION && !g->config.frozen;
    advect(g, LL_FIELD_U, LL_FIELD_V, reflected ? 0.5 * dt : dt, run->team);
    if (reflected) {
        reflect(g, run);
        advect(g, LL_FIELD_C, LL_FIELD_D, 0.5 * dt, run->team);
    }
    if (!g->config.frozen)
        ll_grid_project(g, run);
}

ll_status ll_grid_step(ll_grid *g, double dt, const ll_fluid_run *given)
{
    ll_fluid_run run = given ? *given : (ll_fluid_run){0};
    int64_t count = 0;
    fastest f = find_fastest(g, run.team);
    if (!f.finite)
        return not_finite(g, &f);
    LL_TRY(divide(g, dt, &f, &count));
    for (int64_t i = 0; i < count && ll_goes_on(run.pace); i++)
        substep(g, dt / (double)count, &run);
    g->last_substeps = count;
    g->steps++;
    g->time += dt;
    f = find_fastest(g, run.team);
    return f.finite ? ll_ok() : not_finite(g, &f);
}
