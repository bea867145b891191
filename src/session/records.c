#include "session/records.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>

#include "base/assert.h"
#include "record/integers.h"
#include "record/schema.h"
#include "session/internal.h"
#include "sim/core/scenario_rows.h"

/* ---- session record ---- */

typedef struct session_row {
    double speed, duration_s;
    int64_t behind_ticks;
    uint32_t params_version, generation, viewers;
} session_row;

static const ll_record_field session_fields[] = {
    LL_REAL(session_row, speed, 23, NULL, "virtual seconds per second"),
    LL_STEP(session_row, duration_s, LL_BITS_S, "s", "duration of the scenario"),
    LL_INT(session_row, behind_ticks, "ticks", "ticks from this frame to the end of the log"),
    LL_INT(session_row, params_version, NULL, "changes when the parameters must be read again"),
    LL_INT(session_row, generation, NULL, "changes when time has jumped: discard everything drawn before"),
    LL_INT(session_row, viewers, NULL, "connected viewers"),
};

LL_INTEGERS(session_integers, session_row, session_fields)

static const ll_record session_record = {.id = 0,
                                         .name = "session",
                                         .channel = LL_CHANNEL_SESSION,
                                         .help = "Status and clock of the session.",
                                         .form = LL_FORM_ONE,
                                         LL_ROWS_OF(session_row, session_fields),
                                         .integers = session_integers};

static session_row session_of(const ll_session *s, const ll_record_request *request)
{
    return (session_row){.speed = s->clock.speed,
                         .duration_s = ll_to_s(ll_tick_time(s->end, s->freq)),
                         .behind_ticks = s->head - s->tick,
                         .params_version = s->params_version,
                         .generation = s->generation,
                         .viewers = request->viewers};
}

/* ---- clock record ---- */

typedef struct clock_row {
    int64_t wall_us;
} clock_row;

static const ll_record_field clock_fields[] = {
    LL_INT(clock_row, wall_us, "us", "the daemon's monotonic clock when the frame was taken"),
};

LL_INTEGERS(clock_integers, clock_row, clock_fields)

static const ll_record clock_record = {.id = 60,
                                       .name = "clock",
                                       .channel = LL_CHANNEL_CLOCK,
                                       .help = "Time at which the frame was taken.",
                                       .form = LL_FORM_ONE,
                                       LL_ROWS_OF(clock_row, clock_fields),
                                       .integers = clock_integers};

/* ---- events ---- */

typedef struct event_row {
    uint8_t type, player, fate, outcome;
    uint32_t number, tick;
    double begin_s, end_s;
    float value, device_ms, held_ms;
} event_row;

/* By ll_event_type and ll_fate. */
static const char *const event_types[] = {
    "",           "input", "state", "refusal",  "relay",  "connect",    "accept",  "ping",         "pong",
    "",           "",      "",      "",         "",       "",           "",        "input_result", "applied",
    "correction", "step",  "stall", "rollback", "desync", "connection", "dropped", "display",      "segment",
    "blocked",    NULL};
static const char *const fates[] = {"delivered", "lost", "overflow", "corrupted", NULL};

static const ll_record_field event_fields[] = {
    LL_ENUM(event_row, type, event_types,
            "type of the event; the types up to pong are packets by their message"),
    LL_INT(event_row, player, NULL, "the player that sent, received or caused it"),
    LL_ENUM(event_row, fate, fates, "fate of a packet"),
    LL_INT(event_row, outcome, NULL,
           "input result and applied state: 0 applied, 1 refused, 2 stale, 3 late, 4 undecodable; "
           "connection: its state; segment: 1 sent again, and segment, blocked: 2 to the server"),
    LL_STEP(event_row, begin_s, LL_BITS_S, "s",
            "when it was sent or happened; blocked: when it was complete; negative: in the lobby before the "
            "game"),
    LL_STEP(event_row, end_s, LL_BITS_S, "s",
            "when it arrives; begin_s for a lost packet; blocked: when it was handed over"),
    LL_INT(event_row, number, NULL,
           "input: its sequence number; state, display: the server's tick of the snapshot"),
    LL_STEP(event_row, value, LL_BITS_M, NULL,
            "correction: signed distance in m; input: first axis; applied state: x of the own entity"),
    LL_INT(
        event_row, tick, NULL,
        "input: the server's step that it is meant for; 0: applied with the step after its arrival, or not "
        "answered by snapshots"),
    LL_STEP(event_row, device_ms, LL_BITS_MS, "ms", "input: from moving the controls to making it"),
    LL_STEP(event_row, held_ms, LL_BITS_MS, "ms", "input: from making it to sending it"),
};

LL_INTEGERS(event_integers, event_row, event_fields)

static const ll_record event_record = {.id = 1,
                                       .name = "events",
                                       .channel = LL_CHANNEL_LANES,
                                       .help = "Packets, results of inputs, corrections, steps.",
                                       .form = LL_FORM_LOG,
                                       LL_ROWS_OF(event_row, event_fields),
                                       .integers = event_integers};

static event_row event_of(const ll_event *e)
{
    return (event_row){.type = e->type,
                       .player = e->player,
                       .fate = e->fate,
                       .outcome = e->outcome,
                       .number = e->number,
                       .begin_s = ll_to_s(e->begin),
                       .end_s = ll_to_s(e->end),
                       .value = e->value,
                       .tick = e->tick,
                       .device_ms = e->device_ms,
                       .held_ms = e->held_ms};
}

/* First event of the last seconds. */
static uint32_t first_recent(const ll_session *s, uint32_t oldest)
{
    ll_time from = ll_tick_time(s->tick, s->freq) - (ll_time)(LL_EVENTS_NEW_S * 1e9);
    uint32_t i = s->events.count;
    while (i > oldest && s->events.ring[(i - 1) % LL_EVENT_RING].begin >= from)
        i--;
    return i;
}

static uint32_t first_wanted(const ll_session *s, const ll_record_request *request)
{
    uint32_t end = s->events.count, oldest = s->events.base, first = end;
    if (end - oldest > LL_EVENT_RING)
        oldest = end - LL_EVENT_RING;
    if (request->from_event < end)
        first = request->from_event > oldest ? (uint32_t)request->from_event : oldest;
    uint32_t recent = request->anew ? first_recent(s, oldest) : end;
    return recent < first ? recent : first;
}

static void fill_events(const ll_session *s, const ll_record_request *request, ll_row_set *set)
{
    ll_rows *rows = set->rows[LL_RECORD_EVENTS];
    if (rows == NULL)
        return;
    uint32_t first = first_wanted(s, request);
    rows->first = first;
    event_row some[32];
    int n = 0;
    for (uint32_t i = first; i < s->events.count; i++) {
        some[n++] = event_of(&s->events.ring[i % LL_EVENT_RING]);
        if (n == sizeof some / sizeof *some || i + 1 == s->events.count) {
            ll_row_set_put(set, &event_record, some, n);
            n = 0;
        }
    }
}

/* ---- all records ---- */

static const ll_record *const own[LL_OWN_RECORDS] = {[LL_RECORD_SESSION] = &session_record,
                                                     [LL_RECORD_CLOCK] = &clock_record,
                                                     [LL_RECORD_EVENTS] = &event_record};

static void open_record(ll_row_set *rows, const ll_record *record, const ll_record_request *request)
{
    ll_row_set_add(rows, record, request->channels >> record->channel & 1);
}

void ll_session_fill(const ll_session *s, const ll_record_request *request, ll_row_set *rows)
{
    LL_ASSERT(s->block != NULL);
    for (int i = 0; i < LL_OWN_RECORDS; i++)
        open_record(rows, own[i], request);
    for (const ll_record *const *record = s->scenario.kind->records; *record; record++)
        open_record(rows, *record, request);
    session_row session = session_of(s, request);
    clock_row clock = {(int64_t)(request->wall_ns / 1000)};
    ll_row_set_put(rows, &session_record, &session, 1);
    ll_row_set_put(rows, &clock_record, &clock, 1);
    fill_events(s, request, rows);
    s->scenario.kind->fill(s->block, rows);
    for (int i = 0; i < rows->count; i++)
        if (rows->rows[i] != NULL)
            ll_rows_sort(rows->rows[i]);
}

void ll_all_records(const ll_record *records[LL_ALL_RECORDS_MAX + 1])
{
    int n = 0;
    for (int i = 0; i < LL_OWN_RECORDS; i++)
        records[n++] = own[i];
    for (int k = 0; ll_sim_kinds[k]; k++)
        for (const ll_record *const *record = ll_sim_kinds[k]->records; *record; record++) {
            LL_ASSERT(n < LL_ALL_RECORDS_MAX);
            records[n++] = *record;
        }
    records[n] = NULL;
}

cJSON *ll_stream_schema(void)
{
    const ll_record *records[LL_ALL_RECORDS_MAX + 1];
    ll_all_records(records);
    cJSON *schema = ll_record_schema(records), *channels = cJSON_AddArrayToObject(schema, "channels");
    char hash[17];
    snprintf(hash, sizeof hash, "%016" PRIx64, ll_record_schema_hash(records));
    cJSON_AddStringToObject(schema, "hash", hash);
    for (int i = 0; i < LL_CHANNELS; i++) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "name", ll_channels[i].name);
        cJSON_AddStringToObject(o, "help", ll_channels[i].help);
        cJSON_AddItemToArray(channels, o);
    }
    return schema;
}

uint64_t ll_stream_schema_hash(void)
{
    const ll_record *records[LL_ALL_RECORDS_MAX + 1];
    ll_all_records(records);
    return ll_record_schema_hash(records);
}

static void add_kind(cJSON *kinds, const ll_sim_kind *kind, const ll_metric_table *const *tables)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "kind", kind->name);
    cJSON_AddItemToObject(o, "tables", ll_metrics_schema(tables));
    cJSON_AddItemToArray(kinds, o);
}

cJSON *ll_metrics_of_kinds(void)
{
    cJSON *o = cJSON_CreateObject(), *kinds = cJSON_AddArrayToObject(o, "kinds");
    for (int k = 0; ll_sim_kinds[k]; k++)
        add_kind(kinds, ll_sim_kinds[k], ll_sim_kinds[k]->metric_tables);
    cJSON_AddItemToObject(o, "common", ll_metrics_schema(ll_session_metric_tables));
    return o;
}

cJSON *ll_traces_of_kinds(void)
{
    cJSON *o = cJSON_CreateObject(), *kinds = cJSON_AddArrayToObject(o, "kinds");
    for (int k = 0; ll_sim_kinds[k]; k++)
        add_kind(kinds, ll_sim_kinds[k], ll_sim_kinds[k]->trace_tables);
    return o;
}
