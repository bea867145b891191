/* Changes of sessions, under the rules of durability, and their end. */
#include <stdlib.h>

#include "daemon/hosting/quota.h"
#include "daemon/hosting/session_entry.h"

static ll_status take(ll_session_entry *session_entry, const ll_create_requests *orders, ll_session *session)
{
    ll_time now = ll_host_now();
    double rate = session_entry->host->config.max_commands_per_s;
    if (!ll_bucket_take(&session_entry->commands, rate, rate * 2, now)) {
        atomic_fetch_add(&session_entry->host->refused_commands, 1);
        return ll_error(LL_LIMIT, "This session takes at most %g commands a second.", rate);
    }
    ll_status status = ll_quota_line(session_entry, orders->clock);
    if (ll_failed(&status))
        return status;
    if (now > session_entry->wall)
        session_entry->wall = now;
    int64_t lines = session_entry->lines;
    status = ll_hosted_change(session_entry, orders, session);
    if (!ll_failed(&status))
        session_entry->orders++;
    if (!ll_failed(&status) || lines != session_entry->lines)
        ll_session_entry_save(session_entry);
    return status;
}

/* Where it is, when it was not brought where it was sent; locked. */
static ll_status stay(ll_session_entry *session_entry, bool ours, int64_t goal)
{
    ll_session_info info = ll_session_get_info(session_entry->session);
    if (!ours)
        return ll_error(LL_CONFLICT,
                        "Another command came before the session was at tick %lld: it is at tick %lld.",
                        (long long)goal, (long long)info.tick);
    ll_session_rest(session_entry->session);
    ll_session_entry_save(session_entry);
    return ll_error(LL_INTERRUPTED, "tick %lld of %lld was reached, and the same request goes on from there",
                    (long long)info.tick, (long long)goal);
}

/* Goes along until it is there. It is locked at both ends, but for LL_NOT_FOUND. */
static ll_status go_along(ll_session_entry *session_entry, ll_task *task)
{
    uint32_t orders = session_entry->orders;
    int64_t goal = -1;
    for (;;) {
        ll_session_info info = ll_session_get_info(session_entry->session);
        if (goal >= 0 && session_entry->orders != orders)
            return stay(session_entry, false, goal);
        if (!info.seeking)
            break;
        goal = info.tick + ll_session_due(session_entry->session, session_entry->wall);
        ll_hosted_work(session_entry, task, 0);
        pthread_mutex_unlock(&session_entry->lock);
        atomic_store(&session_entry->touched, ll_host_now());
        ll_session_entry_notify(session_entry); /* who watches sees it go */
        bool more = ll_task_go_on(task);
        pthread_mutex_lock(&session_entry->lock);
        if (session_entry->deleted || !session_entry->session) {
            pthread_mutex_unlock(&session_entry->lock);
            return ll_error(LL_NOT_FOUND, "There is no such session.");
        }
        if (!more && ll_session_get_info(session_entry->session).seeking)
            return stay(session_entry, session_entry->orders == orders, goal);
    }
    if (goal >= 0)
        ll_session_entry_save(session_entry);
    return ll_ok();
}

static ll_status apply(ll_session_entry *session_entry, const ll_create_requests *orders, uint64_t *ticket)
{
    ll_session *session;
    ll_status status = ll_session_entry_enter(session_entry, orders->task, &session, NULL);
    if (ll_failed(&status))
        return status;
    ll_hosted_stop_work(session_entry);
    if (session_entry->deleted || !session_entry->session) {
        pthread_mutex_unlock(&session_entry->lock);
        return ll_error(LL_NOT_FOUND, "There is no such session.");
    }
    status = take(session_entry, orders, session);
    if (!ll_failed(&status) && orders->task) {
        status = go_along(session_entry, orders->task);
        if (status.code == LL_NOT_FOUND)
            return status;
    }
    if (!ll_failed(&status) && orders->tell)
        orders->tell(orders->context, session);
    *ticket = session_entry->ticket;
    ll_session_entry_leave(session_entry);
    return status;
}

ll_status ll_host_command(ll_host *host, ll_session_entry *session_entry, const ll_create_requests *orders)
{
    ll_status status = ll_host_storable(host);
    if (ll_failed(&status))
        return status;
    uint64_t ticket = 0;
    status = apply(session_entry, orders, &ticket);
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
bool ll_host_discard(ll_host *host, ll_session_entry *session_entry, uint64_t *ticket)
{
    pthread_mutex_lock(&session_entry->lock);
    bool first = !session_entry->deleted;
    session_entry->deleted = true;
    atomic_fetch_add(&session_entry->stops, 1);
    /* Now, and not with the last reference: a worker that sleeps may have one. */
    ll_session_entry_count_log(session_entry, -atomic_load(&session_entry->log_bytes));
    if (first) {
        if (session_entry->session)
            ll_session_destroy(session_entry->session);
        session_entry->session = NULL;
        ll_session_entry_count_memory(session_entry, 0);
        atomic_store(&session_entry->status, -1);
        *ticket = ll_store_delete(host->store, session_entry->stored.number);
        ll_ws_stream_close(session_entry->stream, LL_WS_NO_SESSION, "the session was deleted");
    }
    pthread_mutex_unlock(&session_entry->lock);
    if (first)
        ll_host_unregister(host, session_entry);
    return first;
}

ll_status ll_host_delete(ll_host *host, ll_session_entry *session_entry, ll_task *task)
{
    ll_status status = ll_host_storable(host);
    if (ll_failed(&status))
        return status;
    status = ll_session_entry_lock(session_entry, task); /* who computes for it lets go within a piece */
    if (ll_failed(&status))
        return status;
    pthread_mutex_unlock(&session_entry->lock);
    uint64_t ticket = 0;
    if (!ll_host_discard(host, session_entry, &ticket))
        return ll_error(LL_NOT_FOUND, "There is no such session.");
    atomic_fetch_add(&host->deleted, 1);
    return ll_store_wait(host->store, ticket);
}
