/* Sessions that a worker must not run itself, since it owes frames to others every few milliseconds: those
 * that sleep, which may take seconds to wake, and those whose ticks are long. A task of the daemon's own
 * carries them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/hosting/session_entry.h"

/* In pieces, the session locked at both ends; false when it was ended. */
static bool keep_up(ll_session_entry *session_entry, ll_task *task)
{
    while (!session_entry->deleted && session_entry->session && ll_viewers_any(session_entry) &&
           ll_session_entry_is_heavy(session_entry)) {
        if (!ll_session_get_info(session_entry->session).parked)
            ll_viewers_apply(session_entry, ll_host_now());
        int64_t due = ll_hosted_work(session_entry, task, 0);
        if (due < 0)
            break;
        ll_session_entry_note(session_entry);
        ll_session_entry_notify(session_entry);
        if (due == 0)
            break;
        pthread_mutex_unlock(&session_entry->lock);
        bool more = ll_task_go_on(task);
        pthread_mutex_lock(&session_entry->lock);
        if (!more)
            return false;
    }
    return true;
}

static void carry(void *context, ll_task *task)
{
    ll_session_entry *session_entry = context;
    ll_session *session;
    ll_status status = ll_session_entry_enter(session_entry, task, &session, NULL);
    if (!ll_failed(&status)) {
        keep_up(session_entry, task);
        atomic_store(&session_entry->carried,
                     false); /* before the notice: the worker may want it again at once */
        if (session_entry->session && !session_entry->deleted)
            ll_session_entry_note(session_entry);
        pthread_mutex_unlock(&session_entry->lock);
        ll_session_entry_notify(session_entry);
    } else {
        atomic_store(&session_entry->carried, false);
        if (status.code != LL_INTERRUPTED)
            ll_viewers_dismiss(session_entry, status.text);
    }
    ll_session_entry_release(session_entry);
}

void ll_session_entry_carry(ll_session_entry *session_entry)
{
    ll_task_order order = {.client = "the daemon", .own = true, .run = carry, .context = session_entry};
    if (atomic_exchange(&session_entry->carried, true))
        return;
    memcpy(order.session, session_entry->id, sizeof session_entry->id);
    ll_session_entry_retain(session_entry);
    ll_status status = ll_tasks_add(session_entry->host->tasks, &order, NULL);
    if (!ll_failed(&status))
        return;
    atomic_store(&session_entry->carried, false);
    ll_session_entry_release(session_entry);
}
