/* Partial (D): like fast_forward, but by at most projectile_forward_ms, so that no projectile appears far
 * from its muzzle. An older view is compensated in part. Cost: one part of a flight. */
#include "game/weapons/policies.h"

static ll_flight_hit launch(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                            ll_time *start)
{
    ll_time furthest = shot->now - ll_ms(field->past->rules->projectile_forward_ms);
    ll_shot near = *shot;
    near.seen = shot->seen > furthest ? shot->seen : furthest;
    return ll_projectile_fast_forward.launch(field, &near, flight, start);
}

const ll_projectile_family ll_projectile_partial = {.name = "partial",
                                                    .help = "D: forwarded by at most projectile_forward_ms.",
                                                    .looks_back = true,
                                                    .launch = launch};
