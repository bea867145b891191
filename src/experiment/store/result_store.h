/* Where the rows of experiments are kept, and who works on what. One interface; a kind per database.
 *
 * The runs of an experiment are cut into chunks. A worker claims one for a time (a lease), runs it and hands
 * in its rows; rows and the end of the lease are one transaction, fenced by the lease's owner and attempt. So
 * each row is there exactly once, whatever worker or server dies, and a worker that froze beyond its lease is
 * told that its work is no longer wanted. The only clock is the database's.
 *
 * An experiment is of the version of laglab that made it, since another's rows may differ: no other claims
 * its chunks.
 *
 * A store may be used by several threads. */
#pragma once

#include "base/version.h"
#include "experiment/spec/experiment.h"

enum { LL_EXPERIMENT_ID_MAX = 63, LL_OWNER_MAX = 40, LL_ATTEMPTS_MAX = 5, LL_OWNER_HASH_MAX = 127 };

typedef struct ll_result_store ll_result_store;

typedef enum ll_experiment_state {
    LL_EXPERIMENT_RUNNING, /* chunks may be claimed */
    LL_EXPERIMENT_PAUSED,
    LL_EXPERIMENT_CANCELLED,
    LL_EXPERIMENT_DONE,   /* all rows are there */
    LL_EXPERIMENT_FAILED, /* a chunk was given up by LL_ATTEMPTS_MAX workers */
} ll_experiment_state;

extern const char *const ll_experiment_state_names[];

typedef struct ll_experiment_record {
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_experiment_state state;
    int64_t from, to;         /* its runs here: all, or those of a shard */
    int64_t done, leased;     /* runs whose rows are there; of chunks that somebody works on */
    int64_t created_s, age_s; /* Unix time of the database, and how long ago that is by its clock */
    char owner_hash[LL_OWNER_HASH_MAX + 1]; /* of the key that may change it; empty: there is none */
    char version[LL_VERSION_MAX + 1];       /* of laglab; empty: one that did not tell it */
} ll_experiment_record;

typedef struct ll_lease {
    char id[LL_EXPERIMENT_ID_MAX + 1];
    char owner[LL_OWNER_MAX + 1];
    int64_t chunk, from, to; /* runs; chunk < 0: there was nothing to claim */
    int attempt;
} ll_lease;

typedef struct ll_result_store_kind {
    ll_status (*open)(const char *url, ll_result_store **store);
    void (*close)(ll_result_store *store);

    /* Registers an experiment of the store's version, with its runs in chunks of `chunk`. With the same id,
     * specification and version again it changes nothing: a resume. Others under the id are LL_CONFLICT. */
    ll_status (*create)(ll_result_store *store, const ll_experiment_record *record, const char *specification,
                        int64_t chunk);
    ll_status (*specification)(ll_result_store *store, const char *id, char **text); /* caller frees */
    ll_status (*record)(ll_result_store *store, const char *id, ll_experiment_record *record);
    /* In the order of their making. */
    ll_status (*list)(ll_result_store *store, void (*each)(void *context, const ll_experiment_record *record),
                      void *context);
    ll_status (*set_state)(ll_result_store *store, const char *id, ll_experiment_state state);
    ll_status (*remove)(ll_result_store *store, const char *id);

    /* A free chunk, or one whose lease has run out, of the store's version. `id` NULL: of any experiment that
     * is running. */
    ll_status (*claim)(ll_result_store *store, const char *id, const char *owner, double lease_s,
                       ll_lease *lease);
    ll_status (*renew)(ll_result_store *store, const ll_lease *lease, double lease_s); /* LL_CONFLICT: lost */
    /* `metrics` is how many each row has. LL_CONFLICT: the lease was lost, and nothing was stored. */
    ll_status (*finish)(ll_result_store *store, const ll_lease *lease, const ll_row *rows, int64_t count,
                        int metrics);
    /* Makes a chunk free again, as if it had not been claimed. LL_CONFLICT: it was lost. */
    ll_status (*give_back)(ll_result_store *store, const ll_lease *lease);
    /* Ends every lease: for who knows that nobody else is at work. */
    ll_status (*release)(ll_result_store *store);

    /* Bytes that its tables take; NULL where the database has limits of its own. */
    ll_status (*bytes)(ll_result_store *store, int64_t *bytes);

    /* Rows of runs >= `from`, at most `capacity`, in order. */
    ll_status (*read)(ll_result_store *store, const char *id, int64_t from, ll_row *rows, int capacity,
                      int *count);
} ll_result_store_kind;

struct ll_result_store {
    const ll_result_store_kind *kind; /* first member of each kind's own struct */
    const char *version;              /* of who uses it: ll_version */
};

extern const ll_result_store_kind ll_result_store_sqlite;
extern const ll_result_store_kind ll_result_store_postgres; /* only where libpq is */

/* `sqlite:FILE`, or a name without scheme, which is a file of SQLite's; `postgresql://USER@HOST/DATABASE`.
 * Errors of any call never tell a password. LL_UNAVAILABLE from any call: the server does not answer; what
 * was asked may have been done or not, and can be asked for again. */
ll_status ll_result_store_open(const char *url, ll_result_store **store);

/* `url`, or where that is NULL or empty what LAGLAB_STORE in the environment says, which the list of
 * processes does not show; NULL where neither is. */
const char *ll_result_store_url(const char *url);
void ll_result_store_close(ll_result_store *store);

/* LL_CONFLICT: an experiment that is not over is of another version than the store's; the sentence names
 * both. */
ll_status ll_result_store_admits(const ll_result_store *store, const ll_experiment_record *record);
/* The same of all in the store: tells the first. */
ll_status ll_result_store_admits_all(ll_result_store *store);

/* Rows of a store as the source of a table. */
typedef struct ll_stored_rows {
    ll_result_store *store;
    const char *id;
    ll_row *rows;
    int count, at;
    int64_t next;
} ll_stored_rows;

ll_status ll_stored_rows_open(ll_stored_rows *rows, ll_result_store *store, const char *id);
bool ll_stored_rows_next(void *rows, ll_row *row, ll_status *status); /* an ll_row_source */
void ll_stored_rows_close(ll_stored_rows *rows);
