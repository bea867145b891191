/* The store in PostgreSQL: its tables, opening and closing. */
#include "daemon/store/postgres.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "postgres/url.h"

enum { SCHEMA = 1, RETRY_MS = 100 };

/* Numbers are taken in blocks, so that creating a session does not ask the database for one. */
static const char schema[] =
    "CREATE SCHEMA IF NOT EXISTS laglab_sessions;"
    "CREATE TABLE schema_version(version integer NOT NULL);"
    "INSERT INTO schema_version VALUES(1);"
    "CREATE TABLE daemon(inc bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY, token uuid NOT NULL,"
    " url text NOT NULL, engine text NOT NULL,"
    " state text NOT NULL CHECK (state IN ('up','draining','dead')), lease_until timestamptz NOT NULL)"
    " WITH (fillfactor=50);"
    "CREATE SEQUENCE session_number INCREMENT BY 1000;"
    "CREATE TABLE session(no bigint PRIMARY KEY, id text UNIQUE NOT NULL, code text NOT NULL,"
    " engine text NOT NULL, created_ms bigint NOT NULL, keys bytea NOT NULL, owner bigint,"
    " playing boolean NOT NULL, speed double precision NOT NULL, tick bigint NOT NULL,"
    " head_tick bigint NOT NULL, hash_tick bigint NOT NULL, hash_lines bigint NOT NULL,"
    " hash bigint NOT NULL, seen timestamptz NOT NULL) WITH (fillfactor=70);"
    "CREATE INDEX session_owner ON session(owner);"
    "CREATE TABLE line(session bigint NOT NULL, i integer NOT NULL, body text NOT NULL,"
    " PRIMARY KEY(session, i));"
    "CREATE TABLE code(code text PRIMARY KEY, session bigint NOT NULL,"
    " made timestamptz NOT NULL DEFAULT now()) WITH (fillfactor=70);"
    "CREATE INDEX code_session ON code(session);";

/* Who opens a store makes its tables alone, until the end of the transaction. */
#define ALONE "SELECT pg_advisory_xact_lock(7817202);"
#define HAS_TABLE(name) "SELECT to_regclass('" name "') IS NOT NULL"
#define HAS_COLUMN(table, name)                                                                              \
    "SELECT EXISTS (SELECT 1 FROM pg_attribute WHERE attrelid=to_regclass('" table "') AND attname='" name   \
    "' AND NOT attisdropped)"

/* What stores of an earlier laglab lack, and that one does not read. To alter a table locks out all who read
 * or write it, also where nothing is missing: a daemon asks first. Each is a transaction that locks one
 * table, since the commits of daemons that run lock several, not always in the same order. */
static const struct {
    const char *is_there, *make;
} later[] = {
    {HAS_TABLE("answer"), ALONE
     "CREATE TABLE IF NOT EXISTS answer(name text PRIMARY KEY, body text NOT NULL, owner bigint NOT NULL,"
     " answer text, made timestamptz NOT NULL DEFAULT now())"},
    {HAS_TABLE("class"),
     ALONE "CREATE TABLE IF NOT EXISTS class(id text PRIMARY KEY, stem text UNIQUE NOT NULL,"
           " code text UNIQUE NOT NULL, client text NOT NULL, engine text NOT NULL, owner bigint,"
           " body text NOT NULL, seen timestamptz NOT NULL) WITH (fillfactor=70)"},
    {HAS_COLUMN("class", "class_key"), ALONE "ALTER TABLE class ADD COLUMN IF NOT EXISTS class_key text"},
    {HAS_COLUMN("code", "stem"), ALONE "ALTER TABLE code ADD COLUMN IF NOT EXISTS stem text"},
    {HAS_COLUMN("code", "class_key"), ALONE "ALTER TABLE code ADD COLUMN IF NOT EXISTS class_key text"},
    {HAS_COLUMN("code", "log_bytes"),
     ALONE "ALTER TABLE code ADD COLUMN IF NOT EXISTS log_bytes bigint NOT NULL DEFAULT 0"},
    {HAS_TABLE("code_stem"),
     ALONE "CREATE INDEX IF NOT EXISTS code_stem ON code(stem) WHERE stem IS NOT NULL"},
    {HAS_TABLE("code_class_key"),
     ALONE "CREATE INDEX IF NOT EXISTS code_class_key ON code(class_key) WHERE class_key IS NOT NULL"},
    {HAS_TABLE("state"),
     ALONE "CREATE TABLE IF NOT EXISTS state(session bigint PRIMARY KEY, body bytea NOT NULL)"},
    {"SELECT attstorage='e' FROM pg_attribute WHERE attrelid=to_regclass('state') AND attname='body'",
     ALONE "ALTER TABLE state ALTER COLUMN body SET STORAGE EXTERNAL"}, /* it is compressed */
};

/* ---- opening ---- */

/* The version is 0 where it is missing. */
static bool make_schema(pg_link *link, int64_t *version)
{
    *version = SCHEMA;
    bool good = ll_pg_run(link, "BEGIN") && ll_pg_run(link, ALONE) &&
                ll_pg_run(link, "SELECT to_regclass('laglab_sessions.schema_version') IS NOT NULL");
    if (good && !ll_pg_true(link, 0, 0))
        good = ll_pg_run(link, schema);
    else if (good && (good = ll_pg_run(link, "SELECT version FROM schema_version")))
        *version = PQntuples(link->result) > 0 ? ll_pg_whole(link, 0, 0) : 0;
    return good && ll_pg_run(link, "COMMIT");
}

static bool complete_schema(pg_link *link)
{
    for (size_t i = 0; i < sizeof later / sizeof later[0]; i++) {
        if (!ll_pg_run(link, later[i].is_there) ||
            (!ll_pg_true(link, 0, 0) && !ll_pg_run(link, later[i].make)))
            return false;
    }
    return true;
}

static ll_status prepare_schema(postgres_store *s)
{
    pg_link *link = &s->reader;
    int64_t version;
    bool good = make_schema(link, &version);
    if (good && version > SCHEMA)
        return ll_error(LL_BAD_INPUT,
                        "sessions in the store %.120s have schema %" PRId64
                        ", of a newer laglab; this one supports up to %d",
                        s->name, version, SCHEMA);
    if (good && complete_schema(link))
        return ll_ok();
    ll_status status = ll_pg_failure(s, link, "Creating the tables");
    if (PQtransactionStatus(link->db) != PQTRANS_IDLE)
        ll_pg_run(link, "ROLLBACK");
    return status;
}

static void close_store(ll_store *store)
{
    postgres_store *s = (postgres_store *)store;
    ll_pg_end_lease(s);
    ll_pg_close(&s->writer);
    ll_pg_close(&s->reader);
    ll_pg_close(&s->lease);
    if (s->wake >= 0)
        close(s->wake);
    ll_store_end(store);
    free(s->url);
    free(s);
}

/* Sessions are claimed one by one. */
static ll_status list(ll_store *store, void (*each)(void *context, const ll_stored *stored), void *context)
{
    (void)store, (void)each, (void)context;
    return ll_ok();
}

static ll_status list_classes(ll_store *store,
                              void (*each)(void *context, const char *id, int64_t seen_ms, const char *text),
                              void *context)
{
    (void)store, (void)each, (void)context;
    return ll_ok();
}

static const ll_shared_kind shared_kind = {.fenced = ll_pg_fenced,
                                           .lease_left_s = ll_pg_lease_left_s,
                                           .claim = ll_pg_claim,
                                           .release_id = ll_pg_release_id,
                                           .mark_dead = ll_pg_mark_dead,
                                           .ask = ll_pg_ask,
                                           .on_asked = ll_pg_on_asked,
                                           .reserve_code = ll_pg_reserve_code,
                                           .count_keys = ll_pg_count_keys,
                                           .find_code = ll_pg_find_code,
                                           .read_state = ll_pg_read_state,
                                           .open_class = ll_pg_open_class,
                                           .claim_class = ll_pg_claim_class,
                                           .find_class = ll_pg_find_class,
                                           .claim_answer = ll_pg_claim_answer,
                                           .expire = ll_pg_expire,
                                           .replace = ll_pg_replace,
                                           .drain = ll_pg_drain};

static const ll_store_kind postgres_kind = {.shared = &shared_kind,
                                            .retry_ms = RETRY_MS,
                                            .close = close_store,
                                            .commit = ll_pg_commit,
                                            .list = list,
                                            .read_log = ll_pg_read_log,
                                            .list_classes = list_classes,
                                            .new_numbers = ll_pg_new_numbers};

/* Of each connection. A daemon that freezes between two statements of a commit must not keep its row locked,
 * since others wait for that row to mark it as dead. */
static const char session[] =
    "SET search_path TO laglab_sessions; SET client_min_messages TO warning; SET client_encoding TO 'UTF8';"
    "SET idle_in_transaction_session_timeout TO '2s'; SET lock_timeout TO '5s'";

static postgres_store *new_store(const ll_shared_config *config)
{
    postgres_store *s = calloc(1, sizeof *s);
    char *url = strdup(config->url);
    if (!s || !url) {
        free(s);
        free(url);
        return NULL;
    }
    ll_store_init(&s->base, &postgres_kind);
    s->url = url;
    s->lease_s = config->lease_s;
    s->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    snprintf(s->address, sizeof s->address, "%s", config->address);
    snprintf(s->engine, sizeof s->engine, "%s", config->engine ? config->engine : ll_engine);
    ll_pg_name_url(s->url, s->name, sizeof s->name);
    ll_pg_init(&s->writer, session);
    ll_pg_init(&s->reader, session);
    ll_pg_init(&s->lease, session);
    return s;
}

ll_status ll_pg_open_tables(const ll_shared_config *config, postgres_store **store)
{
    *store = NULL;
    postgres_store *s = new_store(config);
    if (!s)
        return ll_error(LL_NO_MEMORY, "out of memory: store");
    ll_status status = ll_pg_check_url(s->url, s->name);
    LL_THEN(status, ll_pg_reach(s, &s->reader));
    LL_THEN(status, prepare_schema(s));
    if (ll_failed(&status))
        close_store(&s->base);
    else
        *store = s;
    return status;
}

ll_status ll_pg_open(const ll_shared_config *config, ll_store **store)
{
    postgres_store *s;
    *store = NULL;
    LL_TRY(ll_pg_open_tables(config, &s));
    ll_status status = ll_pg_reach(s, &s->writer);
    LL_THEN(status, ll_pg_reach(s, &s->lease));
    LL_THEN(status, ll_pg_start_lease(s));
    LL_THEN(status, ll_store_start(&s->base));
    if (ll_failed(&status)) {
        close_store(&s->base);
        return status;
    }
    *store = &s->base;
    return status;
}
