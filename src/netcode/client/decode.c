/* Decodes the world of a snapshot against a baseline that the client holds, or rejects it. */
#include <string.h>

#include "netcode/snapshot/snapshot.h"
#include "netcode/state/client.h"

/* The received world of `tick`, if it lies on the present grid. */
static const ll_world *baseline_of(const void *client, int64_t tick)
{
    ll_client *c = (ll_client *)client; /* nothing changes */
    int64_t oldest = ll_client_oldest(c);
    if (tick < c->snapshots.grid_tick)
        return NULL;
    for (int64_t i = c->snapshots.received - 1; i >= oldest; i--)
        if (ll_client_state(c, i)->tick == tick)
            return ll_snapshot_entry_world(ll_client_state(c, i));
    return NULL;
}

/* A grid is valid from the snapshot on that brings it; an earlier snapshot that arrives late changes
 * nothing. */
static void take_grid(ll_client *c, const ll_quantization *grid, int64_t tick)
{
    bool other = memcmp(grid, &c->snapshots.grid, sizeof *grid) != 0;
    if (c->snapshots.grid_tick != LL_NEVER && (!other || tick < c->snapshots.grid_tick))
        return;
    c->snapshots.grid = *grid;
    c->snapshots.grid_tick = tick;
}

ll_status ll_client_decode(ll_client *c, const ll_snapshot_message *m, const void *bytes, int size,
                           ll_world *world, ll_changed *changed)
{
    const ll_codec *codec = ll_codec_at(m->codec);
    ll_quantization grid = c->snapshots.grid;
    ll_incoming in = {.world = world, .self = c->self, .grid = &grid};
    ll_bit_reader r = {.bytes = bytes, .size = 8 * (int64_t)size};
    if (!codec)
        return ll_error(LL_BAD_INPUT, "codec %d does not exist", m->codec);
    if (codec->compares || (codec->selects && m->baseline > 0))
        in.baseline = baseline_of(c, m->tick - m->baseline);
    if (codec->compares && !in.baseline)
        return ll_error(LL_NOT_FOUND, "snapshot %lld: baseline %lld missing", (long long)m->tick,
                        (long long)m->tick - m->baseline);
    if (codec->selects) {
        in.tick = m->tick;
        in.world_at = baseline_of;
        in.context = c;
        if (c->snapshots.received > 0)
            in.previous = ll_snapshot_entry_world(ll_client_state(c, c->snapshots.received - 1));
        in.changed = changed;
    }
    *world = *ll_client_latest(c); /* copies the header */
    ll_status status = codec->decode(&r, &in);
    if (!ll_failed(&status) && codec->gridded)
        take_grid(c, &grid, m->tick);
    return status;
}
