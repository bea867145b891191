/* Trust: the client flies its shell among what it sees and says what it hits. Insecure: a client that lies
 * hits whom it likes. Cost: none. */
#include "game/weapons/policies.h"

static ll_meeting launch(const ll_field *field, const ll_shot *shot, const ll_flight *flight, ll_time *start)
{
    return ll_shell_none.launch(field, shot, flight, start);
}

const ll_shell_family ll_shell_trust = {.name = "trust",
                                        .help = "The client says what its shells hit; insecure.",
                                        .claims = true,
                                        .launch = launch};
