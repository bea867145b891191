#include "experiment/run/work.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
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

#include "base/assert.h"
#include "base/hash.h"
#include "experiment/spec/until.h"

enum { THREADS_MAX = 256, LOOK_EVERY_S = 1, RETRY_EVERY_S = 1, PATIENCE_S = 120 };

/* A worker thread and its work. */
typedef struct worker_thread {
    struct ll_workers *workers;
    pthread_t thread;
    ll_experiment *experiment;
    char id[LL_EXPERIMENT_ID_MAX + 1]; /* of the loaded experiment */
    ll_row *rows;
    int64_t capacity;
    ll_resampler resampler;
    ll_kept_block kept; /* of one run after another */
    atomic_bool drop;   /* stop the present run: the lease was lost, or the workers stop */
    /* Guarded by the workers' lock: */
    ll_lease lease; /* chunk < 0: none */
    double renew_at;
} worker_thread;

struct ll_workers {
    ll_workers_config config;
    char owner[LL_OWNER_MAX + 1];
    worker_thread worker_threads[THREADS_MAX];
    int count;
    pthread_t keeper; /* renews leases */
    _Atomic int64_t runs;
    atomic_int alive;
    atomic_bool stopping;
    pthread_mutex_t lock; /* guards all members below */
    pthread_cond_t wake;
    bool over; /* all threads except the keeper have ended */
    uint64_t calls;
    ll_status error;
};

int ll_cores(void)
{
    cpu_set_t set;
    int allowed = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return allowed < THREADS_MAX ? allowed : THREADS_MAX;
}

static int64_t share(int64_t runs, int64_t parts)
{
    return (runs + parts - 1) / parts;
}

/* As few chunks as keep all threads busy to the end: claiming and finishing a chunk takes the time of many
 * short runs. Long runs are in more chunks, since a worker that dies loses its chunk; but the queue must stay
 * small enough to be fast. */
int64_t ll_chunk_size(int64_t runs, double run_s)
{
    enum { FEW = 128, MANY = 2000, LARGEST = 5000 };
    const double wanted_s = 2;
    int64_t most = share(runs, FEW), least = share(runs, MANY);
    most = most < 1 ? 1 : most < LARGEST ? most : LARGEST;
    if (run_s * (double)most <= wanted_s)
        return most;
    int64_t size = (int64_t)(wanted_s / run_s);
    return size > least ? size : least < most ? least : most;
}

int64_t ll_experiment_chunk(const ll_experiment *experiment, int64_t runs, double run_s)
{
    int64_t chunk = ll_chunk_size(runs, run_s), repeats = experiment->head.repeats;
    return ll_until_is_set(experiment) ? share(chunk, repeats) * repeats : chunk;
}

static double thread_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

ll_status ll_experiment_time(const ll_experiment *experiment, int64_t run, double *run_s)
{
    ll_row row;
    double from = thread_seconds();
    ll_status status = ll_experiment_run(experiment, run, NULL, NULL, &row);
    *run_s = thread_seconds() - from;
    return status;
}

/* Returns the length of the id without its version, which is the same for all versions. */
static int name_experiment(const ll_experiment *experiment, int64_t from, int64_t to, const char *version,
                           char id[LL_EXPERIMENT_ID_MAX + 1])
{
    int length = snprintf(id, LL_EXPERIMENT_ID_MAX + 1, "%016" PRIx64 "-%" PRId64 "-%" PRId64 "-",
                          ll_experiment_key(experiment), from, to);
    snprintf(id + length, (size_t)(LL_EXPERIMENT_ID_MAX + 1 - length), "%08" PRIx32,
             (uint32_t)ll_hash(0, version, strlen(version)));
    return length;
}

typedef struct rival {
    char id[LL_EXPERIMENT_ID_MAX + 1]; /* this version's id */
    int common;                        /* length of the common part of the ids */
    char version[LL_VERSION_MAX + 1];  /* another version with the same experiment; empty: none */
} rival;

static void note_rival(void *context, const ll_experiment_record *record)
{
    rival *r = context;
    if (strncmp(record->id, r->id, (size_t)r->common) == 0 && strcmp(record->id, r->id) != 0)
        snprintf(r->version, sizeof r->version, "%s", record->version);
}

ll_status ll_experiment_check_version(ll_result_store *store, const ll_experiment *experiment, int64_t from,
                                      int64_t to)
{
    rival r = {0};
    r.common = name_experiment(experiment, from, to, store->version, r.id);
    ll_status status = store->kind->list(store, note_rival, &r);
    if (!ll_failed(&status) && r.version[0])
        status = ll_error(LL_CONFLICT,
                          "laglab %s has started this experiment in the store; results of this one, %s, may "
                          "differ: continue with that version, or run all again with %s",
                          r.version, store->version, "--anew");
    return status;
}

ll_status ll_experiment_register(ll_result_store *store, const ll_experiment *experiment, int64_t from,
                                 int64_t to, double run_s, char id[LL_EXPERIMENT_ID_MAX + 1])
{
    ll_experiment_record record = {.from = from, .to = to};
    name_experiment(experiment, from, to, store->version, record.id);
    memcpy(id, record.id, sizeof record.id);
    char *text = ll_experiment_text(experiment);
    if (!text)
        return ll_error(LL_NO_MEMORY, "out of memory: experiment");
    ll_status status =
        store->kind->create(store, &record, text, ll_experiment_chunk(experiment, to - from, run_s));
    free(text);
    return status;
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Waits until there are more than `calls` calls, or for that time. Locked. */
static void wait_for_call(ll_workers *w, uint64_t calls, double wait_s)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    int64_t ns = until.tv_nsec + (int64_t)(wait_s * 1e9);
    until.tv_sec += ns / 1000000000;
    until.tv_nsec = ns % 1000000000;
    while (calls == w->calls && pthread_cond_timedwait(&w->wake, &w->lock, &until) == 0)
        ;
}

static void rest(ll_workers *w, uint64_t calls, double wait_s)
{
    pthread_mutex_lock(&w->lock);
    if (!atomic_load(&w->stopping))
        wait_for_call(w, calls, wait_s);
    pthread_mutex_unlock(&w->lock);
}

static uint64_t calls_so_far(ll_workers *w)
{
    pthread_mutex_lock(&w->lock);
    uint64_t calls = w->calls;
    pthread_mutex_unlock(&w->lock);
    return calls;
}

/* ---- leases ---- */

static void hold(worker_thread *b, const ll_lease *lease)
{
    ll_workers *w = b->workers;
    pthread_mutex_lock(&w->lock);
    LL_ASSERT(b->lease.chunk < 0); /* a thread runs one chunk at a time */
    b->lease = *lease;
    b->renew_at = seconds() + w->config.lease_s / 2;
    atomic_store(&b->drop, atomic_load(&w->stopping));
    pthread_mutex_unlock(&w->lock);
}

static void return_chunk(worker_thread *b)
{
    pthread_mutex_lock(&b->workers->lock);
    b->lease.chunk = -1;
    pthread_mutex_unlock(&b->workers->lock);
}

static worker_thread *next_to_renew(ll_workers *w)
{
    worker_thread *next = NULL;
    for (int i = 0; i < w->count; i++) {
        worker_thread *b = &w->worker_threads[i];
        if (b->lease.chunk >= 0 && !atomic_load(&b->drop) && (!next || b->renew_at < next->renew_at))
            next = b;
    }
    return next;
}

/* Locked, but unlocks while it waits for the store. */
static void renew(ll_workers *w, worker_thread *b)
{
    ll_lease lease = b->lease;
    pthread_mutex_unlock(&w->lock);
    ll_status status = w->config.store->kind->renew(w->config.store, &lease, w->config.lease_s);
    pthread_mutex_lock(&w->lock);
    if (b->lease.chunk != lease.chunk || b->lease.attempt != lease.attempt)
        return; /* finished meanwhile */
    if (status.code == LL_CONFLICT)
        atomic_store(&b->drop, true);
    b->renew_at = seconds() + (ll_failed(&status) ? RETRY_EVERY_S : w->config.lease_s / 2);
}

/* Renews leases while their chunks are run, however long one run takes. The checks are frequent enough for a
 * lease that begins meanwhile. */
static void *keep_leases(void *context)
{
    ll_workers *w = context;
    pthread_setname_np(pthread_self(), "leases");
    pthread_mutex_lock(&w->lock);
    while (!w->over) {
        worker_thread *b = next_to_renew(w);
        double now = seconds(), check_s = w->config.lease_s / 4;
        if (b && b->renew_at <= now)
            renew(w, b);
        else
            wait_for_call(w, w->calls, b && b->renew_at - now < check_s ? b->renew_at - now : check_s);
    }
    pthread_mutex_unlock(&w->lock);
    return NULL;
}

/* ---- a chunk ---- */

/* Retries while a server does not answer, for a limited time. `since` is 0 at the first try. */
static bool may_retry(ll_workers *w, const ll_status *status, double *since)
{
    if (status->code != LL_UNAVAILABLE || atomic_load(&w->stopping))
        return false;
    if (*since == 0)
        *since = seconds();
    if (seconds() - *since > PATIENCE_S)
        return false;
    rest(w, calls_so_far(w), RETRY_EVERY_S);
    return !atomic_load(&w->stopping);
}

static ll_status read_specification(ll_workers *w, const char *id, char **text)
{
    ll_status status;
    double since = 0;
    do
        status = w->config.store->kind->specification(w->config.store, id, text);
    while (may_retry(w, &status, &since));
    return status;
}

static ll_status load(worker_thread *b, const char *id)
{
    char *text = NULL;
    cJSON *json = NULL;
    if (b->experiment && strcmp(b->id, id) == 0)
        return ll_ok();
    ll_experiment_free(b->experiment);
    b->experiment = NULL;
    ll_status status = read_specification(b->workers, id, &text);
    LL_THEN(status, ll_json_parse(text, strlen(text), &json));
    LL_THEN(status, ll_experiment_parse(json, NULL, &b->experiment));
    if (!ll_failed(&status))
        snprintf(b->id, sizeof b->id, "%s", id);
    cJSON_Delete(json);
    free(text);
    return status;
}

static ll_status store_rows(worker_thread *b, const ll_lease *lease)
{
    ll_status status;
    double since = 0;
    ll_result_store *store = b->workers->config.store;
    do
        status =
            store->kind->finish(store, lease, b->rows, lease->to - lease->from, b->experiment->metric_count);
    while (may_retry(b->workers, &status, &since));
    return status;
}

static bool is_wanted(void *context)
{
    const worker_thread *b = context;
    return !atomic_load_explicit(&b->drop, memory_order_relaxed);
}

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* Makes a run, or the row of a skipped run if its point has enough. */
static ll_status run_or_skip(worker_thread *b, const ll_lease *lease, int64_t run,
                             const ll_interrupt *interrupt, bool *enough)
{
    LL_ASSERT(run >= lease->from && run < lease->to && lease->to - lease->from <= b->capacity);
    ll_row *row = &b->rows[run - lease->from];
    int64_t repeat = run % b->experiment->head.repeats;
    *enough = *enough && repeat > 0;
    if (*enough) {
        ll_until_skip(run, row);
        return ll_ok();
    }
    ll_status status = ll_experiment_run(b->experiment, run, interrupt, &b->kept, row);
    if (!ll_failed(&status) && run - repeat >= lease->from)
        *enough = ll_until_reached(b->experiment, row - repeat, repeat + 1, &b->resampler);
    return status;
}

/* LL_CONFLICT, LL_INTERRUPTED: the lease was lost, or the result is not wanted. */
static ll_status run_chunk(worker_thread *b, const ll_lease *lease)
{
    ll_workers *w = b->workers;
    ll_interrupt interrupt = {is_wanted, now_ns, b};
    int64_t counted = 0;
    if (lease->to - lease->from > b->capacity) {
        free(b->rows);
        b->capacity = lease->to - lease->from;
        b->rows = malloc((size_t)b->capacity * sizeof *b->rows);
    }
    ll_status status = b->rows ? load(b, lease->id) : ll_error(LL_NO_MEMORY, "out of memory: rows");
    bool enough = false; /* of the point */
    for (int64_t run = lease->from; run < lease->to && !ll_failed(&status); run++) {
        status = run_or_skip(b, lease, run, &interrupt, &enough);
        atomic_fetch_add_explicit(&w->runs, 1, memory_order_relaxed);
        counted++;
    }
    LL_THEN(status, store_rows(b, lease));
    if (ll_failed(&status))
        atomic_fetch_sub_explicit(&w->runs, counted, memory_order_relaxed);
    return status;
}

/* ---- threads ---- */

static void keep_error(ll_workers *w, const ll_status *status)
{
    pthread_mutex_lock(&w->lock);
    if (!ll_failed(&w->error))
        w->error = *status;
    pthread_mutex_unlock(&w->lock);
}

typedef struct others {
    const char *version;
    bool at_work;
} others;

static void note_others(void *context, const ll_experiment_record *record)
{
    others *o = context;
    o->at_work |= record->state == LL_EXPERIMENT_RUNNING && record->leased > 0 &&
                  strcmp(record->version, o->version) == 0;
}

/* False when no work is left; chunks of other workers count as work, since they return if those die. */
static bool more_to_come(const ll_workers *w)
{
    ll_experiment_record record;
    ll_result_store *store = w->config.store;
    others o = {store->version, false};
    if (!w->config.drain)
        return true;
    if (!w->config.id) {
        ll_status listed = store->kind->list(store, note_others, &o);
        return o.at_work || listed.code == LL_UNAVAILABLE;
    }
    ll_status status = store->kind->record(store, w->config.id, &record);
    if (!ll_failed(&status))
        note_others(&o, &record);
    return o.at_work || status.code == LL_UNAVAILABLE;
}

static ll_status claim(ll_workers *w, ll_lease *lease)
{
    ll_status status;
    double since = 0;
    const ll_workers_config *o = &w->config;
    do
        status = o->store->kind->claim(o->store, o->id, w->owner, o->lease_s, lease);
    while (may_retry(w, &status, &since));
    return status;
}

/* Claims a chunk and runs it. `found`: there was one. */
static ll_status work_once(worker_thread *b, bool *found)
{
    ll_lease lease;
    ll_workers *w = b->workers;
    ll_status status = claim(w, &lease);
    *found = !ll_failed(&status) && lease.chunk >= 0;
    if (!*found)
        return status;
    hold(b, &lease);
    status = run_chunk(b, &lease);
    return_chunk(b);
    if (status.code == LL_INTERRUPTED) /* the lease was lost, unless the workers stop */
        status.code = LL_CONFLICT;
    if (status.code == LL_CONFLICT && atomic_load(&w->stopping))
        status = w->config.store->kind->return_chunk(w->config.store, &lease);
    ll_workers_notify(w); /* other threads may wait for the end of the last one */
    return status;
}

/* While a thread rests, its state may be memory that others want. */
static void *work(void *context)
{
    worker_thread *b = context;
    pthread_setname_np(pthread_self(), "run");
    ll_workers *w = b->workers;
    if (w->config.nice > 0) /* on Linux: of this thread only */
        setpriority(PRIO_PROCESS, (id_t)syscall(SYS_gettid), w->config.nice);
    while (!atomic_load(&w->stopping)) {
        bool found;
        uint64_t calls = calls_so_far(w);
        ll_status status = work_once(b, &found);
        if (ll_failed(&status) && status.code != LL_CONFLICT &&
            status.code != LL_NOT_FOUND) { /* the experiment was deleted */
            keep_error(w, &status);
            if (!w->config.persist)
                break;
            found = false;
        }
        if (!found && !more_to_come(w))
            break;
        if (!found) {
            ll_kept_block_free(&b->kept);
            rest(w, calls, LOOK_EVERY_S);
        }
    }
    ll_kept_block_free(&b->kept);
    ll_experiment_free(b->experiment);
    ll_resampler_free(&b->resampler);
    free(b->rows);
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

static void prepare(ll_workers *w)
{
    pthread_condattr_t attributes;
    pthread_mutex_init(&w->lock, NULL);
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&w->wake, &attributes);
    pthread_condattr_destroy(&attributes);
    for (int i = 0; i < THREADS_MAX; i++) {
        w->worker_threads[i].workers = w;
        w->worker_threads[i].lease.chunk = -1;
    }
}

static void clear_away(ll_workers *w)
{
    pthread_mutex_destroy(&w->lock);
    pthread_cond_destroy(&w->wake);
    free(w);
}

ll_status ll_workers_start(const ll_workers_config *config, ll_workers **workers)
{
    ll_workers *w = *workers = calloc(1, sizeof *w);
    if (!w)
        return ll_error(LL_NO_MEMORY, "out of memory: workers");
    w->config = *config;
    int wanted = config->threads > 0 ? config->threads : ll_cores();
    name_owner(w->owner);
    prepare(w);
    bool kept = pthread_create(&w->keeper, NULL, keep_leases, w) == 0;
    pthread_mutex_lock(&w->lock); /* the keeper reads the count */
    while (kept && w->count < wanted && w->count < THREADS_MAX) {
        worker_thread *b = &w->worker_threads[w->count];
        atomic_fetch_add(&w->alive, 1);
        if (pthread_create(&b->thread, NULL, work, b) != 0) {
            atomic_fetch_sub(&w->alive, 1);
            break;
        }
        w->count++;
    }
    pthread_mutex_unlock(&w->lock);
    if (w->count > 0)
        return ll_ok();
    if (kept)
        ll_workers_join(w);
    else
        clear_away(w);
    *workers = NULL;
    return ll_error(LL_NO_MEMORY, "cannot start worker threads");
}

int64_t ll_workers_runs(const ll_workers *w)
{
    return atomic_load_explicit(&w->runs, memory_order_relaxed);
}

bool ll_workers_busy(const ll_workers *w)
{
    return atomic_load(&w->alive) > 0;
}

void ll_workers_notify(ll_workers *w)
{
    pthread_mutex_lock(&w->lock);
    w->calls++;
    pthread_cond_broadcast(&w->wake);
    pthread_mutex_unlock(&w->lock);
}

ll_status ll_workers_join(ll_workers *w)
{
    for (int i = 0; i < w->count; i++)
        pthread_join(w->worker_threads[i].thread, NULL);
    pthread_mutex_lock(&w->lock);
    w->over = true;
    pthread_mutex_unlock(&w->lock);
    ll_workers_notify(w);
    pthread_join(w->keeper, NULL);
    ll_status status = w->error;
    clear_away(w);
    return status;
}

void ll_workers_request_stop(ll_workers *w)
{
    pthread_mutex_lock(&w->lock);
    atomic_store(&w->stopping, true);
    for (int i = 0; i < w->count; i++)
        atomic_store(&w->worker_threads[i].drop, true);
    pthread_mutex_unlock(&w->lock);
    ll_workers_notify(w);
}

ll_status ll_workers_stop(ll_workers *w)
{
    ll_workers_request_stop(w);
    return ll_workers_join(w);
}
