/* RFC 4180. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/format/formats.h"

/* Whole numbers, as in most columns, without printf. */
static void whole(FILE *file, int64_t value)
{
    char digits[24], *p = digits + sizeof digits;
    uint64_t left = value < 0 ? (uint64_t)-value : (uint64_t)value;
    do
        *--p = (char)('0' + left % 10);
    while (left /= 10);
    if (value < 0)
        *--p = '-';
    fwrite(p, 1, (size_t)(digits + sizeof digits - p), file);
}

void ll_format_number(FILE *file, double value)
{
    char out[32];
    if (fabs(value) < 1e15 && value == (double)(int64_t)value && !(value == 0 && signbit(value))) {
        whole(file, (int64_t)value);
        return;
    }
    ll_number_text(value, out);
    fputs(out, file);
}

ll_status ll_format_end(FILE *file, const ll_status *status)
{
    if (ll_failed(status))
        return *status;
    return fflush(file) != 0 || ferror(file)
               ? ll_error(LL_IO, "cannot write the results: the disk is full, or the reader has closed")
               : ll_ok();
}

/* A text that a spreadsheet would read as a formula gets an apostrophe before it, which keeps it a text. */
static bool is_formula(const char *text)
{
    char *end;
    if (text[0] == '=' || text[0] == '@' || text[0] == '\t')
        return true;
    if (text[0] != '+' && text[0] != '-')
        return false;
    strtod(text, &end);
    return text[1] != '\0' && *end != '\0';
}

static void quoted(FILE *file, const char *text)
{
    if (is_formula(text)) {
        char *kept = NULL;
        size_t size = strlen(text) + 2;
        kept = malloc(size);
        if (kept) {
            snprintf(kept, size, "'%s", text);
            quoted(file, kept);
        }
        free(kept);
        return;
    }
    if (!strpbrk(text, ",\"\r\n")) {
        fputs(text, file);
        return;
    }
    fputc('"', file);
    for (; *text; text++) {
        if (*text == '"')
            fputc('"', file);
        fputc(*text, file);
    }
    fputc('"', file);
}

static void cell(FILE *file, ll_cell_type type, const ll_cell *c)
{
    if (c->null)
        return;
    if (type == LL_CELL_TEXT)
        quoted(file, c->text);
    else if (type == LL_CELL_BOOL)
        fputs(c->number != 0 ? "true" : "false", file);
    else
        ll_format_number(file, c->number);
}

void ll_csv_put_header(const ll_table *t, FILE *file)
{
    for (int i = 0; i < t->column_count; i++) {
        quoted(file, t->columns[i].name);
        fputs(i + 1 < t->column_count ? "," : "\r\n", file);
    }
}

void ll_csv_put_row(const ll_table *t, const ll_cell *cells, FILE *file)
{
    for (int i = 0; i < t->column_count; i++) {
        cell(file, t->columns[i].type, &cells[i]);
        fputs(i + 1 < t->column_count ? "," : "\r\n", file);
    }
}

/* In place: fields are never longer than their text. */
int ll_csv_split(char *line, char **fields, int most)
{
    int count = 0;
    for (char *from = line, *to = line; count < most;) {
        bool quote = false;
        fields[count++] = to;
        for (; *from && (quote || !strchr(",\r\n", *from)); from++)
            if (*from != '"' || (quote && from[1] == '"' && from++))
                *to++ = *from;
            else
                quote = !quote;
        bool more = *from == ',';
        *to++ = '\0';
        from++;
        if (!more)
            break;
    }
    for (int i = 0; i < count; i++)
        fields[i] += fields[i][0] == '\'' && is_formula(fields[i] + 1);
    return count;
}

static ll_status write(const ll_table *t, FILE *file)
{
    ll_cell cells[LL_COLUMNS_MAX];
    ll_status status = ll_ok();
    ll_csv_put_header(t, file);
    while (!ferror(file) && t->next(t->context, cells, &status))
        ll_csv_put_row(t, cells, file);
    return ll_format_end(file, &status);
}

const ll_format ll_format_csv = {"csv", "text/csv; charset=utf-8", "RFC 4180 with a header", write};
