/* Static: an entity stays where it was sent. Every motion is sent, in steps of the threshold. */
#include "netcode/reckoning/reckoning.h"

static void at(const ll_reckoned *sent, double s, ll_entity *out)
{
    (void)s;
    *out = sent->entity;
    out->vx = out->vy = out->angular_velocity = 0;
}

const ll_reckoning_model ll_reckoning_static = {
    .name = "static", .help = "An entity stays where it was sent.", .at = at};
