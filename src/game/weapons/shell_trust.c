/* Client-authoritative: the client flies its projectile in its own view and reports what it hits. Insecure: a
 * dishonest client hits anything. Cost: none. */
#include "game/weapons/policies.h"

static ll_flight_hit launch(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                            ll_time *start)
{
    return ll_shell_none.launch(field, shot, flight, start);
}

const ll_shell_family ll_shell_trust = {.name = "client_authoritative",
                                        .help = "The client reports the hits of its projectiles; insecure.",
                                        .claims = true,
                                        .launch = launch};
