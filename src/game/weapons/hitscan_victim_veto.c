/* Victim's veto: as rewind, but a hit on a player counts only if the shooter was in sight in the victim's own
 * view within the last veto_grace_ms. The server does not see that view. It reconstructs it from what
 * it knows: the victim draws itself where its inputs have put it, and the shooter as old as its input says
 * (within the same limits as the shooter's view). A step of the grace is one such view. Cost: that of
 * rewind, and two searches of the history and a line of sight for each step of the grace until one is open.
 */
#include "game/weapons/policies.h"

static int judge(const ll_field *field, const ll_shot *shot)
{
    return ll_hitscan_rewind.judge(field, shot);
}

static ll_point at(const ll_history *history, int entity, ll_time time)
{
    ll_point p;
    ll_history_at(history, ll_history_find(history, time), entity, &p.x, &p.y);
    return p;
}

static bool stands(const ll_field *field, const ll_shot *shot, int body)
{
    const ll_past *past = field->past;
    const ll_history *history = past->history;
    bool rejected;
    if (body >= field->arena->players)
        return true;
    ll_time age = ll_view_age(past, body, field->actions[body].view_age_ns, &rejected);
    ll_time earliest = shot->now - ll_ms(past->params->veto_grace_ms), time = shot->now;
    for (int64_t step = history->count - 1; step >= 0 && time >= earliest; step--) {
        if (ll_arena_sees(field->arena, at(history, body, time), at(history, shot->shooter, time - age)))
            return true;
        if (step == 0 || step <= history->count - LL_HISTORY_STEPS)
            return false;
        time = ll_history_time(history, step - 1);
    }
    return false;
}

const ll_hitscan_policy ll_hitscan_victim_veto = {
    .name = "victim_veto",
    .help = "As rewind, unless the shooter was out of the victim's sight for more than veto_grace_ms.",
    .rewinds = true,
    .judge = judge,
    .stands = stands};
