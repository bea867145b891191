#include "cli/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/output.h"
#include "experiment/format/table.h"
#include "netcode/protocol/event.h"
#include "session/records.h"

enum { TIMES = 2, FLAGS_MAX = 160 }; /* columns before those of the record; bytes of a text of flags */

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

/* Where the rows come from: a copy of the session, tick by tick. */
typedef struct trace_source {
    ll_session *copy;
    int64_t tick, end;
    const ll_record *record;
    uint32_t types; /* of events */
    int64_t next_event;
    ll_row_set set;
    const ll_rows *rows; /* of the present tick */
    int row;
    ll_column columns[LL_FIELDS_MAX + TIMES];
    char texts[LL_FIELDS_MAX][FLAGS_MAX];
} trace_source;

/* ---- orders ---- */

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

/* The record that the order names. `types`: of its events. */
static ll_status find_record(const ll_session *session, const char *order, const ll_record **record,
                             uint32_t *types)
{
    const char *equals = strchr(order, '=');
    char name[40], known[200] = "events, packets, corrections";
    if (!equals || equals[1] == '\0')
        return ll_error(LL_BAD_INPUT, "--trace-of: must be RECORD=FILE; got %.100s", order);
    snprintf(name, sizeof name, "%.*s", (int)(equals - order), order);
    *types = strcmp(name, "events") == 0 ? ALL_EVENTS : 0;
    for (size_t i = 0; i < sizeof event_parts / sizeof event_parts[0]; i++)
        if (strcmp(name, event_parts[i].name) == 0)
            *types = event_parts[i].types;
    *record = *types ? events_record() : NULL;
    for (const ll_record *const *r = records_of(session); *r && !*record; r++) {
        bool is_table = (*r)->form != LL_FORM_GRID; /* else a row is a whole image */
        size_t used = strlen(known);
        if (is_table)
            snprintf(known + used, sizeof known - used, ", %s", (*r)->name);
        if (is_table && strcmp((*r)->name, name) == 0)
            *record = *r;
    }
    return *record ? ll_ok() : ll_error(LL_BAD_INPUT, "--trace-of: must be one of %s; got %s", known, name);
}

static const char *file_of(const char *order)
{
    return strchr(order, '=') + 1;
}

ll_status ll_trace_check(const ll_session *session, const char *order)
{
    const ll_record *record;
    uint32_t types;
    const ll_format *format;
    LL_TRY(find_record(session, order, &record, &types));
    return ll_argument_format(NULL, file_of(order), &format);
}

/* ---- rows ---- */

/* Goes on to the next tick, the first time to tick 0. */
static ll_status take_tick(trace_source *t)
{
    t->tick++;
    LL_TRY(ll_session_run_to(t->copy, t->tick));
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

static bool is_wanted(const trace_source *t)
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

static void put_cells(trace_source *t, ll_cell *cells)
{
    const int64_t *values = ll_rows_at(t->rows, t->row);
    ll_session_info info = ll_session_get_info(t->copy);
    cells[0] = (ll_cell){.number = ll_to_s(info.time)};
    cells[1] = (ll_cell){.number = (double)info.tick};
    for (int i = 0; i < t->record->count; i++) {
        const ll_record_field *field = &t->record->fields[i];
        double value = ll_field_value(field, values[i]);
        cells[TIMES + i] = field->names ? (ll_cell){.text = name_of(field, values[i], t->texts[i])}
                                        : (ll_cell){.null = !isfinite(value), .number = value};
        if (field->names && t->texts[i][0] == '\0')
            cells[TIMES + i].null = true;
    }
}

static bool next_row(void *context, ll_cell *cells, ll_status *status)
{
    trace_source *t = context;
    *status = ll_ok();
    for (;; t->row++) {
        while (!ll_failed(status) && (!t->rows || t->row >= t->rows->count)) {
            if (t->tick == t->end)
                return false;
            *status = take_tick(t);
        }
        if (ll_failed(status))
            return false;
        if (is_wanted(t))
            break;
    }
    put_cells(t, cells);
    t->row++;
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

ll_status ll_trace_write(ll_session *session, const char *order)
{
    const ll_format *format;
    trace_source *t = calloc(1, sizeof *t);
    if (!t)
        return ll_error(LL_NO_MEMORY, "out of memory: trace");
    t->tick = -1;
    t->end = ll_session_get_info(session).tick;
    ll_status status = find_record(session, order, &t->record, &t->types);
    LL_THEN(status, ll_argument_format(NULL, file_of(order), &format));
    LL_THEN(status, ll_session_copy(session, t->end, &t->copy));
    if (!ll_failed(&status)) {
        t->columns[0] = column("time_s", LL_CELL_REAL, false);
        t->columns[1] = column("session_tick", LL_CELL_INT, false);
        for (int i = 0; i < t->record->count; i++)
            t->columns[TIMES + i] = column_of(&t->record->fields[i]);
        ll_table table = {t->columns, t->record->count + TIMES, next_row, t};
        status = ll_argument_write(file_of(order), format, &table);
    }
    ll_row_set_free(&t->set);
    ll_session_destroy(t->copy);
    free(t);
    return status;
}

/* ---- the columns of the trace ---- */

typedef struct column_source {
    ll_session *copy;
    int64_t tick, end;
    char names[LL_TRACE_COLUMNS_MAX][LL_TRACE_NAME_MAX];
    double values[LL_TRACE_COLUMNS_MAX];
    ll_column columns[LL_COLUMNS_MAX];
} column_source;

static bool next_tick(void *context, ll_cell *cells, ll_status *status)
{
    column_source *c = context;
    *status = ll_ok();
    if (c->tick == c->end)
        return false;
    *status = ll_session_run_to(c->copy, ++c->tick);
    if (ll_failed(status))
        return false;
    ll_trace_line line = {.values = c->values};
    ll_session_trace_line(c->copy, &line);
    cells[0] = (ll_cell){.number = ll_to_s(ll_session_get_info(c->copy).time)};
    cells[1] = (ll_cell){.number = (double)c->tick};
    for (int i = 0; i < line.count; i++)
        cells[TIMES + i] = (ll_cell){.null = !isfinite(c->values[i]), .number = c->values[i]};
    return true;
}

bool ll_trace_is_csv(const char *path)
{
    const ll_format *format;
    ll_status status = ll_argument_format(NULL, path, &format);
    return ll_failed(&status) || strcmp(format->name, "csv") == 0;
}

ll_status ll_trace_write_columns(ll_session *session, const char *path)
{
    const ll_format *format;
    column_source *c = calloc(1, sizeof *c);
    if (!c)
        return ll_error(LL_NO_MEMORY, "out of memory: trace");
    c->tick = -1;
    c->end = ll_session_get_info(session).tick;
    ll_status status = ll_argument_format(NULL, path, &format);
    LL_THEN(status, ll_session_copy(session, c->end, &c->copy));
    ll_trace_line line = {.names = c->names};
    if (!ll_failed(&status))
        ll_session_trace_line(c->copy, &line);
    if (!ll_failed(&status) && line.count + TIMES > LL_COLUMNS_MAX)
        status =
            ll_error(LL_BAD_INPUT, "--trace: must have at most %d columns in this format; has %d: take csv",
                     LL_COLUMNS_MAX, line.count + TIMES);
    if (!ll_failed(&status)) {
        c->columns[0] = column("time_s", LL_CELL_REAL, false);
        c->columns[1] = column("tick", LL_CELL_INT, false);
        for (int i = 0; i < line.count; i++)
            c->columns[TIMES + i] = column(c->names[i], LL_CELL_REAL, true);
        ll_table table = {c->columns, line.count + TIMES, next_tick, c};
        status = ll_argument_write(path, format, &table);
    }
    ll_session_destroy(c->copy);
    free(c);
    return status;
}
