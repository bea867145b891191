/* Running the simulation: what the log and the timeline say, snapshots, events, failure. */
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "session/internal.h"

#define EVENT_WINDOW (4 * LL_SECOND)

static size_t config_size(const ll_session *s)
{
    return s->scenario.kind->table->size;
}

void ll_session_line(const ll_session *s, const char *op)
{
    if (s->on_line)
        ll_session_emit_op(s, op, s->on_line, s->line_context);
}

void ll_session_drop_snapshots(ll_session *s, int64_t from)
{
    for (int i = 0; i < LL_SNAPSHOTS; i++) {
        ll_checkpoint *shot = &s->snapshots[i];
        if (shot->tick < from)
            continue;
        free(shot->block);
        free(shot->config);
        *shot = (ll_checkpoint){.tick = -1};
    }
}

/* An event has just been written byte by byte, and to read that in wider units makes the processor wait for
 * the writes: members are copied one by one, and volatile, since compilers would join them. */
void ll_session_keep_event(void *context, const void *row)
{
    ll_session *s = context;
    const volatile ll_event *event = row;
    ll_event *slot = &s->events[s->event_count % LL_EVENT_RING];
    slot->id = s->event_count++;
    slot->type = event->type;
    slot->begin = event->begin;
    slot->player = event->player;
    slot->end = event->end;
    slot->fate = event->fate;
    slot->number = event->number;
    slot->outcome = event->outcome;
    slot->value = event->value;
}

static ll_status change_parameters(ll_session *s, const char *values)
{
    ll_status status = ll_apply_values(s->scenario.kind, s->config, values);
    if (ll_failed(&status))
        return status;
    s->scenario.kind->change(s->block, s->config, ll_tick_time(s->tick, s->freq));
    s->stale = s->stale || (s->scenario.kind->begins_anew && s->tick > 0);
    s->epoch++;
    s->params_version++;
    return status;
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
    if (!ll_failed(&status)) /* a log from outside may hold an input for nobody */
        kind->input(s->block, e->player, &e->action);
    s->epoch++;
}

void ll_session_apply_due(ll_session *s)
{
    const ll_scenario_head *head = ll_session_head(s);
    while (ll_timeline_tick(head, s->step, s->freq) <= s->tick) {
        ll_status status = change_parameters(s, head->timeline[s->step++].set);
        s->skipped += ll_failed(&status);
    }
    while (s->next < s->log.count && s->log.entries[s->next].tick <= s->tick)
        apply_entry(s, &s->log.entries[s->next++]);
    ll_session_refresh(s);
}

/* Of a session that is not on its way anywhere: it falls half asleep where it is. */
static void fall_half_asleep(ll_session *s)
{
    if (s->errand != LL_ERRAND_NONE)
        return;
    s->status_asleep = s->status;
    s->errand = LL_ERRAND_WAKE;
    s->goal = s->tick;
}

bool ll_session_refresh(ll_session *s)
{
    const ll_sim_kind *kind = s->scenario.kind;
    ll_time now = ll_tick_time(s->tick, s->freq);
    if (!s->stale || s->status == LL_SESSION_FAILED)
        return true;
    ll_status status = kind->advance(s->block, now, NULL, NULL, s->patience);
    if (status.code == LL_INTERRUPTED) {
        kind->change(s->block, s->config, now);
        fall_half_asleep(s);
        return false;
    }
    s->stale = false;
    if (ll_failed(&status))
        ll_session_fail(s, &status);
    return true;
}

void ll_session_spoil(ll_session *s)
{
    fall_half_asleep(s);
    ll_session_begin_state(s, s->goal);
}

/* A snapshot is taken when its tick is left, so that it holds all commands of that tick. */
void ll_session_shoot(ll_session *s)
{
    int64_t every = s->end / (LL_SNAPSHOTS + 1);
    if (every == 0 || s->tick == 0 || s->tick % every != 0 || s->tick / every > LL_SNAPSHOTS)
        return;
    ll_checkpoint *shot = &s->snapshots[s->tick / every - 1];
    if (shot->tick == s->tick)
        return;
    if (!shot->block) {
        shot->block = malloc(s->block_size);
        shot->config = calloc(1, config_size(s));
    }
    if (!shot->block || !shot->config) { /* only a convenience: without it seeking takes longer */
        ll_session_drop_snapshots(s, s->tick);
        return;
    }
    memcpy(shot->block, s->block, s->block_size);
    ll_param_copy(s->scenario.kind->table, shot->config, s->config);
    shot->tick = s->tick;
    shot->next = s->next;
    shot->step = s->step;
    shot->skipped = s->skipped;
}

/* The block stays as it failed, between this tick and the next; the log tells it, once. */
void ll_session_fail(ll_session *s, const ll_status *why)
{
    bool told = s->failed_at == s->tick;
    s->status = LL_SESSION_FAILED;
    s->error = *why;
    s->failed_at = s->tick;
    if (!told || !s->failed_hash) /* what the log says stays */
        s->failed_hash = s->scenario.kind->hash(s->block);
    if (s->on_line && !told)
        ll_session_emit_failure(s, s->on_line, s->line_context);
}

/* The tick up to which the kind runs by itself: then a snapshot, a change of the scenario's own or a command
 * is due. */
static int64_t stretch_end(const ll_session *s, int64_t to)
{
    if (!s->scenario.kind->stands_at)
        return s->tick + 1;
    int64_t every = s->end / (LL_SNAPSHOTS + 1);
    int64_t snapshot = every > 0 ? (s->tick / every + 1) * every : to;
    int64_t change = ll_timeline_tick(ll_session_head(s), s->step, s->freq);
    int64_t command = s->next < s->log.count ? s->log.entries[s->next].tick : to;
    int64_t end = snapshot < to ? snapshot : to;
    end = change < end ? change : end;
    end = command < end ? command : end;
    LL_ASSERT(end > s->tick);
    return end;
}

/* A session that fails does so behind the same tick however it is driven. */
void ll_session_run(ll_session *s, int64_t to, bool record)
{
    const ll_sim_kind *kind = s->scenario.kind;
    ll_recorder recorder = {ll_session_keep_event, s};
    ll_step_profiler *step_profiler = s->step_profiler.now_ns ? &s->step_profiler : NULL;
    if (!ll_session_refresh(s))
        return;
    while (s->tick < to && s->status != LL_SESSION_FAILED && !s->stale) {
        ll_session_shoot(s);
        int64_t end = stretch_end(s, to);
        ll_time until = ll_tick_time(end, s->freq);
        ll_status status =
            kind->advance(s->block, until, record ? &recorder : NULL, step_profiler, s->patience);
        s->epoch++;
        if (status.code == LL_INTERRUPTED) {
            s->broken = true;
            if (!s->safe)
                ll_session_spoil(s);
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
}

/* A tick's state is that after everything that falls on its time, tick 0 too. */
static ll_status run_first_instant(ll_session *s, bool record)
{
    ll_recorder recorder = {ll_session_keep_event, s};
    ll_step_profiler *step_profiler = s->step_profiler.now_ns ? &s->step_profiler : NULL;
    return s->scenario.kind->advance(s->block, 0, record ? &recorder : NULL, step_profiler, NULL);
}

void ll_session_start_from(ll_session *s, const ll_checkpoint *shot, bool record)
{
    const void *config = shot ? shot->config : s->base;
    ll_status made = ll_ok();
    ll_param_copy(s->scenario.kind->table, s->config, config);
    s->stale = false;
    s->epoch++;
    if (shot)
        memcpy(s->block, shot->block, s->block_size);
    else
        made = s->scenario.kind->init(s->block, s->base);
    if (!shot && !ll_failed(&made))
        made = run_first_instant(s, record);
    s->tick = shot ? shot->tick : 0;
    s->next = shot ? shot->next : 0;
    s->step = shot ? shot->step : 0;
    s->skipped = shot ? shot->skipped : 0;
    if (s->status == LL_SESSION_FAILED) {
        s->status = LL_SESSION_PAUSED;
        s->error = ll_ok();
    }
    if (ll_failed(&made)) {
        s->status = LL_SESSION_FAILED;
        s->error = made;
    }
    ll_session_apply_due(s);
}

int64_t ll_session_quiet(const ll_session *s, int64_t tick)
{
    return tick - ll_tick_at(EVENT_WINDOW, s->freq);
}

/* Begins to make the state of `tick` from the nearest that is kept, with the events of the last seconds
 * before it. */
void ll_session_begin_state(ll_session *s, int64_t tick)
{
    int64_t quiet = ll_session_quiet(s, tick);
    const ll_checkpoint *best = NULL;
    for (int i = 0; i < LL_SNAPSHOTS; i++)
        if (s->snapshots[i].tick >= 0 && s->snapshots[i].tick <= quiet &&
            (!best || s->snapshots[i].tick > best->tick))
            best = &s->snapshots[i];
    ll_session_start_from(s, best, quiet <= 0);
    s->generation++;
    s->event_base = s->event_count;
    s->quiet = quiet;
}

void ll_session_anchor(ll_session *s, ll_time wall)
{
    s->anchor_wall = wall;
    s->anchor_time = ll_tick_time(s->tick, s->freq);
}
