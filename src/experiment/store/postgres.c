/* The store in PostgreSQL, which several machines can share. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/store/kinds.h"

#include "postgres/link.h"
#include "postgres/url.h"

/* Metrics are an array of numbers, for use in SQL: metrics[1] is the first of the specification. */
static const char schema[] =
    "CREATE SCHEMA IF NOT EXISTS laglab;"
    "CREATE TABLE schema_version(version integer NOT NULL);"
    "INSERT INTO schema_version VALUES(2);"
    "CREATE TABLE experiment(id text PRIMARY KEY, specification text NOT NULL, state integer NOT NULL,"
    " first bigint NOT NULL, past bigint NOT NULL, created_s bigint NOT NULL,"
    " number bigint GENERATED ALWAYS AS IDENTITY, owner_hash text NOT NULL, version text NOT NULL);"
    "CREATE TABLE chunk(id text NOT NULL, chunk bigint NOT NULL, first bigint NOT NULL, past bigint NOT NULL,"
    " state integer NOT NULL DEFAULT 0, attempt integer NOT NULL DEFAULT 0, owner text,"
    " lease_until timestamptz, PRIMARY KEY(id, chunk)) WITH (fillfactor=70);"
    "CREATE INDEX chunk_open ON chunk(id, chunk) WHERE state < 2;"
    "CREATE TABLE result(id text NOT NULL, run bigint NOT NULL, status integer NOT NULL, error text,"
    " hash bigint NOT NULL, t_s double precision NOT NULL, metrics double precision[] NOT NULL,"
    " PRIMARY KEY(id, run));";

static const char schema_from_1[] = "ALTER TABLE experiment ADD COLUMN version text NOT NULL DEFAULT '';"
                                    "UPDATE schema_version SET version=2;";

static const char key_table[] =
    "CREATE TABLE IF NOT EXISTS class_key(id text PRIMARY KEY, name text NOT NULL);"
    "CREATE INDEX IF NOT EXISTS class_key_name ON class_key(name)";

#define NOW_S "extract(epoch FROM now())::bigint"

/* Of each connection. Without the timeout a worker that freezes between the end of its lease and the commit
 * would keep its chunk locked. */
static const char session[] = "SET search_path TO laglab; SET idle_in_transaction_session_timeout TO '60s';"
                              "SET client_min_messages TO warning; SET client_encoding TO 'UTF8'";

/* A worker that waits for its connection only finishes later. */
static const ll_pg_patience patience = {.connect_timeout = "10",
                                        .keepalives_idle = "20",
                                        .keepalives_interval = "10",
                                        .keepalives_count = "3",
                                        .tcp_user_timeout = "60000"};

typedef struct postgres_store {
    ll_result_store base;
    ll_pg_link link;
    char name[160]; /* the URL without its password and its query */
} postgres_store;

static ll_status failure(const postgres_store *s, const char *doing)
{
    char reason[LL_PG_REASON_MAX];
    switch (ll_pg_fault_of(&s->link, reason)) {
    case LL_PG_LOST:
        return ll_error(LL_UNAVAILABLE, "server of the store %.100s not usable: %s", s->name, reason);
    case LL_PG_DISK_FULL:
        return ll_error(LL_IO, "disk of the store %.120s is full", s->name);
    case LL_PG_READ_ONLY:
        return ll_error(LL_IO, "cannot write to the store %.120s: %.80s", s->name, reason);
    default:
        return ll_error(LL_IO, "%s in the store %.100s failed: %.100s", doing, s->name, reason);
    }
}

/* Commits, or rolls back after a failure. */
static ll_status end(postgres_store *s, bool good, const char *doing)
{
    if (good && ll_pg_run(&s->link, "COMMIT"))
        return ll_ok();
    ll_status status = failure(s, doing);
    ll_pg_run(&s->link, "ROLLBACK");
    return status;
}

/* ---- the connection ---- */

static ll_status prepare_schema(postgres_store *s)
{
    bool good = ll_pg_run(&s->link, "BEGIN") &&
                ll_pg_query(&s->link, "SELECT pg_advisory_xact_lock(7817201)", "") &&
                ll_pg_query(&s->link, "SELECT to_regclass('laglab.schema_version') IS NOT NULL", "");
    if (good && !ll_pg_true(&s->link, 0, 0))
        return end(s, ll_pg_run(&s->link, schema) && ll_pg_run(&s->link, key_table), "Creating the tables");
    good = good && ll_pg_query(&s->link, "SELECT version FROM schema_version", "");
    int64_t version = good && ll_pg_rows(&s->link) > 0 ? ll_pg_whole(&s->link, 0, 0) : 0;
    if (version == 1)
        good = ll_pg_run(&s->link, schema_from_1);
    good = good && ll_pg_query(&s->link, "SELECT to_regclass('laglab.class_key') IS NOT NULL", "") &&
           (ll_pg_true(&s->link, 0, 0) || ll_pg_run(&s->link, key_table));
    ll_status status = end(s, good, "Opening");
    return !ll_failed(&status) && version > LL_STORE_SCHEMA ? ll_store_newer(s->name, version) : status;
}

static void close_store(ll_result_store *store)
{
    postgres_store *s = (postgres_store *)store;
    ll_pg_close(&s->link);
    free(s);
}

static ll_status open_store(const char *url, ll_result_store **store)
{
    if (!strstr(url, "://"))
        return ll_field_error(LL_BAD_INPUT, "store",
                              "store in PostgreSQL: must be postgresql://USER@HOST/DATABASE");
    postgres_store *s = calloc(1, sizeof *s);
    if (!s)
        return ll_error(LL_NO_MEMORY, "out of memory: store");
    s->base.kind = &ll_result_store_postgres;
    ll_pg_init(&s->link, session);
    ll_pg_name_url(url, s->name, sizeof s->name);
    ll_status status = ll_pg_check_url(url, s->name);
    LL_THEN(status, ll_pg_connect(&s->link, url, &patience) ? ll_ok() : failure(s, "Opening"));
    LL_THEN(status, prepare_schema(s));
    if (ll_failed(&status)) {
        close_store(&s->base);
        return status;
    }
    *store = &s->base;
    return ll_ok();
}

/* A connection that fails during an operation is LL_UNAVAILABLE: the operation may or may not have been done,
 * and can be repeated. */
static postgres_store *enter(ll_result_store *store)
{
    postgres_store *s = (postgres_store *)store;
    ll_pg_lock(&s->link);
    return s;
}

static ll_status leave(postgres_store *s, ll_status status)
{
    return ll_pg_unlock(&s->link, status);
}

/* ---- experiments ---- */

static ll_status specification(ll_result_store *store, const char *id, char **text)
{
    postgres_store *s = enter(store);
    bool good = ll_pg_query(&s->link, "SELECT specification FROM experiment WHERE id=$1", "t", id);
    *text = good && ll_pg_rows(&s->link) > 0 ? strdup(ll_pg_text(&s->link, 0, 0)) : NULL;
    return leave(s, !good ? failure(s, "Reading") : *text ? ll_ok() : ll_store_unknown(id));
}

/* Who makes another one with this class key waits for the end of the transaction, and counts then. */
static bool insert_key(postgres_store *s, const ll_experiment_record *r, bool *full)
{
    if (!r->class_key[0])
        return true;
    if (!ll_pg_query(&s->link, "SELECT pg_advisory_xact_lock(7817206, hashtext($1))", "t", r->class_key) ||
        !ll_pg_query(&s->link, LL_STORE_COUNT_KEY "$1", "t", r->class_key))
        return false;
    *full = r->most_of_key >= 0 && ll_pg_whole(&s->link, 0, 0) >= r->most_of_key;
    return *full || ll_pg_query(&s->link, "INSERT INTO class_key VALUES($1,$2) ON CONFLICT DO NOTHING", "tt",
                                r->id, r->class_key);
}

/* An existing row with the id stays unchanged. */
static bool insert_experiment(postgres_store *s, const ll_experiment_record *r, const char *text,
                              int64_t chunk)
{
    bool good =
        ll_pg_query(&s->link,
                    "INSERT INTO experiment(id,specification,state,first,past,created_s,owner_hash,version)"
                    " VALUES($1,$2,0,$3,$4," NOW_S ",$5,$6) ON CONFLICT DO NOTHING",
                    "ttiitt", r->id, text, r->from, r->to, r->owner_hash, s->base.version);
    if (!good || ll_pg_changed(&s->link) == 0)
        return good;
    return ll_pg_query(&s->link,
                       "INSERT INTO chunk(id,chunk,first,past) SELECT $1, k, $2::bigint+k*$4::bigint,"
                       " least($2::bigint+(k+1)*$4::bigint, $3::bigint)"
                       " FROM generate_series(0, ($3::bigint-$2::bigint+$4::bigint-1)/$4::bigint-1) k",
                       "tiii", r->id, r->from, r->to, chunk);
}

static ll_status create(ll_result_store *store, const ll_experiment_record *r, const char *text,
                        int64_t chunk)
{
    postgres_store *s = enter(store);
    bool full = false, good = ll_pg_run(&s->link, "BEGIN") && insert_key(s, r, &full) &&
                              (full || insert_experiment(s, r, text, chunk));
    ll_status status = end(s, good, "Registering an experiment");
    if (!ll_failed(&status) && full)
        status = ll_store_key_full(r);
    if (!ll_failed(&status) &&
        !ll_pg_query(&s->link, "SELECT specification=$2 AND version=$3 FROM experiment WHERE id=$1", "ttt",
                     r->id, text, store->version))
        status = failure(s, "Reading");
    if (!ll_failed(&status) && ll_pg_rows(&s->link) > 0 && !ll_pg_true(&s->link, 0, 0))
        status = ll_store_taken(s->name, r->id);
    return leave(s, status);
}

static ll_experiment_record read_record(const postgres_store *s, int row)
{
    ll_experiment_record r = {.state = (ll_experiment_state)ll_pg_whole(&s->link, row, 1),
                              .from = ll_pg_whole(&s->link, row, 2),
                              .to = ll_pg_whole(&s->link, row, 3),
                              .created_s = ll_pg_whole(&s->link, row, 4),
                              .done = ll_pg_whole(&s->link, row, 5),
                              .leased = ll_pg_whole(&s->link, row, 6),
                              .age_s = ll_pg_whole(&s->link, row, 10)};
    snprintf(r.id, sizeof r.id, "%s", ll_pg_text(&s->link, row, 0));
    snprintf(r.owner_hash, sizeof r.owner_hash, "%s", ll_pg_text(&s->link, row, 8));
    snprintf(r.version, sizeof r.version, "%s", ll_pg_text(&s->link, row, 9));
    snprintf(r.class_key, sizeof r.class_key, "%s", ll_pg_text(&s->link, row, 11));
    ll_store_set_state(&r, ll_pg_true(&s->link, row, 7));
    return r;
}

static ll_status get_record(ll_result_store *store, const char *id, ll_experiment_record *record)
{
    postgres_store *s = enter(store);
    bool good = ll_pg_query(&s->link, LL_STORE_RECORD(NOW_S) "WHERE e.id=$1", "t", id),
         there = good && ll_pg_rows(&s->link) > 0;
    if (there)
        *record = read_record(s, 0);
    return leave(s, !good ? failure(s, "Reading") : there ? ll_ok() : ll_store_unknown(id));
}

static ll_status list(ll_result_store *store, void (*each)(void *context, const ll_experiment_record *record),
                      void *context)
{
    postgres_store *s = enter(store);
    bool good = ll_pg_query(&s->link, LL_STORE_RECORD(NOW_S) "ORDER BY e.number", "");
    for (int i = 0; good && i < ll_pg_rows(&s->link); i++) {
        ll_experiment_record record = read_record(s, i);
        each(context, &record);
    }
    return leave(s, good ? ll_ok() : failure(s, "Reading"));
}

static ll_status set_state(ll_result_store *store, const char *id, ll_experiment_state state)
{
    postgres_store *s = enter(store);
    bool good = ll_pg_query(&s->link, "UPDATE experiment SET state=$2 WHERE id=$1", "ti", id, (int64_t)state);
    return leave(s, !good                         ? failure(s, "Writing")
                    : ll_pg_changed(&s->link) > 0 ? ll_ok()
                                                  : ll_store_unknown(id));
}

static ll_status remove_experiment(ll_result_store *store, const char *id)
{
    postgres_store *s = enter(store);
    bool good =
        ll_pg_run(&s->link, "BEGIN") && ll_pg_query(&s->link, "DELETE FROM experiment WHERE id=$1", "t", id);
    bool there = good && ll_pg_changed(&s->link) > 0;
    good = good && ll_pg_query(&s->link, "DELETE FROM chunk WHERE id=$1", "t", id) &&
           ll_pg_query(&s->link, "DELETE FROM result WHERE id=$1", "t", id) &&
           ll_pg_query(&s->link, "DELETE FROM class_key WHERE id=$1", "t", id);
    ll_status status = end(s, good, "Deleting");
    return leave(s, ll_failed(&status) || there ? status : ll_store_unknown(id));
}

/* ---- leases ---- */

static ll_status claim(ll_result_store *store, const char *id, const char *owner, double lease_s,
                       ll_lease *lease)
{
    /* Skips rows that others are claiming, without waiting. A chunk that was lost by too many workers is
     * marked as failed, since it probably kills them. */
    static const char free_chunk[] =
        "WITH given_up AS (UPDATE chunk SET state=3 WHERE (id,chunk) IN (SELECT id,chunk FROM chunk"
        " WHERE state=1 AND attempt>=$4 AND lease_until<now() FOR UPDATE SKIP LOCKED)),"
        " turn AS MATERIALIZED (SELECT e.id, e.number,"
        " (SELECT count(*) FROM chunk b WHERE b.id=e.id AND b.state=1 AND b.lease_until>=now()) AS busy,"
        " (SELECT max(l.lease_until) FROM chunk l WHERE l.id=e.id) AS last"
        " FROM experiment e WHERE e.state=0 AND ($3='' OR e.id=$3) AND e.version=$5"
        " AND EXISTS (SELECT FROM chunk o WHERE o.id=e.id AND o.state<2)),"
        " free AS (SELECT c.id,c.chunk FROM turn t JOIN chunk c ON c.id=t.id"
        " WHERE c.state=0 OR (c.state=1 AND c.attempt<$4 AND c.lease_until<now())"
        " ORDER BY t.busy, t.last NULLS FIRST, t.number, c.chunk LIMIT 1 FOR UPDATE OF c SKIP LOCKED)"
        " UPDATE chunk c SET state=1, attempt=c.attempt+1, owner=$1,"
        " lease_until=now()+$2*interval '1 second' FROM free WHERE c.id=free.id AND c.chunk=free.chunk"
        " RETURNING c.id,c.chunk,c.first,c.past,c.attempt";
    postgres_store *s = enter(store);
    *lease = (ll_lease){.chunk = -1};
    bool good = ll_pg_query(&s->link, free_chunk, "trtit", owner, lease_s, id ? id : "",
                            (int64_t)LL_ATTEMPTS_MAX, store->version);
    if (good && ll_pg_rows(&s->link) > 0) {
        lease->chunk = ll_pg_whole(&s->link, 0, 1);
        lease->from = ll_pg_whole(&s->link, 0, 2);
        lease->to = ll_pg_whole(&s->link, 0, 3);
        lease->attempt = (int)ll_pg_whole(&s->link, 0, 4);
        snprintf(lease->id, sizeof lease->id, "%s", ll_pg_text(&s->link, 0, 0));
        snprintf(lease->owner, sizeof lease->owner, "%s", owner);
    }
    return leave(s, good ? ll_ok() : failure(s, "Claiming"));
}

#define MINE "id=$1 AND chunk=$2 AND owner=$3 AND attempt=$4 AND state=1"

static ll_status renew(ll_result_store *store, const ll_lease *l, double lease_s)
{
    postgres_store *s = enter(store);
    bool good = ll_pg_query(&s->link, "UPDATE chunk SET lease_until=now()+$5*interval '1 second' WHERE " MINE,
                            "titir", l->id, l->chunk, l->owner, (int64_t)l->attempt, lease_s);
    return leave(s, !good                         ? failure(s, "Renewing a lease")
                    : ll_pg_changed(&s->link) > 0 ? ll_ok()
                                                  : ll_store_lost(l));
}

static ll_status return_chunk(ll_result_store *store, const ll_lease *l)
{
    postgres_store *s = enter(store);
    bool good = ll_pg_query(&s->link, "UPDATE chunk SET state=0, attempt=attempt-1 WHERE " MINE, "titi",
                            l->id, l->chunk, l->owner, (int64_t)l->attempt);
    return leave(s, !good                         ? failure(s, "Returning a chunk")
                    : ll_pg_changed(&s->link) > 0 ? ll_ok()
                                                  : ll_store_lost(l));
}

static ll_status release(ll_result_store *store)
{
    postgres_store *s = enter(store);
    bool good = ll_pg_query(&s->link, "UPDATE chunk SET state=0, attempt=attempt-1 WHERE state=1", "");
    return leave(s, good ? ll_ok() : failure(s, "Releasing leases"));
}

/* ---- rows in PostgreSQL's binary format: big-endian numbers of n bytes, each with its length before ---- */

enum { FLOAT8_OID = 701, ARRAY_HEAD = 20, FIELDS = 7 };

typedef struct packet {
    char data[1024]; /* a row: 45 bytes of lengths, id, error, 12 for each metric, and 52 */
    int size;
} packet;

static void put(packet *p, int width, uint64_t value)
{
    for (int i = width - 1; i >= 0; i--)
        p->data[p->size++] = (char)(value >> 8 * i);
}

static void put_field(packet *p, int width, uint64_t value)
{
    put(p, 4, (uint64_t)width);
    put(p, width, value);
}

static void put_text(packet *p, const char *text)
{
    size_t length = strlen(text);
    put(p, 4, length);
    memcpy(p->data + p->size, text, length);
    p->size += (int)length;
}

static void put_real(packet *p, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_field(p, 8, bits);
}

static void put_row(packet *p, const char *id, const ll_row *r, int metrics)
{
    p->size = 0;
    put(p, 2, FIELDS);
    put_text(p, id);
    put_field(p, 8, (uint64_t)r->run);
    put_field(p, 4, r->status);
    if (r->error[0])
        put_text(p, r->error);
    else
        put(p, 4, UINT32_MAX); /* NULL */
    put_field(p, 8, r->hash);
    put_real(p, r->t_s);
    put(p, 4, (uint64_t)(ARRAY_HEAD + 12 * metrics));
    put(p, 4, 1); /* dimension */
    put(p, 4, 0); /* without NULL */
    put(p, 4, FLOAT8_OID);
    put(p, 4, (uint64_t)metrics);
    put(p, 4, 1); /* lower bound */
    for (int i = 0; i < metrics; i++)
        put_real(p, r->metrics[i]);
}

static bool copy_rows(postgres_store *s, const char *id, const ll_row *rows, int64_t count, int metrics)
{
    static const char head[] = "PGCOPY\n\377\r\n\0\0\0\0\0\0\0\0", tail[] = "\377\377";
    packet p;
    bool good =
        ll_pg_run(&s->link, "COPY result(id,run,status,error,hash,t_s,metrics) FROM STDIN (FORMAT binary)") &&
        PQputCopyData(s->link.db, head, sizeof head) == 1;
    for (int64_t i = 0; good && i < count; i++) {
        put_row(&p, id, &rows[i], metrics);
        good = PQputCopyData(s->link.db, p.data, p.size) == 1;
    }
    good = good && PQputCopyData(s->link.db, tail, 2) == 1 && PQputCopyEnd(s->link.db, NULL) == 1;
    good = good && ll_pg_keep(&s->link, PQgetResult(s->link.db));
    for (PGresult *rest; (rest = PQgetResult(s->link.db));)
        PQclear(rest);
    return good;
}

static ll_status finish(ll_result_store *store, const ll_lease *l, const ll_row *rows, int64_t count,
                        int metrics)
{
    postgres_store *s = enter(store);
    bool good =
        ll_pg_run(&s->link, "BEGIN") && ll_pg_query(&s->link, "UPDATE chunk SET state=2 WHERE " MINE, "titi",
                                                    l->id, l->chunk, l->owner, (int64_t)l->attempt);
    if (good && ll_pg_changed(&s->link) == 0) {
        ll_pg_run(&s->link, "ROLLBACK");
        return leave(s, ll_store_lost(l));
    }
    return leave(s, end(s, good && copy_rows(s, l->id, rows, count, metrics), "Storing rows"));
}

static uint64_t get(const char *at, int width)
{
    uint64_t value = 0;
    for (int i = 0; i < width; i++)
        value = value << 8 | (unsigned char)at[i];
    return value;
}

static double get_real(const char *at)
{
    double value;
    uint64_t bits = get(at, 8);
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void read_row(const postgres_store *s, int row, ll_row *r)
{
    const char *metrics = ll_pg_text(&s->link, row, 5);
    int elements = (PQgetlength(s->link.result, row, 5) - ARRAY_HEAD) / 12;
    ll_row_clear(r);
    r->run = (int64_t)get(ll_pg_text(&s->link, row, 0), 8);
    r->status = (ll_row_status)get(ll_pg_text(&s->link, row, 1), 4);
    snprintf(r->error, sizeof r->error, "%s", ll_pg_text(&s->link, row, 2));
    r->hash = get(ll_pg_text(&s->link, row, 3), 8);
    r->t_s = get_real(ll_pg_text(&s->link, row, 4));
    for (int i = 0; i < elements && i < LL_EXPERIMENT_METRICS_MAX; i++)
        r->metrics[i] = get_real(metrics + ARRAY_HEAD + 12 * i + 4);
}

static ll_status read_rows(ll_result_store *store, const char *id, int64_t from, ll_row *rows, int capacity,
                           int *count)
{
    postgres_store *s = enter(store);
    bool good =
        ll_pg_query_binary(&s->link,
                           "SELECT run,status,error,hash,t_s,metrics FROM result WHERE id=$1 AND run>=$2"
                           " ORDER BY run LIMIT $3",
                           "tii", id, from, (int64_t)capacity);
    *count = good ? ll_pg_rows(&s->link) : 0;
    for (int i = 0; i < *count; i++)
        read_row(s, i, &rows[i]);
    return leave(s, good ? ll_ok() : failure(s, "Reading"));
}

const ll_result_store_kind ll_result_store_postgres = {.open = open_store,
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
                                                       .read = read_rows};
