/* Where the entities of a server were: a ring of positions by time, for looking into the past.
 *
 * Part of a simulation's block: no pointers. It holds the last LL_HISTORY_STEPS steps: 8.5 s at 60 a second,
 * older than any view. */
#pragma once

#include "game/game.h"

#define LL_HISTORY_STEPS 512

typedef struct ll_history {
    int32_t entities;
    int32_t reserved;
    int64_t count;
    /* then LL_HISTORY_STEPS records of {ll_time; {double x, y} [entities]} */
} ll_history;

size_t ll_history_size(int entities);
void ll_history_init(ll_history *history, int entities);
void ll_history_add(ll_history *history, ll_time time, const ll_world *world);

/* A moment of a history: where it lies among the records, for all entities at once. */
typedef struct ll_moment {
    int64_t before, after; /* records around it; equal at the ends */
    double share;          /* of the way from `before` to `after` */
} ll_moment;

ll_time ll_history_newest(const ll_history *history);

/* The moment of a step, which must be in the ring. */
ll_moment ll_history_step(int64_t step);

/* When record `step` was made, the step that it is of; the nearest that is kept. */
ll_time ll_history_time(const ll_history *history, int64_t step);

ll_moment ll_history_find(const ll_history *history, ll_time time); /* beyond the ends: the end */
void ll_history_at(const ll_history *history, ll_moment moment, int entity, double *x, double *y);
