/* Partial delta: as partial, and of each entity only the differences from the newest state of it that the
 * client has acknowledged (Tribes; Unreal). Snapshots of different entities need no common baseline. */
#include "netcode/snapshot/select.h"

static void encode(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    ll_select_encode(w, out, (ll_selection_rule){.deltas = true}, cost);
}

const ll_codec ll_codec_partial_delta = {
    .name = "partial_delta",
    .help = "As partial, each entity as its differences from its newest acknowledged state.",
    .gridded = true,
    .selects = true,
    .encode = encode,
    .decode = ll_select_decode,
};
