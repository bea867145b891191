/* High water: one number, the newest input that was applied, stands for all before it. An earlier input that
 * was lost, late or refused is taken as applied. Later inputs whose step is over are taken as skipped. Where
 * the server applies inputs on arrival, an input that another has overtaken is dropped though the server will
 * still apply it. */
#include "netcode/client/ack.h"
#include "netcode/state/client.h"

static void take(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state, ll_time now)
{
    uint32_t upto = state->acked < c->inputs.seq ? state->acked : c->inputs.seq;
    for (uint32_t seq = c->inputs.acked + 1; seq <= upto; seq++)
        ll_client_close(c, s, seq, seq <= state->applied ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state, now);
    if (upto > c->inputs.acked || !s->sync->drops_stale)
        c->inputs.acked = upto;
}

const ll_ack ll_ack_high_water = {
    .name = "high_water",
    .help = "One number: all inputs up to it are taken as applied.",
    .take = take,
};
