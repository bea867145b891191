/* Reading from a session: information, metrics, cost, copies and traces. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session/internal.h"
#include "session/records.h"

static size_t checkpoint_bytes(const ll_session *s)
{
    size_t bytes = 0;
    for (int i = 0; i < LL_CHECKPOINTS; i++)
        if (s->checkpoints[i].block)
            bytes += s->block_size + ll_param_used(s->scenario.kind->table, s->config);
    return bytes;
}

static size_t event_bytes(const ll_session *s)
{
    return s->events.ring ? LL_EVENT_RING * sizeof *s->events.ring : 0;
}

static size_t log_bytes(const ll_session *s)
{
    return s->log.capacity * sizeof(ll_log_entry) + s->log.text_bytes;
}

static size_t block_bytes(const ll_session *s)
{
    return s->block ? s->block_size : 0;
}

static ll_block_use block_use(const ll_session *s)
{
    return s->block && s->scenario.kind->use ? s->scenario.kind->use(s->block) : (ll_block_use){0};
}

static size_t fixed_bytes(const ll_session *s)
{
    return sizeof *s + log_bytes(s) + (size_t)s->hashes.capacity * sizeof *s->hashes.marks;
}

/* What remains while the session is parked. */
static size_t parked_bytes(const ll_session *s)
{
    return fixed_bytes(s) + ll_session_packed_bytes(s);
}

size_t ll_session_bytes(const ll_session *s)
{
    size_t configs = s->packed ? ll_session_packed_bytes(s) : 3 * ll_session_config_used(s);
    size_t spare = s->spare ? s->block_size : 0;
    return fixed_bytes(s) + configs + block_bytes(s) + spare + checkpoint_bytes(s) + event_bytes(s);
}

size_t ll_session_awake_bytes(const ll_session *s)
{
    size_t config = ll_session_config_used(s), state = s->block_size + config;
    size_t events = s->scenario.kind->records_events ? LL_EVENT_RING * sizeof *s->events.ring : 0;
    return fixed_bytes(s) + 3 * config + s->block_size + (s->runs_forward ? 0 : LL_CHECKPOINTS * state) +
           events;
}

bool ll_session_begins_anew(const ll_session *s)
{
    return s->scenario.kind->begins_anew && s->tick > 0;
}

ll_session_pulse ll_session_get_pulse(const ll_session *s)
{
    bool waking = s->transition.kind == LL_TRANSITION_WAKE;
    return (ll_session_pulse){.status = waking ? s->transition.status_parked : s->status,
                              .parked = s->block == NULL || waking,
                              .tick = waking ? s->transition.target_tick : s->tick,
                              .at_tick = s->tick,
                              .params_version = s->params_version,
                              .generation = s->generation};
}

ll_session_info ll_session_get_info(const ll_session *s)
{
    ll_session_pulse pulse = ll_session_get_pulse(s);
    return (ll_session_info){
        .status = pulse.status,
        .parked = pulse.parked,
        .seeking = s->transition.kind == LL_TRANSITION_SEEK,
        .tick = pulse.tick,
        .at_tick = s->tick,
        .head_tick = s->head,
        .end_tick = s->end,
        .time = ll_tick_time(pulse.tick, s->freq),
        .head = ll_tick_time(s->head, s->freq),
        .duration = ll_tick_time(s->end, s->freq),
        .tick_freq = s->freq,
        .speed = s->clock.speed,
        .seed = ll_session_seed(s),
        .params_version = s->params_version,
        .generation = s->generation,
        .log_entries = s->log.count,
        .timeline_skipped = s->position.skipped,
        .title = ll_session_title(s),
        .kind = s->scenario.kind->name,
    };
}

int64_t ll_session_failed_at(const ll_session *s)
{
    return s->failure.tick;
}

uint64_t ll_session_failed_hash(const ll_session *s)
{
    return s->failure.hash;
}

const ll_status *ll_session_error(const ll_session *s)
{
    return ll_session_get_info(s).status == LL_SESSION_FAILED ? &s->failure.status : NULL;
}

uint64_t ll_session_hash(ll_session *s)
{
    ll_status status = ll_session_wake(s);
    return ll_failed(&status) ? 0 : s->scenario.kind->hash(s->block);
}

/* For readers of a session that may be parked: it is the same session packed or not. */
static bool is_readable(const ll_session *s)
{
    ll_status status = ll_session_unpack((ll_session *)(uintptr_t)s);
    return !ll_failed(&status);
}

cJSON *ll_session_params(ll_session *s)
{
    if (!is_readable(s))
        return NULL;
    return ll_param_write(s->scenario.kind->table, s->config);
}

static cJSON *report(ll_session *s, const char *name, cJSON *(*what)(const void *block))
{
    char hash[17];
    cJSON *o = cJSON_CreateObject();
    snprintf(hash, sizeof hash, "%016" PRIx64, ll_session_hash(s));
    cJSON_AddNumberToObject(o, "tick", (double)s->tick);
    cJSON_AddNumberToObject(o, "time_s", ll_to_s(ll_tick_time(s->tick, s->freq)));
    cJSON_AddStringToObject(o, "hash", hash);
    if (s->block)
        cJSON_AddItemToObject(o, name, what(s->block));
    return o;
}

cJSON *ll_session_state(ll_session *s)
{
    return report(s, "state", s->scenario.kind->state);
}

cJSON *ll_session_notices(const ll_session *s)
{
    const ll_sim_kind *kind = s->scenario.kind;
    return kind->notices && is_readable(s) ? kind->notices(s->config) : cJSON_CreateArray();
}

#define EXPECTATIONS(X)                                                                                      \
    X(text, metric, NULL, a->metric, "path of the metric", NULL)                                             \
    X(number, min, NULL, a->min, "minimum of the metric that the scenario expects", NULL)                    \
    X(number, value, NULL, value ? value->valuedouble : NAN, "value of the metric",                          \
      "No metric has this path, or the metric is null.")                                                     \
    X(flag, met, NULL, value && value->valuedouble >= a->min, "whether the metric reaches the minimum", NULL)

static const ll_metric_table expectation_table = {
    .path = "expect.*",
    .help = "A metric that the scenario expects to reach a minimum.",
    LL_METRICS_FROM(EXPECTATIONS)};

const ll_metric_table *const ll_session_metric_tables[] = {&expectation_table, NULL};

static void add_expectations(cJSON *metrics, const ll_scenario_head *head)
{
    cJSON *list = cJSON_CreateArray();
    for (int i = 0; i < head->expect_count; i++) {
        const ll_expectation *a = &head->expect[i];
        const cJSON *value = ll_param_number_at(metrics, a->metric);
        cJSON *o = cJSON_CreateObject();
        LL_METRICS_PUT(o, &expectation_table, EXPECTATIONS);
        cJSON_AddItemToArray(list, o);
    }
    cJSON_AddItemToObject(metrics, "expect", list);
}

cJSON *ll_session_metrics(ll_session *s)
{
    cJSON *o = report(s, "metrics", s->scenario.kind->metrics);
    cJSON *metrics = cJSON_GetObjectItemCaseSensitive(o, "metrics");
    if (metrics)
        add_expectations(metrics, ll_session_head(s));
    return o;
}

cJSON *ll_session_metric_values(ll_session *s)
{
    ll_status status = ll_session_wake(s);
    if (ll_failed(&status))
        return NULL;
    cJSON *metrics = s->scenario.kind->metrics(s->block);
    add_expectations(metrics, ll_session_head(s));
    return metrics;
}

void ll_session_time_parts(const ll_session *s, cJSON *metrics, int64_t (*now_ns)(void))
{
    if (s->scenario.kind->time_parts && is_readable(s))
        s->scenario.kind->time_parts(s->scenario.config, metrics, now_ns);
}

void ll_session_account_copy(ll_session *s, const ll_session *copy)
{
    size_t bytes = ll_session_bytes(copy);
    s->meter.trace_bytes = bytes > s->meter.trace_bytes ? bytes : s->meter.trace_bytes;
}

cJSON *ll_session_cost(const ll_session *s)
{
    cJSON *o = cJSON_CreateObject();
    double simulated = ll_to_s(ll_tick_time(s->meter.cpu_ticks, s->freq));
    const ll_block_use use = block_use(s);
    cJSON_AddNumberToObject(o, "ns_per_sim_s",
                            simulated > 0 ? (double)(int64_t)((double)s->meter.cpu_ns / simulated) : 0);
    cJSON_AddNumberToObject(o, "bytes", (double)ll_session_bytes(s));
    cJSON_AddNumberToObject(o, "block_bytes", (double)block_bytes(s));
    cJSON_AddNumberToObject(o, "metric_bytes", (double)use.metrics);
    cJSON_AddNumberToObject(o, "history_bytes", (double)use.histories);
    cJSON_AddNumberToObject(o, "checkpoint_bytes", (double)checkpoint_bytes(s));
    cJSON_AddNumberToObject(o, "event_bytes", (double)event_bytes(s));
    cJSON_AddNumberToObject(o, "trace_bytes", (double)s->meter.trace_bytes);
    cJSON_AddNumberToObject(o, "log_bytes", (double)log_bytes(s));
    cJSON_AddNumberToObject(o, "parked_bytes", (double)parked_bytes(s));
    if (s->scenario.kind->costs && s->meter.step_profiler.metered > 0 && is_readable(s)) {
        cJSON_AddNumberToObject(o, "metered_s", ll_to_s(s->meter.step_profiler.metered));
        s->scenario.kind->costs(s->config, &s->meter.step_profiler, o);
    }
    return o;
}

/* ---- copies ---- */

/* A new session with the commands up to `tick`, at tick 0. */
static ll_status copy(const ll_session *s, int64_t tick, ll_log_line *on_line, void *context,
                      ll_session **out)
{
    if (!is_readable(s))
        return ll_error(LL_NO_MEMORY, "out of memory: configuration of a session");
    cJSON *json = ll_param_write(s->scenario.kind->table, s->scenario.config);
    ll_scenario scenario = {0};
    ll_status status = ll_scenario_parse(json, &scenario);
    cJSON_Delete(json);
    if (ll_failed(&status))
        return status;
    status = ll_session_new(&scenario, s->base, on_line, context, out);
    for (size_t i = 0; !ll_failed(&status) && i < s->log.count && s->log.entries[i].tick <= tick; i++) {
        status = ll_log_append(&(*out)->log, &s->log.entries[i]);
        if (on_line && !ll_failed(&status))
            ll_session_emit_entry(&s->log.entries[i], on_line, context);
    }
    if (ll_failed(&status)) {
        ll_session_destroy(*out);
        *out = NULL;
    }
    return status;
}

ll_status ll_session_copy(const ll_session *s, int64_t tick, ll_session **out)
{
    if (tick < 0 || tick > s->head)
        return ll_field_error(LL_BAD_INPUT, "tick", "tick: must be 0 to %lld; got %lld", (long long)s->head,
                              (long long)tick);
    LL_TRY(copy(s, tick, NULL, NULL, out));
    ll_session_run_forward(*out);
    return ll_ok();
}

/* A copied state is valid only if the log that made it is the same. */
static ll_status copy_state(const ll_session *s, ll_session *c)
{
    if (!ll_session_make_state(c))
        return ll_error(LL_NO_MEMORY, "out of memory: state of a session (%zu bytes)", s->block_size);
    memcpy(c->block, s->block, s->block_size);
    if (c->events.ring && s->events.ring)
        memcpy(c->events.ring, s->events.ring, LL_EVENT_RING * sizeof *c->events.ring);
    ll_param_copy(s->scenario.kind->table, c->config, s->config);
    c->events.count = s->events.count;
    c->events.base = s->events.base;
    c->position = s->position;
    c->position.next = c->log.count;
    return ll_ok();
}

ll_status ll_session_fork(ll_session *s, ll_log_line *on_line, void *context, ll_session **out)
{
    LL_TRY(copy(s, ll_session_get_info(s).tick, on_line, context, out));
    ll_session *c = *out;
    ll_session_info info = ll_session_get_info(s);
    c->tick = c->head = info.tick;
    c->clock.speed = s->clock.speed;
    if (info.status == LL_SESSION_FAILED) {
        c->status = LL_SESSION_FAILED;
        c->failure.tick = s->failure.tick;
        c->failure.hash = s->failure.hash;
        c->failure.status = s->failure.status;
    }
    ll_status status = info.parked ? ll_session_wake(c) : copy_state(s, c);
    if (ll_failed(&status)) {
        ll_session_destroy(c);
        *out = NULL;
        return status;
    }
    if (on_line && c->failure.tick >= 0)
        ll_session_emit_failure(c, on_line, context);
    else if (on_line)
        ll_session_emit_op(c, "pause", on_line, context);
    return status;
}

/* ---- trace ---- */

void ll_session_trace_line(ll_session *s, ll_trace_line *line)
{
    ll_status status = ll_session_wake(s);
    if (!ll_failed(&status))
        s->scenario.kind->trace(s->block, line);
}

bool ll_session_parameter(ll_session *s, const char *path, double *value)
{
    void *member = NULL;
    const ll_param *row =
        is_readable(s) ? ll_param_find(s->scenario.kind->table, s->config, path, &member) : NULL;
    if (!row || !member || row->type > LL_PARAM_CHOICE)
        return false;
    *value = row->type == LL_PARAM_REAL   ? *(const double *)member
             : row->type == LL_PARAM_INT  ? (double)*(const int64_t *)member
             : row->type == LL_PARAM_BOOL ? *(const bool *)member
                                          : *(const int32_t *)member;
    return true;
}

typedef struct csv {
    void (*write)(void *context, const char *text, size_t length);
    void *context;
    char text[16384];
    size_t used;
} csv;

static void flush(csv *out)
{
    out->write(out->context, out->text, out->used);
    out->used = 0;
}

static void put(csv *out, const char *format, double value)
{
    if (out->used + 32 > sizeof out->text)
        flush(out);
    out->used += (size_t)snprintf(out->text + out->used, 32, format, value);
}

static void put_text(csv *out, const char *text)
{
    size_t length = strlen(text);
    if (out->used + length > sizeof out->text)
        flush(out);
    memcpy(out->text + out->used, text, length);
    out->used += length;
}

static void put_row(csv *out, const ll_session *s)
{
    double values[LL_TRACE_COLUMNS_MAX];
    ll_trace_line trace = {.values = values};
    s->scenario.kind->trace(s->block, &trace);
    put(out, "%.9g", ll_to_s(ll_tick_time(s->tick, s->freq)));
    put(out, ",%.0f", (double)s->tick);
    for (int i = 0; i < trace.count; i++)
        put(out, ",%.9g", values[i]);
    put_text(out, "\r\n");
}

static void put_header(csv *out, const ll_session *s)
{
    char names[LL_TRACE_COLUMNS_MAX][LL_TRACE_NAME_MAX];
    ll_trace_line trace = {.names = names};
    s->scenario.kind->trace(s->block, &trace);
    put_text(out, "time_s,tick");
    for (int i = 0; i < trace.count; i++) {
        put_text(out, ",");
        put_text(out, names[i]);
    }
    put_text(out, "\r\n");
}

ll_status ll_session_write_trace(ll_session *copy, int64_t from, int64_t to, const ll_interrupt *interrupt,
                                 void (*write)(void *context, const char *text, size_t length), void *context)
{
    csv out = {.write = write, .context = context};
    ll_piece piece = {1, 0};
    LL_TRY(ll_session_wake(copy));
    put_header(&out, copy);
    ll_status status = ll_session_run_within(copy, from, interrupt);
    for (int64_t tick = from, stop = from; tick <= to && !ll_failed(&status); tick++) {
        if (tick >= stop) {
            if (!ll_next_piece(&piece, interrupt))
                status = ll_error(LL_INTERRUPTED, "interrupted at tick %lld of %lld", (long long)tick,
                                  (long long)to);
            stop = tick + piece.size;
        }
        LL_THEN(status, ll_session_run_to(copy, tick));
        if (!ll_failed(&status))
            put_row(&out, copy);
    }
    flush(&out);
    return status;
}

ll_status ll_session_trace(ll_session *s, int64_t from, int64_t to,
                           void (*write)(void *context, const char *text, size_t length), void *context)
{
    ll_session *scratch;
    if (from < 0 || from > to || to > s->head)
        return ll_field_error(LL_BAD_INPUT, "to_s",
                              "from, to: must be in order from 0 to %lld; got %lld to %lld",
                              (long long)s->head, (long long)from, (long long)to);
    LL_TRY(ll_session_copy(s, to, &scratch));
    ll_status status = ll_session_write_trace(scratch, from, to, NULL, write, context);
    ll_session_account_copy(s, scratch);
    ll_session_destroy(scratch);
    return status;
}
