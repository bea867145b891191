/* Runs handlers: short ones in a thread pool, long ones as tasks. */
#include <stdio.h>
#include <stdlib.h>

#include "base/assert.h"
#include "daemon/http/internal.h"

#define WAITING_JOBS 256

/* ---- thread pool ---- */

bool ll_http_queue(ll_http *http, http_exchange *exchange)
{
    LL_ASSERT(exchange->route->run_on == LL_HTTP_POOL);
    pthread_mutex_lock(&http->job_lock);
    bool taken = http->jobs < WAITING_JOBS && !http->jobs_end;
    if (taken) {
        exchange->next_job = NULL;
        exchange->queued_ns = ll_now_ns();
        if (http->last_job != NULL)
            http->last_job->next_job = exchange;
        else
            http->first_job = exchange;
        http->last_job = exchange;
        http->jobs++;
        pthread_cond_signal(&http->job_there);
    }
    pthread_mutex_unlock(&http->job_lock);
    return taken;
}

void ll_http_run_handler(http_exchange *exchange)
{
    exchange->route->handler(exchange->http->app.context, &exchange->request, &exchange->response);
}

/* NULL when stopping. */
static http_exchange *next_job(ll_http *http, int64_t *busy_since)
{
    pthread_mutex_lock(&http->job_lock);
    if (*busy_since != 0)
        http->ended_ns = ll_now_ns();
    *busy_since = 0;
    while (http->first_job == NULL && !http->jobs_end)
        pthread_cond_wait(&http->job_there, &http->job_lock);
    http_exchange *exchange = http->first_job;
    if (exchange != NULL) {
        http->first_job = exchange->next_job;
        http->last_job = http->first_job != NULL ? http->last_job : NULL;
        http->jobs--;
        *busy_since = exchange->queued_ns;
    }
    pthread_mutex_unlock(&http->job_lock);
    return exchange;
}

typedef struct control_thread {
    ll_http *http;
    int64_t *busy_since;
} control_thread;

static void *control_main(void *argument)
{
    control_thread self = *(control_thread *)argument;
    pthread_setname_np(pthread_self(), "control");
    free(argument);
    http_exchange *exchange;
    while ((exchange = next_job(self.http, self.busy_since)) != NULL) {
        ll_http_run_handler(exchange);
        if (exchange->response.to_work) {
            exchange->request.begun = exchange->response.begun;
            ll_http_clear(&exchange->response);
            ll_status status = ll_http_start_task(self.http, exchange);
            if (!ll_failed(&status))
                continue;
            ll_http_problem(&exchange->response, &exchange->request, &status);
        }
        ll_http_compress(exchange);
        MHD_resume_connection(exchange->connection);
    }
    return NULL;
}

bool ll_http_start_control(ll_http *http)
{
    int i = http->control_threads;
    control_thread *self = malloc(sizeof *self);
    if (self == NULL)
        return false;
    *self = (control_thread){http, &http->busy_since[i]};
    if (pthread_create(&http->control[i], NULL, control_main, self) != 0) {
        free(self);
        return false;
    }
    http->control_threads++;
    return true;
}

void ll_http_stop_control(ll_http *http)
{
    pthread_mutex_lock(&http->job_lock);
    http->jobs_end = true;
    pthread_cond_broadcast(&http->job_there);
    pthread_mutex_unlock(&http->job_lock);
    for (int i = 0; i < http->control_threads; i++)
        pthread_join(http->control[i], NULL);
    http->control_threads = 0;
}

/* ---- tasks ---- */

static void set_task(http_exchange *exchange, ll_task *task)
{
    if (exchange->watched != NULL)
        exchange->watched->task = task;
}

static void work(void *context, ll_task *task)
{
    http_exchange *exchange = context;
    ll_http *http = exchange->http;
    exchange->request.task = task;
    if (ll_task_end_reason(task) == LL_TASK_RUNNING) {
        ll_http_run_handler(exchange);
        ll_http_compress(exchange);
    } else {
        ll_status error = ll_task_error(task, "not started");
        ll_http_problem(&exchange->response, &exchange->request, &error);
    }
    exchange->request.task = NULL;
    pthread_mutex_lock(&http->watch_lock); /* from here on the task cannot be stopped */
    set_task(exchange, NULL);
    pthread_mutex_unlock(&http->watch_lock);
    MHD_resume_connection(exchange->connection);
    pthread_mutex_lock(&http->job_lock);
    http->working--;
    pthread_cond_broadcast(&http->work_done);
    pthread_mutex_unlock(&http->job_lock);
}

ll_status ll_http_start_task(ll_http *http, http_exchange *exchange)
{
    ll_task_spec order = {.budget_s = http->config.request_cpu_s, .run = work, .context = exchange};
    const char *session = exchange->request.parameter[0];
    snprintf(order.client, sizeof order.client, "%s", exchange->request.peer);
    /* Kinds of requests take turns too: four long traces of a session do not keep its description. */
    snprintf(order.session, sizeof order.session, "%.43s %td", session != NULL ? session : "",
             exchange->route - http->app.routes);
    pthread_mutex_lock(&http->job_lock);
    http->working++;
    pthread_mutex_unlock(&http->job_lock);
    ll_task *task = NULL;
    pthread_mutex_lock(&http->watch_lock);
    ll_status status = ll_tasks_add(http->app.tasks, &order, &task);
    if (!ll_failed(&status))
        set_task(exchange, task);
    pthread_mutex_unlock(&http->watch_lock);
    if (ll_failed(&status)) {
        pthread_mutex_lock(&http->job_lock);
        http->working--;
        pthread_mutex_unlock(&http->job_lock);
    }
    return status;
}

void ll_http_stop_tasks(ll_http *http)
{
    if (http->app.tasks != NULL)
        ll_tasks_drain(http->app.tasks);
    pthread_mutex_lock(&http->job_lock);
    while (http->working > 0)
        pthread_cond_wait(&http->work_done, &http->job_lock);
    pthread_mutex_unlock(&http->job_lock);
}

/* ---- statistics ---- */

ll_http_counted ll_http_counts(ll_http *http)
{
    ll_http_counted counted = {.requests = atomic_load(&http->requests),
                               .cut = atomic_load(&http->cut),
                               .upgrades = atomic_load(&http->upgrades),
                               .refused_answers = atomic_load(&http->refused_answers),
                               .answer_bytes = (uint64_t)atomic_load(&http->answer_bytes)};
    int64_t now = ll_now_ns(), oldest = now;
    pthread_mutex_lock(&http->job_lock);
    counted.control = http->jobs;
    if (http->first_job != NULL)
        oldest = http->first_job->queued_ns;
    for (int i = 0; i < 64; i++) {
        counted.control += http->busy_since[i] != 0;
        oldest = http->busy_since[i] != 0 && http->busy_since[i] < oldest ? http->busy_since[i] : oldest;
    }
    int64_t stalled = now - (http->ended_ns > oldest ? http->ended_ns : oldest);
    pthread_mutex_unlock(&http->job_lock);
    counted.control_s = (double)(now - oldest) * 1e-9;
    counted.stalled_s = (double)stalled * 1e-9;
    return counted;
}
