#include "experiment/format/trace_table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "netcode/protocol/event.h"
#include "session/records.h"

enum { TIMES = 2, FLAGS_MAX = 160 }; /* columns before the others; bytes of a text of flags */

#define BIT(type) (UINT32_C(1) << (type))
#define ALL_EVENTS UINT32_MAX

/* Parts of the record `events`. */
static const struct {
    const char *name;
    uint32_t types;
} event_parts[] = {
    {"packets", BIT(LL_EVENT_INPUT) | BIT(LL_EVENT_SNAPSHOT) | BIT(LL_EVENT_REFUSAL) | BIT(LL_EVENT_RELAY) |
                    BIT(LL_EVENT_CONNECT) | BIT(LL_EVENT_ACCEPT) | BIT(LL_EVENT_PING) | BIT(LL_EVENT_PONG)},
    {"corrections", BIT(LL_EVENT_CORRECTION) | BIT(LL_EVENT_ROLLBACK)},
};

/* Rows come from a copy of the session, tick by tick. */
struct ll_trace_table {
    ll_session *copy;
    ll_trace_request request;
    int64_t tick, given; /* the present one; rows */
    ll_table table;
    ll_column columns[LL_COLUMNS_MAX];
    /* of the trace */
    char names[LL_TRACE_COLUMNS_MAX][LL_TRACE_NAME_MAX];
    double values[LL_TRACE_COLUMNS_MAX];
    /* of a record */
    const ll_record *record;
    uint32_t types; /* of events; 0: other records */
    int64_t next_event;
    ll_row_set set;
    const ll_rows *rows; /* of the present tick */
    int row;
    char texts[LL_FIELDS_MAX][FLAGS_MAX];
};

/* ---- records ---- */

static const ll_record *events_record(void)
{
    const ll_record *all[LL_ALL_RECORDS_MAX + 1];
    ll_all_records(all);
    return all[LL_RECORD_EVENTS];
}

static const ll_record *const *records_of(const ll_session *session)
{
    const char *name = ll_session_get_info(session).kind;
    int kind = 0;
    while (strcmp(ll_sim_kinds[kind]->name, name) != 0)
        kind++;
    return ll_sim_kinds[kind]->records;
}

/* `types`: of its events. */
static ll_status find_record(const ll_session *session, const char *name, const char *of,
                             const ll_record **record, uint32_t *types)
{
    char known[200] = "events, packets, corrections";
    *types = strcmp(of, "events") == 0 ? ALL_EVENTS : 0;
    for (size_t i = 0; i < sizeof event_parts / sizeof event_parts[0]; i++)
        if (strcmp(of, event_parts[i].name) == 0)
            *types = event_parts[i].types;
    *record = *types ? events_record() : NULL;
    for (const ll_record *const *r = records_of(session); *r && !*record; r++) {
        bool is_table = (*r)->form != LL_FORM_GRID; /* else a row is a whole image */
        size_t used = strlen(known);
        if (is_table)
            snprintf(known + used, sizeof known - used, ", %s", (*r)->name);
        if (is_table && strcmp((*r)->name, of) == 0)
            *record = *r;
    }
    return *record ? ll_ok()
                   : ll_field_error(LL_BAD_INPUT, name, "%s: must be one of %s; got %.40s", name, known, of);
}

ll_status ll_trace_table_check(const ll_session *session, const char *name, const char *of)
{
    const ll_record *record;
    uint32_t types;
    return find_record(session, name, of, &record, &types);
}

/* ---- rows of a record ---- */

static ll_status fill(ll_trace_table *t)
{
    ll_row_set_clear(&t->set);
    ll_record_request request = {.channels = (uint16_t)(1u << t->record->channel),
                                 .from_event = t->next_event};
    ll_session_fill(t->copy, &request, &t->set);
    if (t->set.failed)
        return ll_error(LL_NO_MEMORY, "out of memory: trace");
    t->rows = NULL;
    t->row = 0;
    for (int i = 0; i < t->set.count; i++)
        if (t->set.record[i] == t->record)
            t->rows = t->set.rows[i];
    if (t->types && t->rows)
        t->next_event = t->rows->first + t->rows->count;
    return ll_ok();
}

/* Goes on to the next tick; the first time to that before the request's, whose events are left out. */
static ll_status take_tick(ll_trace_table *t)
{
    t->tick++;
    LL_TRY(ll_session_run_within(t->copy, t->tick, t->request.interrupt));
    return fill(t);
}

static ll_status skip_earlier(ll_trace_table *t)
{
    if (t->request.from == 0)
        return ll_ok();
    t->tick = t->request.from - 2;
    LL_TRY(take_tick(t));
    t->rows = NULL;
    return ll_ok();
}

static bool is_wanted(const ll_trace_table *t)
{
    return !t->types || t->types & BIT(ll_rows_at(t->rows, t->row)[0]);
}

/* The names of set flags, or that of a value. */
static const char *name_of(const ll_record_field *field, int64_t value, char text[FLAGS_MAX])
{
    text[0] = '\0';
    for (int i = 0; field->names[i]; i++) {
        size_t used = strlen(text);
        if (field->flags ? value >> i & 1 : value == i)
            snprintf(text + used, FLAGS_MAX - used, "%s%s", used ? "|" : "", field->names[i]);
    }
    return text;
}

static void put_times(const ll_trace_table *t, ll_cell *cells)
{
    ll_session_info info = ll_session_get_info(t->copy);
    cells[0] = (ll_cell){.number = ll_to_s(info.time)};
    cells[1] = (ll_cell){.number = (double)info.tick};
}

static void put_record(ll_trace_table *t, ll_cell *cells)
{
    const int64_t *values = ll_rows_at(t->rows, t->row);
    put_times(t, cells);
    for (int i = 0; i < t->record->count; i++) {
        const ll_record_field *field = &t->record->fields[i];
        double value = ll_field_value(field, values[i]);
        cells[TIMES + i] = field->names ? (ll_cell){.text = name_of(field, values[i], t->texts[i])}
                                        : (ll_cell){.null = !isfinite(value), .number = value};
        if (field->names && t->texts[i][0] == '\0')
            cells[TIMES + i].null = true;
    }
}

/* False: there are too many. */
static bool count_row(ll_trace_table *t, ll_status *status)
{
    int64_t most = t->request.rows_max;
    if (most == 0 || t->given++ < most)
        return true;
    *status = ll_error(LL_BAD_INPUT, "a trace must have at most %lld rows; has more by tick %lld",
                       (long long)most, (long long)t->tick);
    return false;
}

static bool next_of_record(void *context, ll_cell *cells, ll_status *status)
{
    ll_trace_table *t = context;
    *status = ll_ok();
    for (;; t->row++) {
        while (!ll_failed(status) && (!t->rows || t->row >= t->rows->count)) {
            if (t->tick == t->request.to)
                return false;
            *status = take_tick(t);
        }
        if (ll_failed(status))
            return false;
        if (is_wanted(t))
            break;
    }
    if (!count_row(t, status))
        return false;
    put_record(t, cells);
    t->row++;
    return true;
}

/* ---- rows of the trace ---- */

static bool next_tick(void *context, ll_cell *cells, ll_status *status)
{
    ll_trace_table *t = context;
    *status = ll_ok();
    if (t->tick == t->request.to || !count_row(t, status))
        return false;
    *status = ll_session_run_within(t->copy, ++t->tick, t->request.interrupt);
    if (ll_failed(status))
        return false;
    ll_trace_line line = {.values = t->values};
    ll_session_trace_line(t->copy, &line);
    put_times(t, cells);
    for (int i = 0; i < line.count; i++)
        cells[TIMES + i] = (ll_cell){.null = !isfinite(t->values[i]), .number = t->values[i]};
    return true;
}

/* ---- columns ---- */

static ll_column column(const char *name, ll_cell_type type, bool nullable)
{
    ll_column c = {.type = type, .nullable = nullable};
    snprintf(c.name, sizeof c.name, "%s", name);
    return c;
}

static ll_column column_of(const ll_record_field *field)
{
    char name[LL_COLUMN_NAME_MAX];
    ll_axis_column(field->name, field->unit, name, sizeof name);
    if (field->names)
        return column(name, LL_CELL_TEXT, true);
    if (field->coding == LL_CODE_INT)
        return column(name, field->type == LL_TYPE_BOOL ? LL_CELL_BOOL : LL_CELL_INT, false);
    return column(name, LL_CELL_REAL, true);
}

static ll_status begin_record(ll_trace_table *t)
{
    LL_TRY(find_record(t->copy, t->request.name, t->request.of, &t->record, &t->types));
    if (t->types)
        ll_session_keep_events(t->copy);
    t->columns[1] = column("session_tick", LL_CELL_INT, false); /* a record may have a tick of its own */
    for (int i = 0; i < t->record->count; i++)
        t->columns[TIMES + i] = column_of(&t->record->fields[i]);
    t->table = (ll_table){t->columns, t->record->count + TIMES, next_of_record, t};
    return skip_earlier(t);
}

static ll_status begin_columns(ll_trace_table *t)
{
    ll_trace_line line = {.names = t->names};
    ll_session_trace_line(t->copy, &line);
    if (line.count + TIMES > LL_COLUMNS_MAX)
        return ll_field_error(LL_BAD_INPUT, t->request.name,
                              "%s: must have at most %d columns in this format; has %d: take csv",
                              t->request.name, LL_COLUMNS_MAX, line.count + TIMES);
    t->columns[1] = column("tick", LL_CELL_INT, false);
    for (int i = 0; i < line.count; i++)
        t->columns[TIMES + i] = column(t->names[i], LL_CELL_REAL, true);
    t->table = (ll_table){t->columns, line.count + TIMES, next_tick, t};
    return ll_ok();
}

ll_status ll_trace_table_new(ll_session *copy, const ll_trace_request *request, ll_trace_table **table)
{
    ll_trace_table *t = calloc(1, sizeof *t);
    *table = NULL;
    if (!t)
        return ll_error(LL_NO_MEMORY, "out of memory: trace");
    t->copy = copy;
    t->request = *request;
    t->tick = request->from - 1;
    t->columns[0] = column("time_s", LL_CELL_REAL, false);
    ll_status status = request->of ? begin_record(t) : begin_columns(t);
    if (ll_failed(&status))
        ll_trace_table_free(t);
    else
        *table = t;
    return status;
}

const ll_table *ll_trace_table_get(const ll_trace_table *t)
{
    return &t->table;
}

void ll_trace_table_free(ll_trace_table *t)
{
    if (!t)
        return;
    ll_row_set_free(&t->set);
    free(t);
}
