#include "daemon/store/internal.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/assert.h"

enum { SCHEMA_VERSION = 1, BUSY_MS = 2000, RETRY_S = 1 };

static const char schema[] =
    "CREATE TABLE sessions(number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE, code TEXT NOT NULL,"
    " created_ms INTEGER NOT NULL, seen_ms INTEGER NOT NULL, keys BLOB NOT NULL,"
    " playing INTEGER NOT NULL, speed REAL NOT NULL, tick INTEGER NOT NULL,"
    " head_tick INTEGER NOT NULL);"
    "CREATE TABLE log(session INTEGER NOT NULL, line_index INTEGER NOT NULL, line TEXT NOT NULL,"
    " PRIMARY KEY(session, line_index)) WITHOUT ROWID;"
    "PRAGMA user_version=1;";

/* Databases that were made before classes were stored get their table when they are opened; an older laglab
 * does not read it. */
static const char class_table[] = "CREATE TABLE IF NOT EXISTS classes(id TEXT PRIMARY KEY,"
                                  " seen_ms INTEGER NOT NULL, state TEXT NOT NULL) WITHOUT ROWID;";

static const char *const statement_sql[STATEMENTS] = {
    [PUT_ROW] = "INSERT OR REPLACE INTO sessions VALUES(?1,?2,?3,?4,?5,?6,?7,?8,?9,?10)",
    [PUT_LINE] = "INSERT OR REPLACE INTO log VALUES(?1,?2,?3)",
    [DELETE_ROW] = "DELETE FROM sessions WHERE number=?1",
    [DELETE_LOG] = "DELETE FROM log WHERE session=?1",
    [PUT_CLASS] = "INSERT OR REPLACE INTO classes VALUES(?1,?2,?3)",
    [DELETE_CLASS] = "DELETE FROM classes WHERE id=?1",
};

/* ---- errors ---- */

ll_status ll_store_error(const ll_store *store, sqlite3 *db, const char *doing)
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

/* ---- the writer thread ---- */

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

static bool delete_session(ll_store *store, int64_t number)
{
    sqlite3_bind_int64(store->prepared[DELETE_ROW], 1, number);
    sqlite3_bind_int64(store->prepared[DELETE_LOG], 1, number);
    return run(store->prepared[DELETE_ROW]) && run(store->prepared[DELETE_LOG]);
}

static bool write_class(ll_store *store, const record *r)
{
    sqlite3_stmt *s = store->prepared[r->type == RECORD_CLASS ? PUT_CLASS : DELETE_CLASS];
    sqlite3_bind_text(s, 1, r->bytes, LL_ID_LENGTH, SQLITE_STATIC);
    if (r->type == RECORD_CLASS) {
        const size_t skipped = LL_ID_LENGTH + 1;
        sqlite3_bind_int64(s, 2, r->index);
        sqlite3_bind_text64(s, 3, r->bytes + skipped, r->size - skipped, SQLITE_STATIC, SQLITE_UTF8);
    }
    return run(s);
}

static bool write_record(ll_store *store, const record *r)
{
    if (r->type == RECORD_CLASS || r->type == RECORD_DELETE_CLASS)
        return write_class(store, r);
    if (r->type == RECORD_DELETE)
        return delete_session(store, r->number);
    if (r->type == RECORD_ROW) {
        ll_stored row;
        memcpy(&row, r->bytes, sizeof row);
        bind_row(store->prepared[PUT_ROW], &row);
        return run(store->prepared[PUT_ROW]);
    }
    sqlite3_stmt *s = store->prepared[PUT_LINE];
    sqlite3_bind_int64(s, 1, r->number);
    sqlite3_bind_int64(s, 2, r->index);
    sqlite3_bind_text64(s, 3, r->bytes, r->size, SQLITE_STATIC, SQLITE_UTF8);
    return run(s);
}

/* All or nothing. A batch whose commit failed may be written again: rows are replaced, not duplicated. */
static ll_status commit(ll_store *store, const record *batch)
{
    sqlite3 *db = store->writer_db;
    bool good = sqlite3_exec(db, "BEGIN IMMEDIATE", NULL, NULL, NULL) == SQLITE_OK;
    for (const record *r = batch; r && good; r = r->next)
        good = write_record(store, r);
    if (good && sqlite3_exec(db, "COMMIT", NULL, NULL, NULL) == SQLITE_OK)
        return ll_ok();
    ll_status failed = ll_store_error(store, db, "Writing");
    if (!sqlite3_get_autocommit(db))
        sqlite3_exec(db, "ROLLBACK", NULL, NULL, NULL);
    return failed;
}

static void free_records(record *r)
{
    while (r) {
        record *next = r->next;
        free(r);
        r = next;
    }
}

static void wait_to_retry(ll_store *store)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += RETRY_S;
    while (!store->closing && pthread_cond_timedwait(&store->queued, &store->lock, &until) != ETIMEDOUT)
        ;
}

/* The lock is held at the call and at the return. */
static void write_batch(ll_store *store)
{
    record *batch = store->first, *last = store->last;
    LL_ASSERT(batch != NULL && last != NULL && last->next == NULL);
    uint64_t ticket = store->ticket;
    int64_t size = store->waiting;
    store->first = store->last = NULL;
    pthread_mutex_unlock(&store->lock);
    ll_status status = commit(store, batch);
    if (!ll_failed(&status))
        free_records(batch);
    pthread_mutex_lock(&store->lock);
    store->failing = ll_failed(&status);
    store->why = status;
    if (store->failing) { /* back to the front of the queue, in order */
        last->next = store->first;
        store->first = batch;
        store->last = store->last ? store->last : last;
        store->failures++;
    } else {
        LL_ASSERT(ticket >= store->durable && size <= store->waiting); /* in the order of the queue */
        store->durable = ticket;
        store->commits++;
        store->waiting -= size;
    }
    pthread_cond_broadcast(&store->done);
    if (store->notify) {
        pthread_mutex_unlock(&store->lock);
        store->notify(store->notify_context);
        pthread_mutex_lock(&store->lock);
    }
}

static void *write_all(void *argument)
{
    ll_store *store = argument;
    pthread_setname_np(pthread_self(), "store");
    pthread_mutex_lock(&store->lock);
    for (;;) {
        while (!store->first && !store->closing)
            pthread_cond_wait(&store->queued, &store->lock);
        if (!store->first)
            break;
        bool last_try = store->closing;
        write_batch(store);
        if (store->failing && last_try)
            break;
        if (store->failing)
            wait_to_retry(store);
    }
    pthread_mutex_unlock(&store->lock);
    return NULL;
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

static ll_status take_lock(ll_store *store)
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

static ll_status prepare_schema(ll_store *store)
{
    sqlite3 *db = store->writer_db;
    int64_t version = 0;
    if (!read_number(db, "PRAGMA user_version", &version))
        return ll_store_error(store, db, "Opening the database");
    if (version > SCHEMA_VERSION)
        return ll_error(LL_IO,
                        "Database in %s has schema %lld, of a newer laglab; this one supports up to %d.",
                        store->directory, (long long)version, SCHEMA_VERSION);
    if (version == 0) {
        char *made = sqlite3_mprintf("BEGIN IMMEDIATE;%sCOMMIT;", schema);
        int result = sqlite3_exec(db, made, NULL, NULL, NULL);
        sqlite3_free(made);
        if (result != SQLITE_OK)
            return ll_store_error(store, db, "Creating the database");
    }
    /* Takes the write lock once, so that a read-only disk is an error now and not at the first command. */
    if (sqlite3_exec(db, "BEGIN IMMEDIATE; PRAGMA user_version=1; COMMIT;", NULL, NULL, NULL) != SQLITE_OK ||
        sqlite3_exec(db, class_table, NULL, NULL, NULL) != SQLITE_OK)
        return ll_store_error(store, db, "Writing");
    int64_t highest = 0;
    if (!read_number(db, "SELECT coalesce(max(number), 0) FROM sessions", &highest))
        return ll_store_error(store, db, "Reading");
    store->next_number = highest + 1;
    return ll_ok();
}

static ll_status open_database(ll_store *store)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/laglab.db", store->directory);
    int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    if (sqlite3_open_v2(path, &store->writer_db, flags, NULL) != SQLITE_OK)
        return ll_store_error(store, store->writer_db, "Opening the database");
    sqlite3_busy_timeout(store->writer_db, BUSY_MS);
    if (sqlite3_exec(store->writer_db, "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;", NULL, NULL,
                     NULL) != SQLITE_OK)
        return ll_store_error(store, store->writer_db, "Opening the database");
    ll_status status = prepare_schema(store);
    for (int i = 0; i < STATEMENTS && !ll_failed(&status); i++) {
        if (sqlite3_prepare_v3(store->writer_db, statement_sql[i], -1, SQLITE_PREPARE_PERSISTENT,
                               &store->prepared[i], NULL) != SQLITE_OK)
            status = ll_store_error(store, store->writer_db, "Opening the database");
    }
    if (ll_failed(&status))
        return status;
    if (sqlite3_open_v2(path, &store->reader_db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, NULL) !=
        SQLITE_OK)
        return ll_store_error(store, store->reader_db, "Opening the database");
    sqlite3_busy_timeout(store->reader_db, BUSY_MS);
    return ll_ok();
}

static void free_store(ll_store *store)
{
    for (int i = 0; i < STATEMENTS; i++)
        sqlite3_finalize(store->prepared[i]);
    sqlite3_close(store->reader_db);
    sqlite3_close(store->writer_db);
    if (store->lock_file >= 0)
        close(store->lock_file);
    free_records(store->first);
    pthread_mutex_destroy(&store->lock);
    pthread_mutex_destroy(&store->reader_lock);
    pthread_cond_destroy(&store->queued);
    pthread_cond_destroy(&store->done);
    free(store->directory);
    free(store);
}

static ll_store *new_store(const char *directory)
{
    ll_store *store = calloc(1, sizeof *store);
    char *name = strdup(directory);
    if (!store || !name) {
        free(store);
        free(name);
        return NULL;
    }
    store->directory = name;
    store->lock_file = -1;
    pthread_mutex_init(&store->lock, NULL);
    pthread_mutex_init(&store->reader_lock, NULL);
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&store->queued, &monotonic);
    pthread_cond_init(&store->done, &monotonic);
    pthread_condattr_destroy(&monotonic);
    return store;
}

ll_status ll_store_open(const char *directory, ll_store **result)
{
    *result = NULL;
    ll_store *store = new_store(directory);
    if (!store)
        return ll_error(LL_NO_MEMORY, "out of memory: store");
    ll_status status = make_directory(directory);
    LL_THEN(status, take_lock(store));
    LL_THEN(status, open_database(store));
    if (!ll_failed(&status) && pthread_create(&store->thread, NULL, write_all, store) != 0)
        status = ll_error(LL_NO_MEMORY, "cannot start store thread");
    if (ll_failed(&status)) {
        free_store(store);
        return status;
    }
    store->started = true;
    *result = store;
    return ll_ok();
}

ll_status ll_store_close(ll_store *store)
{
    if (!store)
        return ll_ok();
    pthread_mutex_lock(&store->lock);
    store->closing = true;
    pthread_cond_broadcast(&store->queued);
    pthread_mutex_unlock(&store->lock);
    pthread_join(store->thread, NULL);
    ll_status status = store->failing ? store->why : ll_ok();
    free_store(store);
    return status;
}

/* ---- queueing ---- */

int64_t ll_store_new_number(ll_store *store)
{
    if (!store)
        return 0;
    pthread_mutex_lock(&store->lock);
    int64_t number = store->next_number++;
    pthread_mutex_unlock(&store->lock);
    return number;
}

static uint64_t enqueue(ll_store *store, record_type type, int64_t number, int64_t index, const void *bytes,
                        size_t size)
{
    if (!store)
        return 0;
    record *r = malloc(sizeof *r + size);
    LL_ASSERT(r); /* without this line the log would be incomplete */
    *r = (record){.type = type, .number = number, .index = index, .size = size};
    if (size)
        memcpy(r->bytes, bytes, size);
    pthread_mutex_lock(&store->lock);
    if (store->last)
        store->last->next = r;
    else
        store->first = r;
    store->last = r;
    store->waiting++;
    uint64_t ticket = ++store->ticket;
    pthread_cond_signal(&store->queued);
    pthread_mutex_unlock(&store->lock);
    return ticket;
}

uint64_t ll_store_put(ll_store *store, const ll_stored *stored)
{
    return enqueue(store, RECORD_ROW, stored->number, 0, stored, sizeof *stored);
}

uint64_t ll_store_line(ll_store *store, int64_t number, int64_t index, const char *line, size_t length)
{
    return enqueue(store, RECORD_LINE, number, index, line, length);
}

uint64_t ll_store_delete(ll_store *store, int64_t number)
{
    return enqueue(store, RECORD_DELETE, number, 0, NULL, 0);
}

uint64_t ll_store_put_class(ll_store *store, const char *id, int64_t seen_ms, const char *text)
{
    size_t length = strlen(text);
    char *bytes = store ? malloc(LL_ID_LENGTH + 1 + length) : NULL;
    if (!bytes)
        return 0;
    snprintf(bytes, LL_ID_LENGTH + 1, "%s", id);
    memcpy(bytes + LL_ID_LENGTH + 1, text, length);
    uint64_t ticket = enqueue(store, RECORD_CLASS, 0, seen_ms, bytes, LL_ID_LENGTH + 1 + length);
    free(bytes);
    return ticket;
}

uint64_t ll_store_delete_class(ll_store *store, const char *id)
{
    return enqueue(store, RECORD_DELETE_CLASS, 0, 0, id, LL_ID_LENGTH + 1);
}

ll_status ll_store_wait(ll_store *store, uint64_t ticket)
{
    if (!store)
        return ll_ok();
    pthread_mutex_lock(&store->lock);
    while (store->durable < ticket && !store->failing)
        pthread_cond_wait(&store->done, &store->lock);
    ll_status status = store->durable < ticket ? store->why : ll_ok();
    pthread_mutex_unlock(&store->lock);
    return status;
}

bool ll_store_failing(ll_store *store, ll_status *why)
{
    if (!store)
        return false;
    pthread_mutex_lock(&store->lock);
    bool failing = store->failing;
    if (failing && why)
        *why = store->why;
    pthread_mutex_unlock(&store->lock);
    return failing;
}

uint64_t ll_store_durable(ll_store *store)
{
    if (!store)
        return UINT64_MAX;
    pthread_mutex_lock(&store->lock);
    uint64_t durable = store->durable;
    pthread_mutex_unlock(&store->lock);
    return durable;
}

ll_store_stats ll_store_get_stats(ll_store *store)
{
    ll_store_stats stats = {0};
    if (!store)
        return stats;
    pthread_mutex_lock(&store->lock);
    stats =
        (ll_store_stats){.queued = store->waiting, .commits = store->commits, .failures = store->failures};
    pthread_mutex_unlock(&store->lock);
    return stats;
}

void ll_store_on_commit(ll_store *store, void (*notify)(void *context), void *context)
{
    if (!store)
        return;
    pthread_mutex_lock(&store->lock);
    store->notify = notify;
    store->notify_context = context;
    pthread_mutex_unlock(&store->lock);
}
