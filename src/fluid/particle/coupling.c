/* The moving body: a rectangle of particles that fluid pushes and that moves its particles.
 *
 * Momentum is exchanged pair by pair, so that the body gains what the fluid loses. It is collected after each
 * solve and moves the body at the end of the substep (staggered). This is stable for bodies that are not much
 * lighter than the fluid that they move. */
#include "base/detmath.h"
#include "fluid/particle/state.h"

void ll_particle_body_place(ll_particles *p)
{
    const int32_t *id = ll_part_id(p);
    const double *local = ll_part_local(p);
    const ll_particle_body *body = &p->body;
    double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    double *u = ll_particle_values(p, LL_PARTICLE_U), *v = ll_particle_values(p, LL_PARTICLE_V);
    double c = ll_cos(body->angle), s = ll_sin(body->angle);
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++) {
        if (id[b] >= -1)
            continue;
        const double *l = local + 2 * (-2 - id[b]);
        double rx = c * l[0] - s * l[1], ry = s * l[0] + c * l[1];
        x[b] = body->x + rx;
        y[b] = body->y + ry;
        u[b] = body->u - body->angular_velocity * ry;
        v[b] = body->v + body->angular_velocity * rx;
    }
}

void ll_particle_body_push(ll_particles *p, double dt)
{
    if (p->body_count == 0)
        return;
    const int32_t *id = ll_part_id(p);
    const double *ax = ll_particle_values(p, LL_PARTICLE_AX), *ay = ll_particle_values(p, LL_PARTICLE_AY);
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    ll_particle_body *body = &p->body;
    double fx = 0, fy = 0, torque = 0;
    for (int32_t b = p->fluid; b < ll_particle_total(p); b++) {
        if (id[b] >= -1)
            continue;
        fx += ax[b];
        fy += ay[b];
        torque += (x[b] - body->x) * ay[b] - (y[b] - body->y) * ax[b];
    }
    body->u += dt * p->mass * fx / body->mass;
    body->v += dt * p->mass * fy / body->mass;
    body->angular_velocity += dt * p->mass * torque / body->inertia;
}

/* Clamps the position to [0, size] at sides with walls. */
static void hold(double *place, double *velocity, double reach, double size, int low, int high)
{
    if (low && *place < reach) {
        *place = reach;
        *velocity = *velocity > 0 ? *velocity : 0;
    }
    if (high && *place > size - reach) {
        *place = size - reach;
        *velocity = *velocity < 0 ? *velocity : 0;
    }
}

void ll_particle_body_move(ll_particles *p, double dt)
{
    if (p->body_count == 0)
        return;
    ll_particle_body *body = &p->body;
    const ll_particle_setup *setup = &p->setup;
    body->u += dt * p->params.gravity_x;
    body->v += dt * p->params.gravity_y;
    body->x += dt * body->u;
    body->y += dt * body->v;
    body->angle += dt * body->angular_velocity;
    double c = ll_cos(body->angle), s = ll_sin(body->angle);
    double w = setup->body.width / 2, h = setup->body.height / 2;
    hold(&body->x, &body->u, __builtin_fabs(c) * w + __builtin_fabs(s) * h, setup->width,
         setup->walls & LL_WALL_LEFT, setup->walls & LL_WALL_RIGHT);
    hold(&body->y, &body->v, __builtin_fabs(s) * w + __builtin_fabs(c) * h, setup->height,
         setup->walls & LL_WALL_BOTTOM, setup->walls & LL_WALL_TOP);
    p->motion.ax = (body->u - p->motion.u0) / dt;
    p->motion.ay = (body->v - p->motion.v0) / dt;
    p->motion.u0 = body->u;
    p->motion.v0 = body->v;
    ll_particle_body_place(p);
    ll_particle_sort_walls(p);
}
