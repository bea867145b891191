/* Per input: a bit for each of the last 64 inputs, set when it was really applied.
 *
 * Where an input belongs to a step, a bit that is not set is final: the step is over, the input is skipped.
 * Where the server applies inputs as they come, it may still come, so the client goes on applying it until it
 * is older than the 64; and a state that is older than the last tells exactly what it includes, so that it
 * does no harm. */
#include "netcode/ack.h"
#include "netcode/client.h"

#define WINDOW 64

static bool applied(const ll_applied *a, uint32_t seq)
{
    uint64_t bits = (uint64_t)a->high << 32 | a->low;
    return seq <= a->newest && a->newest - seq < WINDOW && bits >> (a->newest - seq) & 1;
}

/* By step: up to the acknowledged all is decided. */
static void take_decided(ll_client *c, const ll_client_setup *s, const ll_received *state, ll_time now)
{
    uint32_t upto = state->acked < c->seq ? state->acked : c->seq;
    for (uint32_t seq = c->acked + 1; seq <= upto; seq++)
        ll_client_close(c, s, seq, applied(&c->applied, seq) ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state,
                        now);
    if (upto > c->acked)
        c->acked = upto;
}

/* As they come: what the state does not include is open, unless it is too old to be waited for. */
static void take_as_they_came(ll_client *c, const ll_client_setup *s, const ll_received *state, ll_time now)
{
    uint32_t newest = c->applied.newest < c->seq ? c->applied.newest : c->seq;
    uint32_t first = newest >= WINDOW ? newest - WINDOW + 1 : 1;
    for (uint32_t seq = c->acked + 1; seq < first; seq++)
        if (ll_client_is_open(c, seq))
            ll_client_close(c, s, seq, LL_INPUT_SKIPPED, state, now);
    c->acked = first - 1;
    for (uint32_t seq = first; seq <= c->seq; seq++) {
        ll_pending *p = ll_client_pending(c, seq);
        if (p->seq != seq)
            continue; /* too old for the ring */
        if (applied(&c->applied, seq))
            ll_client_close(c, s, seq, LL_INPUT_APPLIED, state, now);
        else if (p->state == LL_INPUT_APPLIED)
            p->state = LL_INPUT_OPEN; /* this state is older than the one that had it */
    }
    while (c->acked < c->seq && !ll_client_is_open(c, c->acked + 1))
        c->acked++;
}

static void take(ll_client *c, const ll_client_setup *s, const ll_received *state, ll_time now)
{
    if (!(c->parts & LL_PART_APPLIED)) /* the server has not heard yet that more than a number is wanted */
        c->applied = (ll_applied){state->acked, UINT32_MAX, UINT32_MAX};
    if (s->sync->drains)
        take_as_they_came(c, s, state, now);
    else
        take_decided(c, s, state, now);
}

const ll_ack ll_ack_per_input = {
    .name = "per_input",
    .help = "A bit for each of the last 64 inputs: only what was really applied is taken as applied.",
    .wants = LL_PART_APPLIED,
    .take = take,
};
