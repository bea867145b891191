/* State hashes that a session records while it runs. */
#include <string.h>

#include "session/internal.h"

void ll_session_drop_hashes(ll_session *s, int64_t from)
{
    while (s->hash_count > 0 && s->tick_hashes[s->hash_count - 1].tick >= from)
        s->hash_count--;
}

/* Hashes come in ascending order, except after a seek back. */
void ll_session_add_hash(ll_session *s, const ll_tick_hash *mark)
{
    int at = s->hash_count;
    while (at > 0 && s->tick_hashes[at - 1].tick > mark->tick)
        at--;
    if (at > 0 && s->tick_hashes[at - 1].tick == mark->tick) {
        s->tick_hashes[at - 1] = *mark;
        return;
    }
    if (s->hash_count == LL_TICK_HASHES && at == 0)
        return;
    if (s->hash_count == LL_TICK_HASHES) { /* drops the oldest */
        at--;
        memmove(s->tick_hashes, s->tick_hashes + 1, (size_t)at * sizeof *mark);
    } else {
        memmove(s->tick_hashes + at + 1, s->tick_hashes + at, (size_t)(s->hash_count - at) * sizeof *mark);
        s->hash_count++;
    }
    s->tick_hashes[at] = *mark;
}

void ll_session_record_hash(ll_session *s)
{
    if (!s->on_line || !s->block || s->status == LL_SESSION_FAILED)
        return;
    ll_tick_hash mark = {s->tick, s->scenario.kind->hash(s->block)};
    ll_session_add_hash(s, &mark);
    ll_session_emit_hash(&mark, s->on_line, s->line_context);
}
