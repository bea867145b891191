/* Acceleration (DIS: RVW): as velocity and spin, with the acceleration that the entity had when it was sent.
 * The server takes it from the velocities of two updates. It is sent too, and it errs where forces change. */
#include "netcode/reckoning/reckoning.h"

static void at(const ll_reckoned *sent, double s, ll_entity *out)
{
    *out = sent->entity;
    out->x += (sent->entity.vx + sent->ax * s / 2) * s;
    out->y += (sent->entity.vy + sent->ay * s / 2) * s;
    out->vx += sent->ax * s;
    out->vy += sent->ay * s;
    out->angle += sent->entity.angular_velocity * s;
}

const ll_reckoning_model ll_reckoning_acceleration = {
    .name = "acceleration",
    .help = "As velocity_spin, with its acceleration when it was sent.",
    .accelerates = true,
    .at = at};
