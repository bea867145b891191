/* None (A): the flight begins when the server processes the shot, among present targets. The shooter's own
 * view is behind by its age. Cost: none beyond the flight. */
#include "game/weapons/policies.h"

static ll_flight_hit launch(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                            ll_time *start)
{
    (void)field, (void)flight;
    *start = shot->now;
    return (ll_flight_hit){0, LL_MET_NOTHING, LL_NOBODY};
}

const ll_projectile_family ll_projectile_none = {
    .name = "none", .help = "A: the flight begins at the server, in the present.", .launch = launch};
