/* None: judged against the targets at the time the server processes the shot. A shooter must lead by its own
 * lag. Cost: one ray. */
#include "game/weapons/policies.h"

static int judge(const ll_field *field, const ll_shot *shot)
{
    return ll_arena_ray(field->arena, shot->shooter, shot->from, shot->direction, field->present);
}

const ll_hitscan_policy ll_hitscan_none = {
    .name = "none", .help = "Judged against the targets of the server's present.", .judge = judge};
