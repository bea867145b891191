/* High water: one number, the newest input that was really applied, stands for all before it. One before it
 * that was lost, came too late or was refused is taken for applied, those behind it whose step is over for
 * skipped; and where the server applies inputs as they come, one that was overtaken is dropped though it will
 * still be applied. */
#include "netcode/client/ack.h"
#include "netcode/state/client.h"

static void take(ll_client *c, const ll_client_setup *s, const ll_snapshot_entry *state, ll_time now)
{
    uint32_t upto = state->acked < c->seq ? state->acked : c->seq;
    for (uint32_t seq = c->acked + 1; seq <= upto; seq++)
        ll_client_close(c, s, seq, seq <= state->applied ? LL_INPUT_APPLIED : LL_INPUT_SKIPPED, state, now);
    if (upto > c->acked || !s->sync->drops_stale)
        c->acked = upto;
}

const ll_ack ll_ack_high_water = {
    .name = "high_water",
    .help = "One number: all inputs up to it are taken as applied.",
    .take = take,
};
