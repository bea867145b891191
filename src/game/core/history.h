/* Past positions of the entities of a server: a ring by time, for rewinding.
 *
 * Part of a simulation's block: no pointers. It holds the last LL_HISTORY_STEPS steps: 8.5 s at 60 per
 * second, older than any view. */
#pragma once

#include "game/core/game.h"

#define LL_HISTORY_STEPS 512

typedef struct ll_history {
    int32_t entities;
    int32_t reserved;
    int64_t count;
    /* then LL_HISTORY_STEPS ll_history_record */
} ll_history;

typedef struct ll_history_place {
    double x, y;
} ll_history_place;

typedef struct ll_history_record {
    ll_time time;
    ll_history_place at[];
} ll_history_record;

size_t ll_history_size(int entities);
void ll_history_init(ll_history *history, int entities);
void ll_history_add(ll_history *history, ll_time time, const ll_world *world);

/* A time within a history, as records to interpolate, for all entities at once. */
typedef struct ll_moment {
    int64_t before, after; /* records around it; equal at the ends */
    double share;          /* fraction of the way from `before` to `after` */
} ll_moment;

ll_time ll_history_newest(const ll_history *history);

/* A step, which must be in the ring. */
static inline ll_moment ll_history_step(int64_t step)
{
    return (ll_moment){step, step, 0};
}

static inline const ll_history_record *ll_history_record_at(const ll_history *history, int64_t i)
{
    size_t size = sizeof(ll_history_record) + (size_t)history->entities * sizeof(ll_history_place);
    return (const ll_history_record *)((const char *)(history + 1) +
                                       (size_t)(i & (LL_HISTORY_STEPS - 1)) * size);
}

/* Time at which the server made this step, or the nearest one in the ring. */
ll_time ll_history_time(const ll_history *history, int64_t step);

ll_moment ll_history_find(const ll_history *history, ll_time time); /* clamped to the ends */

/* The same. `near`: a record that is probably near, such as that found last; any number will do. */
ll_moment ll_history_find_near(const ll_history *history, ll_time time, int64_t near);

/* Inline, since a frame asks for every entity. */
static inline void ll_history_at(const ll_history *history, ll_moment moment, int entity, double *x,
                                 double *y)
{
    const ll_history_place *a = &ll_history_record_at(history, moment.before)->at[entity];
    const ll_history_place *b = &ll_history_record_at(history, moment.after)->at[entity];
    *x = a->x + moment.share * (b->x - a->x);
    *y = a->y + moment.share * (b->y - a->y);
}
