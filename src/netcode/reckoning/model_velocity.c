/* Velocity (DIS: FPW): an entity goes on at its velocity, without turning. */
#include "netcode/reckoning/reckoning.h"

static void at(const ll_reckoned *sent, double s, ll_entity *out)
{
    *out = sent->entity;
    out->x += sent->entity.vx * s;
    out->y += sent->entity.vy * s;
    out->angular_velocity = 0;
}

const ll_reckoning_model ll_reckoning_velocity = {
    .name = "velocity", .help = "It goes on at its velocity, without turning.", .at = at};
