/* Extrapolation (dead reckoning): an entity continues from the newest snapshot at the velocity that it has
 * there. The error is a t^2 / 2 after t seconds of an unknown acceleration a, and larger across contacts
 * (Fiedler: fine for 50 to 250 ms of ballistic motion, wrong for rigid bodies). */
#include "netcode/state/client.h"

void ll_extrapolate(const ll_client_setup *s, const ll_entity *from, double dt, ll_entity *out)
{
    *out = *from;
    if (s->game->coast) {
        s->game->coast(s->env, out, dt);
        return;
    }
    out->x += from->vx * dt;
    out->y += from->vy * dt;
    out->angle += from->angular_velocity * dt;
}
