/* Divergence-free SPH: Bender and Koschier, IEEE Trans. Vis. Comput. Graph. 23 (2017).
 *
 * Two solves per substep, each a relaxed Jacobi iteration over the stiffness k = p / density^2 that starts
 * from the last substep: one removes the divergence of the velocity, the other corrects the predicted density
 * to its rest value. k is never negative, so there is no tension at the surface. Each iteration goes on
 * beyond its result by a fraction of the change (Y. Nesterov, Soviet Math. Dokl. 27, 1983; with such a bound:
 * H. Mazhar et al., ACM Trans. Graph. 34 (2015)): a third of the iterations then does. */
#include <string.h>

#include "fluid/particle/state.h"

/* Time in which excess density is removed, in h over the speed of sound. Removing it at once would need
 * faster motion, and more pressure, for shorter substeps. */
#define RETURN 100

static double dt_limit(const ll_particles *p, double speed)
{
    return p->params.cfl * p->setup.spacing / (speed + 1e-9 * p->setup.spacing);
}

/* Momentum: that fraction, less with a larger relaxation. An error that an iteration multiplies by 1 - r
 * shrinks while r < (2 + 2 m) / (1 + 2 m); r is at most LARGEST times the relaxation. */
#define MOMENTUM 0.85
#define LARGEST 2.5

static double momentum_of(double relaxation)
{
    double r = LARGEST * relaxation, most = r > 1 ? (2 - r) / (2 * r - 2) : MOMENTUM;
    return most > MOMENTUM ? MOMENTUM : most > 0 ? most : 0;
}

typedef struct solve {
    double *pressure_factor;
    double slack;        /* relative deficit of density up to which a particle is not at the surface */
    double return_share; /* fraction of the excess density to remove in this substep */
    bool density;        /* false: divergence */
    uint8_t reserved[7];
} solve;

static void push(ll_particles *p, const double *pressure_factor, double dt, ll_team *team)
{
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    const double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    ll_particle_push(p, pressure_factor, team);
    ll_particle_body_push(p, dt);
    for (int32_t a = 0; a < p->fluid; a++) {
        u[a] += dt * ax[a];
        v[a] += dt * ay[a];
    }
}

typedef struct relaxation {
    ll_particles *p;
    const solve *s;
    double *step, *error; /* of each particle */
    double *reached;      /* k before it went on */
    double dt, momentum;
} relaxation;

static void relax_part(void *context, int part, int parts)
{
    const relaxation *r = context;
    const ll_particles *p = r->p;
    const solve *s = r->s;
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY),
                 *rate = ll_particle_values(p, LL_PARTICLE_RATE);
    const double *factor = ll_particle_values(p, LL_PARTICLE_FACTOR);
    double *step = r->step, *error = r->error, *reached = r->reached, rest = p->params.density, dt = r->dt;
    ll_share of = ll_share_of(p->fluid, part, parts);
    for (int32_t a = of.begin; a < of.end; a++) {
        double over = dt * rate[a], *pressure_factor = &s->pressure_factor[a];
        if (s->density)
            over += (density[a] > rest ? s->return_share : 1) * (density[a] - rest);
        double wanted = p->params.relaxation * over / (dt * dt * factor[a]);
        error[a] = 0;
        if (!s->density && density[a] < (1 - s->slack) * rest)
            wanted = -*pressure_factor; /* the surface may separate, and has no pressure */
        else
            error[a] = *pressure_factor > 0 || over > 0 ? __builtin_fabs(over) : 0;
        double k = *pressure_factor + wanted;
        k = k > 0 ? k : 0;
        double on = k + r->momentum * (k - reached[a]);
        on = on > 0 ? on : 0;
        reached[a] = k;
        step[a] = on - *pressure_factor;
        *pressure_factor = on;
    }
}

/* After the last iteration nothing would correct a momentum that goes too far. */
static void take_back_momentum(const ll_particles *p, const relaxation *r)
{
    double *pressure_factor = r->s->pressure_factor;
    for (int32_t a = 0; a < p->fluid; a++) {
        r->step[a] += r->reached[a] - pressure_factor[a];
        pressure_factor[a] = r->reached[a];
    }
}

/* Iteration `i`; returns whether it is the last one, by the mean relative density error before it: excess
 * density, and particles pushed too far apart. */
static bool relax(ll_particles *p, const solve *s, double dt, int64_t i, ll_team *team)
{
    relaxation r = {.p = p,
                    .s = s,
                    .step = ll_particle_values(p, LL_PARTICLE_SUM),
                    .error = ll_particle_values(p, LL_PARTICLE_GX),
                    .reached = ll_particle_values(p, LL_PARTICLE_REACHED),
                    .dt = dt,
                    .momentum = momentum_of(p->params.relaxation)};
    double error = 0;
    ll_particle_sum_rate(p, team);
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, relax_part, &r);
    for (int32_t a = 0; a < p->fluid; a++) /* in the order of the particles */
        error += r.error[a];
    error /= p->params.density * p->fluid;
    bool last = (error <= p->params.tolerance && i > 0) || i + 1 == p->params.iterations;
    if (last)
        take_back_momentum(p, &r);
    ll_particle_mirror(p, r.step, 0);
    push(p, r.step, dt, team);
    return last;
}

static void iterate(ll_particles *p, const solve *s, double dt, const ll_fluid_run *run)
{
    ll_particle_mirror(p, s->pressure_factor, s->density ? 1 / p->params.density : 0);
    push(p, s->pressure_factor, dt, run->team);
    memcpy(ll_particle_values(p, LL_PARTICLE_REACHED), s->pressure_factor,
           (size_t)p->fluid * sizeof *s->pressure_factor);
    for (int64_t i = 0; ll_goes_on(run->pace); i++) {
        p->iterations++;
        if (relax(p, s, dt, i, run->team))
            return;
    }
}

static ll_particle_fault substep(ll_particles *p, double dt, const ll_fluid_run *run)
{
    const ll_particle_params *q = &p->params;
    ll_particle_sort_fluid(p);
    ll_particle_fault fault = ll_particle_pairs(p, p->kernel.support, run->team);
    if (fault.reason != NULL)
        return fault;
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    const double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    double *pressure_factor = ll_particle_values(p, LL_PARTICLE_PRESSURE_FACTOR),
           *divergence = ll_particle_values(p, LL_PARTICLE_DIVERGENCE);
    ll_particle_sum_density(p, false, run->team);
    iterate(p, &(solve){.pressure_factor = divergence, .slack = 0.1}, dt, run);
    ll_particle_rest(p);
    ll_particle_add_viscosity(p, run->team);
    ll_particle_body_push(p, dt);
    for (int32_t a = 0; a < p->fluid; a++) {
        u[a] += dt * (ax[a] + q->gravity_x);
        v[a] += dt * (ay[a] + q->gravity_y);
    }
    double share = dt * q->sound_speed / (RETURN * p->kernel.h);
    iterate(
        p,
        &(solve){.pressure_factor = pressure_factor, .return_share = share < 1 ? share : 1, .density = true},
        dt, run);
    double *both = ll_particle_values(p, LL_PARTICLE_SUM);
    for (int32_t a = 0; a < p->fluid; a++)
        both[a] = pressure_factor[a] + divergence[a];
    ll_particle_mirror(p, both, 1 / q->density);
    ll_particle_field_pressure(p, both, run->team);
    for (int32_t a = 0; a < p->fluid; a++) {
        x[a] += dt * u[a];
        y[a] += dt * v[a];
    }
    return (ll_particle_fault){0};
}

/* Two pressure solves per substep, for velocity without divergence and for rest density, started from the
 * last result and ended at a tolerance. Two passes over pairs per iteration, five more; substeps by the CFL
 * condition (Bender and Koschier 2017). */
const ll_particle_method ll_particle_dfsph = {
    .travel = 1,
    .dt_limit = dt_limit,
    .substep = substep,
};
