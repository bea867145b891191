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
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *kernel = ll_part_kernel(p);
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    double *pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE),
           *weight = ll_particle_values(p, LL_PARTICLE_SUM);
    int32_t total = ll_particle_total(p);
    memset(pressure + p->fluid, 0, (size_t)p->wall * sizeof *pressure);
    memset(weight, 0, (size_t)total * sizeof *weight);
    for (int32_t a = 0; a < p->fluid; a++)
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            double gx = p->params.gravity_x - (id[b] < -1 ? p->motion.ax : 0);
            double gy = p->params.gravity_y - (id[b] < -1 ? p->motion.ay : 0);
            pressure[b] += (pressure[a] - density[a] * (gx * ex[k] + gy * ey[k])) * kernel[k];
            weight[b] += kernel[k];
        }
    for (int32_t b = p->fluid; b < total; b++) {
        double mean = weight[b] > 0 ? pressure[b] / weight[b] : 0;
        pressure[b] = mean > 0 ? mean : 0; /* no tension at walls */
    }
}

static void accelerate(ll_particles *p)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *slope = ll_part_slope(p);
    const double *pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE),
                 *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    size_t bytes = (size_t)ll_particle_total(p) * sizeof *ax;
    memset(ax, 0, bytes);
    memset(ay, 0, bytes);
    for (int32_t a = 0; a < p->fluid; a++) {
        double sx = 0, sy = 0, volume = p->mass / density[a], pa = pressure[a];
        for (int32_t k = row[2 * a]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            double f = volume / density[b] * (pa + pressure[b]) * slope[k], fx = f * ex[k], fy = f * ey[k];
            sx += fx;
            sy += fy;
            ax[b] += fx;
            ay[b] += fy;
        }
        ax[a] -= sx;
        ay[a] -= sy;
    }
    ll_particle_add_viscosity(p);
}

/* Adds delta h c times the sum of 2 (rho_a - rho_b - hydrostatic difference) volume e grad W / e^2. The
 * difference is that of Tait's equation at its density: drho/dp = (rho0 / rho)^6 / c^2, dp/dy = rho g. A
 * linear difference would cause a pressure error of 3 g H / c^2 in a column. */
static void diffuse(ll_particles *p)
{
    const ll_particle_params *q = &p->params;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *slope = ll_part_slope(p);
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    double *rate = ll_particle_values(p, LL_PARTICLE_RATE), *steep = ll_particle_values(p, LL_PARTICLE_SUM);
    double scale = 2 * q->diffusion * p->kernel.h * q->sound_speed * p->setup.spacing * p->setup.spacing;
    double half = q->density / (2 * q->sound_speed * q->sound_speed);
    for (int32_t a = 0; a < p->fluid; a++) {
        double r = q->density / density[a], r2 = r * r;
        steep[a] = half * r2 * r2 * r;
    }
    for (int32_t a = 0; a < p->fluid; a++)
        for (int32_t k = row[2 * a]; k < row[2 * a + 1]; k++) {
            int32_t b = pair[k];
            double rest = (steep[a] + steep[b]) * (q->gravity_x * ex[k] + q->gravity_y * ey[k]);
            double flow = scale * (density[a] - density[b] - rest) * slope[k];
            rate[a] += flow;
            rate[b] -= flow;
        }
}

static ll_particle_fault substep(ll_particles *p, double dt, ll_pace *pace)
{
    (void)pace; /* nothing is iterated */
    const ll_particle_params *q = &p->params;
    ll_particle_sort_fluid(p);
    ll_particle_fault fault = ll_particle_pairs(p, p->kernel.support);
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
    accelerate(p);
    ll_particle_body_push(p, dt);
    if (q->lagged_density)
        ll_particle_sum_rate(p);
    for (int32_t a = 0; a < p->fluid; a++) {
        u[a] += dt * (ax[a] + q->gravity_x);
        v[a] += dt * (ay[a] + q->gravity_y);
    }
    if (!q->lagged_density)
        ll_particle_sum_rate(p);
    if (q->diffusion > 0)
        diffuse(p);
    for (int32_t a = 0; a < p->fluid; a++) {
        density[a] += dt * rate[a];
        x[a] += dt * u[a];
        y[a] += dt * v[a];
    }
    p->iterations++;
    return (ll_particle_fault){0};
}

const ll_particle_method ll_particle_wcsph = {
    .name = "wcsph",
    .help = "Pressure from density by Tait's equation, density from the divergence of velocity, with density "
            "diffusion (delta-SPH). No solver: four passes over pairs per substep, but substeps must be as "
            "short as sound needs to cross a quarter of h (Monaghan 1994; Antuono et al. 2010).",
    .travel = 0.5,
    .dt_limit = dt_limit,
    .substep = substep,
};
