#include "netcode/state/recent.h"

#include <string.h>

#include "base/assert.h"

void ll_recent_init(ll_recent *r, int entities, int self)
{
    LL_ASSERT(entities > 0 && entities <= LL_ENTITIES_MAX);
    memset(r, 0, sizeof *r);
    r->entities = entities;
    r->self = self;
}

void ll_recent_start(ll_recent *r)
{
    ll_recent_init(r, r->entities, r->self);
}

static void set_all(const ll_recent *r, uint64_t *bits)
{
    for (int word = 0; word < LL_ENTITY_WORDS; word++) {
        const int left = r->entities - 64 * word;
        bits[word] = left >= 64 ? UINT64_MAX : left > 0 ? (UINT64_C(1) << left) - 1 : 0;
    }
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

static uint64_t *contained_in(const ll_recent *r, int64_t number)
{
    return (uint64_t *)(uintptr_t)r->contained[number & (LL_RECENT_RING - 1)];
}

void ll_recent_note(ll_recent *r, const ll_world *world, const uint64_t *contained)
{
    ll_entity_list list;
    uint64_t *bits = contained_in(r, ++r->newest);
    if (contained)
        memcpy(bits, contained, sizeof(ll_entity_bits));
    else
        set_all(r, bits);
    ll_entity_list_of(&list, bits);
    for (int k = 0; k < list.count; k++)
        if (list.entity[k] != r->self && has_minus_zero(&world->entity[list.entity[k]]))
            r->minus = 1;
}

bool ll_recent_since(const ll_recent *r, int64_t number, ll_entity_bits entities)
{
    if (number <= 0 || r->newest - number > LL_RECENT_RING)
        return false;
    memset(entities, 0, sizeof(ll_entity_bits));
    for (int64_t n = number + 1; n <= r->newest; n++) {
        const uint64_t *bits = contained_in(r, n);
        for (int word = 0; word < LL_ENTITY_WORDS; word++)
            entities[word] |= bits[word];
    }
    return true;
}

void ll_recent_copy(const ll_recent *r, int64_t *holds, bool holds_on, ll_world *to, const ll_world *from)
{
    ll_entity_bits since;
    ll_entity_list list;
    const bool knows = ll_recent_since(r, *holds, since);
    *holds = holds_on ? r->newest : 0;
    if (!knows) {
        memcpy(to, from, ll_world_size(from));
        return;
    }
    ll_entity_list_of(&list, since);
    for (int k = 0; k < list.count; k++) {
        const int ahead = list.entity[k + LL_FETCH_AHEAD], e = list.entity[k];
        ll_entity_fetch(&from->entity[ahead]);
        ll_entity_fetch(&to->entity[ahead]);
        to->entity[e] = from->entity[e];
    }
    to->entity[r->self] = from->entity[r->self];
    memcpy(ll_world_tail(to), ll_world_tail_const(from), (size_t)from->tail);
}

/* ---- what is drawn ---- */

void ll_recent_begin_display(ll_recent *r)
{
    r->settled = r->drawn;
    r->drawn = 0;
    r->shows = 0;
}

void ll_recent_end_display(ll_recent *r, const ll_world *shown)
{
    if (!r->shows)
        set_all(r, r->shown);
    for (int word = 0; word < LL_ENTITY_WORDS; word++) {
        uint64_t unknown = 0;
        for (uint64_t left = r->shown[word]; left != 0; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            if (shown->entity[word * 64 + bit].flags & LL_ENTITY_UNKNOWN)
                unknown |= UINT64_C(1) << bit;
        }
        r->known[word] = (r->known[word] & ~r->shown[word]) | (r->shown[word] & ~unknown);
    }
}
