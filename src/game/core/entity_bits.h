/* Sets of the entities of a world of any size, and ways through them. */
#pragma once

#include "game/core/game.h"

typedef uint64_t ll_entity_bits[LL_ENTITY_WORDS]; /* a bit per entity */

static inline bool ll_entity_bits_have(const uint64_t *bits, int entity)
{
    return bits[entity >> 6] >> (entity & 63) & 1;
}

/* Entities of a large world lie in no cache: a loop over a list fetches those that come next. */
#define LL_FETCH_AHEAD 6

/* The entities of a set, in their order; and then, to be fetched in vain, LL_FETCH_AHEAD times the first of
 * the world. */
typedef struct ll_entity_list {
    int count;
    uint16_t entity[LL_ENTITIES_MAX + LL_FETCH_AHEAD];
} ll_entity_list;

static inline void ll_entity_list_of(ll_entity_list *list, const uint64_t *bits)
{
    int count = 0;
    for (int word = 0; word < LL_ENTITY_WORDS; word++)
        for (uint64_t left = bits[word]; left != 0; left &= left - 1)
            list->entity[count++] = (uint16_t)(word * 64 + __builtin_ctzll(left));
    list->count = count;
    memset(&list->entity[count], 0, LL_FETCH_AHEAD * sizeof list->entity[0]);
}

/* A part of a cache line may hold the start, and the next the end. */
static inline void ll_fetch(const void *at, size_t size)
{
    for (size_t offset = 0; offset < size; offset += 64)
        __builtin_prefetch((const char *)at + offset);
    __builtin_prefetch((const char *)at + size - 1);
}

static inline void ll_entity_fetch(const ll_entity *e)
{
    ll_fetch(e, sizeof *e);
}
