/* Which entities a client's newest snapshots contain, where snapshots contain only some: a snapshot then costs
 * what is in it, and a display what moves, not the whole world each.
 *
 * It says nothing that the client's worlds do not; so it is no part of what is hashed. Snapshots have numbers:
 * 1 is the first after a start of the client, and the newest is ll_client_snapshots.received. */
#pragma once

#include "game/core/game.h"
#include "netcode/snapshot/snapshot.h"

/* A link of the list of entities by their newest snapshot, the newest first. */
typedef struct ll_recent_entity {
    int64_t changed;       /* the newest snapshot that contains it; 0: none since the start */
    uint16_t newer, older; /* 1 + an entity; 0: the end */
    uint32_t reserved;
} ll_recent_entity;

typedef struct ll_recent {
    int64_t self;
    /* The snapshot whose others a world of the client has; 0: of none. */
    int64_t latest, predicted, checked;
    /* The same of the rendered world, but for entities that later snapshots contain, or that have a view error;
     * in the display before, and in this one. */
    int64_t settled, drawn;
    int64_t minus;    /* some other had a zero with a minus, which interpolation may lose */
    int64_t shown;    /* entities that the last display drew anew; -1: all */
    uint16_t newest;  /* 1 + the first of the list */
    uint16_t oldest;  /* 1 + the last */
    uint32_t entities;
    uint64_t known[LL_ENTITY_WORDS]; /* a bit per entity that the rendered world has */
    uint16_t show[(LL_ENTITIES_MAX + 3) / 4 * 4];
    ll_recent_entity entity[];
} ll_recent;

size_t ll_recent_size(int entities); /* a multiple of 8 */
void ll_recent_init(ll_recent *recent, int entities, int self);
void ll_recent_start(ll_recent *recent); /* the client has no snapshot */

/* Snapshot `number`, which gave `world`, contains `entity`; or all. */
void ll_recent_note(ll_recent *recent, const ll_world *world, int entity, int64_t number);
void ll_recent_note_all(ll_recent *recent, const ll_world *world, int64_t number);

/* Copies snapshot `number`, `from`, to a world that has the others of snapshot *holds. `holds_on`: it will
 * have those of this one. */
void ll_recent_copy(const ll_recent *recent, int64_t *holds, int64_t number, bool holds_on, ll_world *to,
                    const ll_world *from);

/* A display draws all entities, or, once `shown` is 0, those that it shows. */
void ll_recent_begin_display(ll_recent *recent);
void ll_recent_end_display(ll_recent *recent, const ll_world *shown);

static inline void ll_recent_show(ll_recent *r, int entity)
{
    r->show[r->shown++] = (uint16_t)entity;
}

/* Where snapshot `number` and later ones contain an entity: for (int e = ll_recent_first(r, n); e >= 0; e =
 * ll_recent_next(r, e, n)). */
static inline int ll_recent_upto(const ll_recent *r, int link, int64_t number)
{
    return link != 0 && r->entity[link - 1].changed >= number ? link - 1 : -1;
}

static inline int ll_recent_first(const ll_recent *r, int64_t number)
{
    return ll_recent_upto(r, r->newest, number);
}

static inline int ll_recent_next(const ll_recent *r, int entity, int64_t number)
{
    return ll_recent_upto(r, r->entity[entity].older, number);
}
