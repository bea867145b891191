#include "session/workload.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "session/internal.h"

struct ll_workload {
    ll_freq freq;
    ll_log inputs; /* only LL_OP_INPUT */
};

void ll_workload_free(ll_workload *w)
{
    if (!w)
        return;
    ll_log_free(&w->inputs);
    free(w);
}

/* ---- reading ---- */

static ll_status add(ll_workload *w, const ll_log_entry *input)
{
    if (w->inputs.count == LL_WORKLOAD_MAX)
        return ll_field_error(LL_BAD_INPUT, "workload", "workload: must have at most %d inputs",
                              LL_WORKLOAD_MAX);
    return ll_log_append(&w->inputs, input);
}

/* The inputs that remain after all rewinds and restarts. */
static ll_status read_log(const char *text, ll_workload *w)
{
    ll_session *s;
    ll_status status = ll_session_restore(text, strlen(text), NULL, NULL, &s);
    if (ll_failed(&status))
        return ll_field_error(status.code, "workload", "workload: %s", status.text);
    w->freq = s->freq;
    for (size_t i = 0; i < s->log.count && !ll_failed(&status); i++)
        if (s->log.entries[i].op == LL_OP_INPUT)
            status = add(w, &s->log.entries[i]);
    ll_session_destroy(s);
    return status;
}

static ll_status check_keys(const cJSON *o, const char *field, const char *const *names, const char *known)
{
    const cJSON *item;
    if (!cJSON_IsObject(o))
        return ll_field_error(LL_BAD_INPUT, field, "%s: must be an object", field);
    cJSON_ArrayForEach(item, o)
    {
        const char *const *name = names;
        while (*name && strcmp(*name, item->string) != 0)
            name++;
        if (!*name)
            return ll_field_error(LL_BAD_INPUT, field, "%s: %.40s is unknown; known are %s", field,
                                  item->string, known);
    }
    return ll_ok();
}

static ll_status read_input(const cJSON *o, size_t index, ll_workload *w)
{
    static const char *const names[] = {"tick", "player", "axes", "buttons", "op", NULL};
    char field[48];
    ll_log_entry e;
    snprintf(field, sizeof field, "workload.inputs.%zu", index);
    ll_status status = check_keys(o, field, names, "tick, player, axes and buttons");
    if (!ll_failed(&status))
        status = ll_input_read(o, &e);
    else
        return status;
    if (ll_failed(&status))
        return ll_field_error(LL_BAD_INPUT, field, "%s: %s", field, status.text);
    const ll_log_entry *last = index > 0 ? &w->inputs.entries[index - 1] : NULL;
    if (last && e.tick < last->tick)
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: tick: must be at least %lld, that of the previous input; got %lld", field,
                              (long long)last->tick, (long long)e.tick);
    return add(w, &e);
}

static ll_status read_object(const cJSON *json, ll_workload *w)
{
    static const char *const names[] = {"tick_hz", "inputs", NULL};
    const cJSON *hz = cJSON_GetObjectItemCaseSensitive(json, "tick_hz"),
                *inputs = cJSON_GetObjectItemCaseSensitive(json, "inputs"), *item;
    size_t index = 0;
    ll_status status = check_keys(json, "workload", names, "tick_hz and inputs");
    if (ll_failed(&status))
        return status;
    if (hz && !(cJSON_IsNumber(hz) && hz->valuedouble >= 1 && hz->valuedouble <= 1000))
        return ll_field_error(LL_BAD_INPUT, "workload.tick_hz",
                              "workload.tick_hz: must be a number from 1 to 1000 Hz");
    if (!cJSON_IsArray(inputs))
        return ll_field_error(LL_BAD_INPUT, "workload.inputs", "workload.inputs: must be an array of inputs");
    w->freq = ll_freq_from_hz(hz ? hz->valuedouble : 60);
    cJSON_ArrayForEach(item, inputs)
    {
        status = read_input(item, index++, w);
        if (ll_failed(&status))
            return status;
    }
    return ll_ok();
}

ll_status ll_workload_parse(const cJSON *json, ll_workload **workload)
{
    ll_workload *w = calloc(1, sizeof *w);
    *workload = NULL;
    if (!w)
        return ll_error(LL_NO_MEMORY, "out of memory: workload");
    ll_status status = ll_ok();
    if (cJSON_IsString(json))
        status = read_log(json->valuestring, w);
    else if (cJSON_IsObject(json))
        status = read_object(json, w);
    else
        status = ll_field_error(LL_BAD_INPUT, "workload",
                                "workload: must be the text of a log, or an object with tick_hz and inputs");
    if (!ll_failed(&status) && w->inputs.count == 0)
        status = ll_field_error(
            LL_BAD_INPUT, "workload",
            "workload has no inputs; record those of a script with laglab run --record-inputs");
    if (ll_failed(&status))
        ll_workload_free(w);
    else
        *workload = w;
    return status;
}

ll_status ll_workload_check(const ll_workload *w, const ll_sim_kind *kind, const void *config)
{
    bool driven = false;
    if (!kind->accepts)
        return ll_field_error(LL_BAD_INPUT, "workload", "workload: kind %s has no players that take inputs",
                              kind->name);
    for (size_t i = 0; i < w->inputs.count; i++) {
        const ll_log_entry *e = &w->inputs.entries[i];
        ll_status status = kind->accepts(config, e->player, &e->action);
        if (ll_failed(&status) && status.code != LL_CONFLICT)
            return ll_field_error(LL_BAD_INPUT, "workload", "workload: input of tick %lld: %s",
                                  (long long)e->tick, status.text);
        driven = driven || !ll_failed(&status);
    }
    return driven ? ll_ok()
                  : ll_field_error(LL_CONFLICT, "workload",
                                   "workload: no player takes its inputs; set players.0.control, or that of "
                                   "another player, to person");
}

cJSON *ll_workload_write(const ll_workload *w)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddItemToObject(o, "tick_hz", ll_param_number((double)w->freq / 1000));
    cJSON *inputs = cJSON_AddArrayToObject(o, "inputs");
    for (size_t i = 0; i < w->inputs.count; i++)
        cJSON_AddItemToArray(inputs, ll_input_write(&w->inputs.entries[i]));
    return o;
}

/* ---- into a session ---- */

/* First tick of clock `there` at or after tick `k` of clock `here`. */
static int64_t map_tick(int64_t k, ll_freq here, ll_freq there)
{
    ll_time time = ll_tick_time(k, here);
    int64_t tick = ll_tick_at(time, there);
    return ll_tick_time(tick, there) < time ? tick + 1 : tick;
}

ll_status ll_session_load(ll_session *s, const ll_workload *w)
{
    LL_ASSERT(s->log.count == 0 && s->tick == 0);
    ll_status status = ll_workload_check(w, s->scenario.kind, s->config);
    if (ll_failed(&status))
        return status;
    for (size_t i = 0; i < w->inputs.count; i++) {
        ll_log_entry e = w->inputs.entries[i];
        e.tick = map_tick(e.tick, w->freq, s->freq);
        if (e.tick >= s->end)
            break;
        status = ll_log_append(&s->log, &e);
        if (ll_failed(&status))
            return status;
        if (s->listener.on_line)
            ll_session_emit_entry(&e, s->listener.on_line, s->listener.context);
        s->head = e.tick;
    }
    if (s->block)
        ll_session_apply_due(s);
    return ll_ok();
}

/* ---- out of a session ---- */

static void emit(cJSON *o, ll_log_line *line, void *context)
{
    char *text = cJSON_PrintUnformatted(o);
    if (text)
        line(context, text, strlen(text));
    cJSON_free(text);
    cJSON_Delete(o);
}

/* Writes the scenario with all players' control set to `person`: the log has the inputs of all of them. */
static int emit_create(const ll_session *s, ll_log_line *line, void *context)
{
    cJSON *o = ll_session_create_line(s), *player;
    cJSON *players = cJSON_GetObjectItem(cJSON_GetObjectItem(o, "scenario"), "players");
    int count = cJSON_GetArraySize(players);
    cJSON_ArrayForEach(player, players)
    {
        cJSON_DeleteItemFromObject(player, "control");
        cJSON_AddStringToObject(player, "control", "person");
    }
    emit(o, line, context);
    return count;
}

static bool same(const ll_action *a, const ll_action *b)
{
    return a->axis[0] == b->axis[0] && a->axis[1] == b->axis[1] && a->buttons == b->buttons;
}

ll_status ll_session_record(ll_session *s, ll_log_line *line, void *context)
{
    const ll_sim_kind *kind = s->scenario.kind;
    ll_action held[LL_PLAYERS_MAX] = {{{0}, 0, 0}};
    if (!kind->controls)
        return ll_error(LL_CONFLICT, "kind %s has no players that take inputs", kind->name);
    int players = emit_create(s, line, context);
    ll_status status = ll_session_wake(s);
    for (int64_t tick = 1; tick <= s->end && !ll_failed(&status); tick++) {
        status = ll_session_run_to(s, tick);
        for (int i = 0; i < players && !ll_failed(&status); i++) {
            ll_log_entry e = {.tick = tick - 1, .op = LL_OP_INPUT, .player = i};
            e.action = kind->controls(s->block, i);
            if (same(&e.action, &held[i]))
                continue;
            held[i] = e.action;
            ll_session_emit_entry(&e, line, context);
        }
    }
    ll_session_emit_op(s, "head", line, context);
    return status;
}
