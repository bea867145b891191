/* Velocity and spin (DIS: RPW): an entity goes on at its velocity and angular velocity. */
#include "netcode/reckoning/reckoning.h"

static void at(const ll_reckoned *sent, double s, ll_entity *out)
{
    *out = sent->entity;
    out->x += sent->entity.vx * s;
    out->y += sent->entity.vy * s;
    out->angle += sent->entity.angular_velocity * s;
}

const ll_reckoning_model ll_reckoning_spin = {
    .name = "velocity_spin", .help = "It goes on at its velocity and angular velocity.", .at = at};
