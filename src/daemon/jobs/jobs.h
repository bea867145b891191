/* Jobs: work that outlives the request that started it: searches for advice. A request starts a job, others
 * watch or end it, and it is deleted when there was no request for it for a while.
 *
 * A job runs as a task of its client. It pauses after a second without a request, continues at the next one,
 * and is cancelled after `job_idle_s` without one. A finished job is kept for ten minutes; the number of jobs
 * is limited. Jobs are not stored: they end with the daemon. Any thread. */
#pragma once

#include "daemon/hosting/host.h"
#include "daemon/support/keys.h"
#include "daemon/support/tasks.h"

struct cJSON;
typedef struct ll_jobs ll_jobs;

typedef enum ll_job_state { LL_JOB_RUNNING, LL_JOB_DONE, LL_JOB_CANCELLED, LL_JOB_FAILED } ll_job_state;

/* What a job does. `run` returns the answer (which the job owns then) or an error, counts in `done`, and may
 * be interrupted; `free` is called once, at the end. */
typedef struct ll_job_spec {
    ll_status (*run)(void *context, const ll_interrupt *interrupt, _Atomic int64_t *done,
                     struct cJSON **answer);
    void (*free)(void *context);
    void *context; /* owned by the job, also on an error */
    int64_t most;  /* final value of `done` */
    const char *client;
} ll_job_spec;

ll_jobs *ll_jobs_new(ll_tasks *tasks, const ll_host_config *config); /* NULL without memory */
void ll_jobs_free(ll_jobs *jobs);                                    /* after the tasks have ended */

/* LL_LIMIT: too many jobs. */
ll_status ll_jobs_add(ll_jobs *jobs, const ll_job_spec *spec, char id[LL_ID_LENGTH + 1],
                      char key[LL_KEY_LENGTH + 1]);
/* Adds to `json`: state, done, runs, and `answer` and `error`, which may be null. LL_NOT_FOUND. */
ll_status ll_jobs_describe(ll_jobs *jobs, const char *id, struct cJSON *json);
/* Cancels and deletes it. LL_NOT_FOUND; LL_FORBIDDEN: wrong key; key NULL: the operator. */
ll_status ll_jobs_remove(ll_jobs *jobs, const char *id, const char *key);
