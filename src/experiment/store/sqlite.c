#include <inttypes.h>
#include <pthread.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>

#include "experiment/store/filesystem.h"
#include "experiment/store/kinds.h"

enum { BUSY_MS = 20000 };

static const char schema[] =
    "CREATE TABLE experiment(id TEXT PRIMARY KEY, specification TEXT NOT NULL, state INTEGER NOT NULL,"
    " first INTEGER NOT NULL, past INTEGER NOT NULL, created_s INTEGER NOT NULL, number INTEGER NOT NULL, "
    "owner_hash TEXT NOT NULL, version TEXT NOT NULL);"
    "CREATE TABLE chunk(id TEXT NOT NULL, chunk INTEGER NOT NULL, first INTEGER NOT NULL, past INTEGER NOT "
    "NULL,"
    " state INTEGER NOT NULL DEFAULT 0, attempt INTEGER NOT NULL DEFAULT 0, owner TEXT, lease_until REAL,"
    " PRIMARY KEY(id, chunk)) WITHOUT ROWID;"
    "CREATE INDEX chunk_open ON chunk(id, chunk) WHERE state < 2;"
    "CREATE TABLE result(id TEXT NOT NULL, run INTEGER NOT NULL, status INTEGER NOT NULL, error TEXT,"
    " hash INTEGER NOT NULL, t_s REAL NOT NULL, metrics BLOB NOT NULL, PRIMARY KEY(id, run)) WITHOUT ROWID;"
    "PRAGMA user_version=2;";

static const char schema_from_1[] =
    "ALTER TABLE experiment ADD COLUMN version TEXT NOT NULL DEFAULT ''; PRAGMA user_version=2;";

static const char key_table[] =
    "CREATE TABLE IF NOT EXISTS class_key(id TEXT PRIMARY KEY, name TEXT NOT NULL) WITHOUT ROWID;";

#define NOW "((julianday('now') - 2440587.5) * 86400.0)"
#define NOW_S "CAST(" NOW " AS INTEGER)"

typedef struct sqlite_store {
    ll_result_store base;
    sqlite3 *db;
    pthread_mutex_t lock; /* guards the connection, which one thread uses at a time */
    char path[512];
} sqlite_store;

static ll_status failure(const sqlite_store *s, const char *doing)
{
    switch (s->db ? sqlite3_errcode(s->db) & 0xff : SQLITE_NOMEM) {
    case SQLITE_FULL:
        return ll_error(LL_IO, "disk of the store %.150s is full", s->path);
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
        return ll_error(LL_IO, "cannot write to the store %.150s: %.60s", s->path, sqlite3_errmsg(s->db));
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return ll_error(LL_IO, "store %.150s is locked by another program", s->path);
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
        return ll_error(LL_IO, "store %.150s is damaged or not an SQLite database", s->path);
    default:
        return ll_error(LL_IO, "%s in the store %.120s failed: %.80s", doing, s->path,
                        s->db ? sqlite3_errmsg(s->db) : "no memory");
    }
}

/* ---- opening ---- */

static ll_status check_filesystem(const sqlite_store *s)
{
    struct statvfs fs;
    char folder[512], type[40];
    if (strcmp(s->path, ":memory:") == 0)
        return ll_ok();
    snprintf(folder, sizeof folder, "%s", s->path);
    char *slash = strrchr(folder, '/');
    snprintf(slash ? slash + (slash == folder) : folder, 2, "%s", slash ? "" : ".");
    if (statvfs(folder, &fs) != 0)
        return ll_ok(); /* opening it gives a better error */
    ll_filesystem_type(folder, type, sizeof type);
    if (ll_filesystem_is_remote(type))
        return ll_error(LL_BAD_INPUT,
                        "store %.100s is on %s, where SQLite loses data: use a local folder, PostgreSQL, or "
                        "--shard on each machine",
                        s->path, type);
    if (fs.f_flag & ST_RDONLY)
        return ll_error(LL_IO, "cannot write to the store %.150s: read-only file system", s->path);
    return ll_ok();
}

static ll_status prepare_schema(sqlite_store *s)
{
    sqlite3_stmt *q = NULL;
    int version = -1;
    if (sqlite3_prepare_v2(s->db, "PRAGMA user_version", -1, &q, NULL) == SQLITE_OK &&
        sqlite3_step(q) == SQLITE_ROW)
        version = sqlite3_column_int(q, 0);
    sqlite3_finalize(q);
    if (version < 0)
        return failure(s, "Opening");
    if (version > LL_STORE_SCHEMA)
        return ll_store_newer(s->path, version);
    const char *missing = version == LL_STORE_SCHEMA ? "" : version == 1 ? schema_from_1 : schema;
    return sqlite3_exec(s->db, missing, NULL, NULL, NULL) == SQLITE_OK &&
                   sqlite3_exec(s->db, key_table, NULL, NULL, NULL) == SQLITE_OK
               ? ll_ok()
               : failure(s, "Creating the tables");
}

static void close_store(ll_result_store *store)
{
    sqlite_store *s = (sqlite_store *)store;
    sqlite3_close(s->db);
    pthread_mutex_destroy(&s->lock);
    free(s);
}

static ll_status open_store(const char *url, ll_result_store **store)
{
    const char *path = strncmp(url, "sqlite:", 7) == 0 ? url + 7 : url;
    sqlite_store *s = calloc(1, sizeof *s);
    if (!s)
        return ll_error(LL_NO_MEMORY, "out of memory: store");
    s->base.kind = &ll_result_store_sqlite;
    pthread_mutex_init(&s->lock, NULL);
    snprintf(s->path, sizeof s->path, "%s", path);
    ll_status status =
        path[0] && strlen(path) < sizeof s->path
            ? check_filesystem(s)
            : ll_field_error(LL_BAD_INPUT, "store", "store: name: must have 1 to 511 characters");
    if (!ll_failed(&status) && sqlite3_open(s->path, &s->db) != SQLITE_OK)
        status = failure(s, "Opening");
    if (!ll_failed(&status)) {
        sqlite3_busy_timeout(s->db, BUSY_MS);
        if (sqlite3_exec(s->db, "PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; BEGIN IMMEDIATE", NULL,
                         NULL, NULL) != SQLITE_OK)
            status = failure(s, "Opening");
    }
    if (!ll_failed(&status)) {
        status = prepare_schema(s);
        sqlite3_exec(s->db, ll_failed(&status) ? "ROLLBACK" : "COMMIT", NULL, NULL, NULL);
    }
    if (ll_failed(&status)) {
        close_store(&s->base);
        return status;
    }
    *store = &s->base;
    return ll_ok();
}

/* ---- statements ---- */

/* `types`: a letter per argument: t text, i int64_t, r double. NULL when it cannot be prepared. */
static sqlite3_stmt *query(sqlite_store *s, const char *sql, const char *types, ...)
{
    sqlite3_stmt *q = NULL;
    va_list arguments;
    if (sqlite3_prepare_v2(s->db, sql, -1, &q, NULL) != SQLITE_OK)
        return NULL;
    va_start(arguments, types);
    for (int i = 1; *types; types++, i++) {
        if (*types == 't')
            sqlite3_bind_text(q, i, va_arg(arguments, const char *), -1, SQLITE_TRANSIENT);
        else if (*types == 'r')
            sqlite3_bind_double(q, i, va_arg(arguments, double));
        else
            sqlite3_bind_int64(q, i, va_arg(arguments, int64_t));
    }
    va_end(arguments);
    return q;
}

/* Runs a statement that returns no rows. */
static bool done(sqlite3_stmt *q)
{
    bool good = q && sqlite3_step(q) == SQLITE_DONE;
    sqlite3_finalize(q);
    return good;
}

static sqlite_store *enter(ll_result_store *store)
{
    sqlite_store *s = (sqlite_store *)store;
    pthread_mutex_lock(&s->lock);
    return s;
}

static ll_status leave(sqlite_store *s, ll_status status)
{
    pthread_mutex_unlock(&s->lock);
    return status;
}

static bool begin(sqlite_store *s)
{
    return sqlite3_exec(s->db, "BEGIN IMMEDIATE", NULL, NULL, NULL) == SQLITE_OK;
}

/* Commits, or rolls back after a failure. */
static ll_status end(sqlite_store *s, bool good, const char *doing)
{
    if (good && sqlite3_exec(s->db, "COMMIT", NULL, NULL, NULL) == SQLITE_OK)
        return ll_ok();
    ll_status status = failure(s, doing);
    if (!sqlite3_get_autocommit(s->db))
        sqlite3_exec(s->db, "ROLLBACK", NULL, NULL, NULL);
    return status;
}

/* ---- experiments ---- */

static ll_status specification(ll_result_store *store, const char *id, char **text)
{
    sqlite_store *s = enter(store);
    sqlite3_stmt *q = query(s, "SELECT specification FROM experiment WHERE id=?1", "t", id);
    int result = q ? sqlite3_step(q) : SQLITE_ERROR;
    *text = result == SQLITE_ROW ? strdup((const char *)sqlite3_column_text(q, 0)) : NULL;
    sqlite3_finalize(q);
    return leave(s, result == SQLITE_ROW    ? ll_ok()
                    : result == SQLITE_DONE ? ll_store_unknown(id)
                                            : failure(s, "Reading"));
}

/* Within the transaction of its creation. */
static bool insert_key(sqlite_store *s, const ll_experiment_record *r, bool *full)
{
    if (!r->class_key[0])
        return true;
    sqlite3_stmt *q = query(s, LL_STORE_COUNT_KEY "?1", "t", r->class_key);
    bool good = q && sqlite3_step(q) == SQLITE_ROW;
    *full = good && r->most_of_key >= 0 && sqlite3_column_int64(q, 0) >= r->most_of_key;
    sqlite3_finalize(q);
    return good && (*full || done(query(s, "INSERT OR REPLACE INTO class_key VALUES(?1,?2)", "tt", r->id,
                                        r->class_key)));
}

static ll_status create(ll_result_store *store, const ll_experiment_record *r, const char *text,
                        int64_t chunk)
{
    sqlite_store *s = enter(store);
    sqlite3_stmt *q = query(s, "SELECT specification=?2 AND version=?3 FROM experiment WHERE id=?1", "ttt",
                            r->id, text, store->version);
    int result = q ? sqlite3_step(q) : SQLITE_ERROR;
    bool same = result == SQLITE_ROW && sqlite3_column_int(q, 0) != 0;
    sqlite3_finalize(q);
    if (result == SQLITE_ROW)
        return leave(s, same ? ll_ok() : ll_store_taken(s->path, r->id));
    bool full = false, good = result == SQLITE_DONE && begin(s) && insert_key(s, r, &full);
    if (good && full) {
        ll_status ended = end(s, true, "Reading");
        return leave(s, ll_failed(&ended) ? ended : ll_store_key_full(r));
    }
    good = good && done(query(s,
                              "INSERT INTO experiment VALUES(?1,?2,0,?3,?4," NOW_S ","
                              "(SELECT coalesce(max(number),0)+1 FROM experiment),?5,?6)",
                              "ttiitt", r->id, text, r->from, r->to, r->owner_hash, store->version));
    for (int64_t k = 0, at = r->from; good && at < r->to; k++, at += chunk)
        good = done(query(s, "INSERT INTO chunk(id,chunk,first,past) VALUES(?1,?2,?3,?4)", "tiii", r->id, k,
                          at, at + chunk < r->to ? at + chunk : r->to));
    return leave(s, end(s, good, "Registering an experiment"));
}

static ll_experiment_record read_record(sqlite3_stmt *q)
{
    ll_experiment_record r = {.state = (ll_experiment_state)sqlite3_column_int(q, 1),
                              .from = sqlite3_column_int64(q, 2),
                              .to = sqlite3_column_int64(q, 3),
                              .created_s = sqlite3_column_int64(q, 4),
                              .done = sqlite3_column_int64(q, 5),
                              .leased = sqlite3_column_int64(q, 6),
                              .age_s = sqlite3_column_int64(q, 10)};
    snprintf(r.id, sizeof r.id, "%s", (const char *)sqlite3_column_text(q, 0));
    snprintf(r.owner_hash, sizeof r.owner_hash, "%s", (const char *)sqlite3_column_text(q, 8));
    snprintf(r.version, sizeof r.version, "%s", (const char *)sqlite3_column_text(q, 9));
    snprintf(r.class_key, sizeof r.class_key, "%s", (const char *)sqlite3_column_text(q, 11));
    ll_store_set_state(&r, sqlite3_column_int(q, 7) != 0);
    return r;
}

static ll_status get_record(ll_result_store *store, const char *id, ll_experiment_record *record)
{
    sqlite_store *s = enter(store);
    sqlite3_stmt *q = query(s, LL_STORE_RECORD(NOW_S) "WHERE e.id=?1", "t", id);
    int result = q ? sqlite3_step(q) : SQLITE_ERROR;
    if (result == SQLITE_ROW)
        *record = read_record(q);
    sqlite3_finalize(q);
    return leave(s, result == SQLITE_ROW    ? ll_ok()
                    : result == SQLITE_DONE ? ll_store_unknown(id)
                                            : failure(s, "Reading"));
}

static ll_status list(ll_result_store *store, void (*each)(void *context, const ll_experiment_record *record),
                      void *context)
{
    sqlite_store *s = enter(store);
    sqlite3_stmt *q = query(s, LL_STORE_RECORD(NOW_S) "ORDER BY e.number", "");
    int result = SQLITE_ERROR;
    while (q && (result = sqlite3_step(q)) == SQLITE_ROW) {
        ll_experiment_record record = read_record(q);
        each(context, &record);
    }
    sqlite3_finalize(q);
    return leave(s, result == SQLITE_DONE ? ll_ok() : failure(s, "Reading"));
}

static ll_status set_state(ll_result_store *store, const char *id, ll_experiment_state state)
{
    sqlite_store *s = enter(store);
    bool good = done(query(s, "UPDATE experiment SET state=?2 WHERE id=?1", "ti", id, (int64_t)state));
    ll_status status = !good                         ? failure(s, "Writing")
                       : sqlite3_changes(s->db) == 0 ? ll_store_unknown(id)
                                                     : ll_ok();
    return leave(s, status);
}

static ll_status remove_experiment(ll_result_store *store, const char *id)
{
    sqlite_store *s = enter(store);
    bool good = begin(s) && done(query(s, "DELETE FROM experiment WHERE id=?1", "t", id));
    bool there = good && sqlite3_changes(s->db) > 0;
    good = good && done(query(s, "DELETE FROM chunk WHERE id=?1", "t", id)) &&
           done(query(s, "DELETE FROM result WHERE id=?1", "t", id)) &&
           done(query(s, "DELETE FROM class_key WHERE id=?1", "t", id));
    ll_status status = end(s, good, "Deleting");
    return leave(s, ll_failed(&status) || there ? status : ll_store_unknown(id));
}

/* ---- leases ---- */

#define TAKE                                                                                                 \
    "UPDATE chunk SET state=1, attempt=attempt+1, owner=?1, lease_until=" NOW "+?2 WHERE (id,chunk)=("
#define IS_FREE "(c.state=0 OR (c.state=1 AND c.lease_until<" NOW "))"
#define TAKEN ") RETURNING id,chunk,first,past,attempt"

/* A sweep's own claims must cost little: its runs may take less. */
static const char of_one[] =
    TAKE "SELECT c.id,c.chunk FROM chunk c JOIN experiment e ON e.id=c.id"
         " WHERE e.state=0 AND c.id=?3 AND e.version=?4 AND " IS_FREE " ORDER BY c.chunk LIMIT 1" TAKEN;
static const char of_any_in_turn[] =
    TAKE "WITH turn AS MATERIALIZED (SELECT e.id, e.number,"
         " (SELECT count(*) FROM chunk b WHERE b.id=e.id AND b.state=1 AND b.lease_until>=" NOW ") AS busy,"
         " (SELECT max(l.lease_until) FROM chunk l WHERE l.id=e.id) AS last"
         " FROM experiment e WHERE e.state=0 AND e.version=?4"
         " AND EXISTS (SELECT 1 FROM chunk o WHERE o.id=e.id AND o.state<2))"
         " SELECT c.id,c.chunk FROM turn t JOIN chunk c ON c.id=t.id WHERE " IS_FREE
         " ORDER BY t.busy, t.last NULLS FIRST, t.number, c.chunk LIMIT 1" TAKEN;

static ll_status claim(ll_result_store *store, const char *id, const char *owner, double lease_s,
                       ll_lease *lease)
{
    sqlite_store *s = enter(store);
    *lease = (ll_lease){.chunk = -1};
    bool good = begin(s);
    /* A chunk that was lost by too many workers is marked as failed, since it probably kills them. */
    good =
        good && done(query(s, "UPDATE chunk SET state=3 WHERE state=1 AND attempt>=?1 AND lease_until<" NOW,
                           "i", (int64_t)LL_ATTEMPTS_MAX));
    sqlite3_stmt *q =
        good ? query(s, id ? of_one : of_any_in_turn, "trtt", owner, lease_s, id ? id : "", store->version)
             : NULL;
    int result = q ? sqlite3_step(q) : SQLITE_ERROR;
    if (result == SQLITE_ROW) {
        lease->chunk = sqlite3_column_int64(q, 1);
        lease->from = sqlite3_column_int64(q, 2);
        lease->to = sqlite3_column_int64(q, 3);
        lease->attempt = sqlite3_column_int(q, 4);
        snprintf(lease->id, sizeof lease->id, "%s", (const char *)sqlite3_column_text(q, 0));
        snprintf(lease->owner, sizeof lease->owner, "%s", owner);
        result = sqlite3_step(q);
    }
    sqlite3_finalize(q);
    return leave(s, end(s, result == SQLITE_DONE, "Claiming"));
}

#define MINE "id=?1 AND chunk=?2 AND owner=?3 AND attempt=?4 AND state=1"

static ll_status renew(ll_result_store *store, const ll_lease *l, double lease_s)
{
    sqlite_store *s = enter(store);
    bool good = done(query(s, "UPDATE chunk SET lease_until=" NOW "+?5 WHERE " MINE, "titir", l->id, l->chunk,
                           l->owner, (int64_t)l->attempt, lease_s));
    return leave(s, !good                         ? failure(s, "Renewing a lease")
                    : sqlite3_changes(s->db) == 0 ? ll_store_lost(l)
                                                  : ll_ok());
}

static ll_status return_chunk(ll_result_store *store, const ll_lease *l)
{
    sqlite_store *s = enter(store);
    bool good = done(query(s, "UPDATE chunk SET state=0, attempt=attempt-1 WHERE " MINE, "titi", l->id,
                           l->chunk, l->owner, (int64_t)l->attempt));
    return leave(s, !good                         ? failure(s, "Returning a chunk")
                    : sqlite3_changes(s->db) == 0 ? ll_store_lost(l)
                                                  : ll_ok());
}

static bool insert_rows(sqlite_store *s, const char *id, const ll_row *rows, int64_t count, int metrics)
{
    sqlite3_stmt *q = query(s, "INSERT INTO result VALUES(?1,?2,?3,?4,?5,?6,?7)", "t", id);
    bool good = q != NULL;
    for (int64_t i = 0; good && i < count; i++) {
        const ll_row *r = &rows[i];
        sqlite3_bind_int64(q, 2, r->run);
        sqlite3_bind_int(q, 3, (int)r->status);
        if (r->error[0])
            sqlite3_bind_text(q, 4, r->error, -1, SQLITE_STATIC);
        else
            sqlite3_bind_null(q, 4);
        sqlite3_bind_int64(q, 5, (int64_t)r->hash);
        sqlite3_bind_double(q, 6, r->t_s);
        sqlite3_bind_blob(q, 7, r->metrics, metrics * (int)sizeof r->metrics[0], SQLITE_STATIC);
        good = sqlite3_step(q) == SQLITE_DONE;
        sqlite3_reset(q);
    }
    sqlite3_finalize(q);
    return good;
}

static ll_status finish(ll_result_store *store, const ll_lease *l, const ll_row *rows, int64_t count,
                        int metrics)
{
    sqlite_store *s = enter(store);
    bool good = begin(s) && done(query(s, "UPDATE chunk SET state=2 WHERE " MINE, "titi", l->id, l->chunk,
                                       l->owner, (int64_t)l->attempt));
    if (good && sqlite3_changes(s->db) == 0) {
        sqlite3_exec(s->db, "ROLLBACK", NULL, NULL, NULL);
        return leave(s, ll_store_lost(l));
    }
    return leave(s, end(s, good && insert_rows(s, l->id, rows, count, metrics), "Storing rows"));
}

static ll_status release(ll_result_store *store)
{
    sqlite_store *s = enter(store);
    bool good = done(query(s, "UPDATE chunk SET state=0, attempt=attempt-1 WHERE state=1", ""));
    return leave(s, good ? ll_ok() : failure(s, "Releasing leases"));
}

static ll_status bytes(ll_result_store *store, int64_t *taken)
{
    sqlite_store *s = enter(store);
    sqlite3_stmt *q = query(s,
                            "SELECT (page_count - freelist_count) * page_size"
                            " FROM pragma_page_count, pragma_freelist_count, pragma_page_size",
                            "");
    bool good = q && sqlite3_step(q) == SQLITE_ROW;
    *taken = good ? sqlite3_column_int64(q, 0) : 0;
    sqlite3_finalize(q);
    return leave(s, good ? ll_ok() : failure(s, "Reading"));
}

/* ---- rows ---- */

static void read_row(sqlite3_stmt *q, ll_row *r)
{
    ll_row_clear(r);
    r->run = sqlite3_column_int64(q, 0);
    r->status = (ll_row_status)sqlite3_column_int(q, 1);
    const unsigned char *error = sqlite3_column_text(q, 2);
    snprintf(r->error, sizeof r->error, "%s", error ? (const char *)error : "");
    r->hash = (uint64_t)sqlite3_column_int64(q, 3);
    r->t_s = sqlite3_column_double(q, 4);
    const void *metrics = sqlite3_column_blob(q, 5);
    size_t size = (size_t)sqlite3_column_bytes(q, 5);
    memcpy(r->metrics, metrics, size < sizeof r->metrics ? size : sizeof r->metrics);
}

static ll_status read_rows(ll_result_store *store, const char *id, int64_t from, ll_row *rows, int capacity,
                           int *count)
{
    sqlite_store *s = enter(store);
    sqlite3_stmt *q =
        query(s,
              "SELECT run,status,error,hash,t_s,metrics FROM result WHERE id=?1 AND run>=?2 ORDER BY run "
              "LIMIT ?3",
              "tii", id, from, (int64_t)capacity);
    int result = SQLITE_ERROR;
    *count = 0;
    while (q && (result = sqlite3_step(q)) == SQLITE_ROW)
        read_row(q, &rows[(*count)++]);
    sqlite3_finalize(q);
    return leave(s, result == SQLITE_DONE ? ll_ok() : failure(s, "Reading"));
}

const ll_result_store_kind ll_result_store_sqlite = {.open = open_store,
                                                     .close = close_store,
                                                     .create = create,
                                                     .specification = specification,
                                                     .record = get_record,
                                                     .list = list,
                                                     .set_state = set_state,
                                                     .remove = remove_experiment,
                                                     .claim = claim,
                                                     .renew = renew,
                                                     .finish = finish,
                                                     .return_chunk = return_chunk,
                                                     .release = release,
                                                     .bytes = bytes,
                                                     .read = read_rows};
