#include "experiment/format/csv_rows.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/format/formats.h"
#include "experiment/format/table_internal.h"

/* ---- from text to row ---- */

static double number(const char *text)
{
    return text[0] ? strtod(text, NULL) : NAN;
}

/* The values that a row does not have, such as its seed, follow from the experiment. What is wrong in the
 * text shows when the row is written again. Returns the number of fields. */
static int read_row(const ll_csv_rows *r, char *line, char *fields[LL_COLUMNS_MAX], ll_row *row)
{
    const ll_experiment *e = r->experiment;
    int columns = ll_result_table_get(r->table)->column_count;
    int count = ll_csv_split(line, fields, LL_COLUMNS_MAX);
    ll_row_clear(row);
    if (count != columns)
        return count;
    char **metrics = fields + columns - ll_version_columns.count - e->metric_count,
         **end = metrics - ll_end_columns.count; /* status, error, hash, t_s */
    row->run = strtoll(fields[0], NULL, 10);
    for (ll_row_status k = LL_ROW_OK; k <= LL_ROW_SKIPPED; k++)
        if (strcmp(ll_row_status_names[k], end[0]) == 0)
            row->status = k;
    snprintf(row->error, sizeof row->error, "%s", end[1]);
    row->hash = strtoull(end[2], NULL, 16);
    row->t_s = number(end[3]);
    for (int i = 0; i < e->metric_count; i++)
        row->metrics[i] = number(metrics[i]);
    return count;
}

static bool the_row(void *context, ll_row *row, ll_status *status)
{
    (void)status;
    *row = ((const ll_csv_rows *)context)->row;
    return true;
}

/* The line of r->row. */
static ll_status write_row(ll_csv_rows *r)
{
    ll_cell cells[LL_COLUMNS_MAX];
    ll_status status = ll_ok();
    const ll_table *t = ll_result_table_get(r->table);
    rewind(r->memory);
    t->next(t->context, cells, &status);
    ll_csv_put_row(t, cells, r->memory);
    fputc('\0', r->memory);
    return fflush(r->memory) == 0 ? status : ll_error(LL_NO_MEMORY, "out of memory: row");
}

ll_status ll_csv_rows_open(ll_csv_rows *r, const ll_experiment *e)
{
    *r = (ll_csv_rows){.experiment = e,
                       .lines = calloc((size_t)e->runs, sizeof *r->lines),
                       .memory = open_memstream(&r->text, &r->size)};
    if (!r->lines || !r->memory)
        return ll_error(LL_NO_MEMORY, "out of memory: rows");
    return ll_result_table_rows(e, r->version, the_row, r, &r->table);
}

/* ---- checks of a line ---- */

/* Names the first field that differs from that of the row written again. */
static ll_status refuse(ll_csv_rows *r, const char *path, char *line)
{
    char *is[LL_COLUMNS_MAX], *must[LL_COLUMNS_MAX];
    const ll_table *t = ll_result_table_get(r->table);
    int i = 0;
    ll_csv_split(line, is, LL_COLUMNS_MAX);
    ll_csv_split(r->text, must, LL_COLUMNS_MAX);
    while (i + 1 < t->column_count && strcmp(is[i], must[i]) == 0)
        i++;
    if (strcmp(is[i], must[i]) == 0)
        return ll_error(LL_BAD_INPUT,
                        "%.150s: the row of run %" PRId64 ": must have quotes only where they are needed",
                        path, r->row.run);
    return ll_error(LL_BAD_INPUT,
                    "%.150s: the row of run %" PRId64
                    ": %.100s: must be `%.40s` in this experiment; got `%.40s`: "
                    "the file is of another experiment, or was changed",
                    path, r->row.run, t->columns[i].name, must[i], is[i]);
}

/* Checks a row, which a truncated copy or an editor may have damaged. */
static ll_status check_line(const ll_csv_rows *r, const char *path, int64_t run, const char *line,
                            size_t size, int fields)
{
    int columns = ll_result_table_get(r->table)->column_count;
    if (strlen(line) != size || fields != columns)
        return ll_error(LL_BAD_INPUT,
                        "%.150s: the row of run %" PRId64 ": must have the %d fields of the header", path,
                        run, columns);
    if (strcspn(line, "\r\n") + 2 != size || strcmp(line + size - 2, "\r\n") != 0)
        return ll_error(LL_BAD_INPUT,
                        "%.150s: the row of run %" PRId64 " is incomplete: the file was truncated or changed",
                        path, run);
    return ll_ok();
}

/* A row ends with the version that computed it. */
static ll_status check_version(ll_csv_rows *r, const char *path, const char *version)
{
    if (version[0] == '\0')
        return ll_error(LL_BAD_INPUT, "%.150s: a row must end with the version of laglab that made it", path);
    if (r->version[0] == '\0')
        snprintf(r->version, sizeof r->version, "%s", version);
    if (strcmp(r->version, version) == 0)
        return ll_ok();
    return ll_error(LL_BAD_INPUT,
                    "%.60s has rows of laglab %.40s, an earlier shard of laglab %s; their results may "
                    "differ: run the shards of one of them again with the other",
                    path, version, r->version);
}

/* `copy` has room for the line. */
static ll_status take_line(ll_csv_rows *r, const char *path, char *line, size_t size, char *copy)
{
    char *end, *fields[LL_COLUMNS_MAX];
    bool digit = line[0] >= '0' && line[0] <= '9', canonical = line[0] != '0' || line[1] == ',';
    int64_t run = digit && canonical ? strtoll(line, &end, 10) : -1;
    if (run < 0 || *end != ',' || run >= r->experiment->runs)
        return ll_error(LL_BAD_INPUT, "%.150s: a row must begin with its run, 0 to %" PRId64 "; got %.40s",
                        path, r->experiment->runs - 1, line);
    memcpy(copy, line, size + 1);
    int count = read_row(r, copy, fields, &r->row);
    LL_TRY(check_line(r, path, run, line, size, count));
    LL_TRY(check_version(r, path, fields[count - 1]));
    LL_TRY(write_row(r));
    if (strcmp(r->text, line) != 0)
        return refuse(r, path, line);
    if (r->lines[run] && strcmp(r->lines[run], line) != 0)
        return ll_error(LL_BAD_INPUT, "%.150s: run %" PRId64 " differs between two shards", path, run);
    if (!r->lines[run])
        r->lines[run] = strdup(line);
    return r->lines[run] ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: rows");
}

/* The header that a sweep of this experiment writes. */
static ll_status check_header(ll_csv_rows *r, const char *path, const char *line, size_t size)
{
    rewind(r->memory);
    ll_csv_put_header(ll_result_table_get(r->table), r->memory);
    fputc('\0', r->memory);
    if (fflush(r->memory) != 0)
        return ll_error(LL_NO_MEMORY, "out of memory: header");
    return strcmp(line, r->text) == 0 && strlen(line) == size
               ? ll_ok()
               : ll_error(LL_BAD_INPUT,
                          "%.200s: must have the header of this experiment's runs in CSV: the file is of "
                          "another experiment, or not from sweep",
                          path);
}

ll_status ll_csv_rows_read(ll_csv_rows *r, const char *path)
{
    FILE *file = fopen(path, "rbe");
    char *line = NULL, *copy = NULL;
    size_t capacity = 0, room = 0;
    bool header = true;
    ssize_t size;
    ll_status status = file ? ll_ok() : ll_error(LL_BAD_INPUT, "cannot read %.200s", path);
    while (!ll_failed(&status) && (size = getline(&line, &capacity, file)) > 0) {
        if (room < capacity) {
            free(copy);
            copy = malloc(room = capacity);
        }
        status = !copy    ? ll_error(LL_NO_MEMORY, "out of memory: row")
                 : header ? check_header(r, path, line, (size_t)size)
                          : take_line(r, path, line, (size_t)size, copy);
        header = false;
    }
    if (!ll_failed(&status) && ferror(file))
        status = ll_error(LL_IO, "cannot read %.200s", path);
    if (!ll_failed(&status) && header)
        status = ll_error(LL_BAD_INPUT, "%.200s is empty", path);
    free(line);
    free(copy);
    if (file)
        fclose(file);
    return status;
}

ll_status ll_csv_rows_check_whole(const ll_csv_rows *r)
{
    int64_t missing = 0, first = -1;
    for (int64_t i = 0; i < r->experiment->runs; i++)
        if (!r->lines[i]) {
            first = first < 0 ? i : first;
            missing++;
        }
    return missing == 0 ? ll_ok()
                        : ll_error(LL_BAD_INPUT,
                                   "%" PRId64 " of %" PRId64 " runs are missing, the first is run %" PRId64,
                                   missing, r->experiment->runs, first);
}

/* ---- as a source ---- */

bool ll_csv_rows_next(void *context, ll_row *row, ll_status *status)
{
    ll_csv_rows *r = context;
    char *fields[LL_COLUMNS_MAX];
    while (r->at < r->experiment->runs && !r->lines[r->at])
        r->at++;
    if (r->at == r->experiment->runs)
        return false;
    char *line = strdup(r->lines[r->at++]);
    if (!line)
        *status = ll_error(LL_NO_MEMORY, "out of memory: row");
    else
        read_row(r, line, fields, row);
    free(line);
    return !ll_failed(status);
}

void ll_csv_rows_seek(void *rows, int64_t run)
{
    ((ll_csv_rows *)rows)->at = run;
}

void ll_csv_rows_close(ll_csv_rows *r)
{
    for (int64_t i = 0; r->lines && i < r->experiment->runs; i++)
        free(r->lines[i]);
    free(r->lines);
    ll_result_table_free(r->table);
    if (r->memory)
        fclose(r->memory);
    free(r->text);
    *r = (ll_csv_rows){0};
}
