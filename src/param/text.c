#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "param/internal.h"

void ll_append(ll_writer *writer, const char *format, ...)
{
    size_t room = writer->size - writer->used;
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(writer->out + writer->used, room, format, arguments);
    va_end(arguments);
    if (length > 0)
        writer->used += (size_t)length < room ? (size_t)length : room - 1;
}

void ll_count_range(const ll_param *row, char *out, size_t size)
{
    ll_writer writer = {out, size, 0};
    if (row->min > 0)
        ll_append(&writer, "%.0f to %.0f", row->min, row->max);
    else
        ll_append(&writer, "at most %.0f", row->max);
}

void ll_append_printable(ll_writer *writer, const char *text, size_t length, size_t limit)
{
    size_t shown = 0;
    while (shown < length) {
        int sequence = ll_utf8_printable(text + shown);
        size_t bytes = sequence == 0 ? 1 : (size_t)sequence;
        if (shown + bytes > limit || writer->used + bytes + sizeof "..." > writer->size) {
            ll_append(writer, "...");
            return;
        }
        memcpy(writer->out + writer->used, sequence == 0 ? "?" : text + shown, bytes);
        writer->used += bytes;
        writer->out[writer->used] = '\0';
        shown += bytes;
    }
}

static int lower(char c)
{
    return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

#define COMPARED 40

/* Edit distance of two names: a letter added, removed or changed, or two neighbours swapped; case is
 * ignored. */
static int distance(const char *a, int a_length, const char *b, int b_length)
{
    int rows[3][COMPARED + 1];
    int *older = rows[0], *old = rows[1], *now = rows[2];
    for (int j = 0; j <= b_length; j++)
        old[j] = j;
    for (int i = 1; i <= a_length; i++) {
        now[0] = i;
        for (int j = 1; j <= b_length; j++) {
            int same = lower(a[i - 1]) == lower(b[j - 1]);
            now[j] = least(old[j - 1] + !same, least(old[j], now[j - 1]) + 1);
            if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]))
                now[j] = least(now[j], older[j - 2] + 1);
        }
        int *spare = older;
        older = old;
        old = now;
        now = spare;
    }
    return old[b_length];
}

/* Names are often written without their unit: `lag` for `lag_ms`. */
static bool begins_like(const char *name, int length, const char *row, int row_length)
{
    int common = least(length, row_length);
    return common >= 3 && distance(name, common, row, common) == 0;
}

const char *ll_nearest_name(const ll_param_table *table, const char *name, size_t length)
{
    const char *nearest = NULL;
    int best = COMPARED;
    if (table == NULL || length > COMPARED)
        return NULL;
    for (int i = 0; i < table->count; i++) {
        const char *row = table->rows[i].name;
        int row_length = (int)strlen(row);
        if (row_length > COMPARED)
            continue;
        int edits = begins_like(name, (int)length, row, row_length)
                        ? 1
                        : distance(name, (int)length, row, row_length);
        if (edits < best && edits <= 1 + row_length / 4 && edits < row_length) {
            best = edits;
            nearest = row;
        }
    }
    return nearest;
}

/* Texts and choices may be bare; other text that is not JSON becomes a string, which the row then rejects. */
cJSON *ll_read_text(const ll_param *row, const char *text)
{
    bool bare = row != NULL && (row->type == LL_PARAM_TEXT || row->type == LL_PARAM_CHOICE) && text[0] != '"';
    cJSON *json = bare ? NULL : cJSON_ParseWithOpts(text, NULL, 1);
    return json != NULL ? json : cJSON_CreateString(text);
}
