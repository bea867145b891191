/* Hashes that a session leaves on its way. */
#include <string.h>

#include "session/internal.h"

void ll_session_forget_marks(ll_session *s, int64_t from)
{
    while (s->mark_count > 0 && s->marks[s->mark_count - 1].tick >= from)
        s->mark_count--;
}

/* They come in order but after a seek back. */
void ll_session_keep_mark(ll_session *s, const ll_mark *mark)
{
    int at = s->mark_count;
    while (at > 0 && s->marks[at - 1].tick > mark->tick)
        at--;
    if (at > 0 && s->marks[at - 1].tick == mark->tick) {
        s->marks[at - 1] = *mark;
        return;
    }
    if (s->mark_count == LL_MARKS && at == 0)
        return;
    if (s->mark_count == LL_MARKS) { /* the first goes */
        at--;
        memmove(s->marks, s->marks + 1, (size_t)at * sizeof *mark);
    } else {
        memmove(s->marks + at + 1, s->marks + at, (size_t)(s->mark_count - at) * sizeof *mark);
        s->mark_count++;
    }
    s->marks[at] = *mark;
}

void ll_session_mark(ll_session *s)
{
    if (!s->on_line || !s->block || s->status == LL_SESSION_FAILED)
        return;
    ll_mark mark = {s->tick, s->scenario.kind->hash(s->block)};
    ll_session_keep_mark(s, &mark);
    ll_session_emit_mark(&mark, s->on_line, s->line_context);
}
