#include <stdio.h>

#include "param/param.h"
#include "record/rows.h"

static void put_number(double value, ll_buffer *out)
{
    char text[32];
    if (value - value != 0) {
        ll_buffer_text(out, "null");
        return;
    }
    if (value > -1e15 && value < 1e15 && value == (double)(int64_t)value)
        snprintf(text, sizeof text, "%lld", (long long)value);
    else
        ll_number_text(value, text);
    ll_buffer_text(out, text);
}

static void put_name(const char *name, ll_buffer *out)
{
    ll_buffer_text(out, "\"");
    ll_buffer_text(out, name);
    ll_buffer_text(out, "\":");
}

static void put_text(const char *text, ll_buffer *out)
{
    ll_buffer_text(out, "\"");
    ll_buffer_text(out, text);
    ll_buffer_text(out, "\"");
}

static void put_flags(const char *const *names, int64_t bits, ll_buffer *out)
{
    const char *between = "";
    ll_buffer_text(out, "[");
    for (int i = 0; names[i] != NULL; i++) {
        if (!(bits >> i & 1))
            continue;
        ll_buffer_text(out, between);
        put_text(names[i], out);
        between = ",";
    }
    ll_buffer_text(out, "]");
}

static const char *name_of(const ll_record_field *f, int64_t value)
{
    for (int64_t i = 0; f->names[i] != NULL && value >= 0; i++)
        if (i == value)
            return f->names[i];
    return "";
}

static void put_value(const ll_record_field *f, int64_t integer, ll_buffer *out)
{
    if (f->flags)
        put_flags(f->names, integer, out);
    else if (f->names != NULL)
        put_text(name_of(f, integer), out);
    else if (f->type == LL_TYPE_BOOL)
        ll_buffer_text(out, integer ? "true" : "false");
    else
        put_number(ll_field_value(f, integer), out);
}

static void put_row(const ll_record *record, const int64_t *row, ll_buffer *out)
{
    for (int k = 0; k < record->count; k++) {
        if (k > 0)
            ll_buffer_text(out, ",");
        put_name(record->fields[k].name, out);
        put_value(&record->fields[k], row[k], out);
    }
}

static void put_plane(const uint8_t *plane, size_t size, ll_buffer *out)
{
    ll_buffer_text(out, ",\"values\":[");
    for (size_t i = 0; i < size; i++) {
        if (i > 0)
            ll_buffer_text(out, ",");
        put_number(plane[i], out);
    }
    ll_buffer_text(out, "]");
}

void ll_rows_json(const ll_rows *rows, int64_t from, ll_buffer *out)
{
    const ll_record *record = rows->record;
    const uint8_t *plane = rows->planes;
    bool log = record->form == LL_FORM_LOG, first = true;
    ll_buffer_text(out, "[");
    for (int i = 0; i < rows->count; i++) {
        if (log && rows->first + i < from)
            continue;
        ll_buffer_text(out, first ? "{" : ",{");
        first = false;
        if (log) {
            put_name("id", out);
            put_number((double)(rows->first + i), out);
            ll_buffer_text(out, ",");
        }
        put_row(record, ll_rows_at(rows, i), out);
        if (record->form == LL_FORM_GRID) {
            put_plane(plane, ll_rows_plane(rows, i), out);
            plane += ll_rows_plane(rows, i);
        }
        ll_buffer_text(out, "}");
    }
    ll_buffer_text(out, "]");
}
