/* Which entities a client's newest snapshots contain, where snapshots contain only some: a snapshot then
 * costs what is in it, and a display what moves, not the whole world each.
 *
 * It says nothing that the client's worlds do not; so it is no part of what is hashed. Snapshots have
 * numbers: 1 is the first after a start of the client, and the newest is ll_client_snapshots.received. */
#pragma once

#include "game/core/entity_bits.h"

#define LL_RECENT_RING 64 /* snapshots: as many as a client keeps */

typedef struct ll_recent {
    int32_t entities, self;
    int64_t newest;
    /* The snapshot whose others a world of the client has; 0: of none. */
    int64_t latest, predicted, checked;
    /* The same of the rendered world, but for entities that later snapshots contain, or that have a view
     * error; in the display before, and in this one. */
    int64_t settled, drawn;
    uint32_t minus;       /* some other had a zero with a minus, which interpolation may lose */
    uint32_t shows;       /* the display has drawn only the entities of `shown` again */
    ll_entity_bits shown; /* all if not `shows` */
    ll_entity_bits known; /* the rendered world has them */
    ll_entity_bits contained[LL_RECENT_RING];
} ll_recent;

void ll_recent_init(ll_recent *recent, int entities, int self);
void ll_recent_start(ll_recent *recent); /* the client has no snapshot */

/* The next snapshot gave `world` and contains these entities; NULL: all. */
void ll_recent_note(ll_recent *recent, const ll_world *world, const uint64_t *contained);

/* The entities of the snapshots after `number`; false: these are too many to know. */
bool ll_recent_since(const ll_recent *recent, int64_t number, ll_entity_bits entities);

/* Copies the newest snapshot, `from`, to a world that has the others of snapshot *holds. `holds_on`: it will
 * have those of this one. */
void ll_recent_copy(const ll_recent *recent, int64_t *holds, bool holds_on, ll_world *to,
                    const ll_world *from);

void ll_recent_begin_display(ll_recent *recent);
void ll_recent_end_display(ll_recent *recent, const ll_world *shown);
