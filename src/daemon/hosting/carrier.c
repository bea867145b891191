/* Sessions that a worker must not run itself, since it owes frames to others every few milliseconds: those
 * that sleep, which may take seconds to wake, and those whose ticks are long. A task of the daemon's own
 * carries them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/hosting/hosted.h"

/* In pieces, the session locked at both ends; false when it was ended. */
static bool keep_up(ll_hosted *hosted, ll_task *task)
{
    while (!hosted->deleted && hosted->session && ll_viewers_any(hosted) && ll_hosted_is_heavy(hosted)) {
        if (!ll_session_get_info(hosted->session).parked)
            ll_viewers_apply(hosted, ll_host_now());
        int64_t due = ll_hosted_work(hosted, task, 0);
        if (due < 0)
            break;
        ll_hosted_note(hosted);
        ll_hosted_notify(hosted);
        if (due == 0)
            break;
        pthread_mutex_unlock(&hosted->lock);
        bool more = ll_task_go_on(task);
        pthread_mutex_lock(&hosted->lock);
        if (!more)
            return false;
    }
    return true;
}

static void carry(void *context, ll_task *task)
{
    ll_hosted *hosted = context;
    ll_session *session;
    ll_status status = ll_hosted_enter(hosted, task, &session, NULL);
    if (!ll_failed(&status)) {
        keep_up(hosted, task);
        atomic_store(&hosted->carried, false); /* before the notice: the worker may want it again at once */
        if (hosted->session && !hosted->deleted)
            ll_hosted_note(hosted);
        pthread_mutex_unlock(&hosted->lock);
        ll_hosted_notify(hosted);
    } else {
        atomic_store(&hosted->carried, false);
        if (status.code != LL_INTERRUPTED)
            ll_viewers_dismiss(hosted, status.text);
    }
    ll_hosted_release(hosted);
}

void ll_hosted_carry(ll_hosted *hosted)
{
    ll_task_order order = {.client = "the daemon", .own = true, .run = carry, .context = hosted};
    if (atomic_exchange(&hosted->carried, true))
        return;
    memcpy(order.session, hosted->id, sizeof hosted->id);
    ll_hosted_retain(hosted);
    ll_status status = ll_tasks_add(hosted->host->tasks, &order, NULL);
    if (!ll_failed(&status))
        return;
    atomic_store(&hosted->carried, false);
    ll_hosted_release(hosted);
}
