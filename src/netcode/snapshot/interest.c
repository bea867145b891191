/* Interest: as partial_delta, of the entities in the receiver's area of interest alone. An entity that leaves
 * the area is sent once more, as gone. At equal density the bytes of a client do not depend on the number of
 * entities. */
#include "netcode/snapshot/select.h"

static void encode(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    ll_select_encode(w, out, (ll_selection_rule){.deltas = true, .interest = true}, cost);
}

const ll_codec ll_codec_interest = {
    .name = "interest",
    .help = "As partial_delta, only entities within interest_radius_m.",
    .gridded = true,
    .selects = true,
    .encode = encode,
    .decode = ll_select_decode,
};
