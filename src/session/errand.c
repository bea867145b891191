/* A session on its way: to another tick, asleep, or awake again. */
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "session/internal.h"

/* A session that had failed fails again, behind the same tick. */
static void fall_asleep_no_more(ll_session *s)
{
    if (s->status == LL_SESSION_FAILED)
        return;
    s->status = s->status_asleep == LL_SESSION_FAILED ? LL_SESSION_PAUSED : s->status_asleep;
    if (s->status_asleep == LL_SESSION_FAILED)
        ll_session_run(s, s->tick + 1, true);
}

static void arrive(ll_session *s)
{
    ll_errand errand = s->errand;
    s->errand = LL_ERRAND_NONE;
    if (errand == LL_ERRAND_WAKE) {
        fall_asleep_no_more(s);
    } else {
        s->params_version++;
        ll_session_line(s, "pause");
        ll_session_mark(s);
    }
}

int64_t ll_session_pursue(ll_session *s, int64_t max_ticks)
{
    s->broken = false;
    while (s->errand != LL_ERRAND_NONE) {
        bool record = s->tick >= s->quiet;
        int64_t to = record || s->quiet > s->goal ? s->goal : s->quiet;
        if (to - s->tick > max_ticks)
            to = s->tick + max_ticks;
        max_ticks -= to - s->tick;
        ll_session_run(s, to, record);
        if (s->broken || (s->stale && s->status != LL_SESSION_FAILED))
            return s->goal - s->tick + 1;
        if (s->tick == s->goal || s->status == LL_SESSION_FAILED)
            arrive(s);
        else if (max_ticks <= 0)
            return s->goal - s->tick;
    }
    return 0;
}

void ll_session_rest(ll_session *s)
{
    if (s->errand != LL_ERRAND_SEEK)
        return;
    s->goal = s->tick;
    ll_session_pursue(s, 1);
}

void ll_session_set_out(ll_session *s, int64_t tick)
{
    bool back = tick < s->tick || (tick == s->tick && s->status == LL_SESSION_FAILED);
    if (s->status != LL_SESSION_FAILED)
        s->status = LL_SESSION_PAUSED;
    if (back)
        ll_session_begin_state(s, tick);
    else
        s->quiet = 0;
    s->errand = LL_ERRAND_SEEK;
    s->goal = tick;
    ll_session_pursue(s, 0); /* it may be there already */
}

void ll_session_make_state(ll_session *s, int64_t tick)
{
    ll_session_begin_state(s, tick);
    if (s->quiet > s->tick)
        ll_session_run(s, s->quiet, false);
    if (!s->broken)
        ll_session_run(s, tick, true);
}

void ll_session_park(ll_session *s)
{
    if (s->errand == LL_ERRAND_WAKE) { /* half awake: as it was asleep */
        s->tick = s->goal;
        s->status = s->status_asleep;
        s->errand = LL_ERRAND_NONE;
    }
    ll_session_rest(s);
    ll_session_drop_snapshots(s, -1);
    free(s->block);
    free(s->events);
    s->block = NULL;
    s->events = NULL;
    s->stale = false;
    s->epoch++;
}

ll_status ll_session_begin_to_wake(ll_session *s)
{
    if (s->block)
        return ll_ok();
    int64_t tick = s->tick;
    s->block = malloc(s->block_size);
    s->events = calloc(LL_EVENT_RING, sizeof *s->events);
    if (!s->block || !s->events) {
        ll_session_park(s);
        return ll_error(LL_NO_MEMORY, "no memory for the state of a session (%zu bytes)", s->block_size);
    }
    s->status_asleep = s->status;
    ll_session_begin_state(s, tick);
    s->errand = LL_ERRAND_WAKE;
    s->goal = tick;
    return ll_ok();
}

ll_status ll_session_wake(ll_session *s)
{
    ll_status status = ll_session_begin_to_wake(s);
    if (!ll_failed(&status) && s->errand == LL_ERRAND_WAKE)
        ll_session_pursue(s, INT64_MAX);
    return status;
}

void ll_session_place(ll_session *s, ll_time wall, const ll_session_place_at *at)
{
    LL_ASSERT(!s->block);
    if (at->head > s->head && at->head <= s->end)
        s->head = at->head;
    if (at->tick >= 0 && at->tick <= s->head)
        s->tick = at->tick;
    if (at->speed > 0)
        s->speed = at->speed;
    bool failed = s->failed_at >= 0 && s->tick == s->failed_at;
    s->status = failed ? LL_SESSION_FAILED : at->playing ? LL_SESSION_PLAYING : LL_SESSION_PAUSED;
    ll_session_anchor(s, wall);
}
