/* Runs sessions that are too slow for a worker in a task of the daemon: those that are parked, which may take
 * seconds to wake, and those with long ticks. It also parks large ones: unmapping their states takes
 * milliseconds, and a worker has to publish other sessions' frames every few. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/hosting/session_entry.h"

/* Works in pieces. The session is locked at the call and at the return; false: the task was stopped. */
static bool run_while_heavy(ll_session_entry *session_entry, ll_task *task)
{
    while (!session_entry->deleted && session_entry->session && ll_viewers_any(session_entry) &&
           ll_session_entry_is_heavy(session_entry)) {
        if (!ll_session_get_info(session_entry->session).parked)
            ll_viewers_apply(session_entry, ll_now_ns());
        int64_t due = ll_session_entry_work(session_entry, task, 0);
        if (due < 0)
            break;
        ll_session_entry_update_stats(session_entry);
        ll_session_entry_notify(session_entry);
        if (due == 0)
            break;
        pthread_mutex_unlock(&session_entry->lock);
        bool more = ll_task_yield(task);
        pthread_mutex_lock(&session_entry->lock);
        if (!more)
            return false;
    }
    return true;
}

static void run_task(void *context, ll_task *task)
{
    ll_session_entry *session_entry = context;
    ll_session *session;
    ll_status status = ll_session_entry_enter(session_entry, task, &session, NULL);
    if (!ll_failed(&status)) {
        run_while_heavy(session_entry, task);
        atomic_store(&session_entry->shared.has_task,
                     false); /* before the notification: the worker may start another task at once */
        if (session_entry->session && !session_entry->deleted)
            ll_session_entry_update_stats(session_entry);
        pthread_mutex_unlock(&session_entry->lock);
        ll_session_entry_notify(session_entry);
    } else {
        atomic_store(&session_entry->shared.has_task, false);
        /* While its deletion is stored it counts as gone: that closes the stream, or, if it fails, the worker
         * starts again. */
        if (status.code == LL_NOT_FOUND)
            ll_session_entry_notify(session_entry);
        else if (status.code != LL_INTERRUPTED)
            ll_viewers_close(session_entry, status.text);
    }
    ll_session_entry_release(session_entry);
}

/* How long a session without viewers stays awake: less with more memory in use, and not at all above three
 * quarters, so that one client's sessions cannot exclude others'. */
ll_time ll_host_park_after(ll_host *host)
{
    double used = (double)atomic_load(&host->usage.memory) / (double)host->usage.memory_max;
    double factor = used < 0.5 ? 1 : used < 0.75 ? 4 * (0.75 - used) : 0;
    return (ll_time)(host->config.park_after_s * 1e9 * factor);
}

bool ll_session_entry_may_park(ll_session_entry *session_entry)
{
    if (!session_entry->session || ll_viewers_any(session_entry))
        return false;
    ll_session_info info = ll_session_get_info(session_entry->session);
    return !info.parked && !info.seeking && /* the request that began a seek continues it */
           ll_now_ns() - atomic_load(&session_entry->shared.last_used) >=
               ll_host_park_after(session_entry->host);
}

void ll_session_entry_park(ll_session_entry *session_entry)
{
    ll_session_entry_save(session_entry);
    ll_frame_state_clear(&session_entry->published.last);
    ll_session_park(session_entry->session);
    ll_session_entry_update_stats(session_entry);
}

/* The worker's conditions once more, since viewers and requests may have come before the task's turn. */
static void run_park(void *context, ll_task *task)
{
    ll_session_entry *session_entry = context;
    (void)task;
    pthread_mutex_lock(&session_entry->lock);
    if (!session_entry->deleted && ll_session_entry_may_park(session_entry))
        ll_session_entry_park(session_entry);
    atomic_store(&session_entry->shared.has_task, false); /* before the notification, as above */
    pthread_mutex_unlock(&session_entry->lock);
    ll_session_entry_notify(session_entry);
    ll_session_entry_release(session_entry);
}

static void start(ll_session_entry *session_entry, void (*run)(void *context, ll_task *task))
{
    ll_task_spec spec = {.client = "the daemon", .own = true, .run = run, .context = session_entry};
    if (atomic_exchange(&session_entry->shared.has_task, true))
        return;
    memcpy(spec.session, session_entry->identity.id, sizeof session_entry->identity.id);
    ll_session_entry_retain(session_entry);
    ll_status status = ll_tasks_add(session_entry->host->tasks, &spec, NULL);
    if (!ll_failed(&status))
        return;
    atomic_store(&session_entry->shared.has_task, false);
    ll_session_entry_release(session_entry);
}

void ll_session_entry_start_task(ll_session_entry *session_entry)
{
    start(session_entry, run_task);
}

void ll_session_entry_start_park(ll_session_entry *session_entry)
{
    start(session_entry, run_park);
}
