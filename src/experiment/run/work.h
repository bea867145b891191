/* Workers: threads that claim chunks from a store, run them and store their rows. */
#pragma once

#include "experiment/store/result_store.h"

/* Registers the runs from..to-1 of an experiment in a store. The id is the same for the same specification,
 * runs and version: registering again resumes it. */
ll_status ll_experiment_register(ll_result_store *store, const ll_experiment *experiment, int64_t from,
                                 int64_t to, char id[LL_EXPERIMENT_ID_MAX + 1]);

/* LL_CONFLICT: another version of laglab has registered the same; the message names both. */
ll_status ll_experiment_check_version(ll_result_store *store, const ll_experiment *experiment, int64_t from,
                                      int64_t to);

typedef struct ll_workers ll_workers;

typedef struct ll_workers_config {
    ll_result_store *store;
    const char *id; /* of one experiment; NULL: all running ones */
    int threads;    /* 0: one per core */
    int nice;       /* added to the threads' nice value */
    bool drain;     /* a thread ends when nothing is left to claim, and after an error of the store; otherwise
                     * it waits for a call, and tries again */
} ll_workers_config;

ll_status ll_workers_start(const ll_workers_config *config, ll_workers **workers);

/* Runs that these workers have made, including those that are not stored yet. */
int64_t ll_workers_runs(const ll_workers *workers);
bool ll_workers_busy(const ll_workers *workers); /* a thread is running */
void ll_workers_notify(ll_workers *workers);     /* call when there is something to claim, or to stop */

/* Interrupts all threads and returns their chunks. Frees. Returns the first error of a thread. */
ll_status ll_workers_stop(ll_workers *workers);
void ll_workers_request_stop(ll_workers *workers); /* the first half of it: join does the rest */
ll_status ll_workers_join(ll_workers *workers);    /* waits until they have ended */

int ll_cores(void);
/* Runs of a chunk when an experiment has `runs` to make. */
int64_t ll_experiment_chunk(const ll_experiment *experiment, int64_t runs);
