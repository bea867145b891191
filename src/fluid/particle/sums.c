#include <string.h>

#include "fluid/particle/state.h"

/* Limits the correction by a single pair: this fraction of the squared gradient of a steep pair. */
#define SOFT 0.05

/* Adami, Hu, Adams, J. Comput. Phys. 231 (2012), eq. 23: twice the wall's velocity minus the mean of the
 * surrounding fluid, so that the velocity vanishes on the wall. */
static void mirror_velocity(ll_particles *p, double *mu, double *mv)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p), *beside = ll_part_beside(p);
    const double *kernel = ll_part_kernel(p), *u = ll_particle_values(p, LL_PARTICLE_U),
                 *v = ll_particle_values(p, LL_PARTICLE_V);
    double *weight = ll_particle_values(p, LL_PARTICLE_SUM);
    size_t bytes = (size_t)p->wall * sizeof *mu;
    memset(weight + p->fluid, 0, bytes);
    memset(mu + p->fluid, 0, bytes);
    memset(mv + p->fluid, 0, bytes);
    for (int32_t i = 0; i < p->beside; i++) {
        int32_t a = beside[i];
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            mu[b] += u[a] * kernel[k];
            mv[b] += v[a] * kernel[k];
            weight[b] += kernel[k];
        }
    }
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++) {
        double scale = weight[b] > 0 ? 1 / weight[b] : 0;
        mu[b] = 2 * u[b] - mu[b] * scale;
        mv[b] = 2 * v[b] - mv[b] * scale;
    }
}

typedef struct viscous {
    ll_particles *p;
    double along;  /* artificial: acts on approach and separation only */
    double across; /* laminar: acts on the whole difference */
    double soft;   /* (0.1 h)^2 */
} viscous;

static inline void drag(const viscous *c, int32_t k, double du, double dv, double *fx, double *fy)
{
    const ll_particles *p = c->p;
    double ex = ll_part_ex(p)[k], ey = ll_part_ey(p)[k], slope = ll_part_slope(p)[k];
    double e2 = ex * ex + ey * ey, near = slope / (e2 + c->soft);
    double along = c->along * (du * ex + dv * ey) * near, across = c->across * e2 * near;
    *fx = along * ex + across * du;
    *fy = along * ey + across * dv;
}

LL_PARTICLE_VISIT(visit_viscosity)
{
    const viscous *c = context;
    const ll_particles *p = c->p;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    const double *mu = ll_particle_values(p, LL_PARTICLE_GX), *mv = ll_particle_values(p, LL_PARTICLE_GY);
    double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    double sx = 0, sy = 0, ua = u[a], va = v[a], fx, fy;
    for (int32_t k = row[2 * a]; k < row[2 * a + 1]; k++) {
        int32_t b = pair[k];
        if (!own && !ll_particle_takes(s, b, inside))
            continue;
        drag(c, k, ua - u[b], va - v[b], &fx, &fy);
        sx += fx;
        sy += fy;
        if (ll_particle_takes(s, b, inside)) {
            ax[b] -= fx;
            ay[b] -= fy;
        }
    }
    if (!own)
        return;
    for (int32_t k = row[2 * a + 1]; p->params.no_slip && k < row[2 * a + 2]; k++) {
        int32_t b = pair[k];
        drag(c, k, ua - mu[b], va - mv[b], &fx, &fy);
        sx += fx;
        sy += fy;
    }
    ax[a] += sx;
    ay[a] += sy;
}

static void viscosity_part(void *context, int part, int parts)
{
    viscous *c = context;
    ll_particle_share s = ll_particle_share_of(c->p, part, parts);
    ll_particle_each(&s, visit_viscosity, c);
}

/* What the viscosity of the fluid does to walls. */
static void drag_walls(const viscous *c)
{
    const ll_particles *p = c->p;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p), *beside = ll_part_beside(p);
    const double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    const double *mu = ll_particle_values(p, LL_PARTICLE_GX), *mv = ll_particle_values(p, LL_PARTICLE_GY);
    double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY), fx, fy;
    for (int32_t i = 0; i < p->beside; i++) {
        int32_t a = beside[i];
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            drag(c, k, u[a] - mu[b], v[a] - mv[b], &fx, &fy);
            ax[b] -= fx;
            ay[b] -= fy;
        }
    }
}

/* Monaghan's artificial viscosity (linear part, of approach and separation) and Morris, Fox, Zhu, J. Comput.
 * Phys. 136 (1997), eq. 22. */
void ll_particle_add_viscosity(ll_particles *p, ll_team *team)
{
    const ll_particle_params *q = &p->params;
    if (q->artificial_viscosity == 0 && q->viscosity == 0)
        return;
    double volume = p->setup.spacing * p->setup.spacing;
    viscous c = {.p = p,
                 .along = volume * q->artificial_viscosity * p->kernel.h * q->sound_speed,
                 .across = volume * 2 * q->viscosity * p->kernel.viscous_scale,
                 .soft = 0.01 * p->kernel.h * p->kernel.h};
    if (q->no_slip)
        mirror_velocity(p, ll_particle_values(p, LL_PARTICLE_GX), ll_particle_values(p, LL_PARTICLE_GY));
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, viscosity_part, &c);
    if (q->no_slip && p->body_count > 0)
        drag_walls(&c);
}

void ll_particle_rest(ll_particles *p)
{
    size_t bytes = (size_t)ll_particle_total(p) * sizeof(double);
    memset(ll_particle_values(p, LL_PARTICLE_AX), 0, bytes);
    memset(ll_particle_values(p, LL_PARTICLE_AY), 0, bytes);
}

/* ---- the rate of density ---- */

LL_PARTICLE_VISIT(visit_rate)
{
    const ll_particles *p = context;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *slope = ll_part_slope(p);
    const double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    double *rate = ll_particle_values(p, LL_PARTICLE_RATE);
    double sum = own ? rate[a] : 0, ua = u[a], va = v[a];
    int32_t k = row[2 * a];
    for (; k < row[2 * a + 1]; k++) {
        int32_t b = pair[k];
        double r = ((ua - u[b]) * ex[k] + (va - v[b]) * ey[k]) * slope[k];
        sum += r;
        if (ll_particle_takes(s, b, inside))
            rate[b] += r;
    }
    if (!own)
        return;
    for (; k < row[2 * a + 2]; k++)
        sum += ((ua - u[pair[k]]) * ex[k] + (va - v[pair[k]]) * ey[k]) * slope[k];
    rate[a] = sum * p->mass;
}

static void rate_part(void *context, int part, int parts)
{
    ll_particles *p = context;
    ll_particle_share s = ll_particle_share_of(p, part, parts);
    double *rate = ll_particle_values(p, LL_PARTICLE_RATE);
    memset(rate + s.begin, 0, (size_t)(s.end - s.begin) * sizeof *rate);
    ll_particle_each(&s, visit_rate, p);
}

void ll_particle_sum_rate(ll_particles *p, ll_team *team)
{
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, rate_part, p);
}

/* ---- density ---- */

/* Two sums of one particle at once. Each lane is one IEEE operation, so the bits equal those of scalars. */
typedef double two __attribute__((vector_size(16), may_alias));

typedef struct density_sums {
    two kernel_squares; /* of the kernel, and of its squared gradient */
    two gradient;
} density_sums;

typedef struct densities {
    ll_particles *p;
    density_sums *sums;
    double soft;
    bool moved;
} densities;

/* Pairs with walls, which do not move, and the result. */
static inline void finish_density(const densities *d, int32_t a, two sum, two gradient)
{
    const ll_particles *p = d->p;
    const int32_t *row = ll_part_row(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *slope = ll_part_slope(p);
    const double *kernel = ll_part_kernel(p);
    for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) {
        sum += (two){kernel[k], 0};
        gradient += slope[k] * (two){ex[k], ey[k]};
    }
    two squares = gradient * gradient;
    double mass = p->mass;
    ll_particle_values(p, LL_PARTICLE_DENSITY)[a] = mass * sum[0];
    ll_particle_values(p, LL_PARTICLE_FACTOR)[a] = mass * mass * (squares[0] + squares[1] + sum[1] + d->soft);
}

LL_PARTICLE_VISIT(visit_density)
{
    const densities *d = context;
    const ll_particles *p = d->p;
    const int32_t *row = ll_part_row(p) + 2 * (size_t)a, *pair = ll_part_pair(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *slope = ll_part_slope(p);
    const double *kernel = ll_part_kernel(p);
    density_sums *sums = d->sums; /* a store of `two` may be to anything, but not to what is local */
    two sum = {0}, gradient = {0};
    if (own) {
        sum = sums[a].kernel_squares + (two){p->kernel.scale, 0};
        gradient = sums[a].gradient;
    }
    for (int32_t k = row[0], end = row[1]; k < end; k++) {
        two g = slope[k] * (two){ex[k], ey[k]}, squares = g * g;
        two both = {kernel[k], squares[0] + squares[1]};
        int32_t b = pair[k];
        sum += both;
        gradient += g;
        if (ll_particle_takes(s, b, inside)) {
            density_sums *other = &sums[b];
            other->kernel_squares += both;
            other->gradient -= g;
        }
    }
    if (own)
        finish_density(d, a, sum, gradient);
}

/* A pair of a particle of another part, whose geometry that part computes meanwhile: by the same formulas. */
static void add_from_halo(const densities *d, int32_t a, const ll_particle_share *s)
{
    const ll_particles *p = d->p;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    for (int32_t k = row[2 * a]; k < row[2 * a + 1]; k++) {
        if (!ll_particle_takes(s, pair[k], false))
            continue;
        ll_particle_pair_geometry of = ll_particle_geometry_of(p, a, pair[k]);
        two g = of.slope * (two){of.ex, of.ey}, squares = g * g;
        d->sums[pair[k]].kernel_squares += (two){of.kernel, squares[0] + squares[1]};
        d->sums[pair[k]].gradient -= g;
    }
}

/* In blocks, so that the geometry that was just computed is read from the cache. */
static void density_part(void *context, int part, int parts)
{
    densities *d = context;
    ll_particle_share s = ll_particle_share_of(d->p, part, parts);
    memset(d->sums + s.begin, 0, (size_t)(s.end - s.begin) * sizeof *d->sums);
    for (int32_t a = s.halo; a < s.begin; a++)
        add_from_halo(d, a, &s);
    for (int32_t from = s.begin, to; from < s.end; from = to) {
        to = ll_particle_block_end(from, s.end);
        if (d->moved)
            ll_particle_geometry(d->p, from, to);
        int32_t tail = to < s.tail ? to : from > s.tail ? from : s.tail;
        for (int32_t a = from; a < tail; a++)
            visit_density(d, a, &s, true, true);
        for (int32_t a = tail; a < to; a++)
            visit_density(d, a, &s, true, false);
    }
}

void ll_particle_sum_density(ll_particles *p, bool moved, ll_team *team)
{
    double steep = p->kernel.slope_scale * p->kernel.h;
    densities d = {.p = p,
                   .sums = (density_sums *)(void *)ll_particle_values(p, LL_PARTICLE_RATE),
                   .soft = SOFT * steep * steep,
                   .moved = moved};
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, density_part, &d);
}

/* ---- pressure ---- */

/* Adami eq. 27 for k: includes the weight of the fluid between, unless there is no pressure to carry it. */
void ll_particle_mirror(ll_particles *p, double *pressure_factor, double volume)
{
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p), *id = ll_part_id(p);
    const int32_t *beside = ll_part_beside(p);
    const double *ex = ll_part_ex(p), *ey = ll_part_ey(p), *kernel = ll_part_kernel(p);
    double *sum = ll_particle_values(p, LL_PARTICLE_GX);
    size_t bytes = (size_t)p->wall * sizeof *pressure_factor;
    memset(pressure_factor + p->fluid, 0, bytes);
    memset(sum + p->fluid, 0, bytes);
    for (int32_t i = 0; i < p->beside; i++) {
        int32_t a = beside[i];
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++) {
            int32_t b = pair[k];
            double gx = p->params.gravity_x - (id[b] < -1 ? p->motion.ax : 0);
            double gy = p->params.gravity_y - (id[b] < -1 ? p->motion.ay : 0);
            double between = pressure_factor[a] > 0 ? volume * (gx * ex[k] + gy * ey[k]) : 0;
            pressure_factor[b] += (pressure_factor[a] - between) * kernel[k];
            sum[b] += kernel[k];
        }
    }
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++)
        pressure_factor[b] = sum[b] > 0 ? pressure_factor[b] / sum[b] : 0;
}

/* What a pass reads, and adds. */
typedef struct pressure_pass {
    ll_particles *p;
    const double *pressure_factor;
} pressure_pass;

LL_PARTICLE_VISIT(visit_pressure)
{
    const pressure_pass *q = context;
    const ll_particles *p = q->p;
    const int32_t *row = ll_part_row(p), *pair = ll_part_pair(p);
    const double *kernel = ll_part_kernel(p), *pressure_factor = q->pressure_factor;
    double *pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE);
    double sum = own ? pressure[a] + pressure_factor[a] * p->kernel.scale : 0;
    int32_t k = row[2 * a];
    for (; k < row[2 * a + 1]; k++) {
        sum += pressure_factor[pair[k]] * kernel[k];
        if (ll_particle_takes(s, pair[k], inside))
            pressure[pair[k]] += pressure_factor[a] * kernel[k];
    }
    if (!own)
        return;
    for (; k < row[2 * a + 2]; k++)
        sum += pressure_factor[pair[k]] * kernel[k];
    pressure[a] = p->params.density * p->mass * p->kernel.gradient_scale * sum;
}

static void pressure_part(void *context, int part, int parts)
{
    pressure_pass *q = context;
    ll_particle_share s = ll_particle_share_of(q->p, part, parts);
    double *pressure = ll_particle_values(q->p, LL_PARTICLE_PRESSURE);
    memset(pressure + s.begin, 0, (size_t)(s.end - s.begin) * sizeof *pressure);
    ll_particle_each(&s, visit_pressure, q);
}

/* A multiplier is not the pressure at its particle. On a displacement u all multipliers together do the work
 * sum of m k_a drho_a, and drho_a is -rho times the kernel's mean of div u around a, scaled as the gradient
 * is. The pressure, which is the work per div u, is therefore the field rho sum of m k_b W(x - x_b).
 * Differences between multipliers that this field does not show have no effect (Bonet and Lok, Comput.
 * Methods Appl. Mech. Eng. 180 (1999)). */
void ll_particle_field_pressure(ll_particles *p, const double *pressure_factor, ll_team *team)
{
    pressure_pass q = {p, pressure_factor};
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, pressure_part, &q);
}

/* What the inner loops read of the pairs. Local: a store of `two` may be to anything, and pointers in the
 * block would be read again for each pair. */
typedef struct gradients {
    const int32_t *pair;
    const double *ex, *ey, *slope;
} gradients;

static inline gradients gradients_of(const ll_particles *p)
{
    return (gradients){ll_part_pair(p), ll_part_ex(p), ll_part_ey(p), ll_part_slope(p)};
}

/* Of pair k; `sum`: of the multipliers of both. */
static inline two push_of(const gradients *g, double mass, double sum, int32_t k)
{
    return mass * sum * g->slope[k] * (two){g->ex[k], g->ey[k]};
}

static inline two *pushes(const ll_particles *p)
{
    return (two *)(void *)ll_particle_values(p, LL_PARTICLE_GX);
}

LL_PARTICLE_VISIT(visit_push)
{
    const pressure_pass *q = context;
    const ll_particles *p = q->p;
    const gradients g = gradients_of(p);
    const int32_t *row = ll_part_row(p) + 2 * (size_t)a;
    const double *of = q->pressure_factor;
    double mass = p->mass, mine = of[a];
    two sum = {0, 0}, *push = pushes(p);
    int32_t k = row[0], walls = row[1], end = row[2];
    for (; k < walls; k++) {
        int32_t b = g.pair[k];
        two f = push_of(&g, mass, mine + of[b], k);
        sum += f;
        if (ll_particle_takes(s, b, inside))
            push[b] += f;
    }
    if (!own)
        return;
    for (; k < end; k++)
        sum += push_of(&g, mass, mine + of[g.pair[k]], k);
    push[a] -= sum;
    ll_particle_values(p, LL_PARTICLE_AX)[a] = push[a][0];
    ll_particle_values(p, LL_PARTICLE_AY)[a] = push[a][1];
}

static void push_part(void *context, int part, int parts)
{
    pressure_pass *q = context;
    ll_particle_share s = ll_particle_share_of(q->p, part, parts);
    memset(pushes(q->p) + s.begin, 0, (size_t)(s.end - s.begin) * sizeof(two));
    ll_particle_each(&s, visit_push, q);
}

static void push_walls(const pressure_pass *q)
{
    const ll_particles *p = q->p;
    const gradients g = gradients_of(p);
    const int32_t *row = ll_part_row(p), *beside = ll_part_beside(p);
    const double *of = q->pressure_factor;
    two *push = pushes(p);
    memset(push + p->fluid, 0, (size_t)p->wall * sizeof *push);
    for (int32_t i = 0; i < p->beside; i++) {
        int32_t a = beside[i];
        for (int32_t k = row[2 * a + 1]; k < row[2 * a + 2]; k++)
            push[g.pair[k]] += push_of(&g, p->mass, of[a] + of[g.pair[k]], k);
    }
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++) {
        ll_particle_values(p, LL_PARTICLE_AX)[b] = push[b][0];
        ll_particle_values(p, LL_PARTICLE_AY)[b] = push[b][1];
    }
}

void ll_particle_push(ll_particles *p, const double *pressure_factor, ll_team *team)
{
    pressure_pass q = {p, pressure_factor};
    ll_team_run(team, p->fluid, LL_PARTICLE_TEAM, push_part, &q);
    if (p->body_count > 0)
        push_walls(&q);
}
