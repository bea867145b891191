#include "netcode/server/detect.h"

#include "netcode/server/validate.h"

void ll_detection_init(ll_detection *d)
{
    *d = (ll_detection){.rate.alarms.first = LL_NEVER, .reaction.alarms.first = LL_NEVER};
    for (int i = 0; i < LL_BODIES_MAX; i++)
        d->reaction.since[i] = -LL_REACTION_HIDDEN;
}

/* ---- rate ---- */

/* Whether an input arrives for the first time. One so old that it is not remembered does not count. */
static bool is_first(ll_rate_watch *w, uint32_t seq)
{
    if (seq > w->newest) {
        uint32_t by = seq - w->newest;
        w->seen = (by < 64 ? w->seen << by : 0) | 1;
        w->newest = seq;
        return true;
    }
    uint32_t back = w->newest - seq;
    uint64_t bit = back < 64 ? UINT64_C(1) << back : 0;
    bool first = bit != 0 && !(w->seen & bit);
    w->seen |= bit;
    return first;
}

bool ll_rate_take(ll_rate_watch *w, uint16_t epoch, uint32_t first, int count, ll_freq client_freq,
                  ll_time now)
{
    if (epoch != w->epoch) { /* the player has joined */
        w->epoch = epoch;
        w->newest = first + (uint32_t)count - 1;
        w->seen = UINT64_MAX;
        w->at = now;
        return false;
    }
    int inputs = 0;
    for (int i = 0; i < count; i++)
        inputs += is_first(w, first + (uint32_t)i);
    double credit = ll_rate_burst(client_freq);
    double due = (double)(now - w->at) * (double)client_freq / 1e12 * (1 + LL_RATE_SLACK);
    w->at = now;
    w->sum = (w->sum - due < -credit ? -credit : w->sum - due) + inputs;
    w->most = w->sum > w->most ? w->sum : w->most;
    if (w->sum <= LL_RATE_ALARM)
        return false;
    w->sum = 0;
    return true;
}

/* ---- reactions ---- */

bool ll_reaction_try(ll_reaction_watch *w, bool fast)
{
    w->shots++;
    w->fast += fast;
    w->sum += fast ? LL_SPRT_HIT : LL_SPRT_MISS;
    bool alarm = w->sum >= LL_SPRT_ALARM, clear = w->sum <= LL_SPRT_CLEAR;
    w->cleared += clear;
    if (alarm || clear)
        w->sum = 0;
    return alarm;
}

/* A body that is in sight for the first time in this input's view may have been drawn right after the input
 * before. One that was hidden for a moment only is no news, and who cannot fire yet does not react. */
static void notice(ll_reaction_watch *w, int body, bool sees, ll_time before, ll_time now)
{
    uint64_t bit = UINT64_C(1) << body;
    if (sees == ((w->in_sight & bit) != 0))
        return;
    bool news = sees && before > 0 && before - w->since[body] >= LL_REACTION_HIDDEN && w->ready <= before;
    w->in_sight ^= bit;
    w->tried = news ? w->tried & ~bit : w->tried | bit;
    w->since[body] = sees ? before : now;
}

static ll_time reaction(ll_reaction_watch *w, int body, ll_time now)
{
    uint64_t bit = UINT64_C(1) << body;
    if (!(w->in_sight & bit) || w->tried & bit)
        return -1;
    w->tried |= bit;
    ll_time since = w->since[body];
    return now - since > LL_REACTION_WITHIN ? -1 : now - since;
}

ll_time ll_reaction_see(ll_reaction_watch *w, const ll_arena *arena, int player, const ll_point *bodies,
                        const ll_aim *shot, ll_time now)
{
    const ll_time before = w->last;
    w->last = now;
    for (int i = 0; i < arena->bodies; i++)
        if (ll_arena_enemies(arena, player, i))
            notice(w, i, ll_arena_sees(arena, bodies[player], bodies[i]), before, now);
    if (!shot)
        return -1;
    w->ready = now + (ll_time)(arena->interval_s[LL_HITSCAN] * 1e9);
    int body = ll_arena_ray(arena, player, shot->from, shot->direction, bodies);
    return body == LL_NOBODY ? -1 : reaction(w, body, now);
}
