/* The log of a session, in memory and as lines of JSON.
 *
 * Lines are only appended. {"op":"rewind"} invalidates the lines after a tick, {"op":"restart"} all earlier
 * lines. Restoring applies both. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session/internal.h"

#include "base/assert.h"

ll_status ll_log_append(ll_log *log, const ll_log_entry *entry)
{
    LL_ASSERT(log->count == 0 ||
              entry->tick >= log->entries[log->count - 1].tick); /* in the order of ticks */
    if (log->count == log->capacity) {
        size_t capacity = log->capacity ? 2 * log->capacity : 16;
        ll_log_entry *entries = realloc(log->entries, capacity * sizeof *entries);
        if (!entries)
            return ll_error(LL_NO_MEMORY, "out of memory: log of the session");
        log->entries = entries;
        log->capacity = capacity;
    }
    ll_log_entry copy = *entry;
    if (entry->values) {
        size_t length = strlen(entry->values) + 1;
        copy.values = malloc(length);
        if (!copy.values)
            return ll_error(LL_NO_MEMORY, "out of memory: log of the session");
        memcpy(copy.values, entry->values, length);
        log->text_bytes += length;
    }
    log->entries[log->count++] = copy;
    return ll_ok();
}

void ll_log_truncate(ll_log *log, size_t count)
{
    while (log->count > count) {
        ll_log_entry *e = &log->entries[--log->count];
        if (e->values)
            log->text_bytes -= strlen(e->values) + 1;
        free(e->values);
    }
}

void ll_log_free(ll_log *log)
{
    ll_log_truncate(log, 0);
    LL_ASSERT(log->text_bytes == 0); /* all texts were counted */
    free(log->entries);
    *log = (ll_log){0};
}

/* ---- writing ---- */

static void emit(cJSON *object, ll_log_line *line, void *context)
{
    char *text = cJSON_PrintUnformatted(object);
    if (text)
        line(context, text, strlen(text));
    cJSON_free(text);
    cJSON_Delete(object);
}

cJSON *ll_session_create_line(const ll_session *s)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "op", "create");
    cJSON_AddNumberToObject(o, "laglab_log", LL_LOG_FORMAT);
    cJSON_AddStringToObject(o, "version", s->version);
    cJSON_AddItemToObject(o, "scenario", ll_param_write(s->scenario.kind->table, s->base));
    return o;
}

void ll_session_emit_create(const ll_session *s, ll_log_line *line, void *context)
{
    emit(ll_session_create_line(s), line, context);
}

void ll_session_emit_restart(const ll_session *s)
{
    if (!s->listener.on_line)
        return;
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "op", "restart");
    cJSON_AddItemToObject(o, "scenario", ll_param_write(s->scenario.kind->table, s->base));
    emit(o, s->listener.on_line, s->listener.context);
}

static void add_input(cJSON *o, const ll_log_entry *entry)
{
    double axes[2] = {(double)entry->action.axis[0], (double)entry->action.axis[1]};
    cJSON_AddNumberToObject(o, "tick", (double)entry->tick);
    cJSON_AddNumberToObject(o, "player", entry->player);
    cJSON_AddItemToObject(o, "axes", cJSON_CreateDoubleArray(axes, 2));
    cJSON_AddNumberToObject(o, "buttons", entry->action.buttons);
}

cJSON *ll_input_write(const ll_log_entry *entry)
{
    cJSON *o = cJSON_CreateObject();
    add_input(o, entry);
    return o;
}

void ll_session_emit_entry(const ll_log_entry *entry, ll_log_line *line, void *context)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "op", entry->op == LL_OP_SET ? "set" : "input");
    if (entry->op == LL_OP_SET) {
        cJSON_AddNumberToObject(o, "tick", (double)entry->tick);
        cJSON_AddItemToObject(o, "values", cJSON_Parse(entry->values));
    } else {
        add_input(o, entry);
    }
    emit(o, line, context);
}

void ll_session_emit_op(const ll_session *s, const char *op, ll_log_line *line, void *context)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "op", op);
    cJSON_AddNumberToObject(o, "tick", (double)s->tick);
    if (strcmp(op, "play") == 0)
        cJSON_AddNumberToObject(o, "speed", s->clock.speed);
    emit(o, line, context);
}

static void add_hash(cJSON *o, uint64_t hash)
{
    char text[17];
    snprintf(text, sizeof text, "%016" PRIx64, hash);
    cJSON_AddStringToObject(o, "hash", text);
}

void ll_session_emit_hash(const ll_tick_hash *mark, ll_log_line *line, void *context)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "op", "hash");
    cJSON_AddNumberToObject(o, "tick", (double)mark->tick);
    add_hash(o, mark->hash);
    emit(o, line, context);
}

/* `tick` is the last tick that was reached; the hash is of the state of the failure after it. */
void ll_session_emit_failure(const ll_session *s, ll_log_line *line, void *context)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "op", "fail");
    cJSON_AddNumberToObject(o, "tick", (double)s->failure.tick);
    cJSON_AddStringToObject(o, "detail", s->failure.status.text);
    if (s->failure.hash)
        add_hash(o, s->failure.hash);
    emit(o, line, context);
}

static void emit_hashes(const ll_session *s, int *next, int64_t before, ll_log_line *line, void *context)
{
    while (*next < s->hashes.count && s->hashes.marks[*next].tick < before)
        ll_session_emit_hash(&s->hashes.marks[(*next)++], line, context);
}

/* The present state's hash, for a session with a listener: a caller that writes the log itself has its own
 * hashes. */
static void emit_present(const ll_session *s, ll_log_line *line, void *context)
{
    if (s->listener.on_line && s->block && s->transition.kind == LL_TRANSITION_NONE &&
        s->status != LL_SESSION_FAILED)
        ll_session_emit_hash(&(ll_tick_hash){s->tick, s->scenario.kind->hash(s->block)}, line, context);
}

void ll_session_log(const ll_session *s, ll_log_line *line, void *context)
{
    int mark = 0;
    ll_status readable = ll_session_unpack((ll_session *)(uintptr_t)s); /* the same session, packed or not */
    if (ll_failed(&readable))
        return;
    ll_session_emit_create(s, line, context);
    for (size_t i = 0; i < s->log.count; i++) {
        emit_hashes(s, &mark, s->log.entries[i].tick, line, context);
        ll_session_emit_entry(&s->log.entries[i], line, context);
    }
    emit_hashes(s, &mark, INT64_MAX, line, context);
    emit_present(s, line, context);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "op", "head");
    cJSON_AddNumberToObject(o, "tick", (double)s->head);
    emit(o, line, context);
    if (s->failure.tick >= 0)
        ll_session_emit_failure(s, line, context);
}
