#include "netcode/snapshot/common.h"

enum { PAST_END = 8 }; /* bytes that ll_bits_append may read after a part */

static const ll_common_part *encode(ll_snapshot_common *c, const ll_outgoing *out,
                                    const ll_common_codec *codec)
{
    int64_t room = (int64_t)sizeof c->bytes - PAST_END - c->bytes_used;
    if (c->count == LL_COMMON_PARTS || room <= 0)
        return NULL;
    ll_common_part *part = &c->part[c->count];
    *part = (ll_common_part){.baseline = out->baseline, .first = codec->first(out), .at = c->bytes_used};
    ll_bit_writer w = {.bytes = c->bytes + part->at, .capacity = 8 * room};
    codec->put(&w, out, part->first, &part->cost);
    if (w.count > w.capacity)
        return NULL;
    part->bits = w.count;
    c->bytes_used += (int32_t)((w.count + 7) / 8);
    c->count++;
    return part;
}

const ll_common_part *ll_common_part_of(const ll_outgoing *out, const ll_common_codec *codec)
{
    ll_snapshot_common *c = out->common;
    if (!c)
        return NULL;
    LL_ASSERT(out->self < out->receivers);
    for (int i = 0; i < c->count; i++)
        if (c->part[i].baseline == out->baseline)
            return &c->part[i];
    return encode(c, out, codec);
}

void ll_put_common(ll_bit_writer *w, const ll_outgoing *out, const ll_common_codec *codec,
                   const ll_common_part *part, int first, ll_snapshot_cost *cost)
{
    if (!part) {
        codec->put(w, out, first, cost);
        return;
    }
    ll_bits_append(w, out->common->bytes + part->at, part->bits);
    ll_snapshot_cost_add(cost, &part->cost);
}
