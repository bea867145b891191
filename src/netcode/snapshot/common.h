/* What the snapshots of one update have in common: the entities after those of the receivers, and the tail.
 * They are encoded once for each baseline that a receiver has, and copied into the messages. */
#pragma once

#include "game/core/game.h"
#include "netcode/snapshot/snapshot.h"

enum { LL_COMMON_PARTS = 16 }; /* further baselines are encoded for each receiver */

typedef struct ll_common_part {
    const ll_cell *baseline; /* NULL: none */
    int32_t first;           /* the first entity that it has */
    int32_t at;              /* in `bytes` */
    int64_t bits;
    ll_snapshot_cost cost;
} ll_common_part;

/* Not part of a block. It is valid while the world and the baselines do not change: its holder clears it
 * before the first message of an update. */
typedef struct ll_snapshot_common {
    int32_t count, bytes_used;
    ll_common_part part[LL_COMMON_PARTS];
    uint8_t bytes[LL_GAME_WORLD_MAX];
} ll_snapshot_common;

static inline void ll_snapshot_common_clear(ll_snapshot_common *c)
{
    c->count = c->bytes_used = 0;
}

/* How a codec encodes it. */
typedef struct ll_common_codec {
    int (*first)(
        const ll_outgoing *out); /* the first entity after the receivers' that is sent; or the count */
    /* Appends the entities from `first` on and the tail, and adds to `cost`. */
    void (*put)(ll_bit_writer *w, const ll_outgoing *out, int first, ll_snapshot_cost *cost);
} ll_common_codec;

/* The part for the baseline of `out`, encoded now if it is the first with that baseline. NULL: the snapshots
 * of `out` have nothing in common, or there is no room. */
const ll_common_part *ll_common_part_of(const ll_outgoing *out, const ll_common_codec *codec);

/* Appends that part, or encodes it where `part` is NULL. */
void ll_put_common(ll_bit_writer *w, const ll_outgoing *out, const ll_common_codec *codec,
                   const ll_common_part *part, int first, ll_snapshot_cost *cost);
