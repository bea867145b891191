/* Rewind: judged against the targets at the shooter's view time, from the shooter's own position. What the
 * shooter saw hit is hit, though it may be behind cover by then (Bernier, "Latency Compensating Methods",
 * 2001; the paper's `traceback`). Cost: one search of the history and one ray. */
#include "game/weapons/policies.h"

static int judge(const ll_field *field, const ll_shot *shot)
{
    ll_point bodies[LL_BODIES_MAX];
    ll_bodies_at(field->arena, field->past->history, shot->seen, bodies);
    return ll_arena_ray(field->arena, shot->shooter, shot->from, shot->direction, bodies);
}

const ll_hitscan_policy ll_hitscan_rewind = {.name = "rewind",
                                             .help = "Judged against the targets at the shooter's view time.",
                                             .rewinds = true,
                                             .judge = judge};
