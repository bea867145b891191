/* All sessions of a host by id and by code. */
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "base/hash.h"
#include "daemon/hosting/session_entry.h"

static unsigned bucket_of(const char *text)
{
    return (unsigned)(ll_hash(0, text, strlen(text)) % LL_HOST_BUCKETS);
}

static ll_session_entry *find_code(ll_host *host, const char *code)
{
    ll_session_entry *session_entry = host->registry.by_code[bucket_of(code)];
    while (session_entry && strcmp(session_entry->identity.code, code) != 0)
        session_entry = session_entry->next_by_code;
    return session_entry;
}

ll_session_entry *ll_host_find(ll_host *host, const char *id)
{
    if (!ll_is_id(id))
        return NULL;
    pthread_mutex_lock(&host->registry.lock);
    ll_session_entry *session_entry = host->registry.by_id[bucket_of(id)];
    while (session_entry && strcmp(session_entry->identity.id, id) != 0)
        session_entry = session_entry->next_by_id;
    if (session_entry)
        ll_session_entry_retain(session_entry);
    pthread_mutex_unlock(&host->registry.lock);
    return session_entry;
}

ll_session_entry *ll_host_find_code(ll_host *host, const char *code)
{
    if (!ll_is_code(code))
        return NULL;
    pthread_mutex_lock(&host->registry.lock);
    ll_session_entry *session_entry = find_code(host, code);
    if (session_entry)
        ll_session_entry_retain(session_entry);
    pthread_mutex_unlock(&host->registry.lock);
    return session_entry;
}

static bool choose_code(ll_host *host, ll_session_entry *session_entry)
{
    for (int attempt = 0; attempt < 1000; attempt++) {
        if (!ll_new_code(host->config.shard, session_entry->identity.code))
            return false;
        if (!find_code(host, session_entry->identity.code))
            return true;
    }
    return false;
}

/* Locked. */
static void add(ll_host *host, ll_session_entry *session_entry)
{
    ll_session_entry_retain(session_entry);
    ll_session_entry **by_id = &host->registry.by_id[bucket_of(session_entry->identity.id)];
    session_entry->next_by_id = *by_id;
    *by_id = session_entry;
    ll_session_entry **by_code = &host->registry.by_code[bucket_of(session_entry->identity.code)];
    session_entry->next_by_code = *by_code;
    *by_code = session_entry;
    LL_ASSERT(host->worker_count > 0);
    unsigned place = host->registry.next_place++;
    session_entry->identity.worker = (int)(place % (unsigned)host->worker_count);
    session_entry->identity.slot = (int)(place / (unsigned)host->worker_count % LL_SLOTS);
    host->registry.sessions++;
    session_entry->identity.serial = ++host->registry.serials;
}

bool ll_host_register(ll_host *host, ll_session_entry *session_entry)
{
    pthread_mutex_lock(&host->registry.lock);
    bool room = host->registry.sessions < host->config.max_sessions &&
                (session_entry->identity.code[0] || choose_code(host, session_entry));
    if (room) {
        LL_ASSERT(session_entry->identity.code[0] != '\0');
        add(host, session_entry);
    }
    pthread_mutex_unlock(&host->registry.lock);
    return room;
}

/* Locked. */
static void remove_code(ll_host *host, ll_session_entry *session_entry)
{
    ll_session_entry **link = &host->registry.by_code[bucket_of(session_entry->identity.code)];
    while (*link && *link != session_entry)
        link = &(*link)->next_by_code;
    LL_ASSERT(*link != NULL); /* in both tables or in none */
    *link = session_entry->next_by_code;
}

void ll_host_unregister(ll_host *host, ll_session_entry *session_entry)
{
    bool found = false;
    pthread_mutex_lock(&host->registry.lock);
    ll_session_entry **link = &host->registry.by_id[bucket_of(session_entry->identity.id)];
    while (*link && *link != session_entry)
        link = &(*link)->next_by_id;
    if (*link) {
        *link = session_entry->next_by_id;
        remove_code(host, session_entry);
        LL_ASSERT(host->registry.sessions > 0);
        host->registry.sessions--;
        found = true;
    }
    pthread_mutex_unlock(&host->registry.lock);
    if (found)
        ll_session_entry_release(session_entry);
}

int64_t ll_host_count_stem(ll_host *host, const char *stem)
{
    int64_t count = 0;
    pthread_mutex_lock(&host->registry.lock);
    for (int i = 0; i < LL_HOST_BUCKETS; i++)
        for (const ll_session_entry *entry = host->registry.by_id[i]; entry; entry = entry->next_by_id)
            count += strncmp(entry->identity.id, stem, LL_STEM_LENGTH) == 0;
    pthread_mutex_unlock(&host->registry.lock);
    return count;
}

/* ---- what an operator sees of them ---- */

static int by_serial(const void *a, const void *b)
{
    int64_t x = ((const ll_host_entry *)a)->serial, y = ((const ll_host_entry *)b)->serial;
    return (x > y) - (x < y);
}

static void fill(ll_host_entry *entry, ll_session_entry *session_entry, ll_time now)
{
    *entry = (ll_host_entry){.serial = session_entry->identity.serial,
                             .status = atomic_load(&session_entry->shared.status),
                             .parked = atomic_load(&session_entry->shared.parked),
                             .viewers = ll_session_entry_viewers(session_entry),
                             .created_ms = session_entry->identity.created_ms,
                             .log_bytes = atomic_load(&session_entry->shared.log_bytes),
                             .class_key = atomic_load(&session_entry->shared.class_key)};
    ll_time last_used = atomic_load(&session_entry->shared.last_used);
    entry->idle_s = now > last_used ? ll_to_s(now - last_used) : 0;
    memcpy(entry->id, session_entry->identity.id, sizeof entry->id);
    memcpy(entry->code, session_entry->identity.code, sizeof entry->code);
}

ll_status ll_host_list(ll_host *host, int64_t after, int most, ll_host_entry **entries, int *count)
{
    ll_time now = ll_now_ns();
    int64_t found = 0;
    pthread_mutex_lock(&host->registry.lock);
    ll_host_entry *all = malloc((size_t)(host->registry.sessions + 1) * sizeof *all);
    for (int i = 0; all && i < LL_HOST_BUCKETS; i++) {
        for (ll_session_entry *session_entry = host->registry.by_id[i]; session_entry;
             session_entry = session_entry->next_by_id)
            if (session_entry->identity.serial > after)
                fill(&all[found++], session_entry, now);
    }
    pthread_mutex_unlock(&host->registry.lock);
    if (!all)
        return ll_error(LL_NO_MEMORY, "out of memory: list of sessions");
    qsort(all, (size_t)found, sizeof *all, by_serial);
    *entries = all;
    *count = found < most ? (int)found : most;
    return ll_ok();
}
