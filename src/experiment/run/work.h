/* Workers: threads that claim chunks from a store, run them and hand in their rows. */
#pragma once

#include "experiment/store/result_store.h"

/* Puts the runs from..to-1 of an experiment into a store, under an id that is the same for the same
 * specification, runs and version of the store's: registered again, it goes on where it was. `run_s`: what a
 * run takes, so that chunks are some seconds at most; 0: not known. */
ll_status ll_experiment_register(ll_result_store *store, const ll_experiment *experiment, int64_t from,
                                 int64_t to, double run_s, char id[LL_EXPERIMENT_ID_MAX + 1]);

/* LL_CONFLICT: another version of laglab has put the same into the store; the sentence names both. */
ll_status ll_experiment_check_version(ll_result_store *store, const ll_experiment *experiment, int64_t from,
                                      int64_t to);

/* Makes a run and tells its time on a core, s. */
ll_status ll_experiment_time(const ll_experiment *experiment, int64_t run, double *run_s);

typedef struct ll_workers ll_workers;

enum { LL_LEASE_MAX_S = 86400 };

typedef struct ll_workers_order {
    ll_result_store *store;
    const char *id; /* of one experiment; NULL: of all that are running */
    int threads;    /* 0: one per core */
    int nice;       /* added to the threads' niceness, so that others on the machine come first */
    double lease_s; /* renewed at its half while a chunk is worked on */
    bool drain;     /* end when nothing is left to claim; otherwise look again and again */
    bool persist;   /* go on after an error of the store, which otherwise ends the thread */
} ll_workers_order;

ll_status ll_workers_start(const ll_workers_order *order, ll_workers **workers);

/* Runs done by these workers, also those that are not stored yet; and those lost with a lease. */
int64_t ll_workers_runs(const ll_workers *workers);
bool ll_workers_busy(const ll_workers *workers); /* some thread has not ended */
void ll_workers_wake(ll_workers *workers);       /* there is something to claim, or to leave */

/* Breaks off what each thread is at and gives its chunk back. Frees. The first error of a thread is the
 * result. A store's server that does not answer is waited for, two minutes at most, before that is an error.
 */
ll_status ll_workers_stop(ll_workers *workers);
void ll_workers_request_stop(ll_workers *workers); /* the first half of it: join does the rest */
ll_status ll_workers_join(ll_workers *workers);    /* waits until they end by themselves */

int ll_cores(void);
int64_t ll_chunk_size(int64_t runs, double run_s); /* in runs; run_s 0: not known */

/* The same of an experiment. Where runs of a point are made until its mean is known a chunk is of whole
 * points: whether a run is made follows from those before it. */
int64_t ll_experiment_chunk(const ll_experiment *experiment, int64_t runs, double run_s);
