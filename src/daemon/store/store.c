/* The queue of records, the thread that writes it, and what does not depend on the kind of store. */
#include "daemon/store/store.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/assert.h"
#include "daemon/store/internal.h"

const double ll_store_time_limits[LL_STORE_TIMES - 1] = {0.0005, 0.001, 0.002, 0.005, 0.01, 0.02,
                                                         0.05,   0.1,   0.2,   0.5,   1};

enum { WAIT_MS = 100 }; /* between two checks of the lease */

static int64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* ---- the writer thread ---- */

static void free_records(record *r)
{
    while (r) {
        record *next = r->next;
        free(r);
        r = next;
    }
}

static struct timespec after_ms(int64_t ms)
{
    int64_t at = now_ns() + ms * 1000000;
    return (struct timespec){.tv_sec = at / 1000000000, .tv_nsec = at % 1000000000};
}

static void wait_to_retry(ll_store *store)
{
    struct timespec until = after_ms(store->kind->retry_ms);
    while (!store->closing && pthread_cond_timedwait(&store->queued, &store->lock, &until) != ETIMEDOUT)
        ;
}

/* Locked. Returns what was queued. */
static record *lose_queue(ll_store *store)
{
    record *queue = store->first;
    if (store->ticket > store->durable)
        store->lost[store->losses++ % LOST_RANGES] = (lost_range){store->durable + 1, store->ticket};
    store->first = store->last = NULL;
    store->stats.queued = 0;
    store->daemon = 0;
    store->failing = false;
    pthread_cond_broadcast(&store->done);
    return queue;
}

/* Calls the hook of commits, without the lock. */
static void call_hook(ll_store *store)
{
    pthread_mutex_lock(&store->lock);
    void (*hook)(void *context) = store->notify;
    void *context = store->notify_context;
    pthread_mutex_unlock(&store->lock);
    if (hook)
        hook(context);
}

void ll_store_fence(ll_store *store, int64_t daemon)
{
    record *queue = NULL;
    pthread_mutex_lock(&store->lock);
    bool present = store->daemon == daemon && daemon != 0;
    if (present)
        queue = lose_queue(store);
    pthread_mutex_unlock(&store->lock);
    free_records(queue);
    if (!present)
        return;
    store->kind->shared->fenced(store);
    call_hook(store);
}

static void count_time(ll_store *store, int64_t ns)
{
    double s = (double)ns * 1e-9;
    int bin = 0;
    while (bin < LL_STORE_TIMES - 1 && s > ll_store_time_limits[bin])
        bin++;
    store->stats.times[bin]++;
    store->stats.commit_s += s;
}

/* Locked. */
static void settle(ll_store *store, record *batch, record *last, uint64_t ticket, int64_t size,
                   ll_status status)
{
    store->failing = ll_failed(&status);
    store->why = status;
    if (store->failing) { /* back to the front of the queue, in order */
        last->next = store->first;
        store->first = batch;
        store->last = store->last ? store->last : last;
        store->stats.failures++;
    } else {
        LL_ASSERT(ticket >= store->durable && size <= store->stats.queued); /* in the order of the queue */
        store->durable = ticket;
        store->stats.commits++;
        store->stats.queued -= size;
    }
    pthread_cond_broadcast(&store->done);
}

/* The lock is held at the call and at the return. */
static void write_batch(ll_store *store)
{
    record *batch = store->first, *last = store->last;
    LL_ASSERT(batch != NULL && last != NULL && last->next == NULL);
    uint64_t ticket = store->ticket;
    int64_t size = store->stats.queued, daemon = store->daemon;
    store->first = store->last = NULL;
    pthread_mutex_unlock(&store->lock);
    int64_t from = now_ns();
    ll_status status = store->kind->commit(store, batch, daemon);
    int64_t ns = now_ns() - from;
    bool fenced = status.code == LL_CONFLICT;
    if (fenced)
        ll_store_fence(store, daemon);
    pthread_mutex_lock(&store->lock);
    /* Fenced by this commit or, while it was under way, by the lease thread: the batch is lost. */
    bool lost = fenced || store->daemon != daemon;
    if (!lost) {
        settle(store, batch, last, ticket, size, status);
        count_time(store, ns);
    }
    pthread_mutex_unlock(&store->lock);
    if (lost || !ll_failed(&status))
        free_records(batch);
    call_hook(store);
    pthread_mutex_lock(&store->lock);
}

static void *write_all(void *argument)
{
    ll_store *store = argument;
    pthread_setname_np(pthread_self(), "store");
    pthread_mutex_lock(&store->lock);
    for (;;) {
        while (!store->first && !store->closing)
            pthread_cond_wait(&store->queued, &store->lock);
        if (!store->first)
            break;
        bool last_try = store->closing;
        write_batch(store);
        if (store->failing && last_try)
            break;
        if (store->failing)
            wait_to_retry(store);
    }
    pthread_mutex_unlock(&store->lock);
    return NULL;
}

/* ---- start and end ---- */

void ll_store_init(ll_store *store, const ll_store_kind *kind)
{
    store->kind = kind;
    pthread_mutex_init(&store->lock, NULL);
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&store->queued, &monotonic);
    pthread_cond_init(&store->done, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

ll_status ll_store_start(ll_store *store)
{
    store->started = pthread_create(&store->thread, NULL, write_all, store) == 0;
    return store->started ? ll_ok() : ll_error(LL_NO_MEMORY, "cannot start store thread");
}

void ll_store_end(ll_store *store)
{
    free_records(store->first);
    pthread_mutex_destroy(&store->lock);
    pthread_cond_destroy(&store->queued);
    pthread_cond_destroy(&store->done);
}

ll_status ll_store_close(ll_store *store)
{
    if (!store)
        return ll_ok();
    pthread_mutex_lock(&store->lock);
    store->closing = true;
    pthread_cond_broadcast(&store->queued);
    pthread_mutex_unlock(&store->lock);
    if (store->started)
        pthread_join(store->thread, NULL);
    ll_status status = store->failing ? store->why : ll_ok();
    store->kind->close(store);
    return status;
}

/* ---- reading ---- */

ll_status ll_store_list(ll_store *store, void (*each)(void *context, const ll_stored *stored), void *context)
{
    return store ? store->kind->list(store, each, context) : ll_ok();
}

ll_status ll_store_list_classes(ll_store *store,
                                void (*each)(void *context, const char *id, int64_t seen_ms,
                                             const char *text),
                                void *context)
{
    return store ? store->kind->list_classes(store, each, context) : ll_ok();
}

ll_status ll_store_read_log(ll_store *store, int64_t number, char **text, size_t *length)
{
    LL_ASSERT(store);
    *text = NULL;
    *length = 0;
    return store->kind->read_log(store, number, text, length);
}

bool ll_store_add_line(log_text *log, const void *line, size_t size)
{
    if (log->length + size + 2 > log->capacity) {
        size_t wanted = (log->length + size + 2) * 2;
        char *bigger = realloc(log->text, wanted);
        if (!bigger)
            return false;
        log->text = bigger;
        log->capacity = wanted;
    }
    memcpy(log->text + log->length, line, size);
    log->length += size;
    log->text[log->length++] = '\n';
    log->text[log->length] = '\0';
    return true;
}

ll_status ll_store_end_log(log_text *log, ll_status status, const char *where, char **text, size_t *length)
{
    if (!ll_failed(&status) && !log->text)
        status = ll_error(LL_IO, "Log of a stored session in %.150s is empty.", where);
    if (ll_failed(&status)) {
        free(log->text);
        return status;
    }
    *text = log->text;
    *length = log->length;
    return status;
}

/* Locked. */
static bool take_number(ll_store *store, ll_store_place *place)
{
    if (store->next_number == store->past_number)
        return false;
    *place = (ll_store_place){store->next_number++, store->daemon};
    return true;
}

ll_status ll_store_new_place(ll_store *store, ll_store_place *place)
{
    *place = (ll_store_place){0};
    if (!store)
        return ll_ok();
    pthread_mutex_lock(&store->lock);
    bool taken = take_number(store, place);
    pthread_mutex_unlock(&store->lock);
    while (!taken) {
        int64_t first, past;
        LL_TRY(store->kind->new_numbers(store, &first, &past)); /* unlocked: it may take long */
        pthread_mutex_lock(&store->lock);
        if (store->next_number == store->past_number) {
            store->next_number = first;
            store->past_number = past;
        }
        taken = take_number(store, place);
        pthread_mutex_unlock(&store->lock);
    }
    return ll_ok();
}

/* ---- queueing ---- */

static record *new_record(record_type type, ll_store_place place, int64_t index, const void *bytes,
                          size_t size)
{
    record *r = malloc(sizeof *r + size);
    LL_ASSERT(r); /* without this line the log would be incomplete */
    *r = (record){.type = type, .place = place, .index = index, .size = size};
    if (bytes)
        memcpy(r->bytes, bytes, size);
    return r;
}

static void append(ll_store_batch *batch, record *r)
{
    if (batch->last)
        batch->last->next = r;
    else
        batch->first = r;
    batch->last = r;
    batch->count++;
}

/* Records of a shared store belong to an incarnation; all of a batch to the same. */
uint64_t ll_store_submit(ll_store *store, ll_store_batch *batch)
{
    ll_store_batch taken = *batch;
    *batch = (ll_store_batch){0};
    if (!store || !taken.first) {
        free_records(taken.first);
        return 0;
    }
    uint64_t ticket = LL_STORE_LOST_TICKET;
    pthread_mutex_lock(&store->lock);
    bool valid = !store->kind->shared || (taken.first->place.daemon == store->daemon && store->daemon != 0);
    if (valid) {
        if (store->last)
            store->last->next = taken.first;
        else
            store->first = taken.first;
        store->last = taken.last;
        store->stats.queued += taken.count;
        ticket = store->ticket += (uint64_t)taken.count;
        pthread_cond_signal(&store->queued);
    }
    pthread_mutex_unlock(&store->lock);
    if (!valid)
        free_records(taken.first);
    return ticket;
}

static uint64_t enqueue(ll_store *store, record_type type, ll_store_place place, int64_t index,
                        const void *bytes, size_t size)
{
    if (!store)
        return 0;
    ll_store_batch one = {0};
    append(&one, new_record(type, place, index, bytes, size));
    return ll_store_submit(store, &one);
}

void ll_store_batch_line(ll_store_batch *batch, ll_store_place place, int64_t index, const char *line,
                         size_t length)
{
    append(batch, new_record(RECORD_LINE, place, index, line, length));
}

void ll_store_batch_put(ll_store_batch *batch, const ll_stored *stored)
{
    append(batch, new_record(RECORD_ROW, stored->place, 0, stored, sizeof *stored));
}

/* Name, NUL, text. */
static record *new_answer(record_type type, const ll_answer_key *key, const char *text)
{
    size_t length = strlen(text);
    record *r = new_record(type, (ll_store_place){.daemon = key->daemon}, 0, NULL, LL_ANSWER_HEX + length);
    memcpy(r->bytes, key->name, LL_ANSWER_HEX);
    memcpy(r->bytes + LL_ANSWER_HEX, text, length);
    return r;
}

void ll_store_batch_answer(ll_store_batch *batch, const ll_answer_key *key, const char *text)
{
    append(batch, new_answer(RECORD_ANSWER, key, text));
}

uint64_t ll_store_release_answer(ll_store *store, const ll_answer_key *key)
{
    ll_store_batch one = {0};
    append(&one, new_answer(RECORD_FREE_ANSWER, key, ""));
    return ll_store_submit(store, &one);
}

void ll_store_batch_free(ll_store_batch *batch)
{
    free_records(batch->first);
    *batch = (ll_store_batch){0};
}

uint64_t ll_store_put(ll_store *store, const ll_stored *stored)
{
    return enqueue(store, RECORD_ROW, stored->place, 0, stored, sizeof *stored);
}

uint64_t ll_store_line(ll_store *store, ll_store_place place, int64_t index, const char *line, size_t length)
{
    return enqueue(store, RECORD_LINE, place, index, line, length);
}

uint64_t ll_store_delete(ll_store *store, ll_store_place place)
{
    return enqueue(store, RECORD_DELETE, place, 0, NULL, 0);
}

uint64_t ll_store_release(ll_store *store, ll_store_place place)
{
    return enqueue(store, RECORD_RELEASE, place, 0, NULL, 0);
}

uint64_t ll_store_put_state(ll_store *store, ll_store_place place, const ll_stored_state *state)
{
    return enqueue(store, RECORD_STATE, place, 0, state->bytes, state->size);
}

uint64_t ll_store_put_class(ll_store *store, int64_t daemon, const char *id, int64_t seen_ms,
                            const char *text)
{
    size_t length = strlen(text);
    char *bytes = store ? malloc(LL_ID_LENGTH + 1 + length) : NULL;
    if (!bytes)
        return 0;
    snprintf(bytes, LL_ID_LENGTH + 1, "%s", id);
    memcpy(bytes + LL_ID_LENGTH + 1, text, length);
    uint64_t ticket = enqueue(store, RECORD_CLASS, (ll_store_place){.daemon = daemon}, seen_ms, bytes,
                              LL_ID_LENGTH + 1 + length);
    free(bytes);
    return ticket;
}

uint64_t ll_store_delete_class(ll_store *store, int64_t daemon, const char *id)
{
    return enqueue(store, RECORD_DELETE_CLASS, (ll_store_place){.daemon = daemon}, 0, id, LL_ID_LENGTH + 1);
}

uint64_t ll_store_release_class(ll_store *store, int64_t daemon, const char *id)
{
    return enqueue(store, RECORD_RELEASE_CLASS, (ll_store_place){.daemon = daemon}, 0, id, LL_ID_LENGTH + 1);
}

/* ---- what became of it ---- */

/* Locked. */
static ll_store_outcome outcome_of(const ll_store *store, uint64_t ticket)
{
    int kept = store->losses < LOST_RANGES ? store->losses : LOST_RANGES;
    if (ticket == LL_STORE_LOST_TICKET)
        return LL_STORE_LOST;
    for (int i = 0; i < kept; i++) {
        if (ticket >= store->lost[i].from && ticket <= store->lost[i].to)
            return LL_STORE_LOST;
    }
    return ticket <= store->durable ? LL_STORE_DURABLE : LL_STORE_PENDING;
}

ll_store_outcome ll_store_get_outcome(ll_store *store, uint64_t ticket)
{
    if (!store)
        return LL_STORE_DURABLE;
    pthread_mutex_lock(&store->lock);
    ll_store_outcome outcome = outcome_of(store, ticket);
    pthread_mutex_unlock(&store->lock);
    return outcome;
}

/* Locked. A server that is there and does not answer fails no commit: the end of the lease ends the wait. */
static ll_status wait_a_while(ll_store *store)
{
    if (!store->kind->shared) {
        pthread_cond_wait(&store->done, &store->lock);
        return ll_ok();
    }
    struct timespec until = after_ms(WAIT_MS);
    pthread_cond_timedwait(&store->done, &store->lock, &until);
    return store->kind->shared->lease_left_s(store) > 0
               ? ll_ok()
               : ll_error(LL_UNAVAILABLE, "The store does not answer; it may still store this.");
}

ll_status ll_store_wait(ll_store *store, uint64_t ticket)
{
    if (!store)
        return ll_ok();
    pthread_mutex_lock(&store->lock);
    ll_status status = ll_ok();
    ll_store_outcome outcome;
    while ((outcome = outcome_of(store, ticket)) == LL_STORE_PENDING && !store->failing &&
           !ll_failed(&status))
        status = wait_a_while(store);
    if (outcome == LL_STORE_LOST)
        status = ll_error(LL_UNAVAILABLE, "This daemon has lost its lease on the session.");
    else if (outcome == LL_STORE_DURABLE)
        status = ll_ok();
    else if (store->failing)
        status = store->why;
    pthread_mutex_unlock(&store->lock);
    return status;
}

bool ll_store_failing(ll_store *store, ll_status *why)
{
    if (!store)
        return false;
    pthread_mutex_lock(&store->lock);
    bool failing = store->failing;
    if (failing && why)
        *why = store->why;
    pthread_mutex_unlock(&store->lock);
    return failing;
}

uint64_t ll_store_durable(ll_store *store)
{
    if (!store)
        return UINT64_MAX;
    pthread_mutex_lock(&store->lock);
    uint64_t durable = store->durable;
    pthread_mutex_unlock(&store->lock);
    return durable;
}

ll_store_stats ll_store_get_stats(ll_store *store)
{
    ll_store_stats stats = {0};
    if (!store)
        return stats;
    pthread_mutex_lock(&store->lock);
    stats = store->stats;
    pthread_mutex_unlock(&store->lock);
    return stats;
}

void ll_store_on_commit(ll_store *store, void (*notify)(void *context), void *context)
{
    if (!store)
        return;
    pthread_mutex_lock(&store->lock);
    store->notify = notify;
    store->notify_context = context;
    pthread_mutex_unlock(&store->lock);
}
