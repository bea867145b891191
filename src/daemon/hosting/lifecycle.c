/* A host from start to stop, and its statistics. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "daemon/hosting/session_entry.h"
#include "daemon/support/access.h"
#include "daemon/support/log.h"

static ll_session_entry *expired(ll_host *host, ll_time before)
{
    ll_session_entry *old = NULL;
    for (int i = 0; i < LL_HOST_BUCKETS && !old; i++) {
        for (ll_session_entry *session_entry = host->registry.by_id[i]; session_entry && !old;
             session_entry = session_entry->next_by_id)
            if (atomic_load(&session_entry->shared.last_used) < before &&
                ll_session_entry_viewers(session_entry) == 0)
                old = session_entry;
    }
    if (old)
        ll_session_entry_retain(old);
    return old;
}

static void expire(ll_host *host)
{
    ll_time before = ll_now_ns() - (ll_time)(host->config.session_ttl_s * 1e9);
    for (;;) {
        pthread_mutex_lock(&host->registry.lock);
        ll_session_entry *old = host->registry.stopping ? NULL : expired(host, before);
        pthread_mutex_unlock(&host->registry.lock);
        if (!old)
            return;
        ll_status status = ll_host_delete(host, old, NULL);
        ll_session_entry_release(old);
        if (ll_failed(&status))
            return; /* the store fails: try again later */
        atomic_fetch_add(&host->counts.expired, 1);
    }
}

static void *reap_expired(void *argument)
{
    ll_host *host = argument;
    pthread_setname_np(pthread_self(), "reaper");
    double period_s = host->config.session_ttl_s / 4;
    ll_time period = (ll_time)((period_s > 30 ? 30 : period_s) * 1e9);
    pthread_mutex_lock(&host->registry.lock);
    while (!host->registry.stopping) {
        struct timespec deadline = ll_deadline(CLOCK_MONOTONIC, period);
        while (!host->registry.stopping &&
               pthread_cond_timedwait(&host->registry.stop, &host->registry.lock, &deadline) == 0)
            ;
        pthread_mutex_unlock(&host->registry.lock);
        expire(host); /* nothing, if it stops */
        pthread_mutex_lock(&host->registry.lock);
    }
    pthread_mutex_unlock(&host->registry.lock);
    return NULL;
}

static void add_stored(void *context, const ll_stored *stored)
{
    ll_host *host = context;
    if (stored->lines == 0 || stored->key_count < 1 || !ll_is_id(stored->id) || !ll_is_code(stored->code)) {
        ll_log_write("warn", "stored session left out", "Session %lld has no log or no key.",
                     (long long)stored->number);
        return;
    }
    ll_session_entry *session_entry = ll_session_entry_new(host);
    if (!session_entry)
        return;
    ll_entry_stored *mine = &session_entry->stored;
    mine->number = stored->number;
    mine->playing = stored->playing;
    mine->speed = stored->speed;
    mine->tick = stored->tick;
    mine->head_tick = stored->head_tick;
    mine->lines = stored->lines;
    ll_session_entry_set_class_key(session_entry,
                                   ll_access_named_key(host->config.access, stored->class_key));
    ll_session_entry_count_log(session_entry, stored->log_bytes);
    session_entry->identity.created_ms = stored->created_ms;
    if (!ll_session_entry_set_keys(session_entry, stored->keys, stored->key_count)) {
        ll_session_entry_release(session_entry);
        return;
    }
    memcpy(session_entry->identity.id, stored->id, sizeof session_entry->identity.id);
    memcpy(session_entry->identity.code, stored->code, sizeof session_entry->identity.code);
    int64_t idle_ms = ll_unix_ms() - stored->seen_ms;
    atomic_store(&session_entry->shared.last_used, host->started - (idle_ms > 0 ? idle_ms : 0) * LL_MS);
    if (!ll_host_register(host, session_entry))
        ll_log_write("warn", "stored session left out", "There are more than --max-sessions.");
    ll_session_entry_release(session_entry);
}

/* Memory of the machine, or of the container if less. */
static int64_t available_memory(void)
{
    static const char *const limits[] = {"/sys/fs/cgroup/memory.max",
                                         "/sys/fs/cgroup/memory/memory.limit_in_bytes"};
    int64_t bytes = (int64_t)sysconf(_SC_PHYS_PAGES) * sysconf(_SC_PAGESIZE), most;
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        FILE *f = fopen(limits[i], "r");
        if (f && fscanf(f, "%" SCNd64, &most) == 1 && most < bytes) /* cgroup files have `max` for no limit */
            bytes = most;
        if (f)
            fclose(f);
    }
    return bytes;
}

ll_status ll_host_create(const ll_host_config *config, ll_store *store, ll_tasks *tasks, ll_host **result)
{
    *result = NULL;
    ll_host *host = calloc(1, sizeof *host);
    if (!host)
        return ll_error(LL_NO_MEMORY, "out of memory: hosting");
    host->config = *config;
    host->store = store;
    host->tasks = tasks;
    host->started = ll_now_ns();
    host->replies.end = &host->replies.first;
    pthread_mutex_init(&host->registry.lock, NULL);
    pthread_mutex_init(&host->replies.lock, NULL);
    ll_cond_init(&host->registry.stop);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    host->worker_count = config->threads > 0 ? (int)config->threads : cores > 0 ? (int)cores : 1;
    host->usage.memory_max =
        config->max_memory_mib > 0 ? config->max_memory_mib << 20 : available_memory() / 4 * 3;
    host->workers = calloc((size_t)host->worker_count, sizeof *host->workers);
    for (int i = 0; host->workers && i < host->worker_count; i++)
        ll_worker_init(host, &host->workers[i], i);
    host->creations =
        ll_rate_limits_new(config->max_new_sessions_per_min / 60, config->max_new_sessions_per_min);
    host->lookups =
        ll_rate_limits_new(config->max_code_lookups_per_min / 60, config->max_code_lookups_per_min);
    ll_status status = host->workers && host->creations && host->lookups
                           ? ll_store_list(store, add_stored, host)
                           : ll_error(LL_NO_MEMORY, "out of memory: hosting");
    if (ll_failed(&status)) {
        ll_host_free(host);
        return status;
    }
    ll_store_on_commit(store, ll_host_send_replies, host);
    *result = host;
    return ll_ok();
}

ll_status ll_host_start(ll_host *host, ll_ws *ws)
{
    ll_ws_hooks hooks = ll_viewers_hooks(host);
    host->ws = ws;
    ll_ws_set_hooks(ws, LL_STREAM_SESSION, &hooks);
    for (int i = 0; i < LL_HOST_BUCKETS; i++) {
        for (ll_session_entry *session_entry = host->registry.by_id[i]; session_entry;
             session_entry = session_entry->next_by_id) {
            ll_session_entry_retain(session_entry); /* for the stream */
            LL_TRY(ll_ws_stream_open(ws, LL_STREAM_SESSION, session_entry->identity.id, session_entry,
                                     &session_entry->stream));
        }
    }
    for (int i = 0; i < host->worker_count; i++)
        LL_TRY(ll_worker_start(&host->workers[i]));
    host->reaper_started = pthread_create(&host->reaper, NULL, reap_expired, host) == 0;
    return host->reaper_started ? ll_ok() : ll_error(LL_NO_MEMORY, "cannot start reaper thread");
}

void ll_host_stop(ll_host *host)
{
    pthread_mutex_lock(&host->registry.lock);
    host->registry.stopping = true;
    pthread_cond_broadcast(&host->registry.stop);
    pthread_mutex_unlock(&host->registry.lock);
    if (host->reaper_started)
        pthread_join(host->reaper, NULL);
    host->reaper_started = false;
    for (int i = 0; i < host->worker_count; i++)
        ll_worker_stop(&host->workers[i]);
}

uint64_t ll_host_save(ll_host *host, bool wait)
{
    uint64_t last = 0;
    if (!wait)
        pthread_mutex_lock(&host->registry.lock); /* other threads may still use the registry */
    for (int i = 0; i < LL_HOST_BUCKETS; i++) {
        for (ll_session_entry *session_entry = host->registry.by_id[i]; session_entry;
             session_entry = session_entry->next_by_id) {
            if (wait)
                pthread_mutex_lock(&session_entry->lock);
            else if (pthread_mutex_trylock(&session_entry->lock) != 0)
                continue;
            ll_session_entry_save(session_entry);
            last = session_entry->stored.ticket > last ? session_entry->stored.ticket : last;
            pthread_mutex_unlock(&session_entry->lock);
        }
    }
    if (!wait)
        pthread_mutex_unlock(&host->registry.lock);
    return last;
}

void ll_host_free(ll_host *host)
{
    if (!host)
        return;
    for (int i = 0; i < LL_HOST_BUCKETS; i++) {
        while (host->registry.by_id[i]) {
            ll_session_entry *session_entry = host->registry.by_id[i];
            host->registry.by_id[i] = session_entry->next_by_id;
            bool streamed = session_entry->stream !=
                            NULL; /* its reference was released: the web server was closed with all streams */
            ll_session_entry_release(session_entry);
            if (streamed)
                ll_session_entry_release(session_entry);
        }
    }
    while (host->replies.first) {
        ll_reply *reply = host->replies.first;
        host->replies.first = reply->next;
        free(reply->good);
        free(reply);
    }
    ll_rate_limits_free(host->creations);
    ll_rate_limits_free(host->lookups);
    free(host->workers);
    pthread_mutex_destroy(&host->registry.lock);
    pthread_mutex_destroy(&host->replies.lock);
    pthread_cond_destroy(&host->registry.stop);
    free(host);
}

const ll_host_config *ll_host_get_config(const ll_host *host)
{
    return &host->config;
}

bool ll_host_allows_lookup(ll_host *host, const char *peer)
{
    bool allowed = ll_rate_limits_take(host->lookups, peer, ll_now_ns());
    if (!allowed)
        atomic_fetch_add(&host->refused.lookups, 1);
    return allowed;
}

static void count(ll_host_stats *stats, ll_session_entry *session_entry)
{
    int status = atomic_load(&session_entry->shared.status);
    int64_t *const by_status[] = {[LL_SESSION_PAUSED] = &stats->paused,
                                  [LL_SESSION_PLAYING] = &stats->playing,
                                  [LL_SESSION_ENDED] = &stats->ended,
                                  [LL_SESSION_FAILED] = &stats->failed};
    if (status < 0)
        stats->unloaded++;
    else
        (*by_status[status])++;
    if (status >= 0 && atomic_load(&session_entry->shared.parked))
        stats->parked++;
}

ll_host_stats ll_host_get_stats(ll_host *host)
{
    ll_host_stats stats = {
        .created = atomic_load(&host->counts.created),
        .deleted = atomic_load(&host->counts.deleted),
        .expired = atomic_load(&host->counts.expired),
        .ticks = atomic_load(&host->counts.ticks),
        .frames = atomic_load(&host->counts.frames),
        .commands = atomic_load(&host->counts.commands),
        .inputs = atomic_load(&host->counts.inputs),
        .refused_sessions = atomic_load(&host->refused.sessions),
        .refused_creations = atomic_load(&host->refused.creations),
        .refused_lookups = atomic_load(&host->refused.lookups),
        .refused_commands = atomic_load(&host->refused.commands),
        .refused_store = (uint64_t)ll_store_get_stats(host->store).refused,
        .refused_memory = atomic_load(&host->refused.memory),
        .refused_logs = atomic_load(&host->refused.logs),
        .log_bytes = atomic_load(&host->usage.log_bytes),
        .memory = atomic_load(&host->usage.memory),
        .memory_max = host->usage.memory_max,
    };
    pthread_mutex_lock(&host->registry.lock);
    stats.sessions = host->registry.sessions;
    for (int i = 0; i < LL_HOST_BUCKETS; i++)
        for (ll_session_entry *session_entry = host->registry.by_id[i]; session_entry;
             session_entry = session_entry->next_by_id)
            count(&stats, session_entry);
    pthread_mutex_unlock(&host->registry.lock);
    return stats;
}
