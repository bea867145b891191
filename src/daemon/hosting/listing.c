/* What an operator sees of all sessions. */
#include <stdlib.h>
#include <string.h>

#include "daemon/hosting/session_entry.h"

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
    ll_time now = ll_host_now();
    int64_t found = 0;
    pthread_mutex_lock(&host->registry.lock);
    ll_host_entry *all = malloc((size_t)(host->registry.sessions + 1) * sizeof *all);
    for (int i = 0; all && i < LL_HOST_BUCKETS; i++) {
        for (ll_session_entry *session_entry = host->registry.by_id[i]; session_entry;
             session_entry = session_entry->next_by_id) {
            if (session_entry->identity.serial > after)
                fill(&all[found++], session_entry, now);
        }
    }
    pthread_mutex_unlock(&host->registry.lock);
    if (!all)
        return ll_error(LL_NO_MEMORY, "out of memory: list of sessions");
    qsort(all, (size_t)found, sizeof *all, by_serial);
    *entries = all;
    *count = found < most ? (int)found : most;
    return ll_ok();
}
