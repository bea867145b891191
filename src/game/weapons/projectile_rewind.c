/* Rewind (C), the paper's method: the flight begins at the shooter's view time. The server rewinds, moves
 * projectile and targets together record by record up to now, and then stays in the present. The hit is that
 * of a server without lag. Cost: one part of a flight per record. */
#include "game/weapons/policies.h"

static ll_flight_hit launch(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                            ll_time *start)
{
    *start = shot->seen;
    ll_flight traced = ll_traced(field->past, flight, ll_to_s(shot->now - shot->seen));
    return ll_flight_through(field->arena, field->past->history, shot->shooter, &traced, shot->seen,
                             shot->seen, shot->now);
}

const ll_projectile_family ll_projectile_rewind = {
    .name = "rewind",
    .help =
        "C: projectile and targets move together from the shooter's view time to now, then in the present.",
    .rewinds = true,
    .looks_back = true,
    .launch = launch};
