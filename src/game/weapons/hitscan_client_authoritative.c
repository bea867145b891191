/* Client-authoritative: the client reports its hits. Insecure: a dishonest client hits anything. Cost:
 * none. */
#include "game/weapons/policies.h"

static int judge(const ll_field *field, const ll_shot *shot)
{
    return ll_arena_enemies(field->arena, shot->shooter, shot->claim) ? shot->claim : LL_NOBODY;
}

const ll_hitscan_policy ll_hitscan_client_authoritative = {
    .name = "client_authoritative", .help = "The client reports its hits; insecure.", .judge = judge};
