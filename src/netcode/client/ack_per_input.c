/* Per input: a bit for each input since the newest state that the server knows the client to have, set when
 * it was really applied.
 *
 * Where an input belongs to a step, a bit that is not set is final: the step is over, the input is skipped.
 * Where the server applies inputs as they come, it may still come, so the client goes on applying it until it
 * is overtaken by 64; and a state that is older than the last tells exactly what it
 * includes, so that it does no harm. */
#include <string.h>

#include "netcode/client/ack.h"
#include "netcode/state/client.h"

static bool applied(const ll_client *c, uint32_t seq)
{
    uint32_t i = c->verdict.newest - seq;
    return seq <= c->verdict.newest && i / 32 < c->verdict.words && c->verdicts[i / 32] >> (i & 31) & 1;
}

/* By step: up to the acknowledged all is decided. */
static void take_decided(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state, ll_time now)
{
    uint32_t upto = state->acked < c->seq ? state->acked : c->seq;
    for (uint32_t seq = c->acked + 1; seq <= upto; seq++)
        ll_client_close(c, s, seq, applied(c, seq) ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state, now);
    if (upto > c->acked)
        c->acked = upto;
}

#define OVERTAKEN 64 /* by so many applied ones an input is no longer waited for */

/* As they come: what the state does not include is open, unless it is too old to be waited for. */
static void take_as_they_came(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state,
                              ll_time now)
{
    uint32_t newest = c->verdict.newest < c->seq ? c->verdict.newest : c->seq;
    uint32_t first = newest >= OVERTAKEN ? newest - OVERTAKEN + 1 : 1;
    for (uint32_t seq = c->acked + 1; seq < first; seq++)
        if (ll_client_is_open(c, seq))
            ll_client_close(c, s, seq, applied(c, seq) ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state, now);
    c->acked = first - 1;
    for (uint32_t seq = first; seq <= c->seq; seq++) {
        ll_pending_input *p = ll_client_pending(c, seq);
        if (p->seq != seq)
            continue; /* too old for the ring */
        if (applied(c, seq))
            ll_client_close(c, s, seq, LL_INPUT_APPLIED, state, now);
        else if (p->state == LL_INPUT_APPLIED)
            p->state = LL_INPUT_OPEN; /* this state is older than the one that had it */
    }
    while (c->acked < c->seq && !ll_client_is_open(c, c->acked + 1))
        c->acked++;
}

static void take(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state, ll_time now)
{
    if (!(c->parts & LL_PART_APPLIED)) { /* the server has not heard yet that more than a number is wanted */
        c->verdict = (ll_input_result_part){state->applied, LL_INPUT_RESULT_WORDS_MAX};
        memset(c->verdicts, 0xff, sizeof c->verdicts);
    }
    if (s->sync->applies_on_arrival)
        take_as_they_came(c, s, state, now);
    else
        take_decided(c, s, state, now);
}

const ll_ack ll_ack_per_input = {
    .name = "per_input",
    .help = "A bit for each input since the last state: only what was really applied is taken as applied.",
    .wants = LL_PART_APPLIED,
    .take = take,
};
