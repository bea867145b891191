/* Telling a session's worker that there is something to do. */
#include <stdlib.h>

#include "daemon/hosting/hosted.h"

void ll_hosted_retain(ll_hosted *hosted)
{
    atomic_fetch_add(&hosted->references, 1);
}

void ll_hosted_notify(ll_hosted *hosted)
{
    ll_worker *worker = &hosted->host->workers[hosted->worker];
    atomic_store(&hosted->pending, true);
    pthread_mutex_lock(&worker->lock);
    if (!hosted->active && !worker->stopping) {
        if (worker->count == worker->capacity) {
            int capacity = worker->capacity ? worker->capacity * 2 : 64;
            ll_hosted **bigger = realloc(worker->active, (size_t)capacity * sizeof *bigger);
            if (bigger) {
                worker->active = bigger;
                worker->capacity = capacity;
            }
        }
        if (worker->count < worker->capacity) {
            ll_hosted_retain(hosted);
            hosted->active = true;
            worker->active[worker->count++] = hosted;
            if (worker->count == 1)
                pthread_cond_signal(&worker->wake);
        }
    }
    pthread_mutex_unlock(&worker->lock);
}
