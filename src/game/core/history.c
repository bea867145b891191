#include "game/core/history.h"

#include <string.h>

#include "base/assert.h"

typedef ll_history_place place;
typedef ll_history_record record;

static size_t record_size(int entities)
{
    return sizeof(record) + (size_t)entities * sizeof(place);
}

size_t ll_history_size(int entities)
{
    return sizeof(ll_history) + LL_HISTORY_STEPS * record_size(entities);
}

void ll_history_init(ll_history *history, int entities)
{
    memset(history, 0, ll_history_size(entities));
    history->entities = entities;
}

static const record *record_at(const ll_history *history, int64_t i)
{
    return ll_history_record_at(history, i);
}

void ll_history_add(ll_history *history, ll_time time, const ll_world *world)
{
    LL_ASSERT(history->count == 0 || time >= ll_history_newest(history)); /* in the order of time */
    record *r = (record *)record_at(history, history->count++);
    r->time = time;
    for (int i = 0; i < history->entities; i++)
        r->at[i] = (place){world->entity[i].x, world->entity[i].y};
}

static int64_t oldest_record(const ll_history *history)
{
    return history->count > LL_HISTORY_STEPS ? history->count - LL_HISTORY_STEPS : 0;
}

ll_time ll_history_newest(const ll_history *history)
{
    LL_ASSERT(history->count > 0);
    return record_at(history, history->count - 1)->time;
}

ll_time ll_history_time(const ll_history *history, int64_t step)
{
    int64_t newest = history->count - 1, oldest = oldest_record(history);
    return record_at(history, step < oldest ? oldest : step > newest ? newest : step)->time;
}

/* Between the two newest records; steps are almost even. */
static ll_time newest_step(const ll_history *history)
{
    const int64_t newest = history->count - 1;
    return newest == oldest_record(history)
               ? 0
               : record_at(history, newest)->time - record_at(history, newest - 1)->time;
}

/* From the newest record it is almost right. */
static int64_t guess(const ll_history *history, ll_time time)
{
    LL_ASSERT(history->count > 0);
    int64_t newest = history->count - 1;
    const record *last = record_at(history, newest);
    if (time >= last->time || newest == oldest_record(history))
        return newest;
    ll_time step = newest_step(history);
    return newest - (step > 0 ? (last->time - time) / step : 0);
}

static int64_t within(int64_t i, int64_t least, int64_t most)
{
    return i < least ? least : i > most ? most : i;
}

ll_moment ll_history_find_near(const ll_history *history, ll_time time, int64_t near)
{
    const int64_t newest = history->count - 1, oldest = oldest_record(history);
    LL_ASSERT(newest >= 0);
    enum { FAR = 8 }; /* steps: to walk over them takes as long as a guess */
    int64_t i = within(near, oldest, newest);
    const ll_time away = time - record_at(history, i)->time;
    if ((away < 0 ? -away : away) > FAR * newest_step(history))
        i = within(guess(history, time), oldest, newest);
    const record *before = record_at(history, i), *after;
    while (i > oldest && before->time > time)
        before = record_at(history, --i);
    for (;; i++, before = after) {
        if (i == newest)
            return (ll_moment){i, i, 0};
        after = record_at(history, i + 1);
        if (after->time > time)
            break;
    }
    const ll_time a = before->time, b = after->time;
    return (ll_moment){i, i + 1, b > a && time > a ? (double)(time - a) / (double)(b - a) : 0};
}

ll_moment ll_history_find(const ll_history *history, ll_time time)
{
    return ll_history_find_near(history, time, guess(history, time));
}
