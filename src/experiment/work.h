/* Workers: threads that claim chunks from a store, run them and hand in their rows. */
#pragma once

#include "experiment/result_store.h"

typedef struct ll_workers ll_workers;

typedef struct ll_workers_order {
    ll_result_store *store;
    const char *id;        /* of one experiment; NULL: of all that are running */
    const char *scenarios; /* folder of the library */
    int threads;           /* 0: one per core */
    int nice;              /* added to the threads' niceness, so that others on the machine come first */
    double lease_s;
    bool drain; /* end when nothing is left to claim; otherwise look again and again */
} ll_workers_order;

ll_status ll_workers_start(const ll_workers_order *order, ll_workers **workers);

/* Runs done by these workers, also those that are not stored yet; and those lost with a lease. */
int64_t ll_workers_runs(const ll_workers *workers);
bool ll_workers_busy(const ll_workers *workers); /* some thread has not ended */
void ll_workers_wake(ll_workers *workers);       /* there is something to claim, or to leave */

/* Lets each thread end after the run it is at; what is not handed in is run again by others. Frees. The first
 * error of a thread is the result. */
ll_status ll_workers_stop(ll_workers *workers);
ll_status ll_workers_join(ll_workers *workers); /* the same, but waits until they end by themselves */

int ll_cores(void);
int64_t ll_chunk_size(int64_t runs); /* for threads of one machine */
