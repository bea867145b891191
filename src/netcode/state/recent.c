#include "netcode/state/recent.h"

#include <string.h>

#include "base/assert.h"

size_t ll_recent_size(int entities)
{
    return sizeof(ll_recent) + (size_t)entities * sizeof(ll_recent_entity);
}

void ll_recent_init(ll_recent *r, int entities, int self)
{
    LL_ASSERT(entities > 0 && entities <= LL_ENTITIES_MAX);
    memset(r, 0, ll_recent_size(entities));
    r->self = self;
    r->entities = (uint32_t)entities;
    r->newest = 1;
    r->oldest = (uint16_t)entities;
    for (int e = 0; e < entities; e++) {
        r->entity[e].newer = (uint16_t)e;
        r->entity[e].older = (uint16_t)(e + 1 < entities ? e + 2 : 0);
    }
    ll_recent_start(r);
}

void ll_recent_start(ll_recent *r)
{
    r->latest = r->predicted = r->checked = r->drawn = r->minus = 0;
    r->shown = -1;
    for (uint32_t e = 0; e < r->entities; e++)
        r->entity[e].changed = 0;
}

/* Moves an entity to the front. */
static void move(ll_recent *r, int entity)
{
    ll_recent_entity *e = &r->entity[entity];
    if (e->newer == 0)
        return;
    r->entity[e->newer - 1].older = e->older;
    if (e->older != 0)
        r->entity[e->older - 1].newer = e->newer;
    else
        r->oldest = e->newer;
    e->newer = 0;
    e->older = r->newest;
    r->entity[r->newest - 1].newer = (uint16_t)(entity + 1);
    r->newest = (uint16_t)(entity + 1);
}

#define MINUS_ZERO (UINT64_C(1) << 63)

static bool has_minus_zero(const ll_entity *e)
{
    uint64_t word[6];
    memcpy(word, e, sizeof word);
    bool has = false;
    for (int i = 0; i < 6; i++)
        has |= word[i] == MINUS_ZERO;
    return has;
}

static void note(ll_recent *r, const ll_world *world, int entity, int64_t number)
{
    r->entity[entity].changed = number;
    r->minus |= entity != r->self && has_minus_zero(&world->entity[entity]);
}

void ll_recent_note(ll_recent *r, const ll_world *world, int entity, int64_t number)
{
    LL_VALIDATE(number >= r->entity[entity].changed);
    note(r, world, entity, number);
    move(r, entity);
}

void ll_recent_note_all(ll_recent *r, const ll_world *world, int64_t number)
{
    for (int e = 0; e < world->entities; e++)
        note(r, world, e, number);
}

void ll_recent_copy(const ll_recent *r, int64_t *holds, int64_t number, bool holds_on, ll_world *to,
                    const ll_world *from)
{
    const int64_t since = *holds + 1;
    *holds = holds_on ? number : 0;
    if (since == 1) {
        memcpy(to, from, ll_world_size(from));
        return;
    }
    for (int e = ll_recent_first(r, since); e >= 0; e = ll_recent_next(r, e, since))
        to->entity[e] = from->entity[e];
    to->entity[r->self] = from->entity[r->self];
    memcpy(ll_world_tail(to), ll_world_tail_const(from), (size_t)from->tail);
}

/* ---- what is drawn ---- */

static void know(ll_recent *r, const ll_world *shown, int entity)
{
    const uint64_t bit = UINT64_C(1) << (entity & 63);
    uint64_t *word = &r->known[entity >> 6];
    *word = shown->entity[entity].flags & LL_ENTITY_UNKNOWN ? *word & ~bit : *word | bit;
}

void ll_recent_begin_display(ll_recent *r)
{
    r->settled = r->drawn;
    r->drawn = 0;
    r->shown = -1;
}

void ll_recent_end_display(ll_recent *r, const ll_world *shown)
{
    for (int e = 0; r->shown < 0 && e < shown->entities; e++)
        know(r, shown, e);
    for (int64_t k = 0; k < r->shown; k++)
        know(r, shown, r->show[k]);
}
