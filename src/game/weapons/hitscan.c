/* Hitscan: the positions that the server judges a shot against, and past positions of bodies. */
#include "game/core/compensate.h"

/* ---- past positions ---- */

void ll_bodies_now(const ll_arena *arena, const ll_world *world, ll_point *bodies)
{
    for (int i = 0; i < arena->bodies; i++)
        bodies[i] = (ll_point){world->entity[i].x, world->entity[i].y};
}

void ll_bodies_at(const ll_arena *arena, const ll_history *history, ll_time time, ll_point *bodies)
{
    ll_moment moment = ll_history_find(history, time);
    for (int i = 0; i < arena->bodies; i++)
        ll_history_at(history, moment, i, &bodies[i].x, &bodies[i].y);
}

ll_time ll_view_age(const ll_past *past, int player, uint32_t stated_ns, bool *rejected)
{
    ll_time age = stated_ns, oldest = past->measured[player] + past->buffer;
    *rejected = age > oldest + ll_ms(past->rules->rewind_tolerance_ms);
    return *rejected ? oldest : age;
}

/* none: judged against the targets at the time the server processes the shot. A shooter must lead by its
 * own lag. Cost: one ray. */
static int judge_present(const ll_field *field, const ll_shot *shot)
{
    return ll_arena_ray(field->arena, shot->shooter, shot->from, shot->direction, field->present);
}

/* rewind: judged against the targets at the shooter's view time, from the shooter's own position. What
 * the shooter saw hit is hit, though it may be behind cover by then (Bernier, "Latency Compensating Methods",
 * 2001; the paper's `traceback`). Cost: one search of the history and one ray. */
static int judge_seen(const ll_field *field, const ll_shot *shot)
{
    ll_point bodies[LL_BODIES_MAX];
    ll_bodies_at(field->arena, field->past->history, shot->seen, bodies);
    return ll_arena_ray(field->arena, shot->shooter, shot->from, shot->direction, bodies);
}

/* client_authoritative: the client reports its hits. Insecure: a dishonest client hits anything. Cost:
 * none. */
static int judge_claim(const ll_field *field, const ll_shot *shot)
{
    return ll_arena_enemies(field->arena, shot->shooter, shot->claim) ? shot->claim : LL_NOBODY;
}

/* hybrid: a young view is rewound whole, an old one less, and from hybrid_none_ms on not at all. So a
 * shooter with little lag hits what it saw, and one with much lag must lead instead of hitting players who
 * hid long ago. Between the two ages the share of the rewind falls linearly. Cost: that of rewind. */
static double hybrid_share(const ll_policy_params *params, ll_time age)
{
    double ms = ll_to_ms(age), full = params->hybrid_full_ms, none = params->hybrid_none_ms;
    if (ms <= full)
        return 1;
    return ms >= none ? 0 : (none - ms) / (none - full);
}

/* victim_veto: as rewind, but a hit on a player counts only if the shooter was in sight in the victim's
 * own view within the last veto_grace_ms. The server does not see that view. It reconstructs it from what it
 * knows: the victim draws itself where its inputs have put it, and the shooter as old as its input says
 * (within the same limits as the shooter's view). A step of the grace is one such view. Cost: that of rewind,
 * and two searches of the history and a line of sight for each step of the grace until one is open. */
static ll_point at(const ll_history *history, int entity, ll_time time)
{
    ll_point p;
    ll_history_at(history, ll_history_find(history, time), entity, &p.x, &p.y);
    return p;
}

static bool sees_shooter(const ll_field *field, const ll_shot *shot, int body)
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

/* X(name, members): the first is the policy without a history. */
#define POLICIES(X)                                                                                          \
    X(none, .judge = judge_present)                                                                          \
    X(rewind, .judge = judge_seen, .rewinds = true)                                                          \
    X(client_authoritative, .judge = judge_claim)                                                            \
    X(hybrid, .judge = judge_seen, .rewinds = true, .share = hybrid_share)                                   \
    X(victim_veto, .judge = judge_seen, .rewinds = true, .stands = sees_shooter)

#define ROW(name, ...) {__VA_ARGS__},
#define NAME(name, ...) #name,

const ll_hitscan_policy ll_hitscan_policies[] = {POLICIES(ROW)};
const char *const ll_hitscan_names[] = {POLICIES(NAME) NULL};
