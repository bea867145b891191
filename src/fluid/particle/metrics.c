#include <math.h>

#include "fluid/particle/state.h"

static bool held(const ll_particle_setup *s, double x, double y)
{
    return !((s->walls & LL_WALL_LEFT && x < 0) || (s->walls & LL_WALL_RIGHT && x > s->width) ||
             (s->walls & LL_WALL_BOTTOM && y < 0) || (s->walls & LL_WALL_TOP && y > s->height));
}

static void compare_pressure(const ll_particles *p, double depth, ll_particle_metrics *m)
{
    const double *y = ll_particle_values(p, LL_PARTICLE_Y),
                 *pressure = ll_particle_values(p, LL_PARTICLE_PRESSURE);
    double weight = -p->params.density * p->params.gravity_y, squares = 0;
    if (!(depth > 0) || !(weight > 0))
        return;
    for (int32_t a = 0; a < p->fluid; a++) {
        double error = pressure[a] / weight - (depth - y[a]);
        squares += error * error;
    }
    m->pressure_rms = sqrt(squares / p->fluid) / depth;
}

ll_particle_metrics ll_particles_measure(const ll_particles *p, double depth)
{
    const ll_particle_setup *s = &p->setup;
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    const double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    const double *density = ll_particle_values(p, LL_PARTICLE_DENSITY);
    ll_particle_metrics m = {.front = -INFINITY, .height = 0};
    double mass = p->mass, half = s->spacing / 2;
    for (int32_t a = 0; a < p->fluid; a++) {
        double square = u[a] * u[a] + v[a] * v[a], over = density[a] / p->params.density - 1;
        m.front = fmax(m.front, x[a] + half);
        if (x[a] < 2 * s->spacing)
            m.height = fmax(m.height, y[a] + half);
        m.mass += held(s, x[a], y[a]) ? mass : 0;
        m.momentum_x += mass * u[a];
        m.momentum_y += mass * v[a];
        m.kinetic_energy += mass * square / 2;
        m.potential_energy -= mass * (p->params.gravity_x * x[a] + p->params.gravity_y * y[a]);
        m.density_mean += over > 0 ? over : 0;
        m.density_max = fmax(m.density_max, over);
        m.speed_max = fmax(m.speed_max, square);
    }
    m.density_mean /= p->fluid;
    m.speed_max = sqrt(m.speed_max);
    const int32_t *row = ll_part_row(p);
    for (int32_t a = 0; p->substeps > 0 && a < p->fluid; a++) /* a pair of fluid particles counts for both */
        m.neighbours += (row[2 * a + 1] - row[2 * a]) + (row[2 * a + 2] - row[2 * a]);
    m.neighbours /= p->fluid;
    compare_pressure(p, depth, &m);
    return m;
}
