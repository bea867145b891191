/* Ticks that may take long. Either they run on a copy of the state, outside of the session, or the session is
 * restored from a copy when they are interrupted. */
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "session/internal.h"

/* A block for a copy of the state. Its pages cost more than the copy, so that one is kept from tick to
 * tick. */
static void *take_spare(ll_session *s)
{
    void *spare = s->spare ? s->spare : ll_state_memory_new(s->block_size);
    s->spare = NULL;
    return spare;
}

static void keep_spare(ll_session *s, void *block)
{
    if (s->spare || !s->block)
        ll_state_memory_free(block);
    else
        s->spare = block;
}

static void drop_unused_spare(ll_session *s, int64_t due)
{
    if (due == 0 && s->status != LL_SESSION_PLAYING)
        ll_session_drop_spare(s);
}

struct ll_background_tick {
    const ll_sim_kind *kind;
    void *block;
    size_t size;
    ll_time until;
    int64_t to;
    uint64_t epoch; /* of the session at the begin; when it differs at the end, the result is discarded */
    bool refreshes; /* recomputes the present state after a change; false: runs one tick */
    bool records;
    ll_status status;
    ll_step_profiler step_profiler;
    uint32_t event_count;
    ll_event events[]; /* the newest LL_EVENT_RING, if it records */
};

static void keep_event(void *context, const void *row)
{
    const ll_event *event = row;
    ll_background_tick *a = context;
    a->events[a->event_count++ % LL_EVENT_RING] = *event;
}

void ll_background_tick_free(ll_background_tick *a)
{
    if (!a)
        return;
    ll_state_memory_free(a->block);
    free(a);
}

ll_status ll_session_begin_background_tick(ll_session *s, ll_time wall, ll_background_tick **tick)
{
    *tick = NULL;
    if (!s->block || ll_session_due(s, wall) == 0)
        return ll_ok();
    if (!s->stale && s->tick == s->transition.target_tick && s->transition.kind != LL_TRANSITION_NONE)
        return ll_ok();
    const bool records = s->events.ring && !s->stale &&
                         (s->transition.kind == LL_TRANSITION_NONE || s->tick >= s->transition.record_from);
    ll_background_tick *a = calloc(1, sizeof *a + (records ? LL_EVENT_RING * sizeof a->events[0] : 0));
    if (a)
        a->block = take_spare(s);
    if (!a || !a->block) {
        ll_background_tick_free(a);
        return ll_error(LL_NO_MEMORY, "out of memory: copy of the state of a session (%zu bytes)",
                        s->block_size);
    }
    if (!s->stale)
        ll_session_take_checkpoint(s);
    memcpy(a->block, s->block, s->block_size);
    a->size = s->block_size;
    a->kind = s->scenario.kind;
    a->refreshes = s->stale;
    a->to = s->tick + !s->stale;
    a->until = ll_tick_time(a->to, s->freq);
    a->epoch = s->interruption.epoch;
    a->records = records;
    a->step_profiler.now_ns = s->meter.step_profiler.now_ns;
    *tick = a;
    return ll_ok();
}

void ll_background_tick_run(ll_background_tick *a, const ll_interrupt *interrupt)
{
    ll_recorder recorder = {.record = keep_event, .context = a};
    a->status = a->kind->advance(a->block, a->until, a->records ? &recorder : NULL,
                                 a->step_profiler.now_ns ? &a->step_profiler : NULL, interrupt, NULL);
}

static void add_cost(ll_session *s, const ll_background_tick *a)
{
    for (int i = 0; i < LL_STEP_PROFILER_PARTS; i++)
        s->meter.step_profiler.ns[i] += a->step_profiler.ns[i];
    s->meter.step_profiler.metered += ll_tick_time(a->to, s->freq) - ll_tick_time(s->tick, s->freq);
}

/* Does what ll_session_run does after a tick. */
static void install_result(ll_session *s, ll_background_tick *a)
{
    void *old = s->block;
    s->block = a->block;
    a->block = old;
    s->interruption.epoch++;
    if (a->refreshes) {
        s->stale = false;
        return;
    }
    uint32_t kept = a->event_count < LL_EVENT_RING ? a->event_count : LL_EVENT_RING;
    for (uint32_t i = a->event_count - kept; i < a->event_count; i++)
        ll_session_keep_event(s, &a->events[i % LL_EVENT_RING]);
    if (ll_failed(&a->status)) {
        if (a->kind->stands_at)
            s->tick = ll_tick_at(a->kind->stands_at(s->block) - 1, s->freq);
        ll_session_fail(s, &a->status);
        return;
    }
    if (a->step_profiler.now_ns)
        add_cost(s, a);
    s->tick = a->to;
    if (s->tick > s->head)
        s->head = s->tick;
    ll_session_apply_due(s);
}

int64_t ll_session_end_background_tick(ll_session *s, ll_background_tick *a, ll_time wall)
{
    bool wanted = s->block && a->epoch == s->interruption.epoch && a->status.code != LL_INTERRUPTED &&
                  ll_session_due(s, wall) > 0;
    if (wanted)
        install_result(s, a);
    if (a->size == s->block_size) { /* a restart meanwhile may have changed it */
        keep_spare(s, a->block);
        a->block = NULL;
    }
    ll_background_tick_free(a);
    if (s->transition.kind != LL_TRANSITION_NONE && s->block && !s->stale &&
        (s->tick == s->transition.target_tick || s->status == LL_SESSION_FAILED))
        ll_session_continue(s, 0);
    ll_session_end_if_over(s);
    int64_t due = ll_session_due(s, wall);
    drop_unused_spare(s, due);
    return due;
}

/* ---- in place ---- */

static bool save_copy(ll_session *s, ll_checkpoint *copy)
{
    const ll_param_table *table = s->scenario.kind->table;
    *copy = (ll_checkpoint){.block = take_spare(s),
                            .config = ll_param_clone(table, s->config, NULL),
                            .tick = s->tick,
                            .position = s->position};
    if (!copy->block || !copy->config)
        return false;
    memcpy(copy->block, s->block, s->block_size);
    return true;
}

static void restore_copy(ll_session *s, const ll_checkpoint *copy)
{
    memcpy(s->block, copy->block, s->block_size);
    ll_param_copy(s->scenario.kind->table, s->config, copy->config);
    s->tick = copy->tick;
    s->position = copy->position;
    s->interruption.epoch++;
}

int64_t ll_session_advance_or_restore(ll_session *s, ll_time wall, int64_t max_ticks, bool *interrupted)
{
    ll_checkpoint copy = {0};
    uint32_t events = s->events.count;
    s->interruption.restorable =
        s->block && s->interruption.by && !s->stale && ll_session_due(s, wall) > 0 && save_copy(s, &copy);
    int64_t due = ll_session_advance(s, wall, max_ticks);
    if (s->interruption.happened && s->interruption.restorable) {
        restore_copy(s, &copy);
        s->events.count = events;
        due = ll_session_due(s, wall);
    }
    *interrupted = s->interruption.happened || s->stale;
    s->interruption.restorable = false;
    keep_spare(s, copy.block);
    free(copy.config);
    drop_unused_spare(s, due);
    return due;
}
