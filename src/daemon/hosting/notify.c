/* Notifies a session's worker that there is work. */
#include <stdlib.h>

#include "daemon/hosting/session_entry.h"

void ll_session_entry_retain(ll_session_entry *session_entry)
{
    atomic_fetch_add(&session_entry->shared.references, 1);
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
