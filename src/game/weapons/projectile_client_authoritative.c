/* Client-authoritative: the client flies its projectile in its own view and reports what it hits. Insecure: a
 * dishonest client hits anything. Cost: none. */
#include "game/weapons/policies.h"

static ll_flight_hit launch(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                            ll_time *start)
{
    return ll_projectile_none.launch(field, shot, flight, start);
}

const ll_projectile_family ll_projectile_client_authoritative = {
    .name = "client_authoritative",
    .help = "The client reports the hits of its projectiles; insecure.",
    .claims = true,
    .launch = launch};
