/* The SQLite database of a folder. */
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "base/assert.h"
#include "daemon/store/internal.h"
#include "experiment/store/read_only.h"

enum { SCHEMA_VERSION = 1, BUSY_MS = 2000 };

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
                            "CREATE TABLE IF NOT EXISTS measurements(id TEXT PRIMARY KEY,"
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
    PUT_CLASS, /* as ll_store_text */
    PUT_MEASUREMENT,
    DELETE_CLASS,
    DELETE_MEASUREMENT,
    STATEMENTS
} statement;

struct ll_database {
    char *directory, *path;
    int lock_file;
    int64_t highest_number;
    sqlite3 *writer; /* of the writer thread; NULL: the files cannot be written, see `why` */
    sqlite3_stmt *prepared[STATEMENTS];
    ll_status why;
    int shared_memory; /* the file, as long as it is open; -1: not open */
    sqlite3 *reader;
    pthread_mutex_t reader_lock;
};

static const char *const statement_sql[STATEMENTS] = {
    [PUT_ROW] = "INSERT OR REPLACE INTO sessions VALUES(?1,?2,?3,?4,?5,?6,?7,?8,?9,?10)",
    [PUT_LINE] = "INSERT OR REPLACE INTO log VALUES(?1,?2,?3)",
    [DELETE_ROW] = "DELETE FROM sessions WHERE number=?1",
    [DELETE_LOG] = "DELETE FROM log WHERE session=?1",
    [PUT_KEY] = "INSERT OR IGNORE INTO class_keys VALUES(?1,?2)",
    [DELETE_KEY] = "DELETE FROM class_keys WHERE session=?1",
    [PUT_CLASS] = "INSERT OR REPLACE INTO classes VALUES(?1,?2,?3)",
    [PUT_MEASUREMENT] = "INSERT OR REPLACE INTO measurements VALUES(?1,?2,?3)",
    [DELETE_CLASS] = "DELETE FROM classes WHERE id=?1",
    [DELETE_MEASUREMENT] = "DELETE FROM measurements WHERE id=?1",
};

/* ---- errors ---- */

/* What SQLite and the system said last, with the name of the file. */
static ll_status failure(const ll_database *database, sqlite3 *db, const char *doing)
{
    int code = db ? sqlite3_errcode(db) : SQLITE_NOMEM, cause = db ? sqlite3_system_errno(db) : 0;
    const char *said = db ? sqlite3_errmsg(db) : "no memory";
    switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return ll_error(LL_IO, "Database in %s is locked by another program.", database->directory);
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
        return ll_error(LL_IO, "%s/laglab.db is damaged or not a database: %s.", database->directory, said);
    default:
        if (cause == 0)
            return ll_error(LL_IO, "%s %s/laglab.db failed: %s.", doing, database->directory, said);
        return ll_error(LL_IO, "%s %s/laglab.db failed: %s (%s).", doing, database->directory, said,
                        strerror(cause));
    }
}

/* ---- writing ---- */

static void bind_row(sqlite3_stmt *s, const ll_stored *row)
{
    sqlite3_bind_int64(s, 1, row->number);
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

static bool delete_session(ll_database *database, int64_t number)
{
    sqlite3_bind_int64(database->prepared[DELETE_ROW], 1, number);
    sqlite3_bind_int64(database->prepared[DELETE_LOG], 1, number);
    sqlite3_bind_int64(database->prepared[DELETE_KEY], 1, number);
    return run(database->prepared[DELETE_ROW]) && run(database->prepared[DELETE_LOG]) &&
           run(database->prepared[DELETE_KEY]);
}

static bool write_text(ll_database *database, const record *r)
{
    sqlite3_stmt *s = database->prepared[(r->type == RECORD_TEXT ? PUT_CLASS : DELETE_CLASS) + r->number];
    sqlite3_bind_text(s, 1, r->bytes, -1, SQLITE_STATIC);
    if (r->type == RECORD_TEXT) {
        const size_t skipped = LL_ID_LENGTH + 1;
        sqlite3_bind_int64(s, 2, r->index);
        sqlite3_bind_text64(s, 3, r->bytes + skipped, r->size - skipped, SQLITE_STATIC, SQLITE_UTF8);
    }
    return run(s);
}

/* The row with the name of its class key, which never changes. */
static bool write_row(ll_database *database, const ll_stored *row)
{
    bind_row(database->prepared[PUT_ROW], row);
    if (!run(database->prepared[PUT_ROW]))
        return false;
    if (!row->class_key[0])
        return true;
    sqlite3_bind_int64(database->prepared[PUT_KEY], 1, row->number);
    sqlite3_bind_text(database->prepared[PUT_KEY], 2, row->class_key, -1, SQLITE_STATIC);
    return run(database->prepared[PUT_KEY]);
}

static bool write_record(ll_database *database, const record *r)
{
    if (r->type == RECORD_TEXT || r->type == RECORD_DELETE_TEXT)
        return write_text(database, r);
    if (r->type == RECORD_DELETE || r->type == RECORD_TRY_DELETE)
        return delete_session(database, r->number);
    if (r->type == RECORD_ROW) {
        ll_stored row;
        memcpy(&row, r->bytes, sizeof row);
        return write_row(database, &row);
    }
    sqlite3_stmt *s = database->prepared[PUT_LINE];
    sqlite3_bind_int64(s, 1, r->number);
    sqlite3_bind_int64(s, 2, r->index);
    sqlite3_bind_text64(s, 3, r->bytes, r->size, SQLITE_STATIC, SQLITE_UTF8);
    return run(s);
}

/* All or nothing. A batch whose commit failed may be written again: rows are replaced, not duplicated. */
ll_status ll_database_commit(ll_database *database, const record *batch)
{
    sqlite3 *db = database->writer;
    if (!db)
        return database->why;
    bool good = sqlite3_exec(db, "BEGIN IMMEDIATE", NULL, NULL, NULL) == SQLITE_OK;
    for (const record *r = batch; r && good; r = r->next)
        good = write_record(database, r);
    if (good && sqlite3_exec(db, "COMMIT", NULL, NULL, NULL) == SQLITE_OK)
        return ll_ok();
    ll_status failed = failure(database, db, "Writing");
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

static ll_status take_lock(ll_database *database)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/lock", database->directory);
    database->lock_file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    int why = errno;
    if (database->lock_file < 0) /* what is there can be read */
        database->lock_file = open(path, O_RDONLY | O_CLOEXEC);
    if (database->lock_file < 0)
        return ll_error(LL_IO, "Cannot write to data directory %s: %s.", database->directory, strerror(why));
    if (flock(database->lock_file, LOCK_EX | LOCK_NB) != 0)
        return ll_error(LL_IO, "Data directory %s is in use by another laglab.", database->directory);
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

static ll_status check_version(const ll_database *database, int64_t version)
{
    if (version <= SCHEMA_VERSION)
        return ll_ok();
    return ll_error(LL_IO, "Database in %s has schema %lld, of a newer laglab; this one supports up to %d.",
                    database->directory, (long long)version, SCHEMA_VERSION);
}

static ll_status prepare_schema(ll_database *database)
{
    sqlite3 *db = database->writer;
    int64_t version = 0;
    if (!read_number(db, "PRAGMA user_version", &version))
        return failure(database, db, "Opening");
    LL_TRY(check_version(database, version));
    if (version == 0) {
        char *made = sqlite3_mprintf("BEGIN IMMEDIATE;%sCOMMIT;", schema);
        int result = sqlite3_exec(db, made, NULL, NULL, NULL);
        sqlite3_free(made);
        if (result != SQLITE_OK)
            return failure(database, db, "Creating");
    }
    /* Takes the write lock once, so that a read-only disk is found now and not at the first command. */
    if (sqlite3_exec(db, "BEGIN IMMEDIATE; PRAGMA user_version=1; COMMIT;", NULL, NULL, NULL) != SQLITE_OK ||
        sqlite3_exec(db, later, NULL, NULL, NULL) != SQLITE_OK)
        return failure(database, db, "Writing");
    return ll_ok();
}

static ll_status open_writer(ll_database *database)
{
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    if (sqlite3_open_v2(database->path, &database->writer, flags, NULL) != SQLITE_OK)
        return failure(database, database->writer, "Opening");
    sqlite3_busy_timeout(database->writer, BUSY_MS);
    if (sqlite3_exec(database->writer, "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;", NULL, NULL,
                     NULL) != SQLITE_OK)
        return failure(database, database->writer, "Opening");
    LL_TRY(prepare_schema(database));
    for (int i = 0; i < STATEMENTS; i++)
        if (sqlite3_prepare_v3(database->writer, statement_sql[i], -1, SQLITE_PREPARE_PERSISTENT,
                               &database->prepared[i], NULL) != SQLITE_OK)
            return failure(database, database->writer, "Opening");
    return ll_ok();
}

/* Of the file of shared memory, for the 4,096 pages of a log, of which 1,000 are used. Written through
 * memory, it would end the process with SIGBUS where the disk is full. Closed only after the connections:
 * that drops their locks. */
static ll_status allocate_shared_memory(ll_database *database)
{
    enum { BYTES = 32 << 10 };
    char path[4200];
    snprintf(path, sizeof path, "%s-shm", database->path);
    database->shared_memory = open(path, O_RDWR | O_CLOEXEC);
    if (database->shared_memory < 0 || fallocate(database->shared_memory, 0, 0, BYTES) == 0 ||
        errno == EOPNOTSUPP)
        return ll_ok();
    return ll_error(LL_IO, "Writing %s failed: %s.", path, strerror(errno));
}

/* Whether the disk can be written to at all, before SQLite does it; which also does not say why not. */
static ll_status check_disk(const ll_database *database)
{
    enum { LEAST_KIB = 256 };
    struct statvfs disk;
    if (access(database->path, W_OK) != 0 && errno != ENOENT)
        return ll_error(LL_IO, "Cannot write to %s: %s.", database->path, strerror(errno));
    if (statvfs(database->directory, &disk) != 0 || disk.f_blocks == 0)
        return ll_ok();
    uint64_t kib = (uint64_t)disk.f_bavail * disk.f_frsize >> 10;
    return kib >= LEAST_KIB
               ? ll_ok()
               : ll_error(LL_IO, "Disk of %s is full: it has %llu KiB left, and needs %d to start.",
                          database->directory, (unsigned long long)kib, LEAST_KIB);
}

static void close_writer(ll_database *database)
{
    for (int i = 0; i < STATEMENTS; i++) {
        sqlite3_finalize(database->prepared[i]);
        database->prepared[i] = NULL;
    }
    sqlite3_close(database->writer);
    database->writer = NULL;
    if (database->shared_memory >= 0)
        close(database->shared_memory);
    database->shared_memory = -1;
}

static void close_reader(ll_database *database)
{
    sqlite3_close(database->reader);
    database->reader = NULL;
}

/* With a writer, another connection next to it. Without one by a connection that writes no file, no shared
 * memory and no lock: the lock of the folder keeps other daemons away. */
static ll_status open_reader(ll_database *database)
{
    int64_t version = 0;
    ll_status status;
    if (database->writer) {
        int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX;
        status = sqlite3_open_v2(database->path, &database->reader, flags, NULL) == SQLITE_OK
                     ? ll_ok()
                     : failure(database, database->reader, "Opening");
        sqlite3_busy_timeout(database->reader, BUSY_MS);
    } else {
        status = ll_open_read_only(database->path, &database->reader)
                     ? ll_ok()
                     : failure(database, database->reader, "Reading");
    }
    if (!ll_failed(&status) &&
        (!read_number(database->reader, "PRAGMA user_version", &version) || version == 0 ||
         !read_number(database->reader, "SELECT coalesce(max(number), 0) FROM sessions",
                      &database->highest_number)))
        status = failure(database, database->reader, "Reading");
    LL_THEN(status, check_version(database, version));
    return status;
}

/* Without a writer when the files can only be read. On an error nothing is open. */
static ll_status open_files(ll_database *database)
{
    ll_status status = check_disk(database);
    bool readable = ll_failed(&status);
    if (!readable) {
        status = open_writer(database);
        readable = ll_failed(&status) && ll_is_unwritable(database->writer);
        LL_THEN(status, allocate_shared_memory(database));
    }
    database->why = status;
    if (ll_failed(&status))
        close_writer(database);
    if (readable || !ll_failed(&status)) {
        ll_status opened = open_reader(database);
        if (readable && !ll_failed(&opened))
            return ll_ok();
        if (!readable)
            status = opened;
    }
    if (ll_failed(&status)) {
        close_reader(database);
        close_writer(database);
    }
    return status;
}

enum { SPARE = 64 << 10, MOST = 16 << 20 };

/* Writes a row that no session has, and deletes it: its pages are there for what comes. */
ll_status ll_database_try_room(ll_database *database, int64_t bytes)
{
    if (!database->writer) {
        pthread_mutex_lock(&database->reader_lock);
        close_reader(database);
        ll_status status = open_files(database);
        pthread_mutex_unlock(&database->reader_lock);
        if (ll_failed(&status) || !database->writer)
            return database->why;
    }
    sqlite3 *db = database->writer;
    char *sql = sqlite3_mprintf("INSERT OR REPLACE INTO class_keys VALUES(0, zeroblob(%lld));"
                                "DELETE FROM class_keys WHERE session=0;",
                                (long long)(bytes < MOST ? bytes : MOST) + SPARE);
    bool good = sql && sqlite3_exec(db, sql, NULL, NULL, NULL) == SQLITE_OK;
    ll_status status = good ? ll_ok() : failure(database, db, "Writing");
    sqlite3_free(sql);
    return status;
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
    row->number = sqlite3_column_int64(s, 0);
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

ll_status ll_database_list(ll_database *database, void (*each)(void *context, const ll_stored *stored),
                           void *context)
{
    static const char sql[] =
        "SELECT *, (SELECT coalesce(max(line_index) + 1, 0) FROM log WHERE session = number),"
        " (SELECT coalesce(sum(length(CAST(line AS BLOB)) + 1), 0) FROM log WHERE session = number),"
        " (SELECT name FROM class_keys WHERE session = number)"
        " FROM sessions ORDER BY number";
    sqlite3_stmt *s = NULL;
    pthread_mutex_lock(&database->reader_lock);
    int result = sqlite3_prepare_v2(database->reader, sql, -1, &s, NULL);
    while (result == SQLITE_OK || result == SQLITE_ROW) {
        result = sqlite3_step(s);
        if (result != SQLITE_ROW)
            break;
        ll_stored row;
        read_row(s, &row);
        each(context, &row);
    }
    ll_status status = result == SQLITE_DONE ? ll_ok() : failure(database, database->reader, "Reading");
    sqlite3_finalize(s);
    pthread_mutex_unlock(&database->reader_lock);
    return status;
}

ll_status ll_database_list_texts(ll_database *database, ll_store_text kind,
                                 void (*each)(void *context, const char *id, int64_t seen_ms,
                                              const char *text),
                                 void *context)
{
    static const char *const sql[] = {[LL_STORE_CLASS] = "SELECT id, seen_ms, state FROM classes",
                                      [LL_STORE_MEASUREMENT] = "SELECT id, seen_ms, state FROM measurements"};
    sqlite3_stmt *s = NULL;
    int64_t tables = 0;
    pthread_mutex_lock(&database->reader_lock);
    /* an earlier database that can only be read has none */
    if (kind == LL_STORE_MEASUREMENT &&
        read_number(database->reader, "SELECT count(*) FROM sqlite_master WHERE name='measurements'",
                    &tables) &&
        tables == 0) {
        pthread_mutex_unlock(&database->reader_lock);
        return ll_ok();
    }
    int result = sqlite3_prepare_v2(database->reader, sql[kind], -1, &s, NULL);
    while (result == SQLITE_OK || result == SQLITE_ROW) {
        result = sqlite3_step(s);
        if (result != SQLITE_ROW)
            break;
        const unsigned char *id = sqlite3_column_text(s, 0), *text = sqlite3_column_text(s, 2);
        if (id && text)
            each(context, (const char *)id, sqlite3_column_int64(s, 1), (const char *)text);
    }
    ll_status status = result == SQLITE_DONE ? ll_ok() : failure(database, database->reader, "Reading");
    sqlite3_finalize(s);
    pthread_mutex_unlock(&database->reader_lock);
    return status;
}

/* Lines, each with its newline. */
typedef struct log_text {
    char *text;
    size_t length, capacity;
} log_text;

static bool add_line(log_text *log, const void *line, size_t size)
{
    if (log->length + size + 2 > log->capacity) {
        size_t wanted = (log->length + size + 2) * 2;
        char *bigger = realloc(log->text, wanted);
        if (!bigger)
            return false;
        log->text = bigger;
        log->capacity = wanted;
    }
    memcpy(log->text + log->length, line, size);
    log->length += size;
    log->text[log->length++] = '\n';
    log->text[log->length] = '\0';
    return true;
}

/* The text as the result; an empty log is an error that names `where`. */
static ll_status end_log(log_text *log, ll_status status, const char *where, char **text, size_t *length)
{
    if (!ll_failed(&status) && !log->text)
        status = ll_error(LL_IO, "Log of a stored session in %.150s is empty.", where);
    if (ll_failed(&status)) {
        free(log->text);
        return status;
    }
    *text = log->text;
    *length = log->length;
    return status;
}

ll_status ll_database_read_log(ll_database *database, int64_t number, char **text, size_t *length)
{
    log_text log = {0};
    sqlite3_stmt *s = NULL;
    pthread_mutex_lock(&database->reader_lock);
    ll_status status = ll_ok();
    int result = sqlite3_prepare_v2(
        database->reader, "SELECT line FROM log WHERE session=?1 ORDER BY line_index", -1, &s, NULL);
    if (result == SQLITE_OK)
        sqlite3_bind_int64(s, 1, number);
    while ((result == SQLITE_OK || result == SQLITE_ROW) && !ll_failed(&status)) {
        result = sqlite3_step(s);
        if (result != SQLITE_ROW)
            break;
        const void *line = sqlite3_column_text(s, 0);
        if (!add_line(&log, line, (size_t)sqlite3_column_bytes(s, 0)))
            status = ll_error(LL_NO_MEMORY, "out of memory: log of a stored session");
    }
    if (!ll_failed(&status) && result != SQLITE_DONE)
        status = failure(database, database->reader, "Reading");
    sqlite3_finalize(s);
    pthread_mutex_unlock(&database->reader_lock);
    return end_log(&log, status, database->directory, text, length);
}

/* ---- opening and closing ---- */

ll_status ll_database_open(const char *directory, ll_database **result)
{
    *result = NULL;
    ll_database *database = calloc(1, sizeof *database);
    char *name = strdup(directory), *path = sqlite3_mprintf("%s/laglab.db", directory);
    if (!database || !name || !path) {
        free(database);
        free(name);
        sqlite3_free(path);
        return ll_error(LL_NO_MEMORY, "out of memory: store");
    }
    database->directory = name;
    database->path = path;
    database->lock_file = database->shared_memory = -1;
    pthread_mutex_init(&database->reader_lock, NULL);
    ll_status status = make_directory(directory);
    LL_THEN(status, take_lock(database));
    LL_THEN(status, open_files(database));
    if (ll_failed(&status))
        ll_database_close(database);
    else
        *result = database;
    return status;
}

void ll_database_close(ll_database *database)
{
    close_reader(database);
    close_writer(database);
    if (database->lock_file >= 0)
        close(database->lock_file);
    pthread_mutex_destroy(&database->reader_lock);
    free(database->directory);
    sqlite3_free(database->path);
    free(database);
}

ll_status ll_database_writable(const ll_database *database)
{
    return database->writer ? ll_ok() : database->why;
}

int64_t ll_database_highest_number(const ll_database *database)
{
    return database->highest_number;
}
