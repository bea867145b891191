#include "daemon/jobs/jobs.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cjson/cJSON.h>

#include "threads/clock.h"

enum { JOBS_MAX = 256, JOBS_PER_CLIENT = 8 }; /* JOBS_PER_CLIENT: that run */

#define KEPT (600 * LL_SECOND)
#define PAUSE_AFTER_NS                                                                                       \
    (800 * LL_MS) /* pause after that time without a request; clients are asked to poll once per             \
                     second, so this hardly delays them */

static const char *const states[] = {"running", "done", "cancelled", "failed"};

typedef struct job {
    struct job *next;
    ll_jobs *jobs;
    char id[LL_ID_LENGTH + 1];
    char client[40];
    ll_key_hash key;
    ll_job_spec spec;
    _Atomic int64_t done;
    _Atomic ll_time last_request; /* time of the last request */
    /* Guarded by the lock of `jobs`: */
    bool removed; /* freed by the last user, the list or the task */
    ll_task *task;
    ll_job_state state;
    ll_time ended;
    cJSON *answer;
    ll_status error;
} job;

struct ll_jobs {
    ll_tasks *tasks;
    const ll_host_config *config;
    pthread_mutex_t lock;
    pthread_cond_t requested; /* for one of them */
    job *first;
    int count;
};

static void free_job(job *j)
{
    j->spec.free(j->spec.context);
    cJSON_Delete(j->answer);
    free(j);
}

/* ---- a job's task ---- */

/* Waits for a request, since the client may have left, or for the job's end. */
static void wait_for_request(job *j)
{
    struct timespec until = ll_deadline(CLOCK_REALTIME, 100 * LL_MS);
    pthread_mutex_lock(&j->jobs->lock);
    pthread_cond_timedwait(&j->jobs->requested, &j->jobs->lock, &until);
    pthread_mutex_unlock(&j->jobs->lock);
}

static bool is_wanted(void *context)
{
    job *j = context;
    ll_time most = (ll_time)(j->jobs->config->job_idle_s * 1e9), idle;
    while ((idle = ll_now_ns() - atomic_load(&j->last_request)) > PAUSE_AFTER_NS && idle <= most &&
           ll_task_end_reason(j->task) == LL_TASK_RUNNING)
        wait_for_request(j);
    if (idle > most)
        ll_task_stop(j->task, LL_TASK_CLIENT_GONE);
    return ll_task_yield(j->task);
}

static void finish(job *j, ll_task *task, const ll_status *status, cJSON *answer)
{
    ll_jobs *jobs = j->jobs;
    ll_task_end end = ll_task_end_reason(task);
    pthread_mutex_lock(&jobs->lock);
    j->task = NULL;
    j->ended = ll_now_ns();
    j->answer = answer;
    j->error = status->code == LL_INTERRUPTED ? ll_task_error(task, status->text) : *status;
    j->state = !ll_failed(status)                                       ? LL_JOB_DONE
               : end == LL_TASK_CLIENT_GONE || end == LL_TASK_CANCELLED ? LL_JOB_CANCELLED
                                                                        : LL_JOB_FAILED;
    bool last = j->removed;
    pthread_mutex_unlock(&jobs->lock);
    if (last)
        free_job(j);
}

static void run(void *context, ll_task *task)
{
    job *j = context;
    cJSON *answer = NULL;
    pthread_mutex_lock(&j->jobs->lock); /* after the lock, `j->task` is set */
    pthread_mutex_unlock(&j->jobs->lock);
    ll_interrupt interrupt = ll_task_interrupt(task);
    interrupt.go_on = is_wanted;
    interrupt.context = j;
    ll_status status = ll_task_end_reason(task) == LL_TASK_RUNNING
                           ? j->spec.run(j->spec.context, &interrupt, &j->done, &answer)
                           : ll_error(LL_INTERRUPTED, "not started");
    finish(j, task, &status, answer);
}

/* ---- the list; locked ---- */

static job **find(ll_jobs *jobs, const char *id)
{
    job **link = &jobs->first;
    while (*link && strcmp((*link)->id, id) != 0)
        link = &(*link)->next;
    return link;
}

static void remove_from_list(ll_jobs *jobs, job **link)
{
    job *j = *link;
    *link = j->next;
    jobs->count--;
    j->removed = true;
    if (j->task)
        ll_task_stop(j->task, LL_TASK_CANCELLED); /* the task frees it */
    else
        free_job(j);
}

static void delete_expired(ll_jobs *jobs)
{
    ll_time before = ll_now_ns() - KEPT;
    for (job **link = &jobs->first; *link;)
        if ((*link)->state != LL_JOB_RUNNING && (*link)->ended < before)
            remove_from_list(jobs, link);
        else
            link = &(*link)->next;
}

/* ---- called by handlers ---- */

static ll_status add_locked(ll_jobs *jobs, job *j)
{
    ll_task_spec spec = {.budget_s = jobs->config->job_cpu_s, .run = run, .context = j};
    int running = 0;
    snprintf(spec.client, sizeof spec.client, "job %.39s",
             j->client); /* so that it does not take the turns of its client's requests */
    snprintf(spec.session, sizeof spec.session, "%s", j->id);
    delete_expired(jobs);
    for (const job *other = jobs->first; other; other = other->next)
        running += other->state == LL_JOB_RUNNING && strcmp(other->client, j->client) == 0;
    if (running >= JOBS_PER_CLIENT)
        return ll_error(LL_LIMIT, "Limit of %d searches of one client reached.", running);
    if (jobs->count >= JOBS_MAX)
        return ll_error(LL_LIMIT, "Limit of %d jobs reached.", jobs->count);
    LL_TRY(ll_tasks_add(jobs->tasks, &spec, &j->task));
    j->next = jobs->first;
    jobs->first = j;
    jobs->count++;
    return ll_ok();
}

ll_status ll_jobs_add(ll_jobs *jobs, const ll_job_spec *spec, char id[LL_ID_LENGTH + 1],
                      char key[LL_KEY_LENGTH + 1])
{
    job *j = calloc(1, sizeof *j);
    if (!j || !ll_new_id(jobs->config->shard, id) || !ll_new_key(key) || !ll_key_hash_make(key, &j->key)) {
        spec->free(spec->context);
        free(j);
        return ll_error(LL_NO_MEMORY, "out of memory: job");
    }
    j->jobs = jobs;
    j->spec = *spec;
    snprintf(j->client, sizeof j->client, "%s", spec->client);
    memcpy(j->id, id, sizeof j->id);
    atomic_init(&j->last_request, ll_now_ns());
    pthread_mutex_lock(&jobs->lock);
    ll_status status = add_locked(jobs, j);
    pthread_mutex_unlock(&jobs->lock);
    if (ll_failed(&status))
        free_job(j);
    return status;
}

static ll_status no_job(void)
{
    return ll_error(LL_NOT_FOUND, "Advice not found, or expired.");
}

ll_status ll_jobs_describe(ll_jobs *jobs, const char *id, cJSON *json)
{
    pthread_mutex_lock(&jobs->lock);
    job *j = *find(jobs, id);
    if (j) {
        atomic_store(&j->last_request, ll_now_ns());
        pthread_cond_broadcast(&jobs->requested);
        cJSON_AddStringToObject(json, "id", j->id);
        cJSON_AddStringToObject(json, "state", states[j->state]);
        cJSON_AddNumberToObject(json, "runs", (double)j->spec.most);
        cJSON_AddNumberToObject(json, "done", (double)atomic_load(&j->done));
        cJSON_AddItemToObject(json, "answer",
                              j->answer ? cJSON_Duplicate(j->answer, true) : cJSON_CreateNull());
        cJSON_AddItemToObject(json, "error",
                              ll_failed(&j->error) ? cJSON_CreateString(j->error.text) : cJSON_CreateNull());
    }
    pthread_mutex_unlock(&jobs->lock);
    return j ? ll_ok() : no_job();
}

ll_status ll_jobs_remove(ll_jobs *jobs, const char *id, const char *key)
{
    ll_status status = ll_ok();
    pthread_mutex_lock(&jobs->lock);
    job **link = find(jobs, id);
    if (!*link)
        status = no_job();
    else if (key && !ll_key_matches(&(*link)->key, key, strlen(key)))
        status = ll_error(LL_FORBIDDEN, "Key of another advice.");
    else
        remove_from_list(jobs, link);
    pthread_mutex_unlock(&jobs->lock);
    return status;
}

/* ---- start and stop ---- */

ll_jobs *ll_jobs_new(ll_tasks *tasks, const ll_host_config *config)
{
    ll_jobs *jobs = calloc(1, sizeof *jobs);
    if (!jobs)
        return NULL;
    jobs->tasks = tasks;
    jobs->config = config;
    pthread_mutex_init(&jobs->lock, NULL);
    pthread_cond_init(&jobs->requested, NULL);
    return jobs;
}

void ll_jobs_free(ll_jobs *jobs)
{
    if (!jobs)
        return;
    while (jobs->first)
        remove_from_list(jobs, &jobs->first);
    pthread_mutex_destroy(&jobs->lock);
    pthread_cond_destroy(&jobs->requested);
    free(jobs);
}
