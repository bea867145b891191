/* Commands to sessions, stored before they are answered, and deletion of sessions. */
#include <stdlib.h>

#include "daemon/hosting/quota.h"
#include "daemon/hosting/session_entry.h"

static ll_status take(ll_session_entry *session_entry, const ll_command_request *request, ll_session *session)
{
    ll_time now = ll_now_ns();
    double rate = session_entry->host->config.max_commands_per_s;
    if (!ll_bucket_take(&session_entry->commands, rate, rate * 2, now)) {
        atomic_fetch_add(&session_entry->host->refused.commands, 1);
        return ll_error(LL_LIMIT, "commands: must be at most %g/s for one session", rate);
    }
    LL_TRY(ll_quota_check_line(session_entry, request->clock));
    if (now > session_entry->wall)
        session_entry->wall = now;
    int64_t lines = session_entry->stored.lines;
    ll_status status = ll_session_entry_change(session_entry, request, session);
    if (!ll_failed(&status))
        session_entry->command_count++;
    if (!ll_failed(&status) || lines != session_entry->stored.lines)
        ll_session_entry_save(session_entry);
    return status;
}

/* The seek did not reach `goal`: stops it at the present tick, unless another command replaced it. Locked. */
static ll_status stop_seek(ll_session_entry *session_entry, bool ours, int64_t goal)
{
    ll_session_info info = ll_session_get_info(session_entry->session);
    if (!ours)
        return ll_error(LL_CONFLICT, "Another command ended the seek to tick %lld at tick %lld.",
                        (long long)goal, (long long)info.tick);
    ll_session_stop_seek(session_entry->session);
    ll_session_entry_save(session_entry);
    return ll_error(LL_INTERRUPTED, "interrupted at tick %lld of %lld; repeat the request to continue",
                    (long long)info.tick, (long long)goal);
}

/* A step of few short ticks ends here. Locked. */
static ll_status begin_seek(ll_session_entry *session_entry, uint32_t *begun)
{
    if (!ll_session_get_info(session_entry->session).seeking)
        return ll_ok();
    if (!ll_session_entry_is_heavy(session_entry) && !session_entry->work.background_tick)
        ll_session_entry_work(session_entry, NULL, 0);
    if (ll_session_get_info(session_entry->session).seeking) {
        *begun = session_entry->command_count;
        return ll_error(LL_INTERRUPTED, "the session was busy seeking");
    }
    ll_session_entry_save(session_entry);
    return ll_ok();
}

/* Runs the seek of a command to its end. Locked at the call and at the return, unless it is gone. */
static ll_status finish_seek(ll_session_entry *session_entry, ll_task *task, uint32_t command_count,
                             bool *locked)
{
    int64_t goal = -1;
    for (;;) {
        ll_session_info info = ll_session_get_info(session_entry->session);
        if (session_entry->command_count != command_count)
            return stop_seek(session_entry, false, goal >= 0 ? goal : info.tick);
        if (!info.seeking)
            break;
        goal = info.tick + ll_session_due(session_entry->session, session_entry->wall);
        ll_session_entry_work(session_entry, task, 0);
        pthread_mutex_unlock(&session_entry->lock);
        atomic_store(&session_entry->shared.last_used, ll_now_ns());
        ll_session_entry_notify(session_entry); /* viewers see the seek advance */
        bool more = ll_task_yield(task);
        pthread_mutex_lock(&session_entry->lock);
        if (session_entry->deleted || !session_entry->session) {
            *locked = false;
            pthread_mutex_unlock(&session_entry->lock);
            return ll_session_entry_gone();
        }
        if (!more && ll_session_get_info(session_entry->session).seeking)
            return stop_seek(session_entry, session_entry->command_count == command_count, goal);
    }
    if (goal >= 0)
        ll_session_entry_save(session_entry);
    return ll_ok();
}

/* Whether a change computes the run so far again, and that takes longer than a short request may. Locked. */
static bool is_long(const ll_session_entry *session_entry, const ll_command_request *request,
                    const ll_session *session)
{
    const double most_ns = 1e6;
    return !request->task && !request->clock && ll_session_begins_anew(session) &&
           (session_entry->work.tick_ns == 0 ||
            (double)ll_session_get_pulse(session).at_tick * session_entry->work.tick_ns > most_ns);
}

static ll_status apply(ll_session_entry *session_entry, const ll_command_request *request, uint64_t *ticket)
{
    ll_session *session;
    LL_TRY(ll_session_entry_enter(session_entry, request->task, &session, NULL));
    if (is_long(session_entry, request, session)) {
        ll_session_entry_leave(session_entry);
        return ll_error(LL_INTERRUPTED, "the session was busy with its past");
    }
    ll_session_entry_stop_work(session_entry);
    if (session_entry->deleted || !session_entry->session) {
        pthread_mutex_unlock(&session_entry->lock);
        return ll_session_entry_gone();
    }
    bool locked = true;
    uint32_t begun = request->begun ? *request->begun : 0;
    ll_status status = begun ? ll_ok() : take(session_entry, request, session);
    if (!ll_failed(&status))
        status = request->task ? finish_seek(session_entry, request->task,
                                             begun ? begun : session_entry->command_count, &locked)
                               : begin_seek(session_entry, request->begun);
    if (!locked)
        return status;
    if (!ll_failed(&status) && request->report)
        request->report(request->context, session);
    *ticket = session_entry->stored.ticket;
    ll_session_entry_leave(session_entry);
    return status;
}

ll_status ll_host_command(ll_host *host, ll_session_entry *session_entry, const ll_command_request *request)
{
    LL_TRY(ll_store_check(host->store));
    uint64_t ticket = 0;
    LL_TRY(apply(session_entry, request, &ticket));
    atomic_fetch_add(&host->counts.commands, 1);
    ll_status status = ll_store_wait(host->store, ticket);
    if (ll_failed(&status))
        return ll_error(status.code, "Command not stored; a restart may lose it: %.170s", status.text);
    return ll_ok();
}

/* Ends one whose `deleted` is set; locked. */
static void forget(ll_session_entry *session_entry)
{
    atomic_fetch_add(&session_entry->shared.cancels, 1);
    /* Not with the last reference: a sleeping worker may hold one for long. */
    ll_session_entry_count_log(session_entry, -atomic_load(&session_entry->shared.log_bytes));
    ll_session_entry_leave_class_key(session_entry);
    if (session_entry->session)
        ll_session_destroy(session_entry->session);
    session_entry->session = NULL;
    ll_session_entry_count_memory(session_entry, 0);
    atomic_store(&session_entry->shared.status, -1);
    ll_ws_stream_close(session_entry->stream, LL_WS_NO_SESSION, "the session was deleted");
}

bool ll_host_discard(ll_host *host, ll_session_entry *session_entry)
{
    pthread_mutex_lock(&session_entry->lock);
    bool first = !session_entry->deleted;
    session_entry->deleted = true;
    if (first) {
        forget(session_entry);
        ll_store_delete(host->store, session_entry->stored.number);
    }
    pthread_mutex_unlock(&session_entry->lock);
    if (first)
        ll_host_unregister(host, session_entry);
    return first;
}

/* Nothing more is queued for it while its deletion is stored; if that fails, it is there again. */
ll_status ll_host_delete(ll_host *host, ll_session_entry *session_entry, ll_task *task)
{
    LL_TRY(ll_store_check(host->store));
    LL_TRY(ll_session_entry_lock(session_entry, task)); /* a task that runs it unlocks within a piece */
    session_entry->deleted = true;
    uint64_t ticket = ll_store_try_delete(host->store, session_entry->stored.number);
    pthread_mutex_unlock(&session_entry->lock);
    ll_status status = ll_store_wait_tried(host->store, ticket);
    pthread_mutex_lock(&session_entry->lock);
    session_entry->deleted = !ll_failed(&status);
    if (!ll_failed(&status))
        forget(session_entry);
    pthread_mutex_unlock(&session_entry->lock);
    if (ll_failed(&status)) {
        ll_session_entry_notify(session_entry);
        return status;
    }
    ll_host_unregister(host, session_entry);
    atomic_fetch_add(&host->counts.deleted, 1);
    return status;
}
