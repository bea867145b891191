/* Replicas: what a server knows of each entity at each client, for snapshots that contain only some of the
 * entities. Per entity the state that was sent last and the newest that the client has acknowledged; per
 * snapshot in flight the entities in it, so that a loss gives them their accumulators back.
 *
 * Part of a simulation's block: no pointers. In a session without such snapshots there are none. */
#pragma once

#include "game/core/entity_bits.h"
#include "netcode/protocol/config.h"
#include "netcode/protocol/quantization.h"
#include "netcode/snapshot/baseline_history.h"

#define LL_SENT_RING 64      /* snapshots in flight; an older one counts as lost */
#define LL_SENT_ENTITIES 255 /* of a snapshot, without the receiver's own */
#define LL_GRID_BUCKETS 1024
#define LL_DELTA_UPDATES (LL_BASELINES - 2) /* a client keeps the worlds of this many updates */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* Of an entity at a client. A state is a cell, or that the client must not have it. */
typedef struct ll_replica_entity {
    ll_cell sent, acked;
    int64_t sent_tick; /* 0: never */
    int64_t acked_tick;
    int64_t acked_update; /* the number of the update that sent it */
    double accumulated;
    uint8_t has_sent;  /* `sent` is what the client has or will have, unless it is lost */
    uint8_t has_acked; /* `acked` is known to have been there */
    uint8_t sent_gone, acked_gone;
    uint8_t reserved[4];
} ll_replica_entity;

/* A snapshot in flight. */
typedef struct ll_sent_snapshot {
    int64_t update;
    int64_t count; /* entities; -1: its step was sent again, so it counts as lost already */
    double accumulated[LL_SENT_ENTITIES + 1];
    uint16_t entity[LL_SENT_ENTITIES + 1];
    uint8_t gone[LL_SENT_ENTITIES + 1];
} ll_sent_snapshot;

/* Sums for metrics. */
typedef struct ll_replica_counts {
    int64_t snapshots, lost; /* sent; of those, lost or not acknowledged in time */
    int64_t in_scope;        /* sum over snapshots */
    int64_t choked;          /* snapshots that left out something that had changed */
    int64_t intervals;       /* between two states of one entity */
    double interval_ticks, interval_ticks_max;
} ll_replica_counts;

/* Of one client. */
typedef struct ll_replica {
    int64_t begun, ended;            /* snapshots sent; of those, decided */
    int64_t tick[LL_SENT_RING];      /* of snapshot i, at i modulo the ring */
    uint64_t known[LL_ENTITY_WORDS]; /* a bit per entity that the client may have */
    uint64_t scope[LL_ENTITY_WORDS]; /* a bit per entity in its area of interest */
    uint16_t epoch;                  /* of the client's connection; 0: none yet */
    uint16_t first;                  /* the entity after that which was sent last */
    uint16_t counts_now;             /* `counts` has begun */
    uint16_t reserved;
    ll_replica_counts counts;
    ll_sent_snapshot sent[LL_SENT_RING];
    ll_replica_entity entity[];
} ll_replica;

/* What all clients have in common: the selection, and the entities in squares as wide as the radius. */
typedef struct ll_replicas {
    int32_t players, entities;
    ll_selection selection;
    int64_t update;                               /* number of the update that is being sent */
    int64_t tick;                                 /* of it; -1: none yet */
    uint16_t bucket[LL_GRID_BUCKETS];             /* 1 + its first entity; 0: none */
    uint16_t next[(LL_ENTITIES_MAX + 3) / 4 * 4]; /* 1 + the next of the same bucket */
    /* then an ll_replica per player */
} ll_replicas;

#pragma GCC diagnostic pop

size_t ll_replicas_size(int players, int entities); /* a multiple of 8 */
void ll_replicas_init(ll_replicas *all, int players, int entities);
ll_replica *ll_replicas_of(const ll_replicas *all, int player);

/* Clients may hold anything: another codec or another grid. */
void ll_replicas_forget(ll_replicas *all);

/* A client begins again in `epoch`. It may still have any entity that it had. */
void ll_replica_restart(ll_replica *replica, int entities, uint16_t epoch);

/* Begins the update that sends the world after step `tick`, if it has not begun. */
void ll_replicas_begin(ll_replicas *all, const ll_world *world, int64_t tick);

/* Sets the scope of `player`: all entities, or with `interest` those in its area. */
void ll_replicas_find_scope(const ll_replicas *all, ll_replica *replica, const ll_world *world, int player,
                            bool interest);

/* The client has the snapshot of `newest`, and of those before it the ones of `mask`: bit i stands for tick
 * newest - 1 - i. The others up to `newest` are lost: their entities get back what they had accumulated. */
void ll_replica_acknowledge(ll_replica *replica, const ll_baseline_history *history, int64_t newest,
                            uint32_t mask);

/* A new record of the snapshot of the present update; without room the oldest counts as lost. NULL: the world
 * of this step has been sent to the client before. Which of both an acknowledgement means is not known, and a
 * client that has the first drops the second: the first counts as lost, unless it is acknowledged already,
 * and the second must contain nothing. */
ll_sent_snapshot *ll_replica_record(ll_replica *replica, const ll_replicas *all);
