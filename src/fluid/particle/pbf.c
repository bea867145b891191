/* Position-based fluids: Macklin and Mueller, ACM Trans. Graph. 32 (2013).
 *
 * Particles are moved, then their positions are corrected a fixed number of times, until none is denser than
 * at rest; velocity is derived from their motion. Pairs are found once per substep, in a range somewhat wider
 * than the kernel, and their vectors are recomputed in each pass. Walls mirror the multipliers of the fluid
 * next to them. */
#include "fluid/particle/state.h"

/* Fraction of the last multipliers used as initial guess: with so few passes, excess could not be undone. */
#define WARM 0.25

static double dt_limit(const ll_particles *p, double speed)
{
    return p->params.cfl * p->setup.spacing / (speed + 1e-9 * p->setup.spacing);
}

/* Changes of the multipliers into SUM, and their total, which stays >= 0, into STIFF. */
static void multipliers(ll_particles *p, double dt, ll_team *team)
{
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY),
                 *factor = ll_particle_values(p, LL_PARTICLE_FACTOR);
    double *step = ll_particle_values(p, LL_PARTICLE_SUM),
           *pressure_factor = ll_particle_values(p, LL_PARTICLE_PRESSURE_FACTOR);
    double rest = p->params.density, scale = p->params.relaxation / (dt * dt);
    ll_particle_sum_density(p, true, team);
    for (int32_t a = 0; a < p->fluid; a++) {
        double wanted = scale * (density[a] - rest) / factor[a];
        step[a] = wanted > -pressure_factor[a] ? wanted : -pressure_factor[a];
        pressure_factor[a] += step[a];
    }
}

static void correct(ll_particles *p, double *pressure_factor, double volume, double dt, ll_team *team)
{
    double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    const double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    ll_particle_mirror(p, pressure_factor, volume);
    ll_particle_push(p, pressure_factor, team);
    ll_particle_body_push(p, dt);
    for (int32_t a = 0; a < p->fluid; a++) {
        x[a] += dt * dt * ax[a];
        y[a] += dt * dt * ay[a];
    }
}

static void warm_start(ll_particles *p, double dt, ll_team *team)
{
    double *pressure_factor = ll_particle_values(p, LL_PARTICLE_PRESSURE_FACTOR);
    for (int32_t a = 0; a < p->fluid; a++)
        pressure_factor[a] *= WARM;
    correct(p, pressure_factor, 1 / p->params.density, dt, team);
}

static void predict(ll_particles *p, double dt)
{
    double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    double *x0 = ll_particle_values(p, LL_PARTICLE_X0), *y0 = ll_particle_values(p, LL_PARTICLE_Y0);
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    for (int32_t a = 0; a < p->fluid; a++) {
        u[a] += dt * p->params.gravity_x;
        v[a] += dt * p->params.gravity_y;
        x0[a] = x[a];
        y0[a] = y[a];
        x[a] += dt * u[a];
        y[a] += dt * v[a];
        double wrap = !p->setup.periodic ? 0 : x[a] < 0 ? p->wrap : x[a] >= p->wrap ? -p->wrap : 0;
        x[a] += wrap;
        x0[a] += wrap;
    }
}

typedef struct smoothing {
    ll_particles *p;
    double share;
} smoothing;

LL_PARTICLE_VISIT(visit_smooth)
{
    const smoothing *c = context;
    const ll_particles *p = c->p;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *kernel = ll_part_kernel(p), *u = ll_particle_values(p, LL_PARTICLE_U),
                 *v = ll_particle_values(p, LL_PARTICLE_V);
    double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    double sx = own ? ax[a] : 0, sy = own ? ay[a] : 0, ua = u[a], va = v[a];
    for (int32_t k = row[2 * a]; k < row[2 * a + 1]; k++) {
        int32_t b = pair[k];
        double du = c->share * kernel[k] * (ua - u[b]), dv = c->share * kernel[k] * (va - v[b]);
        sx -= du;
        sy -= dv;
        if (ll_particle_takes(s, b, inside)) {
            ax[b] += du;
            ay[b] += dv;
        }
    }
    if (!own)
        return;
    ax[a] = sx;
    ay[a] = sy;
}

static void smooth_part(void *context, int part, int parts)
{
    smoothing *c = context;
    ll_particle_share s = ll_particle_share_of(c->p, part, parts);
    ll_particle_each(&s, visit_smooth, c);
}

/* Macklin and Mueller, eq. 17: a fraction of the mean difference from the neighbours' velocity, as an
 * acceleration. */
static void smooth(ll_particles *p, double dt, ll_team *team)
{
    smoothing c = {p, p->params.smoothing * p->setup.spacing * p->setup.spacing / dt};
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, smooth_part, &c);
}

/* Puts particles that passed a wall back to it; velocity, derived from the motion, follows. */
static double keep(double at, double size, int low, int high)
{
    return low && at < 0 ? 0 : high && at > size ? size : at;
}

static void finish(ll_particles *p, double dt, ll_team *team)
{
    double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    const double *x0 = ll_particle_values(p, LL_PARTICLE_X0), *y0 = ll_particle_values(p, LL_PARTICLE_Y0);
    double *pressure_factor = ll_particle_values(p, LL_PARTICLE_PRESSURE_FACTOR);
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    const double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    const ll_particle_setup *s = &p->setup;
    for (int32_t a = 0; a < p->fluid; a++) {
        x[a] = keep(x[a], s->width, s->walls & LL_WALL_LEFT, s->walls & LL_WALL_RIGHT);
        y[a] = keep(y[a], s->height, s->walls & LL_WALL_BOTTOM, s->walls & LL_WALL_TOP);
        u[a] = (x[a] - x0[a]) / dt;
        v[a] = (y[a] - y0[a]) / dt;
    }
    ll_particle_mirror(p, pressure_factor, 1 / p->params.density);
    ll_particle_field_pressure(p, pressure_factor, team);
    ll_particle_rest(p);
    ll_particle_add_viscosity(p, team);
    if (p->params.smoothing > 0)
        smooth(p, dt, team);
    ll_particle_body_push(p, dt);
    for (int32_t a = 0; a < p->fluid; a++) {
        u[a] += dt * ax[a];
        v[a] += dt * ay[a];
    }
}

static ll_particle_fault substep(ll_particles *p, double dt, const ll_fluid_run *run)
{
    predict(p, dt);
    ll_particle_sort_fluid(p);
    ll_particle_fault fault = ll_particle_pairs(p, 1.1 * p->kernel.support, run->team);
    if (fault.reason != NULL)
        return fault;
    warm_start(p, dt, run->team);
    for (int64_t i = 0; i < p->params.iterations && ll_goes_on(run->pace); i++) {
        multipliers(p, dt, run->team);
        correct(p, ll_particle_values(p, LL_PARTICLE_SUM), 0, dt, run->team);
        p->iterations++;
    }
    finish(p, dt, run->team);
    return (ll_particle_fault){0};
}

/* Positions are corrected a fixed number of times so that nothing is denser than at rest, for any step:
 * stiffness depends on the number of iterations, and motion is damped. Four passes over pairs per iteration,
 * one neighbour search (Macklin and Mueller 2013). */
const ll_particle_method ll_particle_pbf = {
    .travel = 4,
    .dt_limit = dt_limit,
    .substep = substep,
};
