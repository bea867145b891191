/* Per input: a bit for each input since the newest snapshot that the server knows the client to have. The bit
 * is set if the input was applied.
 *
 * Where an input belongs to a step, a clear bit is final: the step is over and the input is skipped. Where
 * the server applies inputs on arrival, an input with a clear bit may still arrive. So the client goes on
 * applying it until 64 later inputs were applied. A snapshot older than the last one reports exactly what it
 * includes, so it does no harm. */
#include <string.h>

#include "netcode/client/ack.h"
#include "netcode/state/client.h"

static bool applied(const ll_client *c, uint32_t seq)
{
    uint32_t i = c->results.head.newest - seq;
    return seq <= c->results.head.newest && i / 32 < c->results.head.words &&
           c->results.applied[i / 32] >> (i & 31) & 1;
}

/* By step: all inputs up to the acknowledged one are decided. */
static void take_decided(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state, ll_time now)
{
    uint32_t upto = state->acked < c->inputs.seq ? state->acked : c->inputs.seq;
    for (uint32_t seq = c->inputs.acked + 1; seq <= upto; seq++)
        ll_client_close(c, s, seq, applied(c, seq) ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state, now);
    if (upto > c->inputs.acked)
        c->inputs.acked = upto;
}

#define OVERTAKEN 64 /* number of later applied inputs after which an input is given up */

/* On arrival: an input that the snapshot does not include stays open, unless it is too old. */
static void take_as_they_came(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state,
                              ll_time now)
{
    uint32_t newest = c->results.head.newest < c->inputs.seq ? c->results.head.newest : c->inputs.seq;
    uint32_t first = newest >= OVERTAKEN ? newest - OVERTAKEN + 1 : 1;
    for (uint32_t seq = c->inputs.acked + 1; seq < first; seq++)
        if (ll_client_is_open(c, seq))
            ll_client_close(c, s, seq, applied(c, seq) ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state, now);
    c->inputs.acked = first - 1;
    for (uint32_t seq = first; seq <= c->inputs.seq; seq++) {
        ll_pending_input *p = ll_client_pending(c, seq);
        if (p->seq != seq)
            continue; /* too old for the ring */
        if (applied(c, seq))
            ll_client_close(c, s, seq, LL_INPUT_APPLIED, state, now);
        else if (p->state == LL_INPUT_APPLIED)
            p->state = LL_INPUT_OPEN; /* this snapshot is older than the one that included it */
    }
    while (c->inputs.acked < c->inputs.seq && !ll_client_is_open(c, c->inputs.acked + 1))
        c->inputs.acked++;
}

static void take(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state, ll_time now)
{
    if (!(c->results.parts &
          LL_PART_APPLIED)) { /* the server does not know yet that the client wants more than a number */
        c->results.head = (ll_input_result_part){state->applied, LL_INPUT_RESULT_WORDS_MAX};
        memset(c->results.applied, 0xff, sizeof c->results.applied);
    }
    if (s->sync->applies_on_arrival)
        take_as_they_came(c, s, state, now);
    else
        take_decided(c, s, state, now);
}

const ll_ack ll_ack_per_input = {
    .name = "per_input",
    .help =
        "A bit for each input since the last snapshot: only inputs that were applied are taken as applied.",
    .wants = LL_PART_APPLIED,
    .take = take,
};
