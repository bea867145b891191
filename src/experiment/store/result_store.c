#include "experiment/store/result_store.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/assert.h"
#include "experiment/store/read_only.h"

enum { SCHEMA = 3, BUSY_MS = 1000, ROWS_AT_ONCE = 256 };

/* State of a chunk: 0, its rows are missing; 2, they are stored. */
static const char schema[] =
    "CREATE TABLE experiment(id TEXT PRIMARY KEY, specification TEXT NOT NULL, state INTEGER NOT NULL,"
    " first INTEGER NOT NULL, past INTEGER NOT NULL, created_s INTEGER NOT NULL, number INTEGER NOT NULL, "
    "owner_hash TEXT NOT NULL, version TEXT NOT NULL);"
    "CREATE TABLE chunk(id TEXT NOT NULL, chunk INTEGER NOT NULL, first INTEGER NOT NULL, past INTEGER NOT "
    "NULL,"
    " state INTEGER NOT NULL DEFAULT 0, PRIMARY KEY(id, chunk)) WITHOUT ROWID;"
    "CREATE INDEX chunk_open ON chunk(id, chunk) WHERE state < 2;"
    "CREATE TABLE result(id TEXT NOT NULL, run INTEGER NOT NULL, status INTEGER NOT NULL, error TEXT,"
    " hash INTEGER NOT NULL, t_s REAL NOT NULL, metrics BLOB NOT NULL, PRIMARY KEY(id, run)) WITHOUT ROWID;"
    "PRAGMA user_version=3;";

static const char schema_from_1[] = "ALTER TABLE experiment ADD COLUMN version TEXT NOT NULL DEFAULT '';";
static const char schema_from_2[] =
    "UPDATE chunk SET state=0 WHERE state<>2; ALTER TABLE chunk DROP COLUMN attempt;"
    "ALTER TABLE chunk DROP COLUMN owner; ALTER TABLE chunk DROP COLUMN lease_until; PRAGMA user_version=3;";

/* Names of class keys stand in a table of their own, which a store of an earlier laglab gets when it is
 * opened. */
static const char key_table[] =
    "CREATE TABLE IF NOT EXISTS class_key(id TEXT PRIMARY KEY, name TEXT NOT NULL) WITHOUT ROWID;";

#define NOW_S "CAST((julianday('now') - 2440587.5) * 86400.0 AS INTEGER)"

const char *const ll_experiment_state_names[] = {"running", "paused", "cancelled", "done"};

struct ll_result_store {
    sqlite3 *db;
    pthread_mutex_t lock; /* guards all members; one thread uses the connection at a time */
    ll_chunk claims[LL_CLAIMS_MAX];
    int claimed;
    int64_t turn;      /* number of the experiment of the last claim */
    ll_status written; /* of the last transaction that wrote */
    bool read_only;    /* it could be opened for reading only */
    char path[512];
};

/* ---- messages ---- */

static ll_status failure(const ll_result_store *s, const char *doing)
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
        return ll_error(LL_IO, "store %.150s is in use by another program", s->path);
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
        return ll_error(LL_IO, "store %.150s is damaged or not an SQLite database", s->path);
    default:
        return ll_error(LL_IO, "%s in the store %.120s failed: %.80s", doing, s->path,
                        s->db ? sqlite3_errmsg(s->db) : "no memory");
    }
}

static ll_status unknown(const char *id)
{
    return ll_field_error(LL_NOT_FOUND, "experiment", "experiment %.60s not found in the store", id);
}

static ll_status key_full(const ll_experiment_record *record)
{
    return ll_error(LL_LIMIT, "class key %s has %lld experiments, as many as it may", record->class_key,
                    (long long)record->most_of_key);
}

/* ---- opening ---- */

static ll_status prepare_schema(ll_result_store *s)
{
    sqlite3_stmt *q = NULL;
    int version = -1;
    if (sqlite3_prepare_v2(s->db, "PRAGMA user_version", -1, &q, NULL) == SQLITE_OK &&
        sqlite3_step(q) == SQLITE_ROW)
        version = sqlite3_column_int(q, 0);
    sqlite3_finalize(q);
    if (version < 0)
        return failure(s, "Opening");
    if (version > SCHEMA)
        return ll_error(LL_BAD_INPUT,
                        "the store %.120s is of schema %d, of a newer laglab; this one supports up to %d",
                        s->path, version, SCHEMA);
    const char *const steps[] = {version == 0 ? schema : "", version == 1 ? schema_from_1 : "",
                                 version == 1 || version == 2 ? schema_from_2 : "", key_table};
    for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++)
        if (sqlite3_exec(s->db, steps[i], NULL, NULL, NULL) != SQLITE_OK)
            return failure(s, "Creating the tables");
    return ll_ok();
}

void ll_result_store_close(ll_result_store *s)
{
    if (!s)
        return;
    sqlite3_close(s->db);
    pthread_mutex_destroy(&s->lock);
    free(s);
}

/* Why a file cannot be written, which SQLite does not say. */
static ll_status check_file(const char *path)
{
    if (strcmp(path, ":memory:") == 0)
        return ll_ok();
    int file = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
    if (file < 0)
        return ll_error(LL_IO, "cannot write to the store %.150s: %s", path, strerror(errno));
    close(file);
    return ll_ok();
}

/* The lock of the file lasts until it is closed. So the log's index needs no shared memory, which network
 * file systems lack. `unwritable`: on an error, whether it can perhaps be read. */
static ll_status open_database(ll_result_store *s, bool *unwritable)
{
    ll_status status = check_file(s->path);
    *unwritable = ll_failed(&status);
    LL_TRY(status);
    bool open = sqlite3_open(s->path, &s->db) == SQLITE_OK;
    sqlite3_busy_timeout(s->db, BUSY_MS);
    open = open && sqlite3_exec(s->db,
                                "PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL;"
                                "PRAGMA synchronous=NORMAL; BEGIN IMMEDIATE",
                                NULL, NULL, NULL) == SQLITE_OK;
    status = open ? prepare_schema(s) : failure(s, "Opening");
    *unwritable = ll_failed(&status) && ll_is_unwritable(s->db);
    if (open)
        sqlite3_exec(s->db, ll_failed(&status) ? "ROLLBACK" : "COMMIT", NULL, NULL, NULL);
    return status;
}

/* After `why`, with which it could not be opened for writing. */
static ll_status open_to_read(ll_result_store *s, const ll_status *why)
{
    sqlite3_stmt *q = NULL;
    sqlite3_close(s->db);
    bool good = ll_open_read_only(s->path, &s->db) &&
                sqlite3_prepare_v2(s->db, "PRAGMA user_version", -1, &q, NULL) == SQLITE_OK &&
                sqlite3_step(q) == SQLITE_ROW && sqlite3_column_int(q, 0) == SCHEMA;
    sqlite3_finalize(q);
    s->read_only = good;
    s->written = *why;
    return good ? ll_ok() : *why;
}

static ll_status open_store(const char *path, bool reads, ll_result_store **store)
{
    bool unwritable = false;
    ll_result_store *s = *store = calloc(1, sizeof *s);
    if (!s)
        return ll_error(LL_NO_MEMORY, "out of memory: store");
    pthread_mutex_init(&s->lock, NULL);
    snprintf(s->path, sizeof s->path, "%s", path);
    ll_status status =
        path[0] && strlen(path) < sizeof s->path
            ? open_database(s, &unwritable)
            : ll_field_error(LL_BAD_INPUT, "store", "store: name: must have 1 to 511 characters");
    if (unwritable && reads)
        status = open_to_read(s, &status);
    if (ll_failed(&status)) {
        ll_result_store_close(s);
        *store = NULL;
    }
    return status;
}

ll_status ll_result_store_open(const char *path, ll_result_store **store)
{
    return open_store(path, false, store);
}

ll_status ll_result_store_open_any(const char *path, ll_result_store **store)
{
    return open_store(path, true, store);
}

/* ---- statements ---- */

/* `types`: a letter per argument: t text, i int64_t. NULL when it cannot be prepared. */
static sqlite3_stmt *query(ll_result_store *s, const char *sql, const char *types, ...)
{
    sqlite3_stmt *q = NULL;
    va_list arguments;
    if (sqlite3_prepare_v2(s->db, sql, -1, &q, NULL) != SQLITE_OK)
        return NULL;
    va_start(arguments, types);
    for (int i = 1; *types; types++, i++)
        if (*types == 't')
            sqlite3_bind_text(q, i, va_arg(arguments, const char *), -1, SQLITE_TRANSIENT);
        else
            sqlite3_bind_int64(q, i, va_arg(arguments, int64_t));
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

static void enter(ll_result_store *s)
{
    pthread_mutex_lock(&s->lock);
}

static ll_status leave(ll_result_store *s, ll_status status)
{
    pthread_mutex_unlock(&s->lock);
    return status;
}

static bool begin(ll_result_store *s)
{
    return sqlite3_exec(s->db, "BEGIN IMMEDIATE", NULL, NULL, NULL) == SQLITE_OK;
}

/* Commits, or rolls back after a failure. */
static ll_status end(ll_result_store *s, bool good, const char *doing)
{
    good = good && sqlite3_exec(s->db, "COMMIT", NULL, NULL, NULL) == SQLITE_OK;
    s->written = good ? ll_ok() : failure(s, doing);
    if (!sqlite3_get_autocommit(s->db))
        sqlite3_exec(s->db, "ROLLBACK", NULL, NULL, NULL);
    return s->written;
}

/* ---- whether it works ---- */

bool ll_result_store_failing(ll_result_store *s, ll_status *why)
{
    enter(s);
    ll_status written = s->written;
    leave(s, ll_ok());
    if (why)
        *why = written;
    return ll_failed(&written);
}

void ll_result_store_try(ll_result_store *s)
{
    bool unwritable = false;
    enter(s);
    if (s->read_only) {
        sqlite3_close(s->db);
        s->db = NULL;
        s->written = open_database(s, &unwritable);
        s->read_only = ll_failed(&s->written);
        if (s->read_only)
            open_to_read(s, &s->written);
    }
    ll_status status = s->written;
    if (!s->read_only)
        status = end(
            s, begin(s) && done(query(s, "INSERT OR REPLACE INTO class_key VALUES('',zeroblob(65536))", "")),
            "Writing");
    if (!ll_failed(&status))
        done(query(s, "DELETE FROM class_key WHERE id=''", ""));
    leave(s, ll_ok());
}

/* ---- experiments ---- */

ll_status ll_result_store_specification(ll_result_store *s, const char *id, char **text)
{
    enter(s);
    sqlite3_stmt *q = query(s, "SELECT specification FROM experiment WHERE id=?1", "t", id);
    int result = q ? sqlite3_step(q) : SQLITE_ERROR;
    *text = result == SQLITE_ROW ? strdup((const char *)sqlite3_column_text(q, 0)) : NULL;
    sqlite3_finalize(q);
    return leave(s, result == SQLITE_ROW    ? ll_ok()
                    : result == SQLITE_DONE ? unknown(id)
                                            : failure(s, "Reading"));
}

/* Within the transaction of its creation. */
static bool insert_key(ll_result_store *s, const ll_experiment_record *r, bool *full)
{
    if (!r->class_key[0])
        return true;
    sqlite3_stmt *q =
        query(s, "SELECT count(*) FROM class_key k JOIN experiment e ON e.id=k.id WHERE k.name=?1", "t",
              r->class_key);
    bool good = q && sqlite3_step(q) == SQLITE_ROW;
    *full = good && r->most_of_key >= 0 && sqlite3_column_int64(q, 0) >= r->most_of_key;
    sqlite3_finalize(q);
    return good && (*full || done(query(s, "INSERT OR REPLACE INTO class_key VALUES(?1,?2)", "tt", r->id,
                                        r->class_key)));
}

/* Whether the id is there already; then `same` says whether it is the same experiment. */
static int find_same(ll_result_store *s, const char *id, const char *text, bool *same)
{
    sqlite3_stmt *q = query(s, "SELECT specification=?2 AND version=?3 FROM experiment WHERE id=?1", "ttt",
                            id, text, ll_version);
    int result = q ? sqlite3_step(q) : SQLITE_ERROR;
    *same = result == SQLITE_ROW && sqlite3_column_int(q, 0) != 0;
    sqlite3_finalize(q);
    return result;
}

ll_status ll_result_store_create(ll_result_store *s, const ll_experiment_record *r, const char *text,
                                 int64_t chunk)
{
    bool same = false, full = false;
    enter(s);
    int result = find_same(s, r->id, text, &same);
    if (result == SQLITE_ROW)
        return leave(
            s, same ? ll_ok()
                    : ll_error(LL_CONFLICT, "the store %.120s has another experiment %s", s->path, r->id));
    bool good = result == SQLITE_DONE && begin(s) && insert_key(s, r, &full);
    if (good && full) {
        ll_status ended = end(s, true, "Reading");
        return leave(s, ll_failed(&ended) ? ended : key_full(r));
    }
    good = good && done(query(s,
                              "INSERT INTO experiment VALUES(?1,?2,0,?3,?4," NOW_S ","
                              "(SELECT coalesce(max(number),0)+1 FROM experiment),?5,?6)",
                              "ttiitt", r->id, text, r->from, r->to, r->owner_hash, ll_version));
    for (int64_t k = 0, at = r->from; good && at < r->to; k++, at += chunk)
        good = done(query(s, "INSERT INTO chunk(id,chunk,first,past) VALUES(?1,?2,?3,?4)", "tiii", r->id, k,
                          at, at + chunk < r->to ? at + chunk : r->to));
    return leave(s, end(s, good, "Registering an experiment"));
}

#define RECORD                                                                                               \
    "SELECT e.id,e.state,e.first,e.past,e.created_s,"                                                        \
    " coalesce((SELECT sum(past-first) FROM chunk c WHERE c.id=e.id AND c.state=2),0),"                      \
    " e.owner_hash,e.version," NOW_S                                                                         \
    "-e.created_s,coalesce((SELECT name FROM class_key k WHERE k.id=e.id),'') FROM experiment e "

static ll_experiment_record read_record(sqlite3_stmt *q)
{
    ll_experiment_record r = {.state = (ll_experiment_state)sqlite3_column_int(q, 1),
                              .from = sqlite3_column_int64(q, 2),
                              .to = sqlite3_column_int64(q, 3),
                              .created_s = sqlite3_column_int64(q, 4),
                              .done = sqlite3_column_int64(q, 5),
                              .age_s = sqlite3_column_int64(q, 8)};
    snprintf(r.id, sizeof r.id, "%s", (const char *)sqlite3_column_text(q, 0));
    snprintf(r.owner_hash, sizeof r.owner_hash, "%s", (const char *)sqlite3_column_text(q, 6));
    snprintf(r.version, sizeof r.version, "%s", (const char *)sqlite3_column_text(q, 7));
    snprintf(r.class_key, sizeof r.class_key, "%s", (const char *)sqlite3_column_text(q, 9));
    LL_ASSERT(r.from <= r.to && r.done >= 0 && r.done <= r.to - r.from);
    if (r.done == r.to - r.from)
        r.state = LL_EXPERIMENT_DONE;
    return r;
}

ll_status ll_result_store_record(ll_result_store *s, const char *id, ll_experiment_record *record)
{
    enter(s);
    sqlite3_stmt *q = query(s, RECORD "WHERE e.id=?1", "t", id);
    int result = q ? sqlite3_step(q) : SQLITE_ERROR;
    if (result == SQLITE_ROW)
        *record = read_record(q);
    sqlite3_finalize(q);
    return leave(s, result == SQLITE_ROW    ? ll_ok()
                    : result == SQLITE_DONE ? unknown(id)
                                            : failure(s, "Reading"));
}

ll_status ll_result_store_list(ll_result_store *s,
                               void (*each)(void *context, const ll_experiment_record *record), void *context)
{
    enter(s);
    sqlite3_stmt *q = query(s, RECORD "ORDER BY e.number", "");
    int result = SQLITE_ERROR;
    while (q && (result = sqlite3_step(q)) == SQLITE_ROW) {
        ll_experiment_record record = read_record(q);
        each(context, &record);
    }
    sqlite3_finalize(q);
    return leave(s, result == SQLITE_DONE ? ll_ok() : failure(s, "Reading"));
}

ll_status ll_result_store_set_state(ll_result_store *s, const char *id, ll_experiment_state state)
{
    enter(s);
    bool good =
        begin(s) && done(query(s, "UPDATE experiment SET state=?2 WHERE id=?1", "ti", id, (int64_t)state));
    bool there = good && sqlite3_changes(s->db) > 0;
    ll_status status = end(s, good, "Writing");
    return leave(s, ll_failed(&status) || there ? status : unknown(id));
}

ll_status ll_result_store_remove(ll_result_store *s, const char *id)
{
    enter(s);
    bool good = begin(s) && done(query(s, "DELETE FROM experiment WHERE id=?1", "t", id));
    bool there = good && sqlite3_changes(s->db) > 0;
    good = good && done(query(s, "DELETE FROM chunk WHERE id=?1", "t", id)) &&
           done(query(s, "DELETE FROM result WHERE id=?1", "t", id)) &&
           done(query(s, "DELETE FROM class_key WHERE id=?1", "t", id));
    ll_status status = end(s, good, "Deleting");
    return leave(s, ll_failed(&status) || there ? status : unknown(id));
}

/* ---- versions ---- */

ll_status ll_result_store_check_version(const ll_experiment_record *r)
{
    bool over = r->state != LL_EXPERIMENT_RUNNING && r->state != LL_EXPERIMENT_PAUSED;
    if (over || strcmp(r->version, ll_version) == 0)
        return ll_ok();
    return ll_error(LL_CONFLICT,
                    "experiment %s is of laglab %s; results of this one, %s, may differ, so it adds none: "
                    "continue with that version, or run the experiment again",
                    r->id, r->version[0] ? r->version : "of an unknown version", ll_version);
}

static void inspect(void *first, const ll_experiment_record *record)
{
    ll_status *status = first;
    if (!ll_failed(status))
        *status = ll_result_store_check_version(record);
}

ll_status ll_result_store_check_versions(ll_result_store *store)
{
    ll_status first = ll_ok();
    LL_TRY(ll_result_store_list(store, inspect, &first));
    return first;
}

/* ---- claims ---- */

/* Locked. The index of the claim; -1: there is none. */
static int find_claim(const ll_result_store *s, const char *id, int64_t chunk)
{
    for (int i = 0; i < s->claimed; i++)
        if (s->claims[i].chunk == chunk && strcmp(s->claims[i].id, id) == 0)
            return i;
    return -1;
}

static int claims_of(const ll_result_store *s, const char *id)
{
    int count = 0;
    for (int i = 0; i < s->claimed; i++)
        count += strcmp(s->claims[i].id, id) == 0;
    return count;
}

static void end_claim(ll_result_store *s, const ll_chunk *chunk)
{
    int i = find_claim(s, chunk->id, chunk->chunk);
    LL_ASSERT(i >= 0);
    s->claims[i] = s->claims[--s->claimed];
}

/* Locked. The first chunk of the experiment that is neither stored nor claimed; chunk < 0: none. */
static bool first_free(ll_result_store *s, const char *id, ll_chunk *free_one)
{
    *free_one = (ll_chunk){.chunk = -1};
    sqlite3_stmt *q =
        query(s, "SELECT chunk,first,past FROM chunk WHERE id=?1 AND state<2 ORDER BY chunk", "t", id);
    int result = SQLITE_ERROR;
    while (q && (result = sqlite3_step(q)) == SQLITE_ROW) {
        int64_t chunk = sqlite3_column_int64(q, 0);
        if (find_claim(s, id, chunk) >= 0)
            continue;
        *free_one =
            (ll_chunk){.chunk = chunk, .from = sqlite3_column_int64(q, 1), .to = sqlite3_column_int64(q, 2)};
        snprintf(free_one->id, sizeof free_one->id, "%s", id);
        break;
    }
    sqlite3_finalize(q);
    return result == SQLITE_ROW || result == SQLITE_DONE;
}

/* The order of experiments for the next claim: few claims first, then in turn from the last one on. */
typedef struct rank {
    int claims;
    bool before; /* its number is not behind that of the last claim */
} rank;

static bool goes_first(rank a, rank b)
{
    return a.claims != b.claims ? a.claims < b.claims : b.before && !a.before;
}

/* Locked. False: the database failed. */
static bool find_chunk(ll_result_store *s, const char *id, ll_chunk *found)
{
    sqlite3_stmt *q = query(s,
                            "SELECT e.id,e.number FROM experiment e WHERE e.state=0 AND e.version=?1"
                            " AND (?2='' OR e.id=?2)"
                            " AND EXISTS (SELECT 1 FROM chunk o WHERE o.id=e.id AND o.state<2)"
                            " ORDER BY e.number",
                            "tt", ll_version, id ? id : "");
    rank best = {0};
    int result = SQLITE_ERROR;
    int64_t turn = s->turn;
    bool good = q != NULL;
    while (good && (result = sqlite3_step(q)) == SQLITE_ROW) {
        ll_chunk chunk;
        const char *candidate = (const char *)sqlite3_column_text(q, 0);
        int64_t number = sqlite3_column_int64(q, 1);
        rank own = {claims_of(s, candidate), number <= s->turn};
        if (found->chunk >= 0 && !goes_first(own, best))
            continue;
        good = first_free(s, candidate, &chunk);
        if (!good || chunk.chunk < 0)
            continue;
        *found = chunk;
        best = own;
        turn = number;
    }
    sqlite3_finalize(q);
    s->turn = turn;
    return good && result == SQLITE_DONE;
}

ll_status ll_result_store_claim(ll_result_store *s, const char *id, ll_chunk *chunk)
{
    enter(s);
    *chunk = (ll_chunk){.chunk = -1};
    if (s->claimed < LL_CLAIMS_MAX && !find_chunk(s, id, chunk))
        return leave(s, failure(s, "Claiming"));
    if (chunk->chunk >= 0)
        s->claims[s->claimed++] = *chunk;
    return leave(s, ll_ok());
}

void ll_result_store_return(ll_result_store *s, const ll_chunk *chunk)
{
    enter(s);
    end_claim(s, chunk);
    leave(s, ll_ok());
}

static bool insert_rows(ll_result_store *s, const char *id, const ll_row *rows, int64_t count, int metrics)
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

ll_status ll_result_store_finish(ll_result_store *s, const ll_chunk *chunk, const ll_row *rows, int metrics)
{
    enter(s);
    end_claim(s, chunk);
    bool good = begin(s) && done(query(s, "UPDATE chunk SET state=2 WHERE id=?1 AND chunk=?2 AND state<2",
                                       "ti", chunk->id, chunk->chunk));
    if (good && sqlite3_changes(s->db) == 0) { /* it was deleted meanwhile */
        sqlite3_exec(s->db, "ROLLBACK", NULL, NULL, NULL);
        return leave(s, unknown(chunk->id));
    }
    good = good && insert_rows(s, chunk->id, rows, chunk->to - chunk->from, metrics);
    return leave(s, end(s, good, "Storing rows"));
}

ll_status ll_result_store_bytes(ll_result_store *s, int64_t *taken)
{
    enter(s);
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

ll_status ll_result_store_read(ll_result_store *s, const char *id, int64_t from, ll_row *rows, int capacity,
                               int *count)
{
    enter(s);
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

ll_status ll_stored_rows_open(ll_stored_rows *r, ll_result_store *store, const char *id)
{
    *r = (ll_stored_rows){.store = store, .id = id, .rows = malloc(ROWS_AT_ONCE * sizeof *r->rows)};
    return r->rows ? ll_ok() : ll_error(LL_NO_MEMORY, "no memory for rows");
}

bool ll_stored_rows_next(void *context, ll_row *row, ll_status *status)
{
    ll_stored_rows *r = context;
    if (r->at == r->count) {
        r->at = r->count = 0;
        *status = ll_result_store_read(r->store, r->id, r->next, r->rows, ROWS_AT_ONCE, &r->count);
        if (ll_failed(status) || r->count == 0)
            return false;
        r->next = r->rows[r->count - 1].run + 1;
    }
    *row = r->rows[r->at++];
    return true;
}

void ll_stored_rows_seek(void *context, int64_t run)
{
    ll_stored_rows *r = context;
    r->at = r->count = 0;
    r->next = run;
}

void ll_stored_rows_close(ll_stored_rows *r)
{
    free(r->rows);
    r->rows = NULL;
}
