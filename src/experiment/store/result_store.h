/* Store of experiments: their rows in a database of SQLite, and which of their runs are to be made.
 *
 * The runs of an experiment are divided into chunks. A thread claims a chunk, runs it and stores its rows.
 * The rows of a chunk are one transaction, so that each row is stored exactly once, even when the process
 * dies: what was claimed and not stored is free when the store is opened again.
 *
 * A store is open in one process at a time. An experiment belongs to the version of laglab that created it,
 * since another version's rows may differ: other versions do not claim its chunks.
 *
 * Several threads may use a store. */
#pragma once

#include "base/version.h"
#include "experiment/spec/experiment.h"

enum { LL_EXPERIMENT_ID_MAX = 63, LL_OWNER_HASH_MAX = 127, LL_KEY_NAME = 32, LL_CLAIMS_MAX = 256 };

typedef struct ll_result_store ll_result_store;

typedef enum ll_experiment_state {
    LL_EXPERIMENT_RUNNING, /* chunks may be claimed */
    LL_EXPERIMENT_PAUSED,
    LL_EXPERIMENT_CANCELLED,
    LL_EXPERIMENT_DONE, /* all rows are stored */
} ll_experiment_state;

extern const char *const ll_experiment_state_names[];

typedef struct ll_experiment_record {
    char id[LL_EXPERIMENT_ID_MAX + 1];
    ll_experiment_state state;
    int64_t from, to;                       /* its runs in this store: all, or those of a shard */
    int64_t done;                           /* runs whose rows are stored */
    int64_t created_s, age_s;               /* Unix time; age */
    char owner_hash[LL_OWNER_HASH_MAX + 1]; /* hash of the owner's key; empty: none */
    char version[LL_VERSION_MAX + 1];       /* of laglab; empty: unknown */
    char class_key[LL_KEY_NAME + 1];        /* name of the daemon's class key that made it; empty: none */
    int64_t most_of_key;                    /* of create: how many may have that name; -1: no limit */
} ll_experiment_record;

typedef struct ll_chunk {
    char id[LL_EXPERIMENT_ID_MAX + 1];
    int64_t chunk, from, to; /* runs; chunk < 0: nothing to claim */
} ll_chunk;

/* `path`: a file, or `:memory:`. LL_IO: another process has it open. */
ll_status ll_result_store_open(const char *path, ll_result_store **store);
/* The same; a file that cannot be written, as on a full or read-only disk, is opened for reading. */
ll_status ll_result_store_open_any(const char *path, ll_result_store **store);
void ll_result_store_close(ll_result_store *store); /* NULL: no effect */

/* Whether the last change could not be stored; `why` may be NULL. A change that fails changes nothing. */
bool ll_result_store_failing(ll_result_store *store, ll_status *why);
/* Writes and deletes a row of 64 KiB, and opens for writing what could only be read. */
void ll_result_store_try(ll_result_store *store);

/* Registers an experiment of this version of laglab, with its runs in chunks of `chunk`. Registering the same
 * id, specification and version again changes nothing: a resume. LL_CONFLICT: the id has another
 * specification or version. LL_LIMIT: its class key has as many as it may. */
ll_status ll_result_store_create(ll_result_store *store, const ll_experiment_record *record,
                                 const char *specification, int64_t chunk);
ll_status ll_result_store_specification(ll_result_store *store, const char *id,
                                        char **text); /* caller frees */
ll_status ll_result_store_record(ll_result_store *store, const char *id, ll_experiment_record *record);
/* In order of creation. */
ll_status ll_result_store_list(ll_result_store *store,
                               void (*each)(void *context, const ll_experiment_record *record),
                               void *context);
ll_status ll_result_store_set_state(ll_result_store *store, const char *id, ll_experiment_state state);
ll_status ll_result_store_remove(ll_result_store *store, const char *id);

/* LL_CONFLICT: an unfinished experiment is of another version than this one; the message names both. */
ll_status ll_result_store_check_version(const ll_experiment_record *record);
/* The same for all experiments in the store; the error is that of the first. */
ll_status ll_result_store_check_versions(ll_result_store *store);

/* Claims a free chunk of this version. `id` NULL: of any running experiment; the one with the fewest
 * claimed chunks is first, of several with as many the next in turn, so that experiments of one store share
 * its threads equally. At most LL_CLAIMS_MAX chunks are claimed at a time. */
ll_status ll_result_store_claim(ll_result_store *store, const char *id, ll_chunk *chunk);
/* Stores the rows of a claimed chunk, with `metrics` numbers each, and ends the claim. After an error the
 * chunk is free. LL_NOT_FOUND: the experiment was deleted. */
ll_status ll_result_store_finish(ll_result_store *store, const ll_chunk *chunk, const ll_row *rows,
                                 int metrics);
void ll_result_store_return(ll_result_store *store, const ll_chunk *chunk); /* makes it free again */

ll_status ll_result_store_bytes(ll_result_store *store, int64_t *bytes); /* size of its tables */

/* Rows of runs >= `from`, at most `capacity`, in order. */
ll_status ll_result_store_read(ll_result_store *store, const char *id, int64_t from, ll_row *rows,
                               int capacity, int *count);

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
