#include <string.h>

#include "fluid/particle/state.h"

/* Limits the correction by a single pair: this fraction of the squared gradient of a steep pair. */
#define SOFT 0.05

static void clear(const ll_particles *p, ll_particle_field field)
{
    memset(ll_particle_values(p, field), 0, (size_t)ll_particle_total(p) * sizeof(double));
}

/* Adami, Hu, Adams, J. Comput. Phys. 231 (2012), eq. 23: twice the wall's velocity minus the mean of the
 * surrounding fluid, so that the velocity vanishes on the wall. */
static void mirror_velocity(ll_particles *p, double *mu, double *mv)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *kernel = ll_part_kernel(p), *u = ll_particle_values(p, LL_PARTICLE_U),
                 *v = ll_particle_values(p, LL_PARTICLE_V);
    double *weight = ll_particle_values(p, LL_PARTICLE_SUM);
    clear(p, LL_PARTICLE_SUM);
    memset(mu, 0, (size_t)ll_particle_total(p) * sizeof *mu);
    memset(mv, 0, (size_t)ll_particle_total(p) * sizeof *mv);
    for (int32_t a = 0; a < p->fluid; a++)
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            mu[b] += u[a] * kernel[k];
            mv[b] += v[a] * kernel[k];
            weight[b] += kernel[k];
        }
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++) {
        double scale = weight[b] > 0 ? 1 / weight[b] : 0;
        mu[b] = 2 * u[b] - mu[b] * scale;
        mv[b] = 2 * v[b] - mv[b] * scale;
    }
}

typedef struct viscous {
    double along;  /* artificial: acts on approach and separation only */
    double across; /* laminar: acts on the whole difference */
    double soft;   /* (0.1 h)^2 */
} viscous;

static inline void drag(const ll_particles *p, const viscous *c, int32_t k, double du, double dv, double *fx,
                        double *fy)
{
    double ex = ll_part_ex(p)[k], ey = ll_part_ey(p)[k], slope = ll_part_slope(p)[k];
    double e2 = ex * ex + ey * ey, near = slope / (e2 + c->soft);
    double along = c->along * (du * ex + dv * ey) * near, across = c->across * e2 * near;
    *fx = along * ex + across * du;
    *fy = along * ey + across * dv;
}

/* Monaghan's artificial viscosity (linear part, of approach and separation) and Morris, Fox, Zhu, J. Comput.
 * Phys. 136 (1997), eq. 22. */
void ll_particle_add_viscosity(ll_particles *p)
{
    const ll_particle_params *q = &p->params;
    if (q->artificial_viscosity == 0 && q->viscosity == 0)
        return;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    double *mu = ll_particle_values(p, LL_PARTICLE_GX), *mv = ll_particle_values(p, LL_PARTICLE_GY);
    double volume = p->setup.spacing * p->setup.spacing;
    viscous c = {.along = volume * q->artificial_viscosity * p->kernel.h * q->sound_speed,
                 .across = volume * 2 * q->viscosity * p->kernel.viscous_scale,
                 .soft = 0.01 * p->kernel.h * p->kernel.h};
    if (q->no_slip)
        mirror_velocity(p, mu, mv);
    for (int32_t a = 0; a < p->fluid; a++) {
        double sx = 0, sy = 0, ua = u[a], va = v[a], fx, fy;
        for (int32_t k = row[2 * a]; k < row[2 * a + 1]; k++) {
            int32_t b = pair[k];
            drag(p, &c, k, ua - u[b], va - v[b], &fx, &fy);
            sx += fx;
            sy += fy;
            ax[b] -= fx;
            ay[b] -= fy;
        }
        for (int32_t k = row[2 * a + 1]; q->no_slip && k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            drag(p, &c, k, ua - mu[b], va - mv[b], &fx, &fy);
            sx += fx;
            sy += fy;
            ax[b] -= fx;
            ay[b] -= fy;
        }
        ax[a] += sx;
        ay[a] += sy;
    }
}

void ll_particle_sum_rate(ll_particles *p)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *slope = ll_part_slope(p);
    const double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    double *rate = ll_particle_values(p, LL_PARTICLE_RATE), mass = p->mass;
    clear(p, LL_PARTICLE_RATE);
    for (int32_t a = 0; a < p->fluid; a++) {
        double sum = rate[a], ua = u[a], va = v[a];
        for (int32_t k = row[2 * a]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            double r = ((ua - u[b]) * ex[k] + (va - v[b]) * ey[k]) * slope[k];
            sum += r;
            rate[b] += r;
        }
        rate[a] = sum * mass;
    }
}

/* Two sums of one particle at once. Each lane is one IEEE operation, so the bits equal those of scalars. */
typedef double two __attribute__((vector_size(16), may_alias));

typedef struct density_sums {
    two kernel_squares; /* of the kernel, and of its squared gradient */
    two gradient;
} density_sums;

static void add_densities(ll_particles *p, density_sums *sums, int32_t from, int32_t to)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *slope = ll_part_slope(p);
    const double *kernel = ll_part_kernel(p);
    double *density = ll_particle_values(p, LL_PARTICLE_DENSITY),
           *factor = ll_particle_values(p, LL_PARTICLE_FACTOR);
    double steep = p->kernel.slope_scale * p->kernel.h, soft = SOFT * steep * steep, mass = p->mass;
    for (int32_t a = from; a < to; a++) {
        two sum = sums[a].kernel_squares + (two){p->kernel.scale, 0}, gradient = sums[a].gradient;
        for (int32_t k = row[2 * a]; k < row[2 * a + 1]; k++) {
            density_sums *other = &sums[pair[k]];
            two g = slope[k] * (two){ex[k], ey[k]}, squares = g * g;
            two both = {kernel[k], squares[0] + squares[1]};
            sum += both;
            gradient += g;
            other->kernel_squares += both;
            other->gradient -= g;
        }
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) { /* walls do not move */
            sum += (two){kernel[k], 0};
            gradient += slope[k] * (two){ex[k], ey[k]};
        }
        two squares = gradient * gradient;
        density[a] = mass * sum[0];
        factor[a] = mass * mass * (squares[0] + squares[1] + sum[1] + soft);
    }
}

void ll_particle_sum_density(ll_particles *p, bool moved)
{
    density_sums *sums = (density_sums *)(void *)ll_particle_values(p, LL_PARTICLE_RATE);
    memset(sums, 0, (size_t)p->fluid * sizeof *sums);
    for (int32_t from = 0; from < p->fluid; from += LL_PARTICLE_BLOCK) {
        int32_t to = ll_particle_block_end(p, from);
        if (moved)
            ll_particle_geometry(p, from, to);
        add_densities(p, sums, from, to);
    }
}

/* Adami eq. 27 for k: includes the weight of the fluid between, unless there is no pressure to carry it. */
void ll_particle_mirror(ll_particles *p, double *pressure_factor, double volume)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p), *id = ll_part_id(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *kernel = ll_part_kernel(p);
    double *sum = ll_particle_values(p, LL_PARTICLE_GX);
    size_t bytes = (size_t)p->wall * sizeof *pressure_factor;
    memset(pressure_factor + p->fluid, 0, bytes);
    memset(sum + p->fluid, 0, bytes);
    for (int32_t a = 0; a < p->fluid; a++)
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            double gx = p->params.gravity_x - (id[b] < -1 ? p->motion.ax : 0);
            double gy = p->params.gravity_y - (id[b] < -1 ? p->motion.ay : 0);
            double between = pressure_factor[a] > 0 ? volume * (gx * ex[k] + gy * ey[k]) : 0;
            pressure_factor[b] += (pressure_factor[a] - between) * kernel[k];
            sum[b] += kernel[k];
        }
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++)
        pressure_factor[b] = sum[b] > 0 ? pressure_factor[b] / sum[b] : 0;
}

/* A multiplier is not the pressure at its particle. On a displacement u all multipliers together do the work
 * sum of m k_a drho_a, and drho_a is -rho times the kernel's mean of div u around a, scaled as the gradient
 * is. The pressure, which is the work per div u, is therefore the field rho sum of m k_b W(x - x_b).
 * Differences between multipliers that this field does not show have no effect (Bonet and Lok, Comput.
 * Methods Appl. Mech. Eng. 180 (1999)). */
void ll_particle_field_pressure(ll_particles *p, const double *pressure_factor)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *kernel = ll_part_kernel(p);
    double *pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE);
    double scale = p->params.density * p->mass * p->kernel.gradient_scale;
    clear(p, LL_PARTICLE_PRESSURE);
    for (int32_t a = 0; a < p->fluid; a++) {
        double sum = pressure[a] + pressure_factor[a] * p->kernel.scale;
        for (int32_t k = row[2 * a]; k < row[2 * a + 2]; k++) {
            sum += pressure_factor[pair[k]] * kernel[k];
            pressure[pair[k]] += pressure_factor[a] * kernel[k];
        }
        pressure[a] = scale * sum;
    }
}

void ll_particle_push(ll_particles *p, const double *pressure_factor)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *slope = ll_part_slope(p);
    double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY),
           mass = p->mass;
    two *push = (two *)(void *)ll_particle_values(p, LL_PARTICLE_GX);
    memset(push, 0, (size_t)ll_particle_total(p) * sizeof *push);
    for (int32_t a = 0; a < p->fluid; a++) {
        two sum = {0, 0};
        double ka = pressure_factor[a];
        for (int32_t k = row[2 * a]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            two f = mass * (ka + pressure_factor[b]) * slope[k] * (two){ex[k], ey[k]};
            sum += f;
            push[b] += f;
        }
        push[a] -= sum;
    }
    for (int32_t a = 0; a < ll_particle_total(p); a++) {
        ax[a] = push[a][0];
        ay[a] = push[a][1];
    }
}
