/* Trust: the client says whom it hits. Insecure: a client that lies hits whom it likes. Cost: none. */
#include "game/weapons/policies.h"

static int judge(const ll_field *field, const ll_shot *shot)
{
    return ll_arena_enemies(field->arena, shot->shooter, shot->claim) ? shot->claim : LL_NOBODY;
}

const ll_rifle_policy ll_rifle_trust = {
    .name = "trust", .help = "The client says whom it hits; insecure.", .judge = judge};
