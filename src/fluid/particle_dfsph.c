/* Divergence-free SPH: Bender and Koschier, IEEE Trans. Vis. Comput. Graph. 23 (2017).
 *
 * Two solves in a substep, each a relaxed Jacobi iteration over the stiffness k = p / density^2 that begins
 * with that of the substep before: one makes the velocity free of divergence, the other keeps the density
 * that the particles would come to at its rest value. k is never negative, hence no tension at the surface.
 */
#include <string.h>

#include "fluid/particle_internal.h"

/* How long what is too dense takes to come back to rest, in h over the speed of sound: at once would need the
 * faster motion, and the more pressure, the shorter the substep. */
#define RETURN 100

static double dt_limit(const ll_particles *p, double speed)
{
    return p->params.cfl * p->setup.spacing / (speed + 1e-9 * p->setup.spacing);
}

typedef struct solve {
    double *stiff;
    double slack; /* share of the density at rest that may be missing before a particle counts as surface */
    double return_share; /* of what is too dense, that is undone in this substep */
    bool density;        /* else divergence */
    uint8_t reserved[7];
} solve;

static void push(ll_particles *p, const double *stiff, double dt)
{
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    const double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    ll_particle_push(p, stiff);
    ll_particle_body_push(p, dt);
    for (int32_t a = 0; a < p->fluid; a++) {
        u[a] += dt * ax[a];
        v[a] += dt * ay[a];
    }
}

/* One pass of the iteration; returns the mean relative error of density before it: what is too dense, and
 * what is pushed apart too far. */
static double relax(ll_particles *p, const solve *s, double dt)
{
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY),
                 *rate = ll_particle_values(p, LL_PARTICLE_RATE);
    const double *factor = ll_particle_values(p, LL_PARTICLE_FACTOR);
    double *step = ll_particle_values(p, LL_PARTICLE_SUM), rest = p->params.density, error = 0;
    ll_particle_sum_rate(p);
    for (int32_t a = 0; a < p->fluid; a++) {
        double over = dt * rate[a], *stiff = &s->stiff[a];
        if (s->density)
            over += (density[a] > rest ? s->return_share : 1) * (density[a] - rest);
        double wanted = p->params.relaxation * over / (dt * dt * factor[a]);
        if (!s->density && density[a] < (1 - s->slack) * rest)
            wanted = -*stiff; /* the surface may part, and carries nothing */
        else
            error += *stiff > 0 || over > 0 ? __builtin_fabs(over) : 0;
        step[a] = wanted > -*stiff ? wanted : -*stiff;
        *stiff += step[a];
    }
    ll_particle_mirror(p, step, 0);
    push(p, step, dt);
    return error / (rest * p->fluid);
}

static void iterate(ll_particles *p, const solve *s, double dt, ll_pace *pace)
{
    ll_particle_mirror(p, s->stiff, s->density ? 1 / p->params.density : 0);
    push(p, s->stiff, dt);
    for (int64_t i = 0; i < p->params.iterations && ll_goes_on(pace); i++) {
        p->iterations++;
        if (relax(p, s, dt) <= p->params.tolerance && i > 0)
            return;
    }
}

static ll_particle_fault substep(ll_particles *p, double dt, ll_pace *pace)
{
    const ll_particle_params *q = &p->params;
    ll_particle_sort_fluid(p);
    ll_particle_fault fault = ll_particle_pairs(p, p->support);
    if (fault.reason != NULL)
        return fault;
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    double *stiff = ll_particle_values(p, LL_PARTICLE_STIFF),
           *divergence = ll_particle_values(p, LL_PARTICLE_DIVERGENCE);
    ll_particle_sum_density(p, false);
    iterate(p, &(solve){.stiff = divergence, .slack = 0.1}, dt, pace);
    size_t bytes = (size_t)ll_particle_total(p) * sizeof *ax;
    memset(ax, 0, bytes);
    memset(ay, 0, bytes);
    ll_particle_add_viscosity(p);
    ll_particle_body_push(p, dt);
    for (int32_t a = 0; a < p->fluid; a++) {
        u[a] += dt * (ax[a] + q->gravity_x);
        v[a] += dt * (ay[a] + q->gravity_y);
    }
    double share = dt * q->sound_speed / (RETURN * p->h);
    iterate(p, &(solve){.stiff = stiff, .return_share = share < 1 ? share : 1, .density = true}, dt, pace);
    double *both = ll_particle_values(p, LL_PARTICLE_SUM);
    for (int32_t a = 0; a < p->fluid; a++)
        both[a] = stiff[a] + divergence[a];
    ll_particle_mirror(p, both, 1 / q->density);
    ll_particle_field_pressure(p, both);
    for (int32_t a = 0; a < p->fluid; a++) {
        x[a] += dt * u[a];
        y[a] += dt * v[a];
    }
    return (ll_particle_fault){0};
}

const ll_particle_method ll_particle_dfsph = {
    .name = "dfsph",
    .help = "Two pressure solves in a substep, for velocity without divergence and for density at rest, "
            "begun with the last result and ended at a tolerance. Two passes over pairs an iteration, five "
            "besides; substeps as long as the CFL condition allows (Bender and Koschier 2017).",
    .travel = 1,
    .dt_limit = dt_limit,
    .substep = substep,
};
