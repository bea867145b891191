/* Snapshot encodings.
 *
 * Values known at both ends are not sent: the number of players, entities and tail bytes. The receiver's own
 * entity and the tail are sent bitwise, so that predictions can be compared exactly. */
#pragma once

#include "base/pair.h"
#include "base/status.h"
#include "netcode/protocol/quantization.h"
#include "netcode/snapshot/bits.h"

/* Input of an encoder. */
typedef struct ll_outgoing {
    const ll_world *world;
    int self;                          /* the receiver's own entity */
    int receivers;                     /* the entities before this one may be a receiver's own */
    struct ll_snapshot_common *common; /* snapshot/common.h; NULL: the codec encodes all */
    bool same_tail;                    /* the tail equals the baseline's */
    const ll_quantization *grid;       /* these three are for codecs with a grid */
    const ll_cell *cells;              /* the world's entities on the grid */
    const ll_cell *baseline;           /* entities that the receiver holds, on the same grid; NULL: none */
    struct ll_replica *replica;        /* for codecs that select: what the receiver holds of each entity */
    struct ll_replicas *replicas;      /* what all receivers have in common */
    bool counts;                       /* in the metrics of replicas */
    int64_t tick;                      /* of the world */
} ll_outgoing;

/* Entities of a decoded world, each once, in the order of the snapshot; the others have no values. */
typedef struct ll_changed {
    int count;
    uint64_t has[LL_ENTITY_WORDS];
    uint16_t entity[LL_ENTITIES_MAX];
} ll_changed;

/* Input of a decoder. */
typedef struct ll_incoming {
    ll_world *world; /* output; its header is set */
    int self;
    ll_quantization *grid;    /* of the baseline; a codec that sends a grid sets it */
    const ll_world *baseline; /* NULL: none */

    /* These are for codecs that select. */
    const ll_world *previous; /* the newest received world; NULL: none in this epoch */
    ll_changed *changed;      /* NULL, or with `previous`: output; only these entities of `world` are set, the
                                 others are those of `previous` */
    int64_t tick;             /* of the snapshot */
    /* The received world of a tick, if it is kept and lies on the grid; NULL: it is not. */
    const ll_world *(*world_at)(const void *context, int64_t tick);
    const void *context;
} ll_incoming;

/* Cost of a snapshot. */
typedef struct ll_snapshot_cost {
    int64_t entity_bits, tail_bits;
    int64_t entities, unchanged, resting; /* unchanged: not sent */
    int64_t whole;                        /* snapshots sent without a baseline */
} ll_snapshot_cost;

void ll_snapshot_cost_add(ll_snapshot_cost *sum, const ll_snapshot_cost *cost);

typedef struct ll_codec {
    const char *name;
    bool gridded;  /* rounds to a grid */
    bool compares; /* sends the differences from a baseline, which must exist */
    bool selects;  /* sends some of the entities: needs a replica (netcode/snapshot/replica.h) */

    /* Appends to an empty writer and adds to `cost`. */
    void (*encode)(ll_bit_writer *w, const ll_outgoing *out, ll_snapshot_cost *cost);

    /* Fills in->world; after an error it is undefined. The reader may hold any bytes. */
    ll_status (*decode)(ll_bit_reader *r, const ll_incoming *in);
} ll_codec;

/* X(name), in the order of the choice `snapshot_encoding`, whose index is sent */
#define LL_CODECS(X) X(full) X(quantised) X(delta) X(partial) X(partial_delta) X(interest)

#define LL_CODEC_DECLARE(name) extern const ll_codec ll_codec_##name;
LL_CODECS(LL_CODEC_DECLARE)
#undef LL_CODEC_DECLARE

extern const ll_codec *const ll_codecs[]; /* NULL-terminated */
extern const char *const ll_codec_names[];

int ll_codec_index(const ll_codec *codec);
const ll_codec *ll_codec_at(int index); /* NULL: there is none */

/* ---- shared by the codecs' files ---- */

void ll_put_exact(ll_bit_writer *w, const ll_entity *entity); /* bitwise: one bit for each member that is 0 */
void ll_get_exact(ll_bit_reader *r, ll_entity *entity);

/* An entity on the grid: its differences from `from`, which is all zero if there is nothing to compare
 * with. */
void ll_put_cell(ll_bit_writer *w, const ll_cell *cell, const ll_cell *from);
bool ll_get_cell(ll_bit_reader *r, const ll_cell *from,
                 ll_cell *cell);   /* false: a step that does not exist */
ll_status ll_off_grid(int entity); /* the error in that case */

void ll_put_grid(ll_bit_writer *w, const ll_quantization *grid);
ll_status ll_get_grid(ll_bit_reader *r, ll_quantization *grid);

void ll_put_tail(ll_bit_writer *w, const ll_world *world);
void ll_get_tail(ll_bit_reader *r, ll_world *world);

ll_status ll_decoded_slowly(ll_bit_reader *r, const ll_world *world);

/* Read to the end, and all numbers finite. Most end with a whole byte, and most numbers have a finite sum. */
static inline ll_status ll_decoded(ll_bit_reader *r, const ll_world *world)
{
    ll_pair all = {0, 0};
    for (int i = 0; i < world->entities; i++) {
        const ll_pair *e = (const ll_pair *)(const void *)&world->entity[i];
        all += e[0] + e[1] + e[2];
    }
    const double sum = all[0] + all[1];
    return r->at == r->size && !r->overlong && sum - sum == 0 ? ll_ok() : ll_decoded_slowly(r, world);
}
ll_status ll_decoded_some(ll_bit_reader *r, const ll_world *world, const ll_changed *changed);
