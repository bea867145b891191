#include <math.h>
#include <string.h>

#include "base/assert.h"
#include "base/hash.h"
#include "fluid/particle/parameters.h"
#include "fluid/particle/state.h"

#define METHODS(X) X(WCSPH, wcsph) X(PBF, pbf) X(DFSPH, dfsph)
#define ROW(kind, name) [LL_PARTICLE_##kind] = &ll_particle_##name,
#define NAME(kind, name) [LL_PARTICLE_##kind] = #name,

static const ll_particle_method *const methods[] = {METHODS(ROW)};
const char *const ll_particle_method_names[LL_PARTICLE_METHODS + 1] = {METHODS(NAME)};

static const ll_param rows[] = {
    LL_PARTICLE_ROWS(LL_PARTICLE_DFSPH, 0, -10, 1000, 40, 0.02, 0, 0, 0.4, 100, 0),
};

const ll_param_table ll_particle_table = LL_PARTICLE_TABLE("particles", rows);

/* Masses do not change: a new rest density changes the density only through mass. */
void ll_particles_set_params(ll_particles *p, const ll_particle_params *params)
{
    bool changed = p->params.method != params->method;
    double scale = params->density / p->params.density;
    p->params = *params;
    p->mass = params->density * p->setup.spacing * p->setup.spacing;
    double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    for (int32_t a = 0; a < p->fluid; a++)
        density[a] *= scale;
    if (!changed)
        return;
    /* Values of another method have another meaning. */
    memset(ll_particle_values(p, LL_PARTICLE_PRESSURE_FACTOR), 0,
           (size_t)ll_particle_total(p) * sizeof(double));
    memset(ll_particle_values(p, LL_PARTICLE_DIVERGENCE), 0, (size_t)ll_particle_total(p) * sizeof(double));
    for (int32_t a = 0; a < p->fluid; a++)
        density[a] = params->density;
}

const ll_particle_params *ll_particles_get_params(const ll_particles *p)
{
    return &p->params;
}

const ll_particle_setup *ll_particles_get_setup(const ll_particles *p)
{
    return &p->setup;
}

/* ---- a step ---- */

static ll_status failed(const ll_particles *p, ll_particle_fault fault)
{
    int32_t id = ll_part_id(p)[fault.particle];
    return ll_error(LL_DIVERGED, "step %lld: particle %d %s (%.4g, at most %.4g).", (long long)p->tick, id,
                    fault.reason, fault.value, fault.limit);
}

/* The particle of the largest speed; the first whose state is not finite, if any. */
static int32_t fastest(const ll_particles *p, double *speed)
{
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    const double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    double most = -1;
    int32_t at = 0;
    for (int32_t a = 0; a < p->fluid; a++) {
        double square = u[a] * u[a] + v[a] * v[a];
        if (!(square + x[a] * x[a] + y[a] * y[a] + density[a] * density[a] < 1e300)) {
            *speed = NAN;
            return a;
        }
        if (square > most) {
            most = square;
            at = a;
        }
    }
    *speed = sqrt(most);
    return at;
}

static double dt_limit(const ll_particles *p, double speed)
{
    const ll_particle_params *q = &p->params;
    double limit = methods[q->method]->dt_limit(p, speed);
    double gravity = sqrt(q->gravity_x * q->gravity_x + q->gravity_y * q->gravity_y);
    double viscosity = q->viscosity + q->artificial_viscosity * p->kernel.h * q->sound_speed / 8;
    if (viscosity > 0)
        limit = fmin(limit, 0.125 * p->kernel.h * p->kernel.h / viscosity);
    if (gravity > 0)
        limit = fmin(limit, 0.25 * sqrt(p->kernel.h / gravity));
    return limit;
}

static void wrap(ll_particles *p)
{
    double *x = ll_particle_values(p, LL_PARTICLE_X);
    for (int32_t a = 0; p->setup.periodic && a < p->fluid; a++)
        x[a] += x[a] < 0 ? p->wrap : x[a] >= p->wrap ? -p->wrap : 0;
}

static ll_particle_fault not_finite(int32_t particle)
{
    return (ll_particle_fault){
        .reason = "has a value that is not finite", .particle = particle, .value = NAN};
}

static ll_particle_fault check(const ll_particles *p, double dt)
{
    double speed, travel = methods[p->params.method]->travel;
    int32_t at = fastest(p, &speed);
    double spacings = speed * dt / p->setup.spacing;
    if (isnan(speed))
        return not_finite(at);
    if (spacings > travel)
        return (ll_particle_fault){.reason = "broke the CFL condition: spacings moved in one substep",
                                   .particle = at,
                                   .value = spacings,
                                   .limit = travel};
    return (ll_particle_fault){0};
}

void ll_particles_drag(ll_particles *p, const ll_drag_force *drag_force)
{
    p->drag_force = *drag_force;
}

void ll_particles_put(ll_particles *p, const ll_particle_place *places)
{
    for (int32_t a = 0; a < p->fluid; a++) {
        LL_VALIDATE(ll_part_id(p)[a] >= 0 && ll_part_id(p)[a] < p->fluid);
        const ll_particle_place *to = &places[ll_part_id(p)[a]];
        ll_particle_values(p, LL_PARTICLE_X)[a] = to->x;
        ll_particle_values(p, LL_PARTICLE_Y)[a] = to->y;
        ll_particle_values(p, LL_PARTICLE_U)[a] = to->u;
        ll_particle_values(p, LL_PARTICLE_V)[a] = to->v;
    }
}

static void draw_along(ll_particles *p)
{
    const ll_drag_force *s = &p->drag_force;
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    for (int32_t a = 0; s->radius > 0 && a < p->fluid; a++) {
        double ex = x[a] - s->x, ey = y[a] - s->y;
        if (ex * ex + ey * ey > s->radius * s->radius)
            continue;
        u[a] = s->velocity_x;
        v[a] = s->velocity_y;
    }
}

ll_status ll_particles_step_by(ll_particles *p, double dt, const ll_fluid_run *given)
{
    ll_fluid_run run = given ? *given : (ll_fluid_run){0};
    const ll_particle_params *q = &p->params;
    double left = dt;
    draw_along(p);
    for (int64_t done = 0; left > 0 && ll_goes_on(run.pace); done++) {
        double speed;
        int32_t at = fastest(p, &speed);
        if (isnan(speed))
            return failed(p, not_finite(at));
        double parts = ceil(left / dt_limit(p, speed) * (1 - 1e-12));
        if (parts + (double)done > (double)q->substeps)
            return failed(p, (ll_particle_fault){.reason = "needs too many substeps by the CFL condition",
                                                 .particle = at,
                                                 .value = parts + (double)done,
                                                 .limit = (double)q->substeps});
        double part = parts > 1 ? left / parts : left;
        LL_ASSERT(part > 0 && part <= left); /* time goes on */
        ll_particle_fault fault = methods[q->method]->substep(p, part, &run);
        if (fault.reason == NULL) {
            ll_particle_body_move(p, part);
            wrap(p);
            fault = check(p, part);
        }
        if (fault.reason != NULL)
            return failed(p, fault);
        left = parts > 1 ? left - part : 0;
        p->substeps++;
    }
    p->time += dt;
    p->tick++;
    LL_VALIDATE(ll_broken_off(run.pace) || ll_particles_valid(p));
    return ll_ok();
}

ll_status ll_particles_step(ll_particles *p, double dt)
{
    return ll_particles_step_by(p, dt, NULL);
}

uint64_t ll_particles_hash(const ll_particles *p)
{
    uint64_t h = ll_hash(0, p, offsetof(struct ll_particles, stride));
    return ll_hash(h, (const char *)p + p->at.id, (size_t)(p->at.state_end - p->at.id));
}

bool ll_particles_valid(const ll_particles *p)
{
    const int32_t *id = ll_part_id(p);
    double ids = 0, total = p->fluid;
    for (int32_t a = 0; a < p->fluid; a++) {
        if (id[a] < 0 || id[a] >= p->fluid)
            return false;
        ids += id[a];
    }
    if (ids != total * (total - 1) / 2)
        return false;
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++)
        if (id[b] >= 0 || id[b] < -1 - p->body_count)
            return false;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    for (int32_t a = 0; p->substeps > 0 && a < p->fluid; a++)
        for (int32_t k = row[2 * a]; k < row[2 * a + 2]; k++)
            if (pair[k] <= a || pair[k] >= ll_particle_total(p) ||
                (pair[k] < p->fluid) != (k < row[2 * a + 1]))
                return false;
    return true;
}

/* ---- queries ---- */

ll_particle_view ll_particles_view(const ll_particles *p)
{
    return (ll_particle_view){.count = p->fluid,
                              .id = ll_part_id(p),
                              .x = ll_particle_values(p, LL_PARTICLE_X),
                              .y = ll_particle_values(p, LL_PARTICLE_Y),
                              .u = ll_particle_values(p, LL_PARTICLE_U),
                              .v = ll_particle_values(p, LL_PARTICLE_V),
                              .density = ll_particle_values(p, LL_PARTICLE_DENSITY),
                              .pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE)};
}

ll_particle_body ll_particles_body(const ll_particles *p)
{
    return p->body;
}

ll_particle_stats ll_particles_stats(const ll_particles *p)
{
    return (ll_particle_stats){.tick = p->tick,
                               .time = p->time,
                               .substeps = p->substeps,
                               .iterations = p->iterations,
                               .fluid = p->fluid,
                               .wall = p->wall - p->body_count,
                               .body = p->body_count,
                               .pairs = p->pairs};
}
