/* An SQLite database with one table, `results`. SQLite writes only named files, so it uses a temporary one
 * below $TMPDIR or /tmp, or memory if no file can be written. */
#include <sqlite3.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "experiment/format/formats.h"

static const char *const types[] = {
    [LL_CELL_INT] = "INTEGER", [LL_CELL_REAL] = "REAL", [LL_CELL_BOOL] = "INTEGER", [LL_CELL_TEXT] = "TEXT"};

static char *statement(const ll_table *t, bool create)
{
    sqlite3_str *sql = sqlite3_str_new(NULL);
    sqlite3_str_appendall(sql, create ? "CREATE TABLE results(" : "INSERT INTO results VALUES(");
    for (int i = 0; i < t->column_count; i++) {
        const char *comma = i ? "," : "";
        if (create)
            sqlite3_str_appendf(sql, "%s\"%w\" %s%s", comma, t->columns[i].name, types[t->columns[i].type],
                                t->columns[i].nullable ? "" : " NOT NULL");
        else
            sqlite3_str_appendf(sql, "%s?%d", comma, i + 1);
    }
    sqlite3_str_appendall(sql, create ? ") STRICT" : ")");
    return sqlite3_str_finish(sql);
}

static void bind(sqlite3_stmt *s, int at, ll_cell_type type, const ll_cell *cell)
{
    if (cell->null)
        sqlite3_bind_null(s, at);
    else if (type == LL_CELL_TEXT)
        sqlite3_bind_text(s, at, cell->text, -1, SQLITE_TRANSIENT);
    else if (type == LL_CELL_REAL)
        sqlite3_bind_double(s, at, cell->number);
    else
        sqlite3_bind_int64(s, at, (int64_t)cell->number);
}

static ll_status fill(sqlite3 *db, const ll_table *t)
{
    ll_cell cells[LL_COLUMNS_MAX];
    ll_status status = ll_ok();
    char *create = statement(t, true), *insert = statement(t, false);
    sqlite3_stmt *s = NULL;
    bool good = create && insert &&
                sqlite3_exec(db, "PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF; BEGIN", NULL, NULL,
                             NULL) == SQLITE_OK &&
                sqlite3_exec(db, create, NULL, NULL, NULL) == SQLITE_OK &&
                sqlite3_prepare_v2(db, insert, -1, &s, NULL) == SQLITE_OK;
    while (good && t->next(t->context, cells, &status)) {
        for (int i = 0; i < t->column_count; i++)
            bind(s, i + 1, t->columns[i].type, &cells[i]);
        good = sqlite3_step(s) == SQLITE_DONE;
        sqlite3_reset(s);
    }
    sqlite3_finalize(s);
    good = good && sqlite3_exec(db, "COMMIT", NULL, NULL, NULL) == SQLITE_OK;
    sqlite3_free(create);
    sqlite3_free(insert);
    if (!good && !ll_failed(&status))
        status = ll_error(LL_IO, "cannot create the SQLite file: %s", sqlite3_errmsg(db));
    return status;
}

static ll_status copy(int fd, FILE *file)
{
    char piece[65536];
    ssize_t got;
    off_t at = 0;
    while ((got = pread(fd, piece, sizeof piece, at)) > 0) {
        fwrite(piece, 1, (size_t)got, file);
        at += got;
    }
    return got == 0 ? ll_ok() : ll_error(LL_IO, "cannot read back the SQLite file");
}

/* When no file can be created: in memory. */
static ll_status write_memory(const ll_table *t, FILE *file)
{
    sqlite3 *db = NULL;
    sqlite3_int64 size = 0;
    ll_status status = sqlite3_open(":memory:", &db) == SQLITE_OK
                           ? fill(db, t)
                           : ll_error(LL_NO_MEMORY, "out of memory: SQLite file");
    unsigned char *bytes = ll_failed(&status) ? NULL : sqlite3_serialize(db, "main", &size, 0);
    if (bytes)
        fwrite(bytes, 1, (size_t)size, file);
    else if (!ll_failed(&status))
        status = ll_error(LL_NO_MEMORY, "out of memory: SQLite file");
    sqlite3_free(bytes);
    sqlite3_close(db);
    return status;
}

/* Unlinks it as soon as SQLite has opened it, so that a process that dies leaves no file. */
static ll_status write_disk(const ll_table *t, const char *path, int fd, FILE *file)
{
    sqlite3 *db = NULL;
    bool open = sqlite3_open(path, &db) == SQLITE_OK &&
                sqlite3_exec(db, "SELECT 1 FROM sqlite_master", NULL, NULL, NULL) == SQLITE_OK;
    unlink(path);
    ll_status status = open ? fill(db, t) : ll_error(LL_IO, "cannot open %s", path);
    sqlite3_close(db);
    return ll_failed(&status) ? status : copy(fd, file);
}

static ll_status write_file(const ll_table *t, FILE *file)
{
    const char *folder = getenv("TMPDIR");
    char path[512];
    snprintf(path, sizeof path, "%s/laglab-results-XXXXXX", folder && strlen(folder) < 400 ? folder : "/tmp");
    int fd = mkstemp(path);
    ll_status status = fd >= 0 ? write_disk(t, path, fd, file) : write_memory(t, file);
    if (fd >= 0)
        close(fd);
    return ll_format_end(file, &status);
}

const ll_format ll_format_sqlite = {"sqlite", "application/vnd.sqlite3",
                                    "an SQLite database with the table `results`", write_file};
