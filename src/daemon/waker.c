/* Threads that bring sleeping sessions to the present.
 *
 * A parked session must be run again from the nearest snapshot, a stored one from its log: up to seconds of
 * work that a worker, which owes a frame to others every few milliseconds, must not do. They run with less
 * priority. */
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include "daemon/hosted.h"

void ll_waker_init(ll_waker *waker)
{
    waker->end = &waker->first;
    pthread_mutex_init(&waker->lock, NULL);
    pthread_cond_init(&waker->more, NULL);
}

void ll_waker_take(ll_waker *waker, ll_hosted *hosted)
{
    pthread_mutex_lock(&waker->lock);
    if (!hosted->waking && !waker->stopping) {
        hosted->waking = true;
        hosted->next_to_wake = NULL;
        ll_hosted_retain(hosted);
        *waker->end = hosted;
        waker->end = &hosted->next_to_wake;
        pthread_cond_signal(&waker->more);
    }
    pthread_mutex_unlock(&waker->lock);
}

/* NULL at the end. */
static ll_hosted *next(ll_waker *waker)
{
    pthread_mutex_lock(&waker->lock);
    while (!waker->first && !waker->stopping)
        pthread_cond_wait(&waker->more, &waker->lock);
    ll_hosted *hosted = waker->stopping ? NULL : waker->first;
    if (hosted) {
        waker->first = hosted->next_to_wake;
        if (!waker->first)
            waker->end = &waker->first;
        hosted->waking = false;
    }
    pthread_mutex_unlock(&waker->lock);
    return hosted;
}

static void *wake_all(void *argument)
{
    ll_host *host = argument;
    setpriority(PRIO_PROCESS, (id_t)gettid(), 5); /* of this thread; without effect elsewhere than on Linux */
    for (ll_hosted *hosted = next(&host->waker); hosted; hosted = next(&host->waker)) {
        ll_session *session;
        ll_status status = ll_hosted_enter(hosted, &session, NULL);
        if (ll_failed(&status))
            ll_viewers_dismiss(hosted, status.text);
        else
            ll_hosted_leave(hosted); /* nudges it */
        ll_hosted_release(hosted);
    }
    return NULL;
}

ll_status ll_waker_start(ll_host *host)
{
    ll_waker *waker = &host->waker;
    waker->threads = calloc((size_t)host->worker_count, sizeof *waker->threads);
    while (waker->threads && waker->count < host->worker_count) {
        if (pthread_create(&waker->threads[waker->count], NULL, wake_all, host) != 0)
            break;
        waker->count++;
    }
    return waker->count > 0 ? ll_ok()
                            : ll_error(LL_NO_MEMORY, "The thread that wakes sessions cannot be started.");
}

void ll_waker_stop(ll_waker *waker)
{
    pthread_mutex_lock(&waker->lock);
    waker->stopping = true;
    pthread_cond_broadcast(&waker->more);
    pthread_mutex_unlock(&waker->lock);
    for (int i = 0; i < waker->count; i++)
        pthread_join(waker->threads[i], NULL);
    free(waker->threads);
    waker->threads = NULL;
    waker->count = 0;
    while (waker->first) {
        ll_hosted *hosted = waker->first;
        waker->first = hosted->next_to_wake;
        ll_hosted_release(hosted);
    }
}
