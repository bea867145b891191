/* Transitions of a session: seeking, parking and waking. */
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "memory/state_memory.h"
#include "session/internal.h"

/* A session that had failed fails again, after the same tick. */
static void end_wake(ll_session *s)
{
    if (s->status == LL_SESSION_FAILED)
        return;
    s->status =
        s->transition.status_parked == LL_SESSION_FAILED ? LL_SESSION_PAUSED : s->transition.status_parked;
    if (s->transition.status_parked == LL_SESSION_FAILED)
        ll_session_run(s, s->tick + 1, true);
}

static void end_transition(ll_session *s)
{
    ll_transition transition = s->transition.kind;
    s->transition.kind = LL_TRANSITION_NONE;
    if (transition == LL_TRANSITION_WAKE) {
        end_wake(s);
    } else {
        s->params_version++;
        ll_session_emit_own(s, "pause");
        ll_session_record_hash(s);
    }
}

int64_t ll_session_continue(ll_session *s, int64_t max_ticks)
{
    s->interruption.happened = false;
    while (s->transition.kind != LL_TRANSITION_NONE) {
        bool record = s->tick >= s->transition.record_from;
        int64_t to = record || s->transition.record_from > s->transition.target_tick
                         ? s->transition.target_tick
                         : s->transition.record_from;
        if (to - s->tick > max_ticks)
            to = s->tick + max_ticks;
        max_ticks -= to - s->tick;
        ll_session_run(s, to, record);
        if (s->interruption.happened || (s->stale && s->status != LL_SESSION_FAILED))
            return s->transition.target_tick - s->tick + 1;
        if (s->tick == s->transition.target_tick || s->status == LL_SESSION_FAILED)
            end_transition(s);
        else if (max_ticks <= 0)
            return s->transition.target_tick - s->tick;
    }
    return 0;
}

void ll_session_stop_seek(ll_session *s)
{
    if (s->transition.kind != LL_TRANSITION_SEEK)
        return;
    s->transition.target_tick = s->tick;
    ll_session_continue(s, 1);
}

void ll_session_begin_seek(ll_session *s, int64_t tick)
{
    bool back = tick < s->tick || (tick == s->tick && s->status == LL_SESSION_FAILED);
    if (s->status != LL_SESSION_FAILED)
        s->status = LL_SESSION_PAUSED;
    if (back)
        ll_session_begin_rebuild(s, tick);
    else
        s->transition.record_from = 0;
    s->transition.kind = LL_TRANSITION_SEEK;
    s->transition.target_tick = tick;
    ll_session_continue(s, 0); /* the session may be at the tick already */
}

void ll_session_rebuild(ll_session *s, int64_t tick)
{
    ll_session_begin_rebuild(s, tick);
    if (s->transition.record_from > s->tick)
        ll_session_run(s, s->transition.record_from, false);
    if (!s->interruption.happened)
        ll_session_run(s, tick, true);
}

void ll_kept_block_free(ll_kept_block *kept)
{
    ll_state_memory_free(kept->block);
    *kept = (ll_kept_block){0};
}

/* Not initialised; NULL without memory. */
static void *take_block(ll_session *s)
{
    ll_kept_block *kept = s->kept;
    if (!kept || !kept->block)
        return ll_state_memory_new(s->block_size);
    void *block = kept->block;
    kept->block = NULL;
    if (kept->size >= s->block_size)
        return block;
    ll_state_memory_free(block);
    return ll_state_memory_new(s->block_size);
}

static void return_block(ll_session *s)
{
    if (!s->kept || !s->block) {
        ll_state_memory_free(s->block);
        return;
    }
    LL_ASSERT(!s->kept->block);
    *s->kept = (ll_kept_block){s->block, s->block_size};
}

bool ll_session_make_state(ll_session *s)
{
    const bool keeps_events = s->scenario.kind->records_events && !s->unwatched;
    s->block = take_block(s);
    if (s->block && keeps_events)
        s->events.ring = ll_state_memory_new(LL_EVENT_RING * sizeof *s->events.ring);
    return s->block && (s->events.ring || !keeps_events);
}

void ll_session_drop_state(ll_session *s)
{
    ll_session_drop_checkpoints(s, -1);
    return_block(s);
    ll_session_drop_spare(s);
    ll_state_memory_free(s->events.ring);
    s->block = NULL;
    s->events.ring = NULL;
    s->stale = false;
    s->interruption.epoch++;
}

void ll_session_park(ll_session *s)
{
    if (s->transition.kind == LL_TRANSITION_WAKE) { /* not awake yet: restore what it was while parked */
        s->tick = s->transition.target_tick;
        s->status = s->transition.status_parked;
        s->transition.kind = LL_TRANSITION_NONE;
    }
    ll_session_stop_seek(s);
    ll_session_drop_state(s);
    ll_session_pack(s);
}

ll_status ll_session_begin_wake(ll_session *s)
{
    if (s->block)
        return ll_ok();
    int64_t tick = s->tick;
    LL_TRY(ll_session_unpack(s));
    if (!ll_session_make_state(s)) {
        ll_session_park(s);
        return ll_error(LL_NO_MEMORY, "out of memory: state of a session (%zu bytes)", s->block_size);
    }
    s->transition.status_parked = s->status;
    ll_session_begin_rebuild(s, tick);
    s->transition.kind = LL_TRANSITION_WAKE;
    s->transition.target_tick = tick;
    return ll_ok();
}

ll_status ll_session_wake(ll_session *s)
{
    ll_status status = ll_session_begin_wake(s);
    if (!ll_failed(&status) && s->transition.kind == LL_TRANSITION_WAKE)
        ll_session_continue(s, INT64_MAX);
    return status;
}

void ll_session_set_position(ll_session *s, ll_time wall, const ll_session_position *at)
{
    LL_ASSERT(!s->block);
    if (at->head > s->head && at->head <= s->end)
        s->head = at->head;
    bool known = at->tick >= 0, failed = s->failure.tick >= 0 && s->tick == s->failure.tick;
    if (known && s->failure.tick >= 0) /* it may stand at that tick without having failed again */
        failed = at->tick > s->failure.tick;
    if (failed)
        s->tick = s->failure.tick;
    else if (known && at->tick <= s->head)
        s->tick = at->tick;
    if (at->speed > 0)
        s->clock.speed = at->speed;
    s->status = failed ? LL_SESSION_FAILED : at->playing ? LL_SESSION_PLAYING : LL_SESSION_PAUSED;
    ll_session_set_clock(s, wall);
}
