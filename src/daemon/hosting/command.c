/* Changes of sessions, under the rules of durability, and their end. */
#include <stdlib.h>

#include "daemon/hosting/hosted.h"
#include "daemon/hosting/quota.h"

static ll_status take(ll_hosted *hosted, const ll_host_orders *orders, ll_session *session)
{
    ll_time now = ll_host_now();
    double rate = hosted->host->config.max_commands_per_s;
    if (!ll_bucket_take(&hosted->commands, rate, rate * 2, now)) {
        atomic_fetch_add(&hosted->host->refused_commands, 1);
        return ll_error(LL_LIMIT, "This session takes at most %g commands a second.", rate);
    }
    ll_status status = ll_quota_line(hosted, orders->clock);
    if (ll_failed(&status))
        return status;
    if (now > hosted->wall)
        hosted->wall = now;
    int64_t lines = hosted->lines;
    status = ll_hosted_change(hosted, orders, session);
    if (!ll_failed(&status))
        hosted->orders++;
    if (!ll_failed(&status) || lines != hosted->lines)
        ll_hosted_save(hosted);
    return status;
}

/* Where it is, when it was not brought where it was sent; locked. */
static ll_status stay(ll_hosted *hosted, bool ours, int64_t goal)
{
    ll_session_info info = ll_session_get_info(hosted->session);
    if (!ours)
        return ll_error(LL_CONFLICT,
                        "Another command came before the session was at tick %lld: it is at tick %lld.",
                        (long long)goal, (long long)info.tick);
    ll_session_rest(hosted->session);
    ll_hosted_save(hosted);
    return ll_error(LL_INTERRUPTED, "tick %lld of %lld was reached, and the same request goes on from there",
                    (long long)info.tick, (long long)goal);
}

/* Goes along until it is there. It is locked at both ends, but for LL_NOT_FOUND. */
static ll_status go_along(ll_hosted *hosted, ll_task *task)
{
    uint32_t orders = hosted->orders;
    int64_t goal = -1;
    for (;;) {
        ll_session_info info = ll_session_get_info(hosted->session);
        if (goal >= 0 && hosted->orders != orders)
            return stay(hosted, false, goal);
        if (!info.seeking)
            break;
        goal = info.tick + ll_session_due(hosted->session, hosted->wall);
        ll_hosted_work(hosted, task, 0);
        pthread_mutex_unlock(&hosted->lock);
        atomic_store(&hosted->touched, ll_host_now());
        ll_hosted_notify(hosted); /* who watches sees it go */
        bool more = ll_task_go_on(task);
        pthread_mutex_lock(&hosted->lock);
        if (hosted->deleted || !hosted->session) {
            pthread_mutex_unlock(&hosted->lock);
            return ll_error(LL_NOT_FOUND, "There is no such session.");
        }
        if (!more && ll_session_get_info(hosted->session).seeking)
            return stay(hosted, hosted->orders == orders, goal);
    }
    if (goal >= 0)
        ll_hosted_save(hosted);
    return ll_ok();
}

static ll_status apply(ll_hosted *hosted, const ll_host_orders *orders, uint64_t *ticket)
{
    ll_session *session;
    ll_status status = ll_hosted_enter(hosted, orders->task, &session, NULL);
    if (ll_failed(&status))
        return status;
    ll_hosted_stop_work(hosted);
    if (hosted->deleted || !hosted->session) {
        pthread_mutex_unlock(&hosted->lock);
        return ll_error(LL_NOT_FOUND, "There is no such session.");
    }
    status = take(hosted, orders, session);
    if (!ll_failed(&status) && orders->task) {
        status = go_along(hosted, orders->task);
        if (status.code == LL_NOT_FOUND)
            return status;
    }
    if (!ll_failed(&status) && orders->tell)
        orders->tell(orders->context, session);
    *ticket = hosted->ticket;
    ll_hosted_leave(hosted);
    return status;
}

ll_status ll_host_command(ll_host *host, ll_hosted *hosted, const ll_host_orders *orders)
{
    ll_status status = ll_host_storable(host);
    if (ll_failed(&status))
        return status;
    uint64_t ticket = 0;
    status = apply(hosted, orders, &ticket);
    if (ll_failed(&status))
        return status;
    atomic_fetch_add(&host->commands, 1);
    status = ll_store_wait(host->store, ticket);
    if (ll_failed(&status)) {
        atomic_fetch_add(&host->refused_store, 1);
        return ll_error(LL_IO, "The command could not be stored and may be lost at a restart: %.170s",
                        status.text);
    }
    return ll_ok();
}

/* Out of everything, whether the store works or not: its row goes when it works again. */
bool ll_host_discard(ll_host *host, ll_hosted *hosted, uint64_t *ticket)
{
    pthread_mutex_lock(&hosted->lock);
    bool first = !hosted->deleted;
    hosted->deleted = true;
    atomic_fetch_add(&hosted->stops, 1);
    /* Now, and not with the last reference: a worker that sleeps may have one. */
    ll_hosted_count_log(hosted, -atomic_load(&hosted->log_bytes));
    if (first) {
        if (hosted->session)
            ll_session_destroy(hosted->session);
        hosted->session = NULL;
        ll_hosted_count_memory(hosted, 0);
        atomic_store(&hosted->status, -1);
        *ticket = ll_store_delete(host->store, hosted->stored.number);
        ll_ws_stream_close(hosted->stream, LL_WS_NO_SESSION, "the session was deleted");
    }
    pthread_mutex_unlock(&hosted->lock);
    if (first)
        ll_host_unregister(host, hosted);
    return first;
}

ll_status ll_host_delete(ll_host *host, ll_hosted *hosted, ll_task *task)
{
    ll_status status = ll_host_storable(host);
    if (ll_failed(&status))
        return status;
    status = ll_hosted_lock(hosted, task); /* who computes for it lets go within a piece */
    if (ll_failed(&status))
        return status;
    pthread_mutex_unlock(&hosted->lock);
    uint64_t ticket = 0;
    if (!ll_host_discard(host, hosted, &ticket))
        return ll_error(LL_NOT_FOUND, "There is no such session.");
    atomic_fetch_add(&host->deleted, 1);
    return ll_store_wait(host->store, ticket);
}
