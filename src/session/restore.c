/* Restores a session from its log. {"op":"rewind"} invalidates the lines after a tick, {"op":"restart"} all
 * earlier lines. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session/internal.h"

static ll_status bad_line(size_t number, const char *what)
{
    return ll_error(LL_BAD_INPUT, "line %zu of the log: %s", number, what);
}

static bool read_tick(const cJSON *o, int64_t *tick)
{
    const cJSON *t = cJSON_GetObjectItemCaseSensitive(o, "tick");
    if (!cJSON_IsNumber(t) || !(t->valuedouble >= 0 && t->valuedouble <= 1e15))
        return false;
    *tick = (int64_t)t->valuedouble;
    return true;
}

/* Logs of 0.2.0 have two members that scenarios lost since. Without effect, they are left out; a session that
 * had spectators, or its server on a player's machine, has no replay. */
static void leave_out_gone(cJSON *scenario)
{
    const cJSON *hosting = cJSON_GetObjectItemCaseSensitive(scenario, "hosting");
    const cJSON *spectators = cJSON_GetObjectItemCaseSensitive(scenario, "spectators");
    if (cJSON_IsFalse(cJSON_GetObjectItemCaseSensitive(hosting, "by_player")))
        cJSON_DeleteItemFromObjectCaseSensitive(scenario, "hosting");
    if (cJSON_IsArray(spectators) && cJSON_GetArraySize(spectators) == 0)
        cJSON_DeleteItemFromObjectCaseSensitive(scenario, "spectators");
}

static ll_status read_create(ll_session **session, const cJSON *o, ll_log_line *on_line, void *context)
{
    const cJSON *format = cJSON_GetObjectItemCaseSensitive(o, "laglab_log");
    if (!cJSON_IsNumber(format) || format->valueint != LL_LOG_FORMAT)
        return bad_line(1, "not the header of a laglab log of format 1");
    ll_scenario scenario = {0};
    leave_out_gone(cJSON_GetObjectItemCaseSensitive(o, "scenario"));
    LL_TRY(ll_scenario_parse(cJSON_GetObjectItemCaseSensitive(o, "scenario"), &scenario));
    ll_status status = ll_session_new(&scenario, scenario.config, on_line, context, session);
    const cJSON *version = cJSON_GetObjectItemCaseSensitive(o, "version");
    if (!ll_failed(&status) && cJSON_IsString(version)) /* older logs have no version */
        snprintf((*session)->version, sizeof(*session)->version, "%s", version->valuestring);
    return status;
}

/* Whether both have chosen the same game, scene or problem. */
static bool same_variants(const ll_param_table *table, const void *one, const void *other)
{
    for (int i = 0; i < table->count; i++) {
        const size_t at = table->rows[i].count_offset;
        if (table->rows[i].type == LL_PARAM_VARIANT &&
            memcmp((const char *)one + at, (const char *)other + at, sizeof(int32_t)) != 0)
            return false;
    }
    return true;
}

/* A restart may change live parameters, but neither the clock nor how many elements a list has: the memory of
 * the configurations is theirs. */
static bool same_shape(const ll_session *s, const ll_scenario *other)
{
    return other->kind == s->scenario.kind &&
           same_variants(other->kind->table, s->scenario.config, other->config) &&
           ll_param_used(other->kind->table, other->config) ==
               ll_param_used(other->kind->table, s->scenario.config) &&
           ll_param_clone_size(other->kind->table, other->config, NULL) <= s->config_size &&
           other->kind->tick_freq(other->config) == s->freq &&
           ((const ll_scenario_head *)other->config)->duration_s == ll_session_head(s)->duration_s;
}

static ll_status read_restart(ll_session *s, const cJSON *o, size_t number)
{
    ll_scenario scenario = {0};
    leave_out_gone(cJSON_GetObjectItemCaseSensitive(o, "scenario"));
    ll_status status = ll_scenario_parse_running(cJSON_GetObjectItemCaseSensitive(o, "scenario"), &scenario);
    if (!ll_failed(&status) && !same_shape(s, &scenario))
        status = bad_line(number, "restart of another scenario");
    LL_THEN(status, ll_session_rebase(s, scenario.config));
    ll_scenario_free(&scenario);
    return status;
}

static ll_status read_set(ll_session *s, const cJSON *o, int64_t tick, size_t number)
{
    const cJSON *values = cJSON_GetObjectItemCaseSensitive(o, "values");
    if (!cJSON_IsObject(values))
        return bad_line(number, "`values` missing");
    char *text = cJSON_PrintUnformatted(values);
    ll_status status =
        text ? ll_log_append(&s->log, &(ll_log_entry){.tick = tick, .op = LL_OP_SET, .values = text})
             : ll_error(LL_NO_MEMORY, "out of memory: log of the session");
    cJSON_free(text);
    return status;
}

/* Reads a whole number in [0, most]. A missing member is `default_value`, or an error if that is negative. */
static ll_status read_whole(const cJSON *o, const char *name, double most, double standard, double *value)
{
    const cJSON *member = cJSON_GetObjectItemCaseSensitive(o, name);
    *value = standard;
    if (!member && standard >= 0)
        return ll_ok();
    if (!cJSON_IsNumber(member))
        return ll_field_error(LL_BAD_INPUT, name, "%s: must be a whole number from 0 to %.15g", name, most);
    *value = member->valuedouble;
    if (!(*value >= 0 && *value <= most) || *value != (double)(int64_t)*value)
        return ll_field_error(LL_BAD_INPUT, name, "%s: must be a whole number from 0 to %.15g; got %.15g",
                              name, most, *value);
    return ll_ok();
}

static ll_status read_axis(const cJSON *axes, int i, float *axis)
{
    const cJSON *o = cJSON_GetArrayItem(axes, i);
    if (!cJSON_IsNumber(o) || cJSON_GetArraySize(axes) != 2)
        return ll_field_error(LL_BAD_INPUT, "axes", "axes: must be two numbers from -1 to 1");
    if (!(o->valuedouble >= -1 && o->valuedouble <= 1))
        return ll_field_error(LL_BAD_INPUT, "axes", "axes: must be two numbers from -1 to 1; got %.15g",
                              o->valuedouble);
    *axis = (float)o->valuedouble;
    return ll_ok();
}

ll_status ll_input_read(const cJSON *o, ll_log_entry *entry)
{
    const cJSON *axes = cJSON_GetObjectItemCaseSensitive(o, "axes");
    double tick = 0, player = 0, buttons = 0;
    *entry = (ll_log_entry){.op = LL_OP_INPUT};
    ll_status status = read_whole(o, "tick", 1e9, -1, &tick);
    LL_THEN(status, read_whole(o, "player", LL_PLAYERS_MAX - 1, -1, &player));
    for (int i = 0; i < 2 && !ll_failed(&status); i++)
        status = read_axis(axes, i, &entry->action.axis[i]);
    LL_THEN(status, read_whole(o, "buttons", UINT32_MAX, 0, &buttons));
    if (ll_failed(&status))
        return status; /* a value out of range has no conversion */
    entry->tick = (int64_t)tick;
    entry->player = (int32_t)player;
    entry->action.buttons = (uint32_t)buttons;
    return status;
}

static ll_status read_input(ll_session *s, const cJSON *o, size_t number)
{
    ll_log_entry e;
    ll_status status = ll_input_read(o, &e);
    return ll_failed(&status) ? bad_line(number, status.text) : ll_log_append(&s->log, &e);
}

static void rewind_to(ll_session *s, int64_t tick)
{
    size_t keep = s->log.count;
    while (keep > 0 && s->log.entries[keep - 1].tick > tick)
        keep--;
    ll_log_truncate(&s->log, keep);
    s->head = tick;
    s->failure.tick = -1;
    ll_session_drop_hashes(s, tick + 1);
}

/* A command drops all later ones. */
static void read_command(ll_session *s, int64_t tick)
{
    ll_session_drop_hashes(s, tick);
    if (s->failure.tick >= tick)
        s->failure.tick = -1;
}

static bool read_hash(const cJSON *o, uint64_t *hash)
{
    const cJSON *text = cJSON_GetObjectItemCaseSensitive(o, "hash");
    bool whole = cJSON_IsString(text) && strlen(text->valuestring) == 16 &&
                 strspn(text->valuestring, "0123456789abcdef") == 16;
    *hash = whole ? strtoull(text->valuestring, NULL, 16) : 0;
    return whole;
}

static void read_tick_hash(ll_session *s, const cJSON *o, int64_t tick)
{
    ll_tick_hash mark = {.tick = tick};
    if (read_hash(o, &mark.hash))
        ll_session_add_hash(s, &mark);
}

static void read_failure(ll_session *s, const cJSON *o, int64_t tick)
{
    const cJSON *detail = cJSON_GetObjectItemCaseSensitive(o, "detail");
    s->failure.tick = tick;
    read_hash(o, &s->failure.hash);
    s->failure.status =
        ll_error(LL_DIVERGED, "%s", cJSON_IsString(detail) ? detail->valuestring : "unknown failure");
}

static ll_status read_line(ll_session **session, const cJSON *o, size_t number, ll_log_line *on_line,
                           void *context)
{
    const cJSON *name = cJSON_GetObjectItemCaseSensitive(o, "op");
    const char *op = cJSON_IsString(name) ? name->valuestring : "";
    int64_t tick;
    if (!*session)
        return strcmp(op, "create") == 0 ? read_create(session, o, on_line, context)
                                         : bad_line(number, "header missing before this line");
    ll_session *s = *session;
    if (strcmp(op, "restart") == 0)
        return read_restart(s, o, number);
    if (!read_tick(o, &tick))
        return bad_line(number, "`tick` missing");
    if (tick > s->end)
        return bad_line(number, "tick is after the end of the scenario");
    bool command = strcmp(op, "set") == 0 || strcmp(op, "input") == 0;
    if (command && s->log.count > 0 && s->log.entries[s->log.count - 1].tick > tick)
        return bad_line(number, "tick is before that of the previous line");
    if (tick > s->head && strcmp(op, "rewind") != 0)
        s->head = tick;
    if (tick > s->failure.tick) /* it ran on */
        s->failure.tick = -1;
    if (command)
        read_command(s, tick);
    if (strcmp(op, "set") == 0)
        return read_set(s, o, tick, number);
    if (strcmp(op, "input") == 0)
        return read_input(s, o, number);
    if (strcmp(op, "rewind") == 0)
        rewind_to(s, tick);
    else if (strcmp(op, "hash") == 0)
        read_tick_hash(s, o, tick);
    else if (strcmp(op, "fail") == 0)
        read_failure(s, o, tick);
    else if (strcmp(op, "play") != 0 && strcmp(op, "pause") != 0 && strcmp(op, "head") != 0)
        return bad_line(number, "unknown op");
    return ll_ok();
}

/* Changes are checked after all lines are read, since a later rewind may drop them. */
static ll_status check_changes(ll_session *s)
{
    const ll_sim_kind *kind = s->scenario.kind;
    const ll_scenario_head *head = ll_session_head(s);
    ll_status status = ll_ok();
    int32_t step = 0;
    for (size_t i = 0; i < s->log.count && !ll_failed(&status); i++) {
        while (ll_timeline_tick(head, step, s->freq) <= s->log.entries[i].tick)
            ll_apply_values(kind, s->config, head->timeline[step++].set);
        if (s->log.entries[i].op == LL_OP_SET)
            status = ll_apply_values(kind, s->config, s->log.entries[i].values);
    }
    ll_param_copy(kind->table, s->config, s->base);
    return status;
}

static ll_status read_lines(const char *log, size_t length, ll_log_line *on_line, void *context,
                            ll_session **session)
{
    ll_status status = ll_ok();
    size_t number = 0;
    for (const char *p = log, *end = log + length; p < end && !ll_failed(&status);) {
        const char *newline = memchr(p, '\n', (size_t)(end - p));
        size_t size = newline ? (size_t)(newline - p) : (size_t)(end - p);
        cJSON *o = NULL;
        number++;
        if (size > 0) {
            status = ll_json_parse(p, size, &o);
            if (ll_failed(&status))
                status = bad_line(number, status.text);
            else
                status = read_line(session, o, number, on_line, context);
        }
        cJSON_Delete(o);
        p += size + 1;
    }
    if (!ll_failed(&status) && !*session)
        status = ll_error(LL_BAD_INPUT, "the log is empty");
    return status;
}

ll_status ll_session_restore(const char *log, size_t length, ll_log_line *on_line, void *context,
                             ll_session **session)
{
    *session = NULL;
    ll_status status = read_lines(log, length, on_line, context, session);
    LL_THEN(status, check_changes(*session));
    if (ll_failed(&status)) {
        ll_session_destroy(*session);
        *session = NULL;
    } else {
        ll_session *s = *session;
        bool failed = s->failure.tick >= 0 && s->failure.tick <= s->head;
        s->tick = failed ? s->failure.tick : s->head;
        s->status = failed ? LL_SESSION_FAILED : LL_SESSION_PAUSED;
    }
    return status;
}
