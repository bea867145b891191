/* JSON: an array of objects, or one object per line. */
#include <string.h>

#include "experiment/format/formats.h"

/* Names and texts are known to be printable UTF-8: only quotes and backslashes need escapes. */
static void string(FILE *file, const char *text)
{
    fputc('"', file);
    for (; *text; text++) {
        if (*text == '"' || *text == '\\')
            fputc('\\', file);
        fputc(*text, file);
    }
    fputc('"', file);
}

static void object(const ll_table *t, const ll_cell *cells, FILE *file)
{
    for (int i = 0; i < t->column_count; i++) {
        ll_cell_type type = t->columns[i].type;
        fputc(i ? ',' : '{', file);
        string(file, t->columns[i].name);
        fputc(':', file);
        if (cells[i].null)
            fputs("null", file);
        else if (type == LL_CELL_TEXT)
            string(file, cells[i].text);
        else if (type == LL_CELL_BOOL)
            fputs(cells[i].number != 0 ? "true" : "false", file);
        else
            ll_format_number(file, cells[i].number);
    }
    fputc('}', file);
}

static ll_status objects(const ll_table *t, FILE *file, const char *before, const char *between,
                         const char *after)
{
    ll_cell cells[LL_COLUMNS_MAX];
    ll_status status = ll_ok();
    fputs(before, file);
    for (bool first = true; !ferror(file) && t->next(t->context, cells, &status); first = false) {
        if (!first)
            fputs(between, file);
        object(t, cells, file);
    }
    fputs(after, file);
    return ll_format_end(file, &status);
}

static ll_status write_json(const ll_table *t, FILE *file)
{
    return objects(t, file, "[\n", ",\n", "\n]\n");
}

static ll_status write_ndjson(const ll_table *t, FILE *file)
{
    return objects(t, file, "", "\n", "\n");
}

const ll_format ll_format_json = {"json", "application/json", "an array of objects", write_json};
const ll_format ll_format_ndjson = {"ndjson", "application/x-ndjson", "one object per line", write_ndjson};
