/* Partial: on the grid, and of the changed entities those of the largest accumulated priority that fit
 * snapshot_bytes, each whole (Fiedler, "State Synchronization"). */
#include "netcode/snapshot/select.h"

static void encode(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    ll_select_encode(w, out, (ll_selection_rule){.deltas = false}, cost);
}

const ll_codec ll_codec_partial = {
    .name = "partial",
    .help = "On the grid: the changed entities of the largest accumulated priority that fit snapshot_bytes.",
    .gridded = true,
    .selects = true,
    .encode = encode,
    .decode = ll_select_decode,
};
