#include "session/session.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "session/internal.h"

const char *const ll_session_status_names[] = {"paused", "playing", "ended", "failed"};

/* ---- creation and destruction ---- */

ll_status ll_session_new(const ll_scenario *scenario, const void *base, ll_log_line *on_line, void *context,
                         ll_session **session)
{
    ll_session *s = calloc(1, sizeof *s);
    ll_scenario mine = *scenario;
    *session = NULL;
    if (s) {
        size_t first = ll_param_clone_size(mine.kind->table, mine.config, NULL);
        size_t other = ll_param_clone_size(mine.kind->table, base, NULL);
        s->scenario.kind = mine.kind;
        s->config_size = (first > other ? first : other) / 8 * 8 + 8;
    }
    if (!s || !ll_session_allocate(s)) {
        ll_scenario_free(&mine);
        free(s);
        return ll_error(LL_NO_MEMORY, "out of memory: session");
    }
    ll_param_copy(mine.kind->table, s->base, base);
    ll_param_copy(mine.kind->table, s->config, base);
    ll_param_copy(mine.kind->table, s->scenario.config, mine.config);
    s->freq = scenario->kind->tick_freq(base);
    s->block_size = scenario->kind->size(base);
    s->end = ll_tick_at((ll_time)llround(ll_session_head(s)->duration_s * 1e9), s->freq);
    ll_scenario_free(&mine); /* `base` may be its */
    s->observes_all = true;
    s->clock.speed = 1;
    s->failure.tick = -1;
    snprintf(s->version, sizeof s->version, "%s", ll_version);
    for (int i = 0; i < LL_CHECKPOINTS; i++)
        s->checkpoints[i].tick = -1;
    s->listener.on_line = on_line;
    s->listener.context = context;
    *session = s;
    if (on_line)
        ll_session_emit_create(s, on_line, context);
    return ll_ok();
}

/* Makes the initial state of a new session. Destroys the session when that fails. */
static ll_status begin(ll_session **session)
{
    ll_status status = ll_session_wake(*session);
    if (!ll_failed(&status) &&
        (*session)->status == LL_SESSION_FAILED) /* the initial state could not be made */
        status = (*session)->failure.status;
    if (ll_failed(&status)) {
        ll_session_destroy(*session);
        *session = NULL;
    }
    return status;
}

ll_status ll_session_open(ll_scenario *scenario, ll_log_line *on_line, void *context, ll_session **session)
{
    ll_status status = ll_session_new(scenario, scenario->config, on_line, context, session);
    LL_THEN(status, begin(session));
    *scenario = (ll_scenario){0};
    return status;
}

ll_status ll_session_open_forward(ll_scenario *scenario, ll_kept_block *kept, ll_session **session)
{
    ll_status status = ll_session_new(scenario, scenario->config, NULL, NULL, session);
    if (!ll_failed(&status)) {
        ll_session_run_forward(*session);
        (*session)->kept = kept;
        status = begin(session);
    }
    *scenario = (ll_scenario){0};
    return status;
}

ll_status ll_session_open_unwatched(ll_scenario *scenario, ll_session **session)
{
    ll_status status = ll_session_new(scenario, scenario->config, NULL, NULL, session);
    if (!ll_failed(&status)) {
        (*session)->unwatched = true;
        status = begin(session);
    }
    *scenario = (ll_scenario){0};
    return status;
}

void ll_session_run_forward(ll_session *s)
{
    LL_ASSERT(!s->block);
    s->runs_forward = true;
    s->unwatched = true;
}

void ll_session_keep_events(ll_session *s)
{
    LL_ASSERT(!s->block);
    s->unwatched = false;
}

void ll_session_observe_only(ll_session *s, const char *const *paths, int count)
{
    const ll_sim_kind *kind = s->scenario.kind;
    LL_ASSERT(s->tick == 0 && s->block);
    if (!kind->observe)
        return;
    s->observes_all = false;
    s->observes = 0;
    for (int i = 0; i < count; i++)
        s->observes |= kind->observed_for(paths[i]);
    kind->observe(s->block, s->observes);
}

ll_status ll_session_create(const cJSON *json, int64_t seed, ll_log_line *on_line, void *context,
                            ll_session **session)
{
    ll_scenario scenario = {0};
    *session = NULL;
    LL_TRY(ll_scenario_parse(json, &scenario));
    if (seed >= 0)
        ((ll_scenario_head *)scenario.config)->seed = seed;
    return ll_session_open(&scenario, on_line, context, session);
}

void ll_session_destroy(ll_session *s)
{
    if (!s)
        return;
    ll_session_drop_state(s);
    ll_log_free(&s->log);
    free(s->hashes.marks);
    free(s->packed);
    ll_state_memory_free(s->memory);
    free(s);
}

/* ---- running ---- */

void ll_session_pause(ll_session *s)
{
    s->stop_tick = 0;
    if (s->status != LL_SESSION_PLAYING)
        return;
    s->status = LL_SESSION_PAUSED;
    ll_session_emit_own(s, "pause");
    ll_session_record_hash(s);
}

void ll_session_end_if_over(ll_session *s)
{
    if (s->tick >= s->end && s->status == LL_SESSION_PLAYING)
        s->status = LL_SESSION_ENDED;
    if (s->stop_tick > 0 && s->tick >= s->stop_tick && s->status == LL_SESSION_PLAYING)
        ll_session_pause(s);
}

int64_t ll_session_due(const ll_session *s, ll_time wall)
{
    if (s->transition.kind != LL_TRANSITION_NONE)
        return s->transition.target_tick - s->tick + s->stale;
    if (s->status != LL_SESSION_PLAYING)
        return 0;
    ll_time due = s->clock.time + (ll_time)((double)(wall - s->clock.wall) * s->clock.speed);
    int64_t target = due > 0 ? ll_tick_at(due, s->freq) : 0;
    target = target > s->end ? s->end : target;
    target = s->stop_tick > 0 && target > s->stop_tick ? s->stop_tick : target;
    return target > s->tick ? target - s->tick : 0;
}

void ll_session_set_team(ll_session *s, ll_team *team)
{
    s->team = team;
}

void ll_session_set_interrupt(ll_session *s, const ll_interrupt *interrupt)
{
    s->interruption.by = interrupt;
}

int64_t ll_session_advance(ll_session *s, ll_time wall, int64_t max_ticks)
{
    s->interruption.happened = false;
    ll_session_drop_spare(s);
    ll_status status = ll_session_begin_wake(s);
    if (ll_failed(&status))
        return 0;
    if (s->transition.kind != LL_TRANSITION_NONE) {
        int64_t left = ll_session_continue(s, max_ticks);
        return left > 0 ? left : ll_session_due(s, wall);
    }
    if (s->status != LL_SESSION_PLAYING)
        return 0;
    int64_t target = s->tick + ll_session_due(s, wall);
    int64_t to = target - s->tick > max_ticks ? s->tick + max_ticks : target;
    if (to > s->tick)
        ll_session_run(s, to, true);
    ll_session_end_if_over(s);
    return s->status == LL_SESSION_PLAYING ? target - s->tick : 0;
}

void ll_session_move_to(ll_session *s, int64_t tick)
{
    if (tick < s->tick || (tick == s->tick && s->status == LL_SESSION_FAILED)) {
        ll_session_rebuild(s, tick);
    } else {
        ll_session_run(s, ll_session_first_recorded(s, tick), false);
        if (!s->interruption.happened)
            ll_session_run(s, tick, true);
    }
    s->params_version++;
}

ll_status ll_session_run_to(ll_session *s, int64_t tick)
{
    s->interruption.happened = false;
    LL_TRY(ll_session_wake(s));
    if (tick < 0 || tick > s->end)
        return ll_field_error(LL_BAD_INPUT, "tick", "tick: must be 0 to %lld; got %lld", (long long)s->end,
                              (long long)tick);
    if (s->interruption.happened || s->stale)
        return ll_error(LL_INTERRUPTED, "interrupted while the session was waking");
    ll_session_stop_seek(s);
    if (tick != s->tick || s->status == LL_SESSION_FAILED)
        ll_session_move_to(s, tick);
    if (s->interruption.happened || s->stale)
        return ll_error(LL_INTERRUPTED, "interrupted before tick %lld", (long long)tick);
    return s->status == LL_SESSION_FAILED ? s->failure.status : ll_ok();
}

ll_status ll_session_run_within(ll_session *s, int64_t tick, const ll_interrupt *interrupt)
{
    ll_piece piece = {1, 0};
    ll_status status = ll_ok();
    int64_t at = s->tick;
    do {
        if (!ll_next_piece(&piece, interrupt))
            return ll_error(LL_INTERRUPTED, "interrupted at tick %lld of %lld", (long long)at,
                            (long long)tick);
        s->interruption.by = interrupt;
        int64_t from = at;
        at = tick - at > piece.size ? at + piece.size : tick;
        status = ll_session_run_to(s, at);
        s->interruption.by = NULL;
        if (status.code == LL_INTERRUPTED)
            return ll_error(LL_INTERRUPTED, "interrupted at tick %lld of %lld", (long long)from,
                            (long long)tick);
    } while (at < tick && !ll_failed(&status));
    return status;
}

/* Drops all commands after the present tick, since a new command changes what follows it. */
static void drop_later_commands(ll_session *s)
{
    ll_session_stop_seek(s);
    ll_session_drop_checkpoints(s, s->tick);
    ll_session_drop_hashes(s, s->tick);
    s->failure.tick = -1;
    if (s->head == s->tick)
        return;
    ll_log_truncate(&s->log, s->position.next);
    s->head = s->tick;
    ll_session_emit_own(s, "rewind");
}

static ll_status append(ll_session *s, const ll_log_entry *entry)
{
    drop_later_commands(s);
    LL_TRY(ll_log_append(&s->log, entry));
    ll_session_apply_due(s);
    if (s->listener.on_line)
        ll_session_emit_entry(entry, s->listener.on_line, s->listener.context);
    return ll_ok();
}

static ll_status collect(void *context, const char *path, const char *value)
{
    cJSON *json = cJSON_Parse(value);
    if (!json)
        return ll_error(LL_NO_MEMORY, "out of memory: patch");
    cJSON_AddItemToObject(context, path, json);
    return ll_ok();
}

ll_status ll_session_patch(ll_session *s, ll_time wall, const cJSON *patch)
{
    (void)wall;
    ll_status status = ll_session_wake(s);
    if (ll_failed(&status))
        return status;
    if (s->status == LL_SESSION_FAILED)
        return ll_error(LL_CONFLICT, "the session has failed: %s", s->failure.status.text);
    void *probe = ll_param_clone(s->scenario.kind->table, s->config, NULL);
    cJSON *values = cJSON_CreateObject();
    char *text = NULL;
    if (!probe || !values) {
        status = ll_error(LL_NO_MEMORY, "out of memory: patch");
        goto cleanup;
    }
    status = ll_change_values(s->scenario.kind, probe, patch, collect, values);
    if (ll_failed(&status) || cJSON_GetArraySize(values) == 0)
        goto cleanup;
    text = cJSON_PrintUnformatted(values);
    status = append(s, &(ll_log_entry){.tick = s->tick, .op = LL_OP_SET, .values = text});
cleanup:
    cJSON_free(text);
    cJSON_Delete(values);
    free(probe);
    return status;
}

static const ll_log_entry *last_input(const ll_session *s, int player)
{
    for (size_t i = s->position.next; i-- > 0;)
        if (s->log.entries[i].op == LL_OP_INPUT && s->log.entries[i].player == player)
            return &s->log.entries[i];
    return NULL;
}

ll_status ll_session_input(ll_session *s, ll_time wall, int player, const ll_action *action)
{
    (void)wall;
    LL_TRY(ll_session_wake(s));
    if (s->status == LL_SESSION_FAILED || s->tick >= s->end)
        return ll_error(LL_CONFLICT, "the session has ended");
    if (!s->scenario.kind->input)
        return ll_error(LL_CONFLICT, "kind %s has no players that take inputs", s->scenario.kind->name);
    LL_TRY(s->scenario.kind->accepts(s->config, player, action));
    const ll_log_entry *last = last_input(s, player);
    const ll_action none = {0}, *held = last ? &last->action : &none;
    if (memcmp(held, action, sizeof *action) == 0)
        return ll_ok();
    return append(s,
                  &(ll_log_entry){.tick = s->tick, .op = LL_OP_INPUT, .player = player, .action = *action});
}

/* Some live parameters determine the size of the block (server.sync: the longest packets); a change keeps the
 * layout, a new start makes its own. */
static ll_status resize(ll_session *s, size_t size)
{
    if (size == s->block_size)
        return ll_ok();
    if (s->block) {
        void *block = ll_state_memory_new(size);
        if (!block)
            return ll_error(LL_NO_MEMORY, "out of memory: state of a session (%zu bytes)", size);
        ll_state_memory_free(s->block);
        s->block = block;
    }
    ll_session_drop_spare(s);
    s->block_size = size;
    return ll_ok();
}

ll_status ll_session_rebase(ll_session *s, const void *base)
{
    LL_TRY(resize(s, s->scenario.kind->size(base)));
    s->transition.kind = LL_TRANSITION_NONE;
    s->failure.tick = -1;
    s->hashes.count = 0;
    ll_session_drop_checkpoints(s, -1);
    ll_log_truncate(&s->log, 0);
    ll_param_copy(s->scenario.kind->table, s->base, base);
    ll_param_copy(s->scenario.kind->table, s->config, base);
    s->position.next = 0;
    s->tick = s->head = 0;
    s->failure.status = ll_ok();
    if (s->status == LL_SESSION_FAILED || s->status == LL_SESSION_ENDED)
        s->status = LL_SESSION_PAUSED;
    s->params_version++;
    if (s->block)
        ll_session_rebuild(s, 0);
    return ll_ok();
}

void ll_session_step_profiler(ll_session *s, int64_t (*now_ns)(void))
{
    s->meter.step_profiler.now_ns = now_ns;
}

void ll_session_account(ll_session *s, int64_t cpu_ns, int64_t ticks)
{
    s->meter.cpu_ns += cpu_ns;
    s->meter.cpu_ticks += ticks;
}
