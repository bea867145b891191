#include "experiment/work.h"

#include <cjson/cJSON.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

enum { THREADS_MAX = 256, LOOK_EVERY_S = 1 };

struct ll_workers {
    ll_workers_order order;
    char owner[LL_OWNER_MAX + 1];
    pthread_t threads[THREADS_MAX];
    int count;
    _Atomic int64_t runs;
    atomic_int alive;
    atomic_bool stopping;
    pthread_mutex_t lock; /* of what follows */
    pthread_cond_t wake;
    uint64_t calls;
    ll_status error;
};

/* What a thread works on. */
typedef struct bench {
    ll_workers *workers;
    ll_experiment *experiment;
    char id[LL_EXPERIMENT_ID_MAX + 1]; /* of the experiment that is held */
    ll_row *rows;
    int64_t capacity;
} bench;

int ll_cores(void)
{
    cpu_set_t set;
    int allowed = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return allowed < THREADS_MAX ? allowed : THREADS_MAX;
}

int64_t ll_chunk_size(int64_t runs)
{
    enum { CHUNKS = 512, LARGEST = 5000 };
    int64_t size = (runs + CHUNKS - 1) / CHUNKS;
    return size < 1 ? 1 : size < LARGEST ? size : LARGEST;
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* ---- a chunk ---- */

static ll_status load(bench *b, const char *id)
{
    char *text = NULL;
    cJSON *json = NULL;
    ll_result_store *store = b->workers->order.store;
    if (b->experiment && strcmp(b->id, id) == 0)
        return ll_ok();
    ll_experiment_free(b->experiment);
    b->experiment = NULL;
    ll_status status = store->kind->specification(store, id, &text);
    if (!ll_failed(&status))
        status = ll_json_parse(text, strlen(text), &json);
    if (!ll_failed(&status))
        status = ll_experiment_parse(json, b->workers->order.scenarios, &b->experiment);
    if (!ll_failed(&status))
        snprintf(b->id, sizeof b->id, "%s", id);
    cJSON_Delete(json);
    free(text);
    return status;
}

/* LL_CONFLICT: it is no longer this worker's, or not wanted. */
static ll_status run_chunk(bench *b, const ll_lease *lease)
{
    ll_workers *w = b->workers;
    ll_result_store *store = w->order.store;
    int64_t counted = 0;
    double renew_at = seconds() + w->order.lease_s / 2;
    if (lease->to - lease->from > b->capacity) {
        free(b->rows);
        b->capacity = lease->to - lease->from;
        b->rows = malloc((size_t)b->capacity * sizeof *b->rows);
    }
    ll_status status = b->rows ? load(b, lease->id) : ll_error(LL_NO_MEMORY, "no memory for rows");
    for (int64_t run = lease->from; run < lease->to && !ll_failed(&status); run++) {
        if (atomic_load(&w->stopping))
            return ll_error(LL_CONFLICT, "stopped");
        status = ll_experiment_run(b->experiment, run, &b->rows[run - lease->from]);
        atomic_fetch_add_explicit(&w->runs, 1, memory_order_relaxed);
        counted++;
        if (!ll_failed(&status) && seconds() > renew_at) {
            status = store->kind->renew(store, lease, w->order.lease_s);
            renew_at = seconds() + w->order.lease_s / 2;
        }
    }
    if (!ll_failed(&status))
        status =
            store->kind->finish(store, lease, b->rows, lease->to - lease->from, b->experiment->metric_count);
    if (ll_failed(&status))
        atomic_fetch_sub_explicit(&w->runs, counted, memory_order_relaxed);
    return status;
}

/* ---- threads ---- */

static uint64_t calls_so_far(ll_workers *w)
{
    pthread_mutex_lock(&w->lock);
    uint64_t calls = w->calls;
    pthread_mutex_unlock(&w->lock);
    return calls;
}

/* Until somebody calls, beyond those `calls` that were there before the look at the store; or for a second.
 */
static void wait_for_work(ll_workers *w, uint64_t calls)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += LOOK_EVERY_S;
    pthread_mutex_lock(&w->lock);
    while (calls == w->calls && !atomic_load(&w->stopping) &&
           pthread_cond_timedwait(&w->wake, &w->lock, &until) == 0)
        ;
    pthread_mutex_unlock(&w->lock);
}

static void keep_error(ll_workers *w, const ll_status *status)
{
    pthread_mutex_lock(&w->lock);
    if (!ll_failed(&w->error))
        w->error = *status;
    pthread_mutex_unlock(&w->lock);
}

/* False when nothing of `id` is left, not even with other workers. */
static bool more_to_come(const ll_workers *w)
{
    ll_experiment_record record;
    if (!w->order.drain)
        return true;
    if (!w->order.id)
        return false;
    ll_status status = w->order.store->kind->record(w->order.store, w->order.id, &record);
    return !ll_failed(&status) && record.state == LL_EXPERIMENT_RUNNING && record.leased > 0;
}

static void *work(void *context)
{
    bench b = {.workers = context};
    ll_workers *w = context;
    const ll_workers_order *o = &w->order;
    if (o->nice > 0) /* of this thread alone, on Linux */
        setpriority(PRIO_PROCESS, (id_t)syscall(SYS_gettid), o->nice);
    while (!atomic_load(&w->stopping)) {
        ll_lease lease;
        uint64_t calls = calls_so_far(w);
        ll_status status = o->store->kind->claim(o->store, o->id, w->owner, o->lease_s, &lease);
        bool found = !ll_failed(&status) && lease.chunk >= 0;
        if (found)
            status = run_chunk(&b, &lease);
        if (found) /* others may wait to hear that this was the last */
            ll_workers_wake(w);
        if (ll_failed(&status) && status.code != LL_CONFLICT &&
            status.code != LL_NOT_FOUND) { /* it was deleted */
            keep_error(w, &status);
            if (o->drain)
                break;
            found = false;
        }
        if (!found && !more_to_come(w))
            break;
        if (!found)
            wait_for_work(w, calls);
    }
    ll_experiment_free(b.experiment);
    free(b.rows);
    atomic_fetch_sub(&w->alive, 1);
    return NULL;
}

static void name_owner(char owner[LL_OWNER_MAX + 1])
{
    unsigned char random[16];
    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        memset(random, 0, sizeof random);
    for (size_t i = 0; i < sizeof random; i++)
        snprintf(owner + 2 * i, 3, "%02x", random[i]);
}

ll_status ll_workers_start(const ll_workers_order *order, ll_workers **workers)
{
    ll_workers *w = *workers = calloc(1, sizeof *w);
    if (!w)
        return ll_error(LL_NO_MEMORY, "no memory for workers");
    w->order = *order;
    int wanted = order->threads > 0 ? order->threads : ll_cores();
    name_owner(w->owner);
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->wake, NULL);
    for (; w->count < wanted && w->count < THREADS_MAX; w->count++) {
        atomic_fetch_add(&w->alive, 1);
        if (pthread_create(&w->threads[w->count], NULL, work, w) != 0) {
            atomic_fetch_sub(&w->alive, 1);
            break;
        }
    }
    if (w->count > 0)
        return ll_ok();
    ll_workers_join(w);
    *workers = NULL;
    return ll_error(LL_NO_MEMORY, "no thread could be started");
}

int64_t ll_workers_runs(const ll_workers *w)
{
    return atomic_load_explicit(&w->runs, memory_order_relaxed);
}

bool ll_workers_busy(const ll_workers *w)
{
    return atomic_load(&w->alive) > 0;
}

void ll_workers_wake(ll_workers *w)
{
    pthread_mutex_lock(&w->lock);
    w->calls++;
    pthread_cond_broadcast(&w->wake);
    pthread_mutex_unlock(&w->lock);
}

ll_status ll_workers_join(ll_workers *w)
{
    for (int i = 0; i < w->count; i++)
        pthread_join(w->threads[i], NULL);
    ll_status status = w->error;
    pthread_mutex_destroy(&w->lock);
    pthread_cond_destroy(&w->wake);
    free(w);
    return status;
}

ll_status ll_workers_stop(ll_workers *w)
{
    atomic_store(&w->stopping, true);
    ll_workers_wake(w);
    return ll_workers_join(w);
}
