/* Store of experiments: their rows, and the distribution of work. One interface; one kind per database.
 *
 * The runs of an experiment are divided into chunks. A worker claims a chunk for a time (a lease), runs it
 * and stores its rows. Rows and the end of the lease are one transaction, which checks the lease's owner and
 * attempt. So each row is stored exactly once, even when workers or servers die; a worker that was frozen
 * beyond its lease gets an error. The only clock is the database's.
 *
 * An experiment belongs to the version of laglab that created it, since another version's rows may differ:
 * other versions do not claim its chunks.
 *
 * Several threads may use a store. */
#pragma once

#include "base/version.h"
#include "experiment/spec/experiment.h"

enum {
    LL_EXPERIMENT_ID_MAX = 63,
    LL_OWNER_MAX = 40,
    LL_ATTEMPTS_MAX = 5,
    LL_OWNER_HASH_MAX = 127,
    LL_KEY_NAME = 32
};

typedef struct ll_result_store ll_result_store;

typedef enum ll_experiment_state {
    LL_EXPERIMENT_RUNNING, /* chunks may be claimed */
    LL_EXPERIMENT_PAUSED,
    LL_EXPERIMENT_CANCELLED,
    LL_EXPERIMENT_DONE,   /* all rows are stored */
    LL_EXPERIMENT_FAILED, /* LL_ATTEMPTS_MAX workers lost a chunk */
} ll_experiment_state;

extern const char *const ll_experiment_state_names[];

typedef struct ll_experiment_record {
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_experiment_state state;
    int64_t from, to;                       /* its runs in this store: all, or those of a shard */
    int64_t done, leased;                   /* runs whose rows are stored; runs of leased chunks */
    int64_t created_s, age_s;               /* Unix time of the database; age by its clock */
    char owner_hash[LL_OWNER_HASH_MAX + 1]; /* hash of the owner's key; empty: none */
    char version[LL_VERSION_MAX + 1];       /* of laglab; empty: unknown */
    char class_key[LL_KEY_NAME + 1];        /* name of the daemon's class key that made it; empty: none */
    int64_t most_of_key;                    /* of create: how many may have that name; -1: no limit */
} ll_experiment_record;

typedef struct ll_lease {
    char id[LL_EXPERIMENT_ID_MAX + 1];
    char owner[LL_OWNER_MAX + 1];
    int64_t chunk, from, to; /* runs; chunk < 0: nothing to claim */
    int attempt;
} ll_lease;

typedef struct ll_result_store_kind {
    ll_status (*open)(const char *url, ll_result_store **store);
    void (*close)(ll_result_store *store);

    /* Registers an experiment of the store's version, with its runs in chunks of `chunk`. Registering the
     * same id, specification and version again changes nothing: a resume. LL_CONFLICT: the id has another
     * specification or version. LL_LIMIT: its class key has as many as it may. */
    ll_status (*create)(ll_result_store *store, const ll_experiment_record *record, const char *specification,
                        int64_t chunk);
    ll_status (*specification)(ll_result_store *store, const char *id, char **text); /* caller frees */
    ll_status (*record)(ll_result_store *store, const char *id, ll_experiment_record *record);
    /* In order of creation. */
    ll_status (*list)(ll_result_store *store, void (*each)(void *context, const ll_experiment_record *record),
                      void *context);
    ll_status (*set_state)(ll_result_store *store, const char *id, ll_experiment_state state);
    ll_status (*remove)(ll_result_store *store, const char *id);

    /* Claims a free chunk of the store's version, or one whose lease has expired. `id` NULL: of any running
     * experiment; the one with the fewest leased chunks is first, of several with as many the one whose last
     * lease is the oldest, so that experiments of one store share its workers equally. */
    ll_status (*claim)(ll_result_store *store, const char *id, const char *owner, double lease_s,
                       ll_lease *lease);
    ll_status (*renew)(ll_result_store *store, const ll_lease *lease,
                       double lease_s); /* LL_CONFLICT: the lease was lost */
    /* `metrics`: number per row. LL_CONFLICT: the lease was lost, and nothing was stored. */
    ll_status (*finish)(ll_result_store *store, const ll_lease *lease, const ll_row *rows, int64_t count,
                        int metrics);
    /* Makes a chunk free again, without counting the attempt. LL_CONFLICT: the lease was lost. */
    ll_status (*return_chunk)(ll_result_store *store, const ll_lease *lease);
    /* Ends every lease: only when no other worker can be running. */
    ll_status (*release)(ll_result_store *store);

    /* Size of its tables, bytes; NULL if the database has limits of its own. */
    ll_status (*bytes)(ll_result_store *store, int64_t *bytes);

    /* Rows of runs >= `from`, at most `capacity`, in order. */
    ll_status (*read)(ll_result_store *store, const char *id, int64_t from, ll_row *rows, int capacity,
                      int *count);
} ll_result_store_kind;

struct ll_result_store {
    const ll_result_store_kind *kind; /* first member of each kind's own struct */
    const char *version;              /* of the caller: ll_version */
};

extern const ll_result_store_kind ll_result_store_sqlite;
extern const ll_result_store_kind ll_result_store_postgres; /* only if built with libpq */

/* `sqlite:FILE`, or a name without scheme, which is an SQLite file; `postgresql://USER@HOST/DATABASE`.
 * Messages never contain a password. LL_UNAVAILABLE from any call: the server does not answer; the operation
 * may or may not have been done, and can be repeated. */
ll_status ll_result_store_open(const char *url, ll_result_store **store);

/* `url`, or if NULL or empty the environment's LAGLAB_STORE, which the list of processes does not show; NULL
 * if that is missing too. */
const char *ll_result_store_url(const char *url);
void ll_result_store_close(ll_result_store *store);

/* LL_CONFLICT: an unfinished experiment is of another version than the store's; the message names both. */
ll_status ll_result_store_check_version(const ll_result_store *store, const ll_experiment_record *record);
/* The same for all experiments in the store; the error is that of the first. */
ll_status ll_result_store_check_versions(ll_result_store *store);

/* Rows of a store, as the source of a table. */
typedef struct ll_stored_rows {
    ll_result_store *store;
    const char *id;
    ll_row *rows;
    int count, at;
    int64_t next;
} ll_stored_rows;

ll_status ll_stored_rows_open(ll_stored_rows *rows, ll_result_store *store, const char *id);
bool ll_stored_rows_next(void *rows, ll_row *row, ll_status *status); /* an ll_row_source function */
void ll_stored_rows_seek(void *rows, int64_t run); /* the next row is that of `run`, or the first after it */
void ll_stored_rows_close(ll_stored_rows *rows);
