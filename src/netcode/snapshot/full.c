/* Full: the world as it lies in memory. The simplest encoding: 448 bits per entity. */
#include <string.h>

#include "netcode/snapshot/snapshot.h"

static void encode(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost)
{
    int64_t bits = 8 * (int64_t)ll_world_size(out->world);
    if (bits <= w->capacity)
        memcpy(w->bytes, out->world, ll_world_size(out->world));
    w->count += bits;
    cost->entity_bits += out->world->entities * 8 * (int64_t)sizeof(ll_entity);
    cost->tail_bits += 8 * (int64_t)out->world->tail;
    cost->entities += out->world->entities;
}

static ll_status decode(ll_bit_reader *r, const ll_incoming *in)
{
    size_t size = ll_world_size(in->world);
    if (r->size != 8 * (int64_t)size)
        return ll_error(LL_BAD_INPUT, "a full snapshot of this world must have %zu bytes; got %lld", size,
                        (long long)r->size / 8);
    if (memcmp(in->world, r->bytes, sizeof *in->world) != 0)
        return ll_error(
            LL_BAD_INPUT,
            "a full snapshot must be of a world of %d players, %d entities and a tail of %d bytes",
            in->world->players, in->world->entities, in->world->tail);
    memcpy(in->world, r->bytes, size);
    r->at = r->size;
    return ll_decoded(r, in->world);
}

const ll_codec ll_codec_full = {
    .name = "full",
    .help = "The world as it lies in memory.",
    .encode = encode,
    .decode = decode,
};
