/* Runs the simulation: applies the log and the timeline, takes checkpoints, keeps events, handles
 * failures. */
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "session/internal.h"

#define EVENT_WINDOW (4 * LL_SECOND)

void ll_session_emit_own(const ll_session *s, const char *op)
{
    if (s->listener.on_line)
        ll_session_emit_op(s, op, s->listener.on_line, s->listener.context);
}

void ll_session_drop_checkpoints(ll_session *s, int64_t from)
{
    for (int i = 0; i < LL_CHECKPOINTS; i++) {
        ll_checkpoint *checkpoint = &s->checkpoints[i];
        if (checkpoint->tick < from)
            continue;
        ll_state_memory_free(checkpoint->block);
        free(checkpoint->config);
        *checkpoint = (ll_checkpoint){.tick = -1};
    }
}

/* Copies the members one by one, volatile: the event has just been written in narrow stores, and a wider load
 * would stall until they have retired. Without volatile, compilers merge the copies. */
void ll_session_keep_event(void *context, const void *row)
{
    ll_session *s = context;
    const volatile ll_event *event = row;
    ll_event *slot = &s->events.ring[s->events.count % LL_EVENT_RING];
    slot->id = s->events.count++;
    slot->type = event->type;
    slot->begin = event->begin;
    slot->player = event->player;
    slot->end = event->end;
    slot->fate = event->fate;
    slot->number = event->number;
    slot->outcome = event->outcome;
    slot->value = event->value;
    slot->tick = event->tick;
    slot->device_ms = event->device_ms;
    slot->held_ms = event->held_ms;
}

static ll_status change_parameters(ll_session *s, const char *values)
{
    LL_TRY(ll_apply_values(s->scenario.kind, s->config, values));
    s->scenario.kind->change(s->block, s->config, ll_tick_time(s->tick, s->freq));
    s->stale = s->stale || (s->scenario.kind->begins_anew && s->tick > 0);
    s->interruption.epoch++;
    s->params_version++;
    return ll_ok();
}

static void apply_entry(ll_session *s, const ll_log_entry *e)
{
    const ll_sim_kind *kind = s->scenario.kind;
    if (e->op == LL_OP_SET) {
        ll_status status = change_parameters(s, e->values);
        LL_ASSERT(!ll_failed(&status)); /* validated when the command was taken */
        return;
    }
    if (!kind->input)
        return;
    ll_status status = kind->accepts(s->config, e->player, &e->action);
    if (!ll_failed(&status)) /* a log from elsewhere may hold an input for a player that takes none */
        kind->input(s->block, e->player, &e->action);
    s->interruption.epoch++;
}

/* Starts to wake the session again, at its tick; nothing if it is already waking or seeking. */
static void begin_rewake(ll_session *s)
{
    if (s->transition.kind != LL_TRANSITION_NONE)
        return;
    s->transition.status_parked = s->status;
    s->transition.kind = LL_TRANSITION_WAKE;
    s->transition.target_tick = s->tick;
}

/* Brings a stale block to the present tick; false when it was interrupted. */
static bool refresh(ll_session *s)
{
    const ll_sim_kind *kind = s->scenario.kind;
    ll_time now = ll_tick_time(s->tick, s->freq);
    if (!s->stale || s->status == LL_SESSION_FAILED)
        return true;
    ll_status status = kind->advance(s->block, now, NULL, NULL, s->interruption.by, s->team);
    if (status.code == LL_INTERRUPTED) {
        kind->change(s->block, s->config, now);
        begin_rewake(s);
        return false;
    }
    s->stale = false;
    if (ll_failed(&status))
        ll_session_fail(s, &status);
    return true;
}

void ll_session_apply_due(ll_session *s)
{
    const ll_scenario_head *head = ll_session_head(s);
    while (ll_timeline_tick(head, s->position.step, s->freq) <= s->tick) {
        ll_status status = change_parameters(s, head->timeline[s->position.step++].set);
        s->position.skipped += ll_failed(&status);
    }
    while (s->position.next < s->log.count && s->log.entries[s->position.next].tick <= s->tick)
        apply_entry(s, &s->log.entries[s->position.next++]);
    refresh(s);
}

/* The block was interrupted within a tick: rebuilds it. */
static void invalidate(ll_session *s)
{
    begin_rewake(s);
    ll_session_begin_rebuild(s, s->transition.target_tick);
}

/* Takes a checkpoint if one is due. It is taken when the session leaves the tick, so that it includes all
 * commands of that tick. */
void ll_session_take_checkpoint(ll_session *s)
{
    int64_t every = s->end / (LL_CHECKPOINTS + 1);
    if (s->runs_forward || every == 0 || s->tick == 0 || s->tick % every != 0 ||
        s->tick / every > LL_CHECKPOINTS || s->block_size > LL_CHECKPOINT_BYTES_MAX)
        return;
    LL_ASSERT(s->tick / every >= 1); /* tick 0 needs no checkpoint */
    ll_checkpoint *checkpoint = &s->checkpoints[s->tick / every - 1];
    if (checkpoint->tick == s->tick)
        return;
    if (!checkpoint->block) {
        checkpoint->block = ll_state_memory_new(s->block_size);
        checkpoint->config = calloc(1, s->config_size);
    }
    if (!checkpoint->block ||
        !checkpoint->config) { /* checkpoints are optional: without them seeking takes longer */
        ll_session_drop_checkpoints(s, s->tick);
        return;
    }
    memcpy(checkpoint->block, s->block, s->block_size);
    ll_param_copy(s->scenario.kind->table, checkpoint->config, s->config);
    checkpoint->tick = s->tick;
    checkpoint->position = s->position;
}

/* The block keeps the state of the failure, between this tick and the next. The failure is logged once. */
void ll_session_fail(ll_session *s, const ll_status *why)
{
    bool logged = s->failure.tick == s->tick;
    s->status = LL_SESSION_FAILED;
    s->failure.status = *why;
    s->failure.tick = s->tick;
    if (!logged || !s->failure.hash) /* the hash that the log has is kept */
        s->failure.hash = s->scenario.kind->hash(s->block);
    if (s->listener.on_line && !logged)
        ll_session_emit_failure(s, s->listener.on_line, s->listener.context);
}

/* The tick up to which the kind can run without interruption: then a checkpoint, a step of the timeline or a
 * command is due. */
static int64_t end_of_run(const ll_session *s, int64_t to)
{
    if (!s->scenario.kind->stands_at)
        return s->tick + 1;
    int64_t every = s->end / (LL_CHECKPOINTS + 1);
    int64_t snapshot = every > 0 ? (s->tick / every + 1) * every : to;
    int64_t change = ll_timeline_tick(ll_session_head(s), s->position.step, s->freq);
    int64_t command = s->position.next < s->log.count ? s->log.entries[s->position.next].tick : to;
    int64_t end = snapshot < to ? snapshot : to;
    end = change < end ? change : end;
    end = command < end ? command : end;
    LL_ASSERT(end > s->tick);
    return end;
}

static void drop_event(void *context, const void *row)
{
    (void)context;
    (void)row;
}

/* NULL: no one reads events or packets of this run. */
static const ll_recorder *recorder_of(ll_session *s, bool record, ll_recorder *recorder)
{
    if (!s->on_packet && !(record && s->events.ring))
        return NULL;
    *recorder = (ll_recorder){
        .record = s->events.ring ? ll_session_keep_event : drop_event, .context = s, .packet = s->on_packet};
    return recorder;
}

/* A failure comes after the same tick, whether the session is paced, replayed or seeks. */
void ll_session_run(ll_session *s, int64_t to, bool record)
{
    const ll_sim_kind *kind = s->scenario.kind;
    ll_recorder kept;
    const ll_recorder *recorder = recorder_of(s, record, &kept);
    ll_step_profiler *step_profiler = s->meter.step_profiler.now_ns ? &s->meter.step_profiler : NULL;
    if (!refresh(s))
        return;
    while (s->tick < to && s->status != LL_SESSION_FAILED && !s->stale) {
        ll_session_take_checkpoint(s);
        int64_t end = end_of_run(s, to);
        ll_time until = ll_tick_time(end, s->freq);
        ll_status status =
            kind->advance(s->block, until, recorder, step_profiler, s->interruption.by, s->team);
        s->interruption.epoch++;
        if (status.code == LL_INTERRUPTED) {
            s->interruption.happened = true;
            if (!s->interruption.restorable)
                invalidate(s);
            return;
        }
        if (step_profiler)
            step_profiler->metered += until - ll_tick_time(s->tick, s->freq);
        if (ll_failed(&status)) {
            if (kind->stands_at)
                s->tick = ll_tick_at(kind->stands_at(s->block) - 1, s->freq);
            ll_session_fail(s, &status);
            break;
        }
        s->tick = end;
        ll_session_apply_due(s);
    }
    if (s->tick > s->head)
        s->head = s->tick;
    if (s->failure.tick >= 0 && s->tick > s->failure.tick) { /* the failure that the log has did not come */
        s->failure.tick = -1;
        ll_session_emit_own(s, "head");
    }
}

/* The state of a tick includes everything that happens at its time; this holds for tick 0 too. */
static ll_status run_tick_zero(ll_session *s, bool record)
{
    ll_recorder kept;
    ll_step_profiler *step_profiler = s->meter.step_profiler.now_ns ? &s->meter.step_profiler : NULL;
    return s->scenario.kind->advance(s->block, 0, recorder_of(s, record, &kept), step_profiler, NULL,
                                     s->team);
}

/* `checkpoint` NULL: from the beginning. */
static void start_from(ll_session *s, const ll_checkpoint *checkpoint, bool record)
{
    const void *config = checkpoint ? checkpoint->config : s->base;
    ll_status made = ll_ok();
    ll_param_copy(s->scenario.kind->table, s->config, config);
    s->stale = false;
    s->interruption.epoch++;
    if (checkpoint)
        memcpy(s->block, checkpoint->block, s->block_size);
    else
        made = s->scenario.kind->init(s->block, s->base);
    if (!checkpoint && !s->observes_all)
        s->scenario.kind->observe(s->block, s->observes);
    if (!checkpoint && !ll_failed(&made))
        made = run_tick_zero(s, record);
    LL_ASSERT(!checkpoint || (checkpoint->tick > 0 && checkpoint->position.next <= s->log.count));
    s->tick = checkpoint ? checkpoint->tick : 0;
    s->position = checkpoint ? checkpoint->position : (ll_log_position){0};
    if (s->status == LL_SESSION_FAILED) {
        s->status = LL_SESSION_PAUSED;
        if (s->failure.tick < 0) /* else the log has it, with its reason */
            s->failure.status = ll_ok();
    }
    if (ll_failed(&made)) {
        s->status = LL_SESSION_FAILED;
        s->failure.status = made;
    }
    ll_session_apply_due(s);
}

int64_t ll_session_first_recorded(const ll_session *s, int64_t tick)
{
    return tick - ll_tick_at(EVENT_WINDOW, s->freq);
}

/* The newest one that is older than the events kept. */
static const ll_checkpoint *nearest_checkpoint(const ll_session *s, int64_t record_from)
{
    const ll_checkpoint *best = NULL;
    for (int i = 0; i < LL_CHECKPOINTS; i++)
        if (s->checkpoints[i].tick >= 0 && s->checkpoints[i].tick <= record_from &&
            (!best || s->checkpoints[i].tick > best->tick))
            best = &s->checkpoints[i];
    return best;
}

void ll_session_begin_rebuild(ll_session *s, int64_t tick)
{
    int64_t record_from = ll_session_first_recorded(s, tick);
    start_from(s, nearest_checkpoint(s, record_from), record_from <= 0);
    s->generation++;
    s->events.base = s->events.count;
    s->transition.record_from = record_from;
}

void ll_session_set_clock(ll_session *s, ll_time wall)
{
    s->clock.wall = wall;
    s->clock.time = ll_tick_time(s->tick, s->freq);
}
