/* The queue of records and the thread that writes it. */
#include "daemon/store/store.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/assert.h"
#include "base/vtime.h"
#include "daemon/store/internal.h"
#include "daemon/support/log.h"
#include "threads/clock.h"

const double ll_store_time_limits[LL_STORE_TIMES - 1] = {0.0005, 0.001, 0.002, 0.005, 0.01, 0.02,
                                                         0.05,   0.1,   0.2,   0.5,   1};

enum { RETRY_S = 1, HOOKS = 2 }; /* RETRY_S: after a failed commit */

typedef struct hook {
    void (*notify)(void *context);
    void *context;
} hook;

struct ll_store {
    ll_database *database;
    pthread_t thread;

    pthread_mutex_t lock; /* guards all members below */
    pthread_cond_t queued, done;
    record *first, *last;
    uint64_t ticket, durable;
    uint64_t dropped_after, dropped_to; /* tickets at the last failure */
    int64_t next_number;
    ll_store_stats stats;
    bool closing, failing;
    ll_status why;
    int64_t failing_since, refused_before; /* when it began to fail: ns, and what was refused until then */
    hook hooks[HOOKS];
};

/* ---- the writer thread ---- */

static void free_records(record *r)
{
    while (r) {
        record *next = r->next;
        free(r);
        r = next;
    }
}

static void wait_to_retry(ll_store *store)
{
    struct timespec until = ll_deadline(CLOCK_MONOTONIC, (int64_t)RETRY_S * 1000000000);
    while (!store->closing && pthread_cond_timedwait(&store->queued, &store->lock, &until) != ETIMEDOUT)
        ;
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

static bool is_droppable(const record *r)
{
    return r->type == RECORD_TEXT || r->type == RECORD_DELETE_TEXT || r->type == RECORD_TRY_DELETE;
}

/* Removes from the queue what is not tried again. Locked. */
static void drop_some(ll_store *store)
{
    store->dropped_after = store->durable;
    store->dropped_to = store->ticket;
    store->last = NULL;
    for (record **link = &store->first; *link;) {
        record *r = *link;
        if (is_droppable(r)) {
            *link = r->next;
            free(r);
            store->stats.queued--;
        } else {
            store->last = r;
            link = &r->next;
        }
    }
}

/* One line when it begins to fail and one when it works again. Locked. */
static void log_change(ll_store *store, const ll_status *status)
{
    bool failing = ll_failed(status);
    if (failing && !store->failing) {
        store->failing_since = ll_now_ns();
        store->refused_before = store->stats.refused;
        ll_log_write("error", "the store fails", "%s Changes are refused until it works again.",
                     status->text);
    } else if (!failing && store->failing) {
        ll_log_write("warn", "the store works again", "It failed for %.1f s; %lld changes were refused.",
                     ll_to_s(ll_now_ns() - store->failing_since),
                     (long long)(store->stats.refused - store->refused_before));
    }
}

/* Locked. */
static void settle(ll_store *store, record *batch, record *last, uint64_t ticket, int64_t size,
                   ll_status status)
{
    log_change(store, &status);
    store->failing = ll_failed(&status);
    store->why = status;
    if (store->failing) { /* back to the front of the queue, in order */
        if (last) {
            last->next = store->first;
            store->first = batch;
        }
        drop_some(store);
        store->stats.failures++;
    } else {
        LL_ASSERT(ticket >= store->durable && size <= store->stats.queued); /* in the order of the queue */
        store->durable = ticket;
        store->stats.commits++;
        store->stats.queued -= size;
    }
    pthread_cond_broadcast(&store->done);
}

/* After a failure, room for more than what is queued is tried first: otherwise small records would still fit
 * on a full disk, and larger ones fail again. */
static ll_status commit(ll_store *store, const record *batch, bool try_room)
{
    int64_t bytes = 0;
    for (const record *r = batch; r; r = r->next)
        bytes += (int64_t)r->size;
    if (try_room)
        LL_TRY(ll_database_try_room(store->database, bytes));
    return ll_database_commit(store->database, batch);
}

/* The lock is held at the call and at the return. */
static void write_batch(ll_store *store)
{
    record *batch = store->first, *last = store->last;
    LL_ASSERT(!last || last->next == NULL);
    uint64_t ticket = store->ticket;
    int64_t size = store->stats.queued;
    bool try_room = store->failing && !store->closing;
    store->first = store->last = NULL;
    pthread_mutex_unlock(&store->lock);
    int64_t from = ll_now_ns();
    ll_status status = commit(store, batch, try_room);
    int64_t ns = ll_now_ns() - from;
    pthread_mutex_lock(&store->lock);
    settle(store, batch, last, ticket, size, status);
    count_time(store, ns);
    hook hooks[HOOKS];
    memcpy(hooks, store->hooks, sizeof hooks);
    pthread_mutex_unlock(&store->lock);
    if (!ll_failed(&status))
        free_records(batch);
    for (int i = 0; i < HOOKS; i++)
        if (hooks[i].notify)
            hooks[i].notify(hooks[i].context);
    pthread_mutex_lock(&store->lock);
}

static void *write_all(void *argument)
{
    ll_store *store = argument;
    pthread_setname_np(pthread_self(), "store");
    pthread_mutex_lock(&store->lock);
    for (;;) {
        while (!store->first && !store->closing && !store->failing)
            pthread_cond_wait(&store->queued, &store->lock);
        if (!store->first && store->closing)
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

static void free_store(ll_store *store)
{
    ll_database_close(store->database);
    free_records(store->first);
    pthread_mutex_destroy(&store->lock);
    pthread_cond_destroy(&store->queued);
    pthread_cond_destroy(&store->done);
    free(store);
}

ll_status ll_store_open(const char *directory, ll_store **result)
{
    *result = NULL;
    ll_database *database;
    LL_TRY(ll_database_open(directory, &database));
    ll_store *store = calloc(1, sizeof *store);
    if (!store) {
        ll_database_close(database);
        return ll_error(LL_NO_MEMORY, "out of memory: store");
    }
    store->database = database;
    store->next_number = ll_database_highest_number(database) + 1;
    store->why = ll_database_writable(database);
    log_change(store, &store->why);
    store->failing = ll_failed(&store->why);
    pthread_mutex_init(&store->lock, NULL);
    ll_cond_init(&store->queued);
    pthread_cond_init(&store->done, NULL);
    if (pthread_create(&store->thread, NULL, write_all, store) != 0) {
        free_store(store);
        return ll_error(LL_NO_MEMORY, "cannot start store thread");
    }
    *result = store;
    return ll_ok();
}

ll_status ll_store_close(ll_store *store)
{
    if (!store)
        return ll_ok();
    pthread_mutex_lock(&store->lock);
    store->closing = true;
    pthread_cond_broadcast(&store->queued);
    pthread_mutex_unlock(&store->lock);
    pthread_join(store->thread, NULL);
    ll_status status = store->first ? store->why : ll_ok();
    free_store(store);
    return status;
}

/* ---- reading ---- */

ll_status ll_store_list(ll_store *store, void (*each)(void *context, const ll_stored *stored), void *context)
{
    return store ? ll_database_list(store->database, each, context) : ll_ok();
}

ll_status ll_store_list_texts(ll_store *store, ll_store_text kind,
                              void (*each)(void *context, const char *id, int64_t seen_ms, const char *text),
                              void *context)
{
    return store ? ll_database_list_texts(store->database, kind, each, context) : ll_ok();
}

ll_status ll_store_read_log(ll_store *store, int64_t number, char **text, size_t *length)
{
    LL_ASSERT(store);
    *text = NULL;
    *length = 0;
    return ll_database_read_log(store->database, number, text, length);
}

int64_t ll_store_new_number(ll_store *store)
{
    if (!store)
        return 0;
    pthread_mutex_lock(&store->lock);
    int64_t number = store->next_number++;
    pthread_mutex_unlock(&store->lock);
    return number;
}

/* ---- queueing ---- */

static record *new_record(record_type type, int64_t number, int64_t index, const void *bytes, size_t size)
{
    record *r = malloc(sizeof *r + size);
    LL_ASSERT(r); /* without this line the log would be incomplete */
    *r = (record){.type = type, .number = number, .index = index, .size = size};
    if (size > 0)
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

uint64_t ll_store_submit(ll_store *store, ll_store_batch *batch)
{
    ll_store_batch taken = *batch;
    *batch = (ll_store_batch){0};
    if (!store || !taken.first) {
        free_records(taken.first);
        return 0;
    }
    pthread_mutex_lock(&store->lock);
    if (store->failing && is_droppable(taken.first)) {
        pthread_mutex_unlock(&store->lock);
        free_records(taken.first);
        return 0;
    }
    if (store->last)
        store->last->next = taken.first;
    else
        store->first = taken.first;
    store->last = taken.last;
    store->stats.queued += taken.count;
    uint64_t ticket = store->ticket += (uint64_t)taken.count;
    pthread_cond_signal(&store->queued);
    pthread_mutex_unlock(&store->lock);
    return ticket;
}

static uint64_t enqueue(ll_store *store, record_type type, int64_t number, int64_t index, const void *bytes,
                        size_t size)
{
    if (!store)
        return 0;
    ll_store_batch one = {0};
    append(&one, new_record(type, number, index, bytes, size));
    return ll_store_submit(store, &one);
}

void ll_store_batch_line(ll_store_batch *batch, int64_t number, int64_t index, const char *line,
                         size_t length)
{
    append(batch, new_record(RECORD_LINE, number, index, line, length));
}

void ll_store_batch_put(ll_store_batch *batch, const ll_stored *stored)
{
    append(batch, new_record(RECORD_ROW, stored->number, 0, stored, sizeof *stored));
}

void ll_store_batch_free(ll_store_batch *batch)
{
    free_records(batch->first);
    *batch = (ll_store_batch){0};
}

uint64_t ll_store_put(ll_store *store, const ll_stored *stored)
{
    return enqueue(store, RECORD_ROW, stored->number, 0, stored, sizeof *stored);
}

uint64_t ll_store_line(ll_store *store, int64_t number, int64_t index, const char *line, size_t length)
{
    return enqueue(store, RECORD_LINE, number, index, line, length);
}

uint64_t ll_store_delete(ll_store *store, int64_t number)
{
    return enqueue(store, RECORD_DELETE, number, 0, NULL, 0);
}

uint64_t ll_store_try_delete(ll_store *store, int64_t number)
{
    return enqueue(store, RECORD_TRY_DELETE, number, 0, NULL, 0);
}

uint64_t ll_store_put_text(ll_store *store, ll_store_text kind, const char *id, int64_t seen_ms,
                           const char *text)
{
    size_t length = strlen(text);
    char *bytes = store ? malloc(LL_ID_LENGTH + 1 + length) : NULL;
    if (!bytes)
        return 0;
    snprintf(bytes, LL_ID_LENGTH + 1, "%s", id);
    memcpy(bytes + LL_ID_LENGTH + 1, text, length);
    uint64_t ticket = enqueue(store, RECORD_TEXT, kind, seen_ms, bytes, LL_ID_LENGTH + 1 + length);
    free(bytes);
    return ticket;
}

uint64_t ll_store_delete_text(ll_store *store, ll_store_text kind, const char *id)
{
    return enqueue(store, RECORD_DELETE_TEXT, kind, 0, id, strlen(id) + 1);
}

/* ---- what became of it ---- */

ll_status ll_store_wait(ll_store *store, uint64_t ticket)
{
    if (!store)
        return ll_ok();
    pthread_mutex_lock(&store->lock);
    while (ticket > store->durable && !store->failing)
        pthread_cond_wait(&store->done, &store->lock);
    ll_status status = ticket > store->durable ? store->why : ll_ok();
    store->stats.refused += ll_failed(&status);
    pthread_mutex_unlock(&store->lock);
    return status;
}

ll_status ll_store_wait_tried(ll_store *store, uint64_t ticket)
{
    LL_TRY(ll_store_wait(store, ticket));
    if (!store)
        return ll_ok();
    pthread_mutex_lock(&store->lock); /* it may work again by now */
    bool dropped = ticket == 0 || (ticket > store->dropped_after && ticket <= store->dropped_to);
    ll_status why = store->failing ? store->why : ll_error(LL_IO, "The store failed for a moment.");
    store->stats.refused += dropped;
    pthread_mutex_unlock(&store->lock);
    return dropped ? why : ll_ok();
}

ll_status ll_store_check(ll_store *store)
{
    ll_status why;
    if (!ll_store_failing(store, &why))
        return ll_ok();
    pthread_mutex_lock(&store->lock);
    store->stats.refused++;
    pthread_mutex_unlock(&store->lock);
    return ll_error(why.code, "Storage unavailable; change rejected: %.180s", why.text);
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
    int i = 0;
    while (i < HOOKS - 1 && store->hooks[i].notify)
        i++;
    store->hooks[i] = (hook){notify, context};
    pthread_mutex_unlock(&store->lock);
}
