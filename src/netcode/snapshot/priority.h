/* Priority accumulators: which entities a snapshot of limited size contains (Fiedler, "State
 * Synchronization").
 *
 * Each update adds an entity's priority to its accumulator. The entities with the largest are sent, and only
 * theirs start again at 0. So of K places an entity of priority p gets p K / (sum of all p) per update, where
 * that is at most 1. It waits about sum p / (K p) updates; no accumulator of a pile that is cut at its
 * highest grows beyond 4 sum p / K (Kuszmaul, "Bamboo Trimming Revisited", K = 1), and none was seen
 * beyond 2. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct ll_candidate {
    double accumulated;
    int32_t entity;
    int32_t turn; /* of equal accumulators the lowest goes first; no index must always be the last */
} ll_candidate;

/* The turn of an entity where `first` is the one after that which was sent last: round robin. */
static inline int32_t ll_candidate_turn(int entity, int first, int entities)
{
    return entity >= first ? entity - first : entity - first + entities;
}

/* Makes `count` candidates a heap, and takes the first from one. Cost: linear; logarithmic. */
void ll_candidates_order(ll_candidate *heap, int count);
ll_candidate ll_candidates_take(ll_candidate *heap, int *count);
