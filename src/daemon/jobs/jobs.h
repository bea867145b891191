/* Work that outlives the request that asked for it: advice. A job is made by a request, watched and ended by
 * others, and gone when nobody has asked for it for a while.
 *
 * A job runs as a task of its client. It rests when nobody has asked for it in the last second, goes on when
 * somebody does, and is cancelled when nobody has in `job_idle_s`; what is over is kept for ten minutes, and
 * at most so many are. Jobs are not stored: they end with the daemon. Any thread. */
#pragma once

#include "daemon/hosting/host.h"
#include "daemon/support/keys.h"
#include "daemon/support/tasks.h"

struct cJSON;
typedef struct ll_jobs ll_jobs;

typedef enum ll_job_state { LL_JOB_RUNNING, LL_JOB_DONE, LL_JOB_CANCELLED, LL_JOB_FAILED } ll_job_state;

/* What a job does. `run` gives the answer (the job's then) or an error, counts in `done`, and may be broken
 * off; `free` is called once, at the end. */
typedef struct ll_job_spec {
    ll_status (*run)(void *context, const ll_interrupt *interrupt, _Atomic int64_t *done,
                     struct cJSON **answer);
    void (*free)(void *context);
    void *context; /* taken, also on an error */
    int64_t most;  /* that `done` may count to */
    const char *client;
} ll_job_spec;

ll_jobs *ll_jobs_new(ll_tasks *tasks, const ll_host_config *config); /* NULL without memory */
void ll_jobs_free(ll_jobs *jobs);                                    /* after the tasks have ended */

/* LL_LIMIT: there are as many as may be. */
ll_status ll_jobs_add(ll_jobs *jobs, const ll_job_spec *order, char id[LL_ID_LENGTH + 1],
                      char key[LL_KEY_LENGTH + 1]);
/* Adds to `json`: state, done, runs, and `answer` and `error`, which may be null. LL_NOT_FOUND. */
ll_status ll_jobs_describe(ll_jobs *jobs, const char *id, struct cJSON *json);
/* Cancels and forgets it. LL_NOT_FOUND; LL_FORBIDDEN: it is not its key; NULL is the operator's. */
ll_status ll_jobs_remove(ll_jobs *jobs, const char *id, const char *key);
