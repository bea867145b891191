/* The store in an SQLite database of a folder: of one daemon. */
#include <errno.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/assert.h"
#include "daemon/store/internal.h"

enum { SCHEMA_VERSION = 1, BUSY_MS = 2000, RETRY_MS = 1000 };

static const char schema[] =
    "CREATE TABLE sessions(number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE, code TEXT NOT NULL,"
    " created_ms INTEGER NOT NULL, seen_ms INTEGER NOT NULL, keys BLOB NOT NULL,"
    " playing INTEGER NOT NULL, speed REAL NOT NULL, tick INTEGER NOT NULL,"
    " head_tick INTEGER NOT NULL);"
    "CREATE TABLE log(session INTEGER NOT NULL, line_index INTEGER NOT NULL, line TEXT NOT NULL,"
    " PRIMARY KEY(session, line_index)) WITHOUT ROWID;"
    "PRAGMA user_version=1;";

/* Databases of an earlier laglab get these tables when they are opened; that one does not read them. */
static const char later[] = "CREATE TABLE IF NOT EXISTS classes(id TEXT PRIMARY KEY,"
                            " seen_ms INTEGER NOT NULL, state TEXT NOT NULL) WITHOUT ROWID;"
                            "CREATE TABLE IF NOT EXISTS class_keys(session INTEGER PRIMARY KEY,"
                            " name TEXT NOT NULL);";

typedef enum statement {
    PUT_ROW,
    PUT_LINE,
    DELETE_ROW,
    DELETE_LOG,
    PUT_KEY,
    DELETE_KEY,
    PUT_CLASS,
    DELETE_CLASS,
    STATEMENTS
} statement;

typedef struct sqlite_store {
    ll_store base;
    char *directory;
    int lock_file;
    sqlite3 *writer_db; /* of the writer thread */
    sqlite3_stmt *prepared[STATEMENTS];
    sqlite3 *reader_db;
    pthread_mutex_t reader_lock;
} sqlite_store;

static const char *const statement_sql[STATEMENTS] = {
    [PUT_ROW] = "INSERT OR REPLACE INTO sessions VALUES(?1,?2,?3,?4,?5,?6,?7,?8,?9,?10)",
    [PUT_LINE] = "INSERT OR REPLACE INTO log VALUES(?1,?2,?3)",
    [DELETE_ROW] = "DELETE FROM sessions WHERE number=?1",
    [DELETE_LOG] = "DELETE FROM log WHERE session=?1",
    [PUT_KEY] = "INSERT OR IGNORE INTO class_keys VALUES(?1,?2)",
    [DELETE_KEY] = "DELETE FROM class_keys WHERE session=?1",
    [PUT_CLASS] = "INSERT OR REPLACE INTO classes VALUES(?1,?2,?3)",
    [DELETE_CLASS] = "DELETE FROM classes WHERE id=?1",
};

/* ---- errors ---- */

/* What SQLite said last, with the name of the folder. */
static ll_status failure(const sqlite_store *store, sqlite3 *db, const char *doing)
{
    int code = db ? sqlite3_errcode(db) : SQLITE_NOMEM;
    switch (code & 0xff) {
    case SQLITE_FULL:
        return ll_error(LL_IO, "Disk of %s is full.", store->directory);
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
        return ll_error(LL_IO, "Cannot write to %s: %s.", store->directory, sqlite3_errmsg(db));
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return ll_error(LL_IO, "Database in %s is locked by another program.", store->directory);
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
        return ll_error(LL_IO, "%s/laglab.db is damaged or not a database: %s.", store->directory,
                        sqlite3_errmsg(db));
    default:
        return ll_error(LL_IO, "%s in %s failed: %s.", doing, store->directory,
                        db ? sqlite3_errmsg(db) : "no memory");
    }
}

/* ---- writing ---- */

static void bind_row(sqlite3_stmt *s, const ll_stored *row)
{
    sqlite3_bind_int64(s, 1, row->place.number);
    sqlite3_bind_text(s, 2, row->id, -1, SQLITE_STATIC);
    sqlite3_bind_text(s, 3, row->code, -1, SQLITE_STATIC);
    sqlite3_bind_int64(s, 4, row->created_ms);
    sqlite3_bind_int64(s, 5, row->seen_ms);
    sqlite3_bind_blob(s, 6, row->keys, row->key_count * (int)sizeof row->keys[0], SQLITE_STATIC);
    sqlite3_bind_int(s, 7, row->playing);
    sqlite3_bind_double(s, 8, row->speed);
    sqlite3_bind_int64(s, 9, row->tick);
    sqlite3_bind_int64(s, 10, row->head_tick);
}

static bool run(sqlite3_stmt *s)
{
    int result = sqlite3_step(s);
    sqlite3_reset(s);
    sqlite3_clear_bindings(s);
    return result == SQLITE_DONE;
}

static bool delete_session(sqlite_store *store, int64_t number)
{
    sqlite3_bind_int64(store->prepared[DELETE_ROW], 1, number);
    sqlite3_bind_int64(store->prepared[DELETE_LOG], 1, number);
    sqlite3_bind_int64(store->prepared[DELETE_KEY], 1, number);
    return run(store->prepared[DELETE_ROW]) && run(store->prepared[DELETE_LOG]) &&
           run(store->prepared[DELETE_KEY]);
}

static bool write_class(sqlite_store *store, const record *r)
{
    sqlite3_stmt *s = store->prepared[r->type == RECORD_CLASS ? PUT_CLASS : DELETE_CLASS];
    sqlite3_bind_text(s, 1, r->bytes, -1, SQLITE_STATIC);
    if (r->type == RECORD_CLASS) {
        const size_t skipped = LL_ID_LENGTH + 1;
        sqlite3_bind_int64(s, 2, r->index);
        sqlite3_bind_text64(s, 3, r->bytes + skipped, r->size - skipped, SQLITE_STATIC, SQLITE_UTF8);
    }
    return run(s);
}

/* The row with the name of its class key, which never changes. */
static bool write_row(sqlite_store *store, const ll_stored *row)
{
    bind_row(store->prepared[PUT_ROW], row);
    if (!run(store->prepared[PUT_ROW]))
        return false;
    if (!row->class_key[0])
        return true;
    sqlite3_bind_int64(store->prepared[PUT_KEY], 1, row->place.number);
    sqlite3_bind_text(store->prepared[PUT_KEY], 2, row->class_key, -1, SQLITE_STATIC);
    return run(store->prepared[PUT_KEY]);
}

static bool write_record(sqlite_store *store, const record *r)
{
    if (r->type == RECORD_CLASS || r->type == RECORD_DELETE_CLASS)
        return write_class(store, r);
    if (r->type == RECORD_DELETE)
        return delete_session(store, r->place.number);
    if (r->type == RECORD_ROW) {
        ll_stored row;
        memcpy(&row, r->bytes, sizeof row);
        return write_row(store, &row);
    }
    sqlite3_stmt *s = store->prepared[PUT_LINE];
    sqlite3_bind_int64(s, 1, r->place.number);
    sqlite3_bind_int64(s, 2, r->index);
    sqlite3_bind_text64(s, 3, r->bytes, r->size, SQLITE_STATIC, SQLITE_UTF8);
    return run(s);
}

/* All or nothing. A batch whose commit failed may be written again: rows are replaced, not duplicated. */
static ll_status commit(ll_store *base, const record *batch, int64_t daemon)
{
    sqlite_store *store = (sqlite_store *)base;
    sqlite3 *db = store->writer_db;
    (void)daemon;
    bool good = sqlite3_exec(db, "BEGIN IMMEDIATE", NULL, NULL, NULL) == SQLITE_OK;
    for (const record *r = batch; r && good; r = r->next)
        good = write_record(store, r);
    if (good && sqlite3_exec(db, "COMMIT", NULL, NULL, NULL) == SQLITE_OK)
        return ll_ok();
    ll_status failed = failure(store, db, "Writing");
    if (!sqlite3_get_autocommit(db))
        sqlite3_exec(db, "ROLLBACK", NULL, NULL, NULL);
    return failed;
}

/* ---- opening ---- */

static ll_status make_directory(const char *directory)
{
    char path[4096];
    size_t length = strlen(directory);
    if (length == 0 || length >= sizeof path)
        return ll_error(LL_IO, "data directory: has %zu characters; must have 1 to %zu", length,
                        sizeof path - 1);
    memcpy(path, directory, length + 1);
    for (char *p = path + 1; *p; p++) {
        if (*p != '/')
            continue;
        *p = '\0';
        mkdir(path, 0700); /* only the last one has to exist */
        *p = '/';
    }
    if (mkdir(path, 0700) != 0 && errno != EEXIST)
        return ll_error(LL_IO, "Cannot create data directory %s: %s.", directory, strerror(errno));
    return ll_ok();
}

static ll_status take_lock(sqlite_store *store)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/lock", store->directory);
    store->lock_file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (store->lock_file < 0)
        return ll_error(LL_IO, "Cannot write to data directory %s: %s.", store->directory, strerror(errno));
    if (flock(store->lock_file, LOCK_EX | LOCK_NB) != 0)
        return ll_error(LL_IO, "Data directory %s is in use by another laglab.", store->directory);
    return ll_ok();
}

static bool read_number(sqlite3 *db, const char *sql, int64_t *number)
{
    sqlite3_stmt *s = NULL;
    bool found = sqlite3_prepare_v2(db, sql, -1, &s, NULL) == SQLITE_OK && sqlite3_step(s) == SQLITE_ROW;
    if (found)
        *number = sqlite3_column_int64(s, 0);
    sqlite3_finalize(s);
    return found;
}

static ll_status check_version(const sqlite_store *store, int64_t version)
{
    if (version <= SCHEMA_VERSION)
        return ll_ok();
    return ll_error(LL_IO, "Database in %s has schema %lld, of a newer laglab; this one supports up to %d.",
                    store->directory, (long long)version, SCHEMA_VERSION);
}

static ll_status prepare_schema(sqlite_store *store)
{
    sqlite3 *db = store->writer_db;
    int64_t version = 0;
    if (!read_number(db, "PRAGMA user_version", &version))
        return failure(store, db, "Opening the database");
    LL_TRY(check_version(store, version));
    if (version == 0) {
        char *made = sqlite3_mprintf("BEGIN IMMEDIATE;%sCOMMIT;", schema);
        int result = sqlite3_exec(db, made, NULL, NULL, NULL);
        sqlite3_free(made);
        if (result != SQLITE_OK)
            return failure(store, db, "Creating the database");
    }
    /* Takes the write lock once, so that a read-only disk is an error now and not at the first command. */
    if (sqlite3_exec(db, "BEGIN IMMEDIATE; PRAGMA user_version=1; COMMIT;", NULL, NULL, NULL) != SQLITE_OK ||
        sqlite3_exec(db, later, NULL, NULL, NULL) != SQLITE_OK)
        return failure(store, db, "Writing");
    int64_t highest = 0;
    if (!read_number(db, "SELECT coalesce(max(number), 0) FROM sessions", &highest))
        return failure(store, db, "Reading");
    store->base.next_number = highest + 1;
    store->base.past_number = INT64_MAX;
    return ll_ok();
}

static ll_status open_database(sqlite_store *store)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/laglab.db", store->directory);
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    if (sqlite3_open_v2(path, &store->writer_db, flags, NULL) != SQLITE_OK)
        return failure(store, store->writer_db, "Opening the database");
    sqlite3_busy_timeout(store->writer_db, BUSY_MS);
    if (sqlite3_exec(store->writer_db, "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;", NULL, NULL,
                     NULL) != SQLITE_OK)
        return failure(store, store->writer_db, "Opening the database");
    ll_status status = prepare_schema(store);
    for (int i = 0; i < STATEMENTS && !ll_failed(&status); i++) {
        if (sqlite3_prepare_v3(store->writer_db, statement_sql[i], -1, SQLITE_PREPARE_PERSISTENT,
                               &store->prepared[i], NULL) != SQLITE_OK)
            status = failure(store, store->writer_db, "Opening the database");
    }
    if (ll_failed(&status))
        return status;
    if (sqlite3_open_v2(path, &store->reader_db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, NULL) !=
        SQLITE_OK)
        return failure(store, store->reader_db, "Opening the database");
    sqlite3_busy_timeout(store->reader_db, BUSY_MS);
    return ll_ok();
}

/* ---- reading ---- */

static void read_text(sqlite3_stmt *s, int column, char *text, size_t size)
{
    const unsigned char *value = sqlite3_column_text(s, column);
    snprintf(text, size, "%s", value ? (const char *)value : "");
}

static void read_row(sqlite3_stmt *s, ll_stored *row)
{
    memset(row, 0, sizeof *row);
    row->place.number = sqlite3_column_int64(s, 0);
    read_text(s, 1, row->id, sizeof row->id);
    read_text(s, 2, row->code, sizeof row->code);
    row->created_ms = sqlite3_column_int64(s, 3);
    row->seen_ms = sqlite3_column_int64(s, 4);
    const void *keys = sqlite3_column_blob(s, 5);
    int bytes = sqlite3_column_bytes(s, 5);
    row->key_count = bytes / (int)sizeof row->keys[0];
    if (row->key_count > LL_STORE_KEYS)
        row->key_count = LL_STORE_KEYS;
    if (row->key_count > 0)
        memcpy(row->keys, keys, (size_t)row->key_count * sizeof row->keys[0]);
    row->playing = sqlite3_column_int(s, 6) != 0;
    row->speed = sqlite3_column_double(s, 7);
    row->tick = sqlite3_column_int64(s, 8);
    row->head_tick = sqlite3_column_int64(s, 9);
    row->lines = sqlite3_column_int64(s, 10);
    row->log_bytes = sqlite3_column_int64(s, 11);
    read_text(s, 12, row->class_key, sizeof row->class_key);
}

static ll_status list(ll_store *base, void (*each)(void *context, const ll_stored *stored), void *context)
{
    sqlite_store *store = (sqlite_store *)base;
    static const char sql[] =
        "SELECT *, (SELECT coalesce(max(line_index) + 1, 0) FROM log WHERE session = number),"
        " (SELECT coalesce(sum(length(CAST(line AS BLOB)) + 1), 0) FROM log WHERE session = number),"
        " (SELECT name FROM class_keys WHERE session = number)"
        " FROM sessions ORDER BY number";
    sqlite3_stmt *s = NULL;
    pthread_mutex_lock(&store->reader_lock);
    int result = sqlite3_prepare_v2(store->reader_db, sql, -1, &s, NULL);
    while (result == SQLITE_OK || result == SQLITE_ROW) {
        result = sqlite3_step(s);
        if (result != SQLITE_ROW)
            break;
        ll_stored row;
        read_row(s, &row);
        each(context, &row);
    }
    ll_status status = result == SQLITE_DONE ? ll_ok() : failure(store, store->reader_db, "Reading");
    sqlite3_finalize(s);
    pthread_mutex_unlock(&store->reader_lock);
    return status;
}

static ll_status list_classes(ll_store *base,
                              void (*each)(void *context, const char *id, int64_t seen_ms, const char *text),
                              void *context)
{
    sqlite_store *store = (sqlite_store *)base;
    sqlite3_stmt *s = NULL;
    pthread_mutex_lock(&store->reader_lock);
    int result = sqlite3_prepare_v2(store->reader_db, "SELECT id, seen_ms, state FROM classes", -1, &s, NULL);
    while (result == SQLITE_OK || result == SQLITE_ROW) {
        result = sqlite3_step(s);
        if (result != SQLITE_ROW)
            break;
        const unsigned char *id = sqlite3_column_text(s, 0), *text = sqlite3_column_text(s, 2);
        if (id && text)
            each(context, (const char *)id, sqlite3_column_int64(s, 1), (const char *)text);
    }
    ll_status status = result == SQLITE_DONE ? ll_ok() : failure(store, store->reader_db, "Reading");
    sqlite3_finalize(s);
    pthread_mutex_unlock(&store->reader_lock);
    return status;
}

static ll_status read_log(ll_store *base, int64_t number, char **text, size_t *length)
{
    sqlite_store *store = (sqlite_store *)base;
    log_text log = {0};
    sqlite3_stmt *s = NULL;
    pthread_mutex_lock(&store->reader_lock);
    ll_status status = ll_ok();
    int result = sqlite3_prepare_v2(
        store->reader_db, "SELECT line FROM log WHERE session=?1 ORDER BY line_index", -1, &s, NULL);
    if (result == SQLITE_OK)
        sqlite3_bind_int64(s, 1, number);
    while ((result == SQLITE_OK || result == SQLITE_ROW) && !ll_failed(&status)) {
        result = sqlite3_step(s);
        if (result != SQLITE_ROW)
            break;
        const void *line = sqlite3_column_text(s, 0);
        if (!ll_store_add_line(&log, line, (size_t)sqlite3_column_bytes(s, 0)))
            status = ll_error(LL_NO_MEMORY, "out of memory: log of a stored session");
    }
    if (!ll_failed(&status) && result != SQLITE_DONE)
        status = failure(store, store->reader_db, "Reading");
    sqlite3_finalize(s);
    pthread_mutex_unlock(&store->reader_lock);
    return ll_store_end_log(&log, status, store->directory, text, length);
}

static ll_status new_numbers(ll_store *base, int64_t *first, int64_t *past)
{
    (void)base, (void)first, (void)past;
    return ll_error(LL_LIMIT, "no numbers are left for sessions");
}

/* ---- the kind ---- */

static void close_store(ll_store *base)
{
    sqlite_store *store = (sqlite_store *)base;
    for (int i = 0; i < STATEMENTS; i++)
        sqlite3_finalize(store->prepared[i]);
    sqlite3_close(store->reader_db);
    sqlite3_close(store->writer_db);
    if (store->lock_file >= 0)
        close(store->lock_file);
    pthread_mutex_destroy(&store->reader_lock);
    ll_store_end(base);
    free(store->directory);
    free(store);
}

static const ll_store_kind sqlite_kind = {.retry_ms = RETRY_MS,
                                          .close = close_store,
                                          .commit = commit,
                                          .list = list,
                                          .read_log = read_log,
                                          .list_classes = list_classes,
                                          .new_numbers = new_numbers};

static sqlite_store *new_store(const char *directory)
{
    sqlite_store *store = calloc(1, sizeof *store);
    char *name = strdup(directory);
    if (!store || !name) {
        free(store);
        free(name);
        return NULL;
    }
    ll_store_init(&store->base, &sqlite_kind);
    store->directory = name;
    store->lock_file = -1;
    pthread_mutex_init(&store->reader_lock, NULL);
    return store;
}

ll_status ll_store_open(const char *directory, ll_store **result)
{
    *result = NULL;
    sqlite_store *store = new_store(directory);
    if (!store)
        return ll_error(LL_NO_MEMORY, "out of memory: store");
    ll_status status = make_directory(directory);
    LL_THEN(status, take_lock(store));
    LL_THEN(status, open_database(store));
    LL_THEN(status, ll_store_start(&store->base));
    if (ll_failed(&status)) {
        close_store(&store->base);
        return status;
    }
    *result = &store->base;
    return ll_ok();
}

/* ---- opening to read only ---- */

/* A database that was made before classes, or the keys of classes, were stored lacks their tables: empty
 * ones of this connection stand for them. */
static bool complete(sqlite3 *db)
{
    static const struct {
        const char *is_there, *make;
    } tables[] = {{"SELECT count(*) FROM sqlite_master WHERE name='classes'",
                   "CREATE TEMP TABLE classes(id, seen_ms, state)"},
                  {"SELECT count(*) FROM sqlite_master WHERE name='class_keys'",
                   "CREATE TEMP TABLE class_keys(session INTEGER PRIMARY KEY, name TEXT)"}};
    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; i++) {
        int64_t there;
        if (!read_number(db, tables[i].is_there, &there) ||
            (there == 0 && sqlite3_exec(db, tables[i].make, NULL, NULL, NULL) != SQLITE_OK))
            return false;
    }
    return true;
}

static ll_status open_to_read(sqlite_store *store)
{
    char path[4096];
    int64_t version = 0;
    snprintf(path, sizeof path, "%s/laglab.db", store->directory);
    if (sqlite3_open_v2(path, &store->reader_db, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, NULL) !=
        SQLITE_OK)
        return failure(store, store->reader_db, "Opening the database");
    sqlite3_busy_timeout(store->reader_db, BUSY_MS);
    if (!read_number(store->reader_db, "PRAGMA user_version", &version))
        return failure(store, store->reader_db, "Reading");
    LL_TRY(check_version(store, version));
    if (version == 0)
        return ll_error(LL_NOT_FOUND, "There are no sessions in %s.", store->directory);
    return complete(store->reader_db) ? ll_ok() : failure(store, store->reader_db, "Reading");
}

ll_status ll_sqlite_open_source(const char *directory, ll_store **result)
{
    char path[4096];
    struct stat found;
    *result = NULL;
    snprintf(path, sizeof path, "%s/laglab.db", directory);
    if (stat(path, &found) != 0)
        return ll_error(LL_NOT_FOUND, "There are no sessions in %.200s: it has no laglab.db.", directory);
    sqlite_store *store = new_store(directory);
    if (!store)
        return ll_error(LL_NO_MEMORY, "out of memory: store");
    ll_status status = take_lock(store);
    LL_THEN(status, open_to_read(store));
    if (ll_failed(&status))
        close_store(&store->base);
    else
        *result = &store->base;
    return status;
}
