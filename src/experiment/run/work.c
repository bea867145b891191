#include "experiment/run/work.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "base/assert.h"
#include "base/hash.h"
#include "experiment/spec/until.h"
#include "threads/clock.h"

enum { RETRY_EVERY_S = 1 };

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
} worker_thread;

struct ll_workers {
    ll_workers_config config;
    worker_thread worker_threads[LL_CLAIMS_MAX];
    int count;
    _Atomic int64_t runs;
    atomic_int alive;
    atomic_bool stopping;
    pthread_mutex_t lock; /* guards all members below */
    pthread_cond_t wake;
    uint64_t calls;
    ll_status error;
};

int ll_cores(void)
{
    cpu_set_t set;
    int allowed = sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
    return allowed < LL_CLAIMS_MAX ? allowed : LL_CLAIMS_MAX;
}

static int64_t share(int64_t runs, int64_t parts)
{
    return (runs + parts - 1) / parts;
}

/* As few chunks as keep all threads busy to the end: finishing a chunk takes the time of many short runs.
 * With an `until` rule a chunk has whole points, since whether a run is made depends on the earlier ones of
 * its point. */
int64_t ll_experiment_chunk(const ll_experiment *experiment, int64_t runs)
{
    enum { CHUNKS = 128, LARGEST = 5000 };
    int64_t chunk = share(runs, CHUNKS), repeats = experiment->head.repeats;
    chunk = chunk < 1 ? 1 : chunk < LARGEST ? chunk : LARGEST;
    return ll_until_is_set(experiment) ? share(chunk, repeats) * repeats : chunk;
}

/* Returns the length of the id without its version, which is the same for all versions. */
static int name_experiment(const ll_experiment *experiment, int64_t from, int64_t to,
                           char id[LL_EXPERIMENT_ID_MAX + 1])
{
    int length = snprintf(id, LL_EXPERIMENT_ID_MAX + 1, "%016" PRIx64 "-%" PRId64 "-%" PRId64 "-",
                          ll_experiment_key(experiment), from, to);
    snprintf(id + length, (size_t)(LL_EXPERIMENT_ID_MAX + 1 - length), "%08" PRIx32,
             (uint32_t)ll_hash(0, ll_version, strlen(ll_version)));
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
    r.common = name_experiment(experiment, from, to, r.id);
    ll_status status = ll_result_store_list(store, note_rival, &r);
    if (!ll_failed(&status) && r.version[0])
        status = ll_error(LL_CONFLICT,
                          "laglab %s has started this experiment in the store; results of this one, %s, may "
                          "differ: continue with that version, or run all again with %s",
                          r.version, ll_version, "--anew");
    return status;
}

ll_status ll_experiment_register(ll_result_store *store, const ll_experiment *experiment, int64_t from,
                                 int64_t to, char id[LL_EXPERIMENT_ID_MAX + 1])
{
    ll_experiment_record record = {.from = from, .to = to};
    name_experiment(experiment, from, to, record.id);
    memcpy(id, record.id, sizeof record.id);
    char *text = ll_experiment_text(experiment);
    if (!text)
        return ll_error(LL_NO_MEMORY, "out of memory: experiment");
    ll_status status =
        ll_result_store_create(store, &record, text, ll_experiment_chunk(experiment, to - from));
    free(text);
    return status;
}

/* Waits until there are more than `calls` calls; `retry`: at most for RETRY_EVERY_S. */
static void rest(ll_workers *w, uint64_t calls, bool retry)
{
    struct timespec until = ll_deadline(CLOCK_MONOTONIC, RETRY_EVERY_S * LL_SECOND);
    pthread_mutex_lock(&w->lock);
    int waited = 0;
    while (calls == w->calls && waited == 0 && !atomic_load(&w->stopping))
        waited = retry ? pthread_cond_timedwait(&w->wake, &w->lock, &until)
                       : pthread_cond_wait(&w->wake, &w->lock);
    pthread_mutex_unlock(&w->lock);
}

static uint64_t calls_so_far(ll_workers *w)
{
    pthread_mutex_lock(&w->lock);
    uint64_t calls = w->calls;
    pthread_mutex_unlock(&w->lock);
    return calls;
}

/* ---- a chunk ---- */

static ll_status load(worker_thread *b, const char *id)
{
    char *text = NULL;
    cJSON *json = NULL;
    if (b->experiment && strcmp(b->id, id) == 0)
        return ll_ok();
    ll_experiment_free(b->experiment);
    b->experiment = NULL;
    ll_status status = ll_result_store_specification(b->workers->config.store, id, &text);
    LL_THEN(status, ll_json_parse(text, strlen(text), &json));
    LL_THEN(status, ll_experiment_parse(json, NULL, NULL, &b->experiment));
    if (!ll_failed(&status))
        snprintf(b->id, sizeof b->id, "%s", id);
    cJSON_Delete(json);
    free(text);
    return status;
}

static bool is_wanted(void *context)
{
    const ll_workers *w = context;
    return !atomic_load_explicit(&w->stopping, memory_order_relaxed);
}

/* Makes a run, or the row of a skipped run if its point has enough. */
static ll_status run_or_skip(worker_thread *b, const ll_chunk *chunk, int64_t run,
                             const ll_interrupt *interrupt, bool *enough)
{
    LL_ASSERT(run >= chunk->from && run < chunk->to && chunk->to - chunk->from <= b->capacity);
    ll_row *row = &b->rows[run - chunk->from];
    int64_t repeat = run % b->experiment->head.repeats;
    *enough = *enough && repeat > 0;
    if (*enough) {
        ll_until_skip(run, row);
        return ll_ok();
    }
    ll_status status = ll_experiment_run(b->experiment, run, interrupt, &b->kept, row);
    if (!ll_failed(&status) && run - repeat >= chunk->from)
        *enough = ll_until_reached(b->experiment, row - repeat, repeat + 1, &b->resampler);
    return status;
}

static ll_status run_chunk(worker_thread *b, const ll_chunk *chunk)
{
    ll_workers *w = b->workers;
    ll_interrupt interrupt = {is_wanted, ll_now_ns, w};
    int64_t counted = 0;
    if (chunk->to - chunk->from > b->capacity) {
        free(b->rows);
        b->capacity = chunk->to - chunk->from;
        b->rows = malloc((size_t)b->capacity * sizeof *b->rows);
    }
    ll_status status = b->rows ? load(b, chunk->id) : ll_error(LL_NO_MEMORY, "out of memory: rows");
    bool enough = false; /* of the point */
    for (int64_t run = chunk->from; run < chunk->to && !ll_failed(&status); run++) {
        status = run_or_skip(b, chunk, run, &interrupt, &enough);
        atomic_fetch_add_explicit(&w->runs, 1, memory_order_relaxed);
        counted++;
    }
    if (ll_failed(&status))
        ll_result_store_return(w->config.store, chunk);
    else
        status = ll_result_store_finish(w->config.store, chunk, b->rows, b->experiment->metric_count);
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

/* Claims a chunk and runs it. `found`: there was one. */
static ll_status work_once(worker_thread *b, bool *found)
{
    ll_chunk chunk;
    ll_workers *w = b->workers;
    ll_status status = ll_result_store_claim(w->config.store, w->config.id, &chunk);
    *found = !ll_failed(&status) && chunk.chunk >= 0;
    return *found ? run_chunk(b, &chunk) : status;
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
        bool failed = ll_failed(&status) && status.code != LL_INTERRUPTED &&
                      status.code != LL_NOT_FOUND; /* the experiment was deleted */
        if (failed)
            keep_error(w, &status);
        if (w->config.drain && (failed || !found))
            break;
        if (failed || !found) {
            ll_kept_block_free(&b->kept);
            rest(w, calls, failed);
        }
    }
    ll_kept_block_free(&b->kept);
    ll_experiment_free(b->experiment);
    ll_resampler_free(&b->resampler);
    free(b->rows);
    atomic_fetch_sub(&w->alive, 1);
    return NULL;
}

static void prepare(ll_workers *w)
{
    pthread_mutex_init(&w->lock, NULL);
    ll_cond_init(&w->wake);
    for (int i = 0; i < LL_CLAIMS_MAX; i++)
        w->worker_threads[i].workers = w;
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
    prepare(w);
    while (w->count < wanted && w->count < LL_CLAIMS_MAX) {
        worker_thread *b = &w->worker_threads[w->count];
        atomic_fetch_add(&w->alive, 1);
        if (pthread_create(&b->thread, NULL, work, b) != 0) {
            atomic_fetch_sub(&w->alive, 1);
            break;
        }
        w->count++;
    }
    if (w->count > 0)
        return ll_ok();
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
    ll_status status = w->error;
    clear_away(w);
    return status;
}

void ll_workers_request_stop(ll_workers *w)
{
    atomic_store(&w->stopping, true);
    ll_workers_notify(w);
}

ll_status ll_workers_stop(ll_workers *w)
{
    ll_workers_request_stop(w);
    return ll_workers_join(w);
}
