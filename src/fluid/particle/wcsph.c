/* Weakly compressible SPH with density diffusion (delta-SPH).
 *
 * Monaghan, J. Comput. Phys. 110 (1994): Tait's equation of state. Molteni and Colagrossi, Comput. Phys.
 * Commun. 180 (2009): diffusion; Fourtakas et al., Comput. Fluids 190 (2019): of the dynamic part of density
 * only. Adami, Hu, Adams, J. Comput. Phys. 231 (2012): wall pressure. Density uses the velocity after the
 * forces (semi-implicit), which keeps the scheme stable without damping. */
#include <string.h>

#include "fluid/particle/state.h"

static double dt_limit(const ll_particles *p, double speed)
{
    return 0.25 * p->kernel.h / (p->params.sound_speed + speed);
}

static void pressure_of_fluid(ll_particles *p)
{
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    double *pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE), rest = p->params.density;
    double stiffness = rest * p->params.sound_speed * p->params.sound_speed / 7;
    for (int32_t a = 0; a < p->fluid; a++) {
        double r = density[a] / rest, r2 = r * r;
        pressure[a] = stiffness * (r2 * r2 * r2 * r - 1);
    }
}

/* Adami eq. 27: mean pressure of the surrounding fluid, with the weight of the fluid between. */
static void pressure_of_walls(ll_particles *p)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p), *id = ll_part_id(p);
    const int32_t *beside = ll_part_beside(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *kernel = ll_part_kernel(p);
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    double *pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE),
           *weight = ll_particle_values(p, LL_PARTICLE_SUM);
    int32_t total = ll_particle_total(p);
    memset(pressure + p->fluid, 0, (size_t)p->wall * sizeof *pressure);
    memset(weight + p->fluid, 0, (size_t)p->wall * sizeof *weight);
    for (int32_t i = 0; i < p->beside; i++) {
        int32_t a = beside[i];
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            double gx = p->params.gravity_x - (id[b] < -1 ? p->motion.ax : 0);
            double gy = p->params.gravity_y - (id[b] < -1 ? p->motion.ay : 0);
            pressure[b] += (pressure[a] - density[a] * (gx * ex[k] + gy * ey[k])) * kernel[k];
            weight[b] += kernel[k];
        }
    }
    for (int32_t b = p->fluid; b < total; b++) {
        double mean = weight[b] > 0 ? pressure[b] / weight[b] : 0;
        pressure[b] = mean > 0 ? mean : 0; /* no tension at walls */
    }
}

/* Of a particle on others. */
typedef struct source {
    const double *pressure, *density, *slope;
    double volume, own;
} source;

static inline source source_of(const ll_particles *p, int32_t a)
{
    source s = {.pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE),
                .density = ll_particle_values(p, LL_PARTICLE_DENSITY),
                .slope = ll_part_slope(p)};
    s.volume = p->mass / s.density[a];
    s.own = s.pressure[a];
    return s;
}

static inline double force(const source *s, int32_t b, int32_t k)
{
    return s->volume / s->density[b] * (s->own + s->pressure[b]) * s->slope[k];
}

LL_PARTICLE_VISIT(visit_force)
{
    const ll_particles *p = context;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p);
    double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    double sx = 0, sy = 0;
    source from = source_of(p, a);
    int32_t k = row[2 * a];
    for (; k < row[2 * a + 1]; k++) {
        int32_t b = pair[k];
        double f = force(&from, b, k), fx = f * ex[k], fy = f * ey[k];
        sx += fx;
        sy += fy;
        if (ll_particle_takes(s, b, inside)) {
            ax[b] += fx;
            ay[b] += fy;
        }
    }
    if (!own)
        return;
    for (; k < row[2 * a + 2]; k++) {
        double f = force(&from, pair[k], k), fx = f * ex[k], fy = f * ey[k];
        sx += fx;
        sy += fy;
    }
    ax[a] -= sx;
    ay[a] -= sy;
}

static void force_part(void *context, int part, int parts)
{
    ll_particles *p = context;
    ll_particle_share s = ll_particle_share_of(p, part, parts);
    ll_particle_each(&s, visit_force, p);
}

static void push_walls(ll_particles *p)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p), *beside = ll_part_beside(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p);
    double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    for (int32_t i = 0; i < p->beside; i++) {
        int32_t a = beside[i];
        source from = source_of(p, a);
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) {
            double f = force(&from, pair[k], k);
            ax[pair[k]] += f * ex[k];
            ay[pair[k]] += f * ey[k];
        }
    }
}

static void accelerate(ll_particles *p, ll_team *team)
{
    ll_particle_rest(p);
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, force_part, p);
    if (p->body_count > 0)
        push_walls(p);
    ll_particle_add_viscosity(p, team);
}

typedef struct diffusion {
    ll_particles *p;
    double scale;
} diffusion;

LL_PARTICLE_VISIT(visit_flow)
{
    const diffusion *d = context;
    const ll_particles *p = d->p;
    const ll_particle_params *q = &p->params;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *slope = ll_part_slope(p);
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    const double *steep = ll_particle_values(p, LL_PARTICLE_SUM);
    double *rate = ll_particle_values(p, LL_PARTICLE_RATE);
    for (int32_t k = row[2 * a]; k < row[2 * a + 1]; k++) {
        int32_t b = pair[k];
        double rest = (steep[a] + steep[b]) * (q->gravity_x * ex[k] + q->gravity_y * ey[k]);
        double flow = d->scale * (density[a] - density[b] - rest) * slope[k];
        if (own)
            rate[a] += flow;
        if (ll_particle_takes(s, b, inside))
            rate[b] -= flow;
    }
}

static void flow_part(void *context, int part, int parts)
{
    diffusion *d = context;
    ll_particle_share s = ll_particle_share_of(d->p, part, parts);
    ll_particle_each(&s, visit_flow, d);
}

/* Adds delta h c times the sum of 2 (rho_a - rho_b - hydrostatic difference) volume e grad W / e^2. The
 * difference is that of Tait's equation at its density: drho/dp = (rho0 / rho)^6 / c^2, dp/dy = rho g. A
 * linear difference would cause a pressure error of 3 g H / c^2 in a column. */
static void diffuse(ll_particles *p, ll_team *team)
{
    const ll_particle_params *q = &p->params;
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    double *steep = ll_particle_values(p, LL_PARTICLE_SUM);
    double half = q->density / (2 * q->sound_speed * q->sound_speed);
    for (int32_t a = 0; a < p->fluid; a++) {
        double r = q->density / density[a], r2 = r * r;
        steep[a] = half * r2 * r2 * r;
    }
    diffusion d = {p, 2 * q->diffusion * p->kernel.h * q->sound_speed * p->setup.spacing * p->setup.spacing};
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, flow_part, &d);
}

static ll_particle_fault substep(ll_particles *p, double dt, const ll_fluid_run *run)
{
    const ll_particle_params *q = &p->params;
    ll_particle_sort_fluid(p);
    ll_particle_fault fault = ll_particle_pairs(p, p->kernel.support, run->team);
    if (fault.reason != NULL)
        return fault;
    double *density = ll_particle_values(p, LL_PARTICLE_DENSITY),
           *rate = ll_particle_values(p, LL_PARTICLE_RATE);
    double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    const double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++)
        density[b] = q->density;
    pressure_of_fluid(p);
    pressure_of_walls(p);
    accelerate(p, run->team);
    ll_particle_body_push(p, dt);
    if (q->lagged_density)
        ll_particle_sum_rate(p, run->team);
    for (int32_t a = 0; a < p->fluid; a++) {
        u[a] += dt * (ax[a] + q->gravity_x);
        v[a] += dt * (ay[a] + q->gravity_y);
    }
    if (!q->lagged_density)
        ll_particle_sum_rate(p, run->team);
    if (q->diffusion > 0)
        diffuse(p, run->team);
    for (int32_t a = 0; a < p->fluid; a++) {
        density[a] += dt * rate[a];
        x[a] += dt * u[a];
        y[a] += dt * v[a];
    }
    p->iterations++;
    return (ll_particle_fault){0};
}

/* Pressure from density by Tait's equation, density from the divergence of velocity, with density
 * diffusion (delta-SPH). No solver: four passes over pairs per substep, but substeps must be as short as
 * sound needs to cross a quarter of h (Monaghan 1994; Antuono et al. 2010). */
const ll_particle_method ll_particle_wcsph = {
    .travel = 0.5,
    .dt_limit = dt_limit,
    .substep = substep,
};
