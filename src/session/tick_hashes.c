/* State hashes that a session records while it runs. */
#include <stdlib.h>
#include <string.h>

#include "session/internal.h"

void ll_session_drop_hashes(ll_session *s, int64_t from)
{
    while (s->hashes.count > 0 && s->hashes.marks[s->hashes.count - 1].tick >= from)
        s->hashes.count--;
}

static bool grow(ll_session_hashes *hashes)
{
    int capacity = hashes->capacity ? 4 * hashes->capacity : 4;
    capacity = capacity < LL_TICK_HASHES ? capacity : LL_TICK_HASHES;
    if (capacity == hashes->capacity)
        return true;
    ll_tick_hash *marks = realloc(hashes->marks, (size_t)capacity * sizeof *marks);
    if (!marks)
        return false;
    hashes->marks = marks;
    hashes->capacity = capacity;
    return true;
}

/* Hashes come in ascending order, except after a seek back. */
void ll_session_add_hash(ll_session *s, const ll_tick_hash *mark)
{
    int at = s->hashes.count;
    while (at > 0 && s->hashes.marks[at - 1].tick > mark->tick)
        at--;
    if (at > 0 && s->hashes.marks[at - 1].tick == mark->tick) {
        s->hashes.marks[at - 1] = *mark;
        return;
    }
    if (s->hashes.count == LL_TICK_HASHES && at == 0)
        return;
    if (s->hashes.count == s->hashes.capacity && !grow(&s->hashes))
        return;                              /* hashes are optional: a replay then checks fewer */
    if (s->hashes.count == LL_TICK_HASHES) { /* drops the oldest */
        at--;
        memmove(s->hashes.marks, s->hashes.marks + 1, (size_t)at * sizeof *mark);
    } else {
        memmove(s->hashes.marks + at + 1, s->hashes.marks + at,
                (size_t)(s->hashes.count - at) * sizeof *mark);
        s->hashes.count++;
    }
    s->hashes.marks[at] = *mark;
}

void ll_session_record_hash(ll_session *s)
{
    if (!s->listener.on_line || !s->block || s->status == LL_SESSION_FAILED)
        return;
    ll_tick_hash mark = {s->tick, s->scenario.kind->hash(s->block)};
    ll_session_add_hash(s, &mark);
    ll_session_emit_hash(&mark, s->listener.on_line, s->listener.context);
}
