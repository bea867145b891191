#include "netcode/client/ack.h"

#include <string.h>

#include "netcode/state/client.h"

/* An input is decided by `state`, a snapshot. `now`: the frame that draws it. */
static void close_input(ll_client *c, const ll_client_setup *s, uint32_t seq, ll_input_state how,
                        const ll_snapshot_entry *state, ll_time now)
{
    ll_pending_input *p = ll_client_pending(c, seq);
    if (p->seq != seq)
        return; /* no such input: the clock snapped beyond it, or a newer input overwrote it */
    p->state = (uint8_t)how;
    if (p->closed_once)
        return;
    p->closed_once = 1;
    if (!(s->client_metrics->observes & LL_OBSERVE_INPUTS))
        return;
    if (now >= s->client_metrics->from)
        ll_input_history_closed(&s->client_metrics->input_history, seq, how == LL_INPUT_APPLIED, state->tick);
    if (how == LL_INPUT_APPLIED)
        ll_client_metrics_acknowledged(s->client_metrics, seq, state->tick, p->made, state->arrived, now);
}

/* High water: one number, the newest input that was applied, stands for all before it. An earlier input that
 * was lost, late or refused is taken as applied. Later inputs whose step is over are taken as skipped. Where
 * the server applies inputs on arrival, an input that another has overtaken is dropped though the server will
 * still apply it. */
static void take_high_water(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state,
                            ll_time now)
{
    uint32_t upto = state->acked < c->inputs.seq ? state->acked : c->inputs.seq;
    for (uint32_t seq = c->inputs.acked + 1; seq <= upto; seq++)
        close_input(c, s, seq, seq <= state->applied ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state, now);
    if (upto > c->inputs.acked || !s->sync->drops_stale)
        c->inputs.acked = upto;
}

/* Per input: a bit for each input since the newest snapshot that the server knows the client to have. The bit
 * is set if the input was applied.
 *
 * Where an input belongs to a step, a clear bit is final: the step is over and the input is skipped. Where
 * the server applies inputs on arrival, an input with a clear bit may still arrive. So the client goes on
 * applying it until 64 later inputs were applied. A snapshot older than the last one reports exactly what it
 * includes, so it does no harm. */
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
        close_input(c, s, seq, applied(c, seq) ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state, now);
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
            close_input(c, s, seq, applied(c, seq) ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state, now);
    c->inputs.acked = first - 1;
    for (uint32_t seq = first; seq <= c->inputs.seq; seq++) {
        ll_pending_input *p = ll_client_pending(c, seq);
        if (p->seq != seq)
            continue; /* too old for the ring */
        if (applied(c, seq))
            close_input(c, s, seq, LL_INPUT_APPLIED, state, now);
        else if (p->state == LL_INPUT_APPLIED)
            p->state = LL_INPUT_OPEN; /* this snapshot is older than the one that included it */
    }
    while (c->inputs.acked < c->inputs.seq && !ll_client_is_open(c, c->inputs.acked + 1))
        c->inputs.acked++;
}

static void take_per_input(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state,
                           ll_time now)
{
    if (!(c->results.parts & LL_PART_APPLIED)) {
        /* the server does not know yet that the client wants more than a number */
        c->results.head = (ll_input_result_part){state->applied, LL_INPUT_RESULT_WORDS_MAX};
        memset(c->results.applied, 0xff, sizeof c->results.applied);
    }
    if (s->sync->applies_on_arrival)
        take_as_they_came(c, s, state, now);
    else
        take_decided(c, s, state, now);
}

#define ACKS(X)                                                                                              \
    X(high_water, .take = take_high_water)                                                                   \
    X(per_input, .take = take_per_input, .wants = LL_PART_APPLIED)

#define ROW(name, ...) &(const ll_ack){__VA_ARGS__},
#define NAME(name, ...) #name,

const ll_ack *const ll_acks[] = {ACKS(ROW) NULL};
const char *const ll_ack_names[] = {ACKS(NAME) NULL};
