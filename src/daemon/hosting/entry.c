/* A session of the daemon: its memory, who it is, what a key permits on it, what it counts, its viewers. */
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "daemon/hosting/session_entry.h"
#include "daemon/support/access.h"

static const double mebi = 1 << 20;

ll_session_entry *ll_session_entry_new(ll_host *host)
{
    ll_session_entry *session_entry = calloc(1, sizeof *session_entry);
    if (!session_entry)
        return NULL;
    session_entry->host = host;
    session_entry->identity.created_ms = ll_unix_ms();
    session_entry->published.tick = -1;
    session_entry->inbox.inputs_end = &session_entry->inbox.inputs;
    atomic_init(&session_entry->shared.references, 1);
    atomic_init(&session_entry->shared.last_used, ll_now_ns());
    atomic_init(&session_entry->shared.status, -1);
    pthread_mutex_init(&session_entry->lock, NULL);
    pthread_mutex_init(&session_entry->inbox.lock, NULL);
    pthread_cond_init(&session_entry->work.background_tick_done, NULL);
    return session_entry;
}

void ll_session_entry_retain(ll_session_entry *session_entry)
{
    atomic_fetch_add(&session_entry->shared.references, 1);
}

static void free_viewers(ll_session_entry *session_entry)
{
    while (session_entry->inbox.viewers) {
        ll_viewer *viewer = session_entry->inbox.viewers;
        session_entry->inbox.viewers = viewer->next;
        free(viewer);
    }
    while (session_entry->inbox.inputs) {
        ll_stream_input *input = session_entry->inbox.inputs;
        session_entry->inbox.inputs = input->next;
        free(input);
    }
}

void ll_session_entry_release(ll_session_entry *session_entry)
{
    if (!session_entry || atomic_fetch_sub(&session_entry->shared.references, 1) > 1)
        return;
    free_viewers(session_entry);
    ll_store_batch_free(&session_entry->stored.collected);
    ll_frame_state_clear(&session_entry->published.last);
    if (session_entry->session)
        ll_session_destroy(session_entry->session);
    atomic_fetch_sub(&session_entry->host->usage.memory, session_entry->memory);
    ll_session_entry_count_log(session_entry, -atomic_load(&session_entry->shared.log_bytes));
    ll_session_entry_leave_class_key(session_entry);
    pthread_mutex_destroy(&session_entry->lock);
    pthread_mutex_destroy(&session_entry->inbox.lock);
    pthread_cond_destroy(&session_entry->work.background_tick_done);
    free(session_entry->identity.keys);
    free(session_entry);
}

bool ll_session_entry_set_keys(ll_session_entry *session_entry, const ll_key_hash *keys, int count)
{
    ll_key_hash *mine = malloc((size_t)count * sizeof *mine);
    if (!mine)
        return false;
    memcpy(mine, keys, (size_t)count * sizeof *mine);
    session_entry->identity.keys = mine;
    session_entry->identity.key_count = count;
    return true;
}

const char *ll_session_entry_id(const ll_session_entry *session_entry)
{
    return session_entry->identity.id;
}

const char *ll_session_entry_code(const ll_session_entry *session_entry)
{
    return session_entry->identity.code;
}

int ll_session_entry_viewers(const ll_session_entry *session_entry)
{
    return session_entry->stream ? ll_ws_viewers(session_entry->stream) : 0;
}

bool ll_session_entry_glance(ll_session_entry *session_entry, ll_session_glance *glance)
{
    if (pthread_mutex_trylock(&session_entry->lock) != 0)
        return false;
    bool loaded = session_entry->session && !session_entry->deleted;
    if (loaded) {
        ll_session_info info = ll_session_get_info(session_entry->session);
        *glance = (ll_session_glance){info.status, info.tick, info.params_version};
    }
    pthread_mutex_unlock(&session_entry->lock);
    return loaded;
}

void ll_session_entry_count_log(ll_session_entry *session_entry, int64_t bytes)
{
    atomic_fetch_add(&session_entry->shared.log_bytes, bytes);
    atomic_fetch_add(&session_entry->host->usage.log_bytes, bytes);
    if (session_entry->shared.client_bytes)
        atomic_fetch_add(session_entry->shared.client_bytes, bytes);
    ll_class_key *key = atomic_load(&session_entry->shared.class_key);
    if (key)
        atomic_fetch_add(&key->used[LL_KEY_LOGS], bytes);
}

void ll_session_entry_set_class_key(ll_session_entry *session_entry, ll_class_key *key)
{
    atomic_store(&session_entry->shared.class_key, key);
    if (key)
        atomic_fetch_add(&key->used[LL_KEY_SESSIONS], 1);
}

void ll_session_entry_leave_class_key(ll_session_entry *session_entry)
{
    ll_class_key *key = atomic_exchange(&session_entry->shared.class_key, NULL);
    if (key)
        atomic_fetch_sub(&key->used[LL_KEY_SESSIONS], 1);
}

void ll_session_entry_on_line(void *context, const char *line, size_t length)
{
    ll_session_entry *session_entry = context;
    if (session_entry->restoring)
        return;
    if (length > 9 && memcmp(line, "{\"op\":\"re", 9) == 0) /* rewind, restart */
        session_entry->stored.rewound = true; /* the head of the stored row is wrong, see ll_viewers_apply */
    ll_session_entry_count_log(session_entry, (int64_t)length + 1);
    ll_entry_stored *stored = &session_entry->stored;
    int64_t index = stored->lines++;
    if (stored->collecting)
        ll_store_batch_line(&stored->collected, stored->number, index, line, length);
    else
        stored->ticket = ll_store_line(session_entry->host->store, stored->number, index, line, length);
}

void ll_session_entry_count_memory(ll_session_entry *session_entry, int64_t bytes)
{
    LL_ASSERT(bytes >= 0);
    atomic_fetch_add(&session_entry->host->usage.memory, bytes - session_entry->memory);
    session_entry->memory = bytes;
}

void ll_session_entry_update_stats(ll_session_entry *session_entry)
{
    ll_session_info info = ll_session_get_info(session_entry->session);
    atomic_store(&session_entry->shared.status, (int)info.status);
    atomic_store(&session_entry->shared.parked, info.parked);
    ll_session_entry_count_memory(session_entry,
                                  (int64_t)(info.parked ? ll_session_bytes(session_entry->session)
                                                        : ll_session_awake_bytes(session_entry->session)));
}

ll_status ll_session_entry_fits(ll_session_entry *session_entry)
{
    ll_host *host = session_entry->host;
    int64_t others = atomic_load(&host->usage.memory) - session_entry->memory;
    int64_t wanted = (int64_t)ll_session_awake_bytes(session_entry->session);
    if (others + wanted <= host->usage.memory_max) {
        ll_session_entry_count_memory(session_entry, wanted); /* before catching up, which may take long */
        return ll_ok();
    }
    atomic_fetch_add(&host->refused.memory, 1);
    return ll_error(LL_NO_MEMORY, "This session needs up to %.1f MiB; awake sessions use %.1f of %.1f MiB.",
                    (double)wanted / mebi, (double)others / mebi, (double)host->usage.memory_max / mebi);
}

/* ---- memory of requests ---- */

ll_status ll_host_reserve_memory(ll_host *host, int64_t bytes)
{
    if (atomic_fetch_add(&host->usage.memory, bytes) + bytes <= host->usage.memory_max)
        return ll_ok();
    atomic_fetch_sub(&host->usage.memory, bytes);
    atomic_fetch_add(&host->refused.memory, 1);
    return ll_error(LL_NO_MEMORY, "This needs %.1f MiB in addition to the session; not available at present.",
                    (double)bytes / mebi);
}

void ll_host_release_memory(ll_host *host, int64_t bytes)
{
    atomic_fetch_sub(&host->usage.memory, bytes);
}

/* ---- keys ---- */

int ll_session_entry_find_role(const ll_session_entry *session_entry, const char *key, size_t length,
                               bool *guest)
{
    int role = LL_ROLE_NONE;
    const ll_host *host = session_entry->host;
    *guest = false;
    for (int i = 0; i < session_entry->identity.key_count; i++) /* constant time: compares every key */
        if (ll_key_matches(&session_entry->identity.keys[i], key, length))
            role = i - 1;
    if (ll_access_is_operator(host->config.access, key, length))
        role = LL_ROLE_OWNER;
    if (role != LL_ROLE_NONE || !host->guest_role)
        return role;
    *guest = true;
    return host->guest_role(host->guest_context, session_entry->identity.id, key, length);
}

int ll_session_entry_role(const ll_session_entry *session_entry, const char *key, size_t length)
{
    bool guest;
    return ll_session_entry_find_role(session_entry, key, length, &guest);
}

void ll_host_set_guests(ll_host *host, ll_host_guest_role *role, void *context)
{
    host->guest_role = role;
    host->guest_context = context;
}

/* ---- viewers, and the worker ---- */

bool ll_viewers_any(ll_session_entry *session_entry)
{
    return atomic_load(&session_entry->inbox.viewer_count) > 0;
}

void ll_viewers_close(ll_session_entry *session_entry, const char *reason)
{
    pthread_mutex_lock(&session_entry->inbox.lock);
    for (ll_viewer *v = session_entry->inbox.viewers; v; v = v->next)
        ll_ws_close(session_entry->host->ws, v->id, LL_WS_TRY_LATER, reason);
    pthread_mutex_unlock(&session_entry->inbox.lock);
}

void ll_session_entry_revoke_guests(ll_session_entry *session_entry, int role)
{
    pthread_mutex_lock(&session_entry->inbox.lock);
    for (ll_viewer *v = session_entry->inbox.viewers; v; v = v->next)
        if (v->guest && v->role == role)
            v->role = LL_ROLE_NONE;
    pthread_mutex_unlock(&session_entry->inbox.lock);
}

void ll_session_entry_notify(ll_session_entry *session_entry)
{
    ll_worker *worker = &session_entry->host->workers[session_entry->identity.worker];
    atomic_store(&session_entry->shared.pending, true);
    pthread_mutex_lock(&worker->lock);
    if (!session_entry->active && !worker->stopping) {
        if (worker->count == worker->capacity) {
            int capacity = worker->capacity ? worker->capacity * 2 : 64;
            ll_active *bigger = realloc(worker->active, (size_t)capacity * sizeof *bigger);
            if (bigger) {
                worker->active = bigger;
                worker->capacity = capacity;
            }
        }
        if (worker->count < worker->capacity) {
            ll_session_entry_retain(session_entry);
            session_entry->active = true;
            worker->active[worker->count++] = (ll_active){session_entry, session_entry->identity.slot};
            if (worker->count == 1)
                pthread_cond_signal(&worker->wake);
        }
    }
    pthread_mutex_unlock(&worker->lock);
}
