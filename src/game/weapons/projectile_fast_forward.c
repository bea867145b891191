/* Fast-forward (B): the projectile is put where it would be by the shooter's view time, and its way there is
 * tested against the present targets. So the first part of the flight hits targets at positions where they
 * were not yet, and misses those that have moved on: a defect in shipped games (devotion, PR 168). Cost: one
 * part of a flight. */
#include "game/weapons/policies.h"

static ll_flight_hit launch(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                            ll_time *start)
{
    *start = shot->seen;
    double s = ll_to_s(shot->now - shot->seen);
    ll_flight traced = ll_traced(field->past, flight, s);
    return ll_arena_flight(field->arena, shot->shooter, &traced, 0, s, field->present, field->present);
}

const ll_projectile_family ll_projectile_fast_forward = {
    .name = "fast_forward",
    .help = "B: forwarded by the age of the shooter's view, among present targets.",
    .looks_back = true,
    .launch = launch};
