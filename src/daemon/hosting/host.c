/* Runs a session up to the present for workers, tasks and requests, each within its time. */
#include "daemon/hosting/host.h"

#include <time.h>

#include "base/assert.h"
#include "daemon/hosting/session_entry.h"

static const double piece_ms = 2;             /* longest time that a session is locked */
static const double worker_tick_limit_ms = 2; /* longer ticks are run by a task, not by a worker */
static const double lock_timeout_ms = 20;     /* longest wait of a task for a session's lock at a time */
static const double short_wait_ms = 2;        /* the same of a short request, which then becomes a task */
enum { LIGHT_BYTES = 6 << 20 };               /* short requests copy and hash no larger session */
static const double catch_up_ms = 50;         /* longest time that a request spends on catching up */
static const double tick_limit_ms =
    20; /* longest time of a tick while the lock is held, then it is interrupted */
static const double short_tick_ns = 20000;      /* shorter ticks are timed by the wall clock, ... */
static const int64_t short_stretch_ns = 200000; /* ... but not where they took longer than this together */
static const int64_t unknown_time = -1;
static const double change_wait_ms = 20; /* longest wait of a change for a background tick */

/* ---- running up to the present ---- */

bool ll_session_entry_is_heavy(const ll_session_entry *session_entry)
{
    return session_entry->work.tick_ns == 0 ||
           session_entry->work.tick_ns > worker_tick_limit_ms * 1e6; /* 0: unknown, so it may be long */
}

static void update_mean_cost(ll_session_entry *session_entry, int64_t ns, int64_t ticks)
{
    LL_ASSERT(ticks > 0 && ns >= 0);
    double each = (double)ns / (double)ticks, weight = session_entry->work.tick_ns == 0 ? 1
                                                       : ticks > 16                     ? 0.5
                                                                                        : 0.1;
    session_entry->work.tick_ns += (each - session_entry->work.tick_ns) * weight;
    if (session_entry->work.tick_ns < 10)
        session_entry->work.tick_ns = 10;
}

/* Times ticks by this thread's processor time, so that the machine's load does not count as theirs. Reading
 * it is a system call, which costs as much as a short tick: where ticks are short the wall clock does. */
typedef struct stopwatch {
    bool exact; /* by the processor time */
    int64_t from;
} stopwatch;

static stopwatch start_stopwatch(const ll_session_entry *session_entry)
{
    const ll_entry_work *work = &session_entry->work;
    bool exact = work->tick_ns == 0 || work->tick_ns > short_tick_ns || work->doubtful;
    return (stopwatch){exact, exact ? ll_thread_cpu_ns() : ll_now_ns()};
}

/* The time since its start, or `unknown_time`: a stretch that was long by the wall clock had long ticks, or
 * other threads ran meanwhile; the next one is timed exactly. */
static int64_t read_stopwatch(ll_session_entry *session_entry, const stopwatch *watch)
{
    int64_t ns = (watch->exact ? ll_thread_cpu_ns() : ll_now_ns()) - watch->from;
    session_entry->work.doubtful = !watch->exact && ns > short_stretch_ns;
    return session_entry->work.doubtful ? unknown_time : ns;
}

/* A limit of this thread's processor time. */
typedef struct time_limit {
    int64_t ns;
    int64_t until; /* 0: it begins when it is asked for first */
} time_limit;

static bool before_deadline(void *context)
{
    time_limit *limit = context;
    int64_t now = ll_thread_cpu_ns();
    if (limit->until == 0)
        limit->until = now + limit->ns;
    return now < limit->until;
}

static void account(ll_session_entry *session_entry, const ll_session_pulse *before, int64_t ns)
{
    int64_t ticks = ll_session_get_pulse(session_entry->session).at_tick - before->at_tick;
    if (ticks <= 0)
        return;
    if (ns == unknown_time)
        ns = (int64_t)((double)ticks * session_entry->work.tick_ns);
    update_mean_cost(session_entry, ns, ticks);
    if (!before->parked)
        ll_session_account(session_entry->session, ns, ticks);
    atomic_fetch_add(&session_entry->host->counts.ticks, (uint64_t)ticks);
}

static int64_t advance(ll_session_entry *session_entry, ll_time wall, double max_ms, bool restorable)
{
    if (wall < session_entry->wall)
        wall = session_entry->wall;
    session_entry->wall = wall;
    double chunk = session_entry->work.tick_ns > 0 ? max_ms * 1e6 / session_entry->work.tick_ns : 1;
    int64_t most = chunk < 1 ? 1 : chunk > 100000 ? 100000 : (int64_t)chunk, due;
    ll_session_pulse before = ll_session_get_pulse(session_entry->session);
    bool interrupted = false;
    stopwatch watch = start_stopwatch(session_entry);
    time_limit limit = {.ns = (int64_t)((max_ms + tick_limit_ms) * 1e6)};
    limit.until = watch.exact ? watch.from + limit.ns : 0;
    ll_interrupt interrupt = {before_deadline, ll_thread_cpu_ns, &limit};
    ll_session_step_profiler(session_entry->session,
                             ll_viewers_any(session_entry) ? ll_thread_cpu_ns : NULL); /* the page shows it */
    ll_session_set_interrupt(session_entry->session, &interrupt);
    if (restorable)
        due = ll_session_advance_or_restore(session_entry->session, wall, most, &interrupted);
    else
        due = ll_session_advance(session_entry->session, wall, most);
    ll_session_set_interrupt(session_entry->session, NULL);
    interrupted = interrupted || (!before.parked && ll_session_get_pulse(session_entry->session).parked);
    if (interrupted && session_entry->work.tick_ns < tick_limit_ms * 1e6)
        session_entry->work.tick_ns = tick_limit_ms * 1e6;
    else if (!interrupted)
        account(session_entry, &before, read_stopwatch(session_entry, &watch));
    session_entry->work.behind = due > 0;
    return due;
}

int64_t ll_session_entry_advance(ll_session_entry *session_entry, ll_time wall, double max_ms)
{
    return advance(session_entry, wall, max_ms, false);
}

typedef struct background_run {
    const ll_session_entry *session_entry;
    ll_task *task;
    ll_time until; /* 0: no limit */
    uint32_t cancels;
} background_run;

static bool is_still_wanted(void *context)
{
    const background_run *m = context;
    return atomic_load(&m->session_entry->shared.cancels) == m->cancels &&
           (m->until == 0 || ll_now_ns() < m->until) && ll_task_yield(m->task);
}

/* Runs a tick on a copy; the session is unlocked meanwhile. */
static int64_t run_background_tick(ll_session_entry *session_entry, ll_task *task,
                                   ll_background_tick *background_tick, double most_ms)
{
    ll_time until = most_ms > 0 ? ll_now_ns() + (ll_time)(most_ms * 1e6) : 0;
    background_run m = {session_entry, task, until, atomic_load(&session_entry->shared.cancels)};
    ll_interrupt interrupt = {is_still_wanted, ll_thread_cpu_ns, &m};
    session_entry->work.background_tick = true;
    pthread_mutex_unlock(&session_entry->lock);
    int64_t from = ll_thread_cpu_ns();
    ll_background_tick_run(background_tick, &interrupt);
    int64_t ns = ll_thread_cpu_ns() - from;
    pthread_mutex_lock(&session_entry->lock);
    session_entry->work.background_tick = false;
    pthread_cond_broadcast(&session_entry->work.background_tick_done);
    if (session_entry->deleted || !session_entry->session) {
        ll_background_tick_free(background_tick);
        return -1;
    }
    ll_session_pulse before = ll_session_get_pulse(session_entry->session);
    int64_t due =
        ll_session_end_background_tick(session_entry->session, background_tick, session_entry->wall);
    account(session_entry, &before, ns);
    if (ll_session_get_info(session_entry->session).at_tick == before.at_tick &&
        session_entry->work.tick_ns < (double)ns)
        session_entry->work.tick_ns = (double)ns; /* a lower bound: the tick was interrupted */
    session_entry->work.behind = due > 0;
    return due;
}

/* Waits at most `ms` for a background tick. */
static void await_background_tick(ll_session_entry *session_entry, double ms)
{
    struct timespec until = ll_deadline(CLOCK_REALTIME, (int64_t)(ms * 1e6));
    while (session_entry->work.background_tick &&
           pthread_cond_timedwait(&session_entry->work.background_tick_done, &session_entry->lock, &until) ==
               0)
        ;
}

int64_t ll_session_entry_work(ll_session_entry *session_entry, ll_task *task, double most_ms)
{
    ll_background_tick *background_tick = NULL;
    ll_time now = ll_now_ns();
    if (session_entry->work.background_tick) {
        await_background_tick(session_entry, lock_timeout_ms);
        return session_entry->deleted || !session_entry->session
                   ? -1
                   : ll_session_due(session_entry->session, session_entry->wall);
    }
    if (!ll_session_entry_is_heavy(session_entry))
        return advance(session_entry, now, piece_ms, true);
    if (now > session_entry->wall)
        session_entry->wall = now;
    ll_session_step_profiler(session_entry->session, ll_viewers_any(session_entry) ? ll_thread_cpu_ns : NULL);
    ll_status status =
        ll_session_begin_background_tick(session_entry->session, session_entry->wall, &background_tick);
    return ll_failed(&status) || !background_tick
               ? advance(session_entry, now, piece_ms, true)
               : run_background_tick(session_entry, task, background_tick, most_ms);
}

ll_status ll_session_entry_change(ll_session_entry *session_entry, const ll_command_request *request,
                                  ll_session *session)
{
    int64_t limit_ns = (int64_t)(tick_limit_ms * 1e6);
    time_limit limit = {.ns = limit_ns, .until = ll_thread_cpu_ns() + limit_ns};
    ll_interrupt interrupt = {before_deadline, ll_thread_cpu_ns, &limit};
    ll_session_set_interrupt(session, &interrupt);
    ll_status status = request->change(request->context, session, session_entry->wall);
    ll_session_set_interrupt(session, NULL);
    if (ll_session_get_info(session).parked)
        session_entry->work.tick_ns = 0;
    return status;
}

void ll_session_entry_stop_work(ll_session_entry *session_entry)
{
    await_background_tick(session_entry, change_wait_ms);
    if (session_entry->work.background_tick)
        atomic_fetch_add(&session_entry->shared.cancels, 1);
}

/* ---- entering ---- */

static bool try_lock(ll_session_entry *session_entry, double ms)
{
    if (pthread_mutex_trylock(&session_entry->lock) == 0)
        return true;
    struct timespec until = ll_deadline(CLOCK_REALTIME, (int64_t)(ms * 1e6));
    return pthread_mutex_timedlock(&session_entry->lock, &until) == 0;
}

ll_status ll_session_entry_gone(void)
{
    return ll_error(LL_NOT_FOUND, "Session not found.");
}

ll_status ll_session_entry_lock(ll_session_entry *session_entry, ll_task *task)
{
    while (!try_lock(session_entry, task ? lock_timeout_ms : short_wait_ms))
        if (!task || !ll_task_yield(task))
            return ll_error(LL_INTERRUPTED, "the session was busy");
    if (!session_entry->deleted)
        return ll_ok();
    pthread_mutex_unlock(&session_entry->lock);
    return ll_session_entry_gone();
}

/* Loads the session and begins to wake it; locked. */
static ll_status begin_wake(ll_session_entry *session_entry)
{
    ll_status status = ll_ok();
    if (!session_entry->session)
        status = ll_session_entry_load(session_entry);
    LL_THEN(status, ll_session_entry_fits(session_entry));
    LL_THEN(status, ll_session_begin_wake(session_entry->session));
    if (ll_failed(&status) && session_entry->session) {
        ll_session_park(session_entry->session);
        ll_session_entry_update_stats(session_entry);
    }
    return status;
}

/* Unlocks the session for others and yields the task's turn. Locks again, except on failure. */
static ll_status yield(ll_session_entry *session_entry, ll_task *task)
{
    pthread_mutex_unlock(&session_entry->lock);
    atomic_store(&session_entry->shared.last_used, ll_now_ns());
    if (!ll_task_yield(task))
        return ll_error(LL_INTERRUPTED, "the session was not awake yet");
    return ll_session_entry_lock(session_entry, task);
}

static ll_status wake(ll_session_entry *session_entry, ll_task *task)
{
    ll_status status = ll_ok();
    while (!session_entry->session || ll_session_get_info(session_entry->session).parked) {
        status = begin_wake(session_entry);
        if (ll_failed(&status)) {
            pthread_mutex_unlock(&session_entry->lock);
            return status;
        }
        if (ll_session_entry_work(session_entry, task, 0) < 0) {
            pthread_mutex_unlock(&session_entry->lock);
            return ll_session_entry_gone();
        }
        if (!ll_session_get_info(session_entry->session).parked)
            break;
        status = yield(session_entry, task);
        if (ll_failed(&status))
            return status;
    }
    return status;
}

/* Computing time to reach the present, in ms; 0: up to date, or seeking. */
static double behind_ms(ll_session_entry *session_entry)
{
    bool seeking = ll_session_get_info(session_entry->session).seeking;
    int64_t due = seeking ? 0 : ll_session_due(session_entry->session, ll_now_ns());
    double tick_ns = session_entry->work.tick_ns > 0 ? session_entry->work.tick_ns : 1000;
    return (double)due * tick_ns * 1e-6;
}

/* Runs up to the present if that takes less than catch_up_ms. */
static ll_status catch_up(ll_session_entry *session_entry, ll_task *task)
{
    ll_status status = ll_ok();
    ll_time until = ll_now_ns() + (ll_time)(2 * catch_up_ms * 1e6);
    double behind = behind_ms(session_entry);
    while (behind > 0 && behind < catch_up_ms && ll_now_ns() < until &&
           !session_entry->work.background_tick) {
        if (!task && (behind > piece_ms || session_entry->work.tick_ns == 0)) {
            pthread_mutex_unlock(&session_entry->lock);
            return ll_error(LL_INTERRUPTED, "the session was not up to date");
        }
        if (!task)
            ll_session_entry_advance(session_entry, ll_now_ns(), piece_ms);
        if (task && ll_session_entry_work(session_entry, task, catch_up_ms) < 0) {
            pthread_mutex_unlock(&session_entry->lock);
            return ll_session_entry_gone();
        }
        behind = behind_ms(session_entry);
        if (!task || behind == 0)
            break;
        status = yield(session_entry, task);
        if (ll_failed(&status))
            return status;
    }
    return status;
}

ll_status ll_session_entry_enter(ll_session_entry *session_entry, ll_task *task, ll_session **session,
                                 bool *was_parked)
{
    atomic_store(&session_entry->shared.last_used, ll_now_ns());
    LL_TRY(ll_session_entry_lock(session_entry, task));
    bool parked = session_entry->session && ll_session_get_info(session_entry->session).parked;
    if (was_parked)
        *was_parked = parked;
    if (!task && (!session_entry->session || parked || session_entry->work.background_tick ||
                  ll_session_awake_bytes(session_entry->session) > LIGHT_BYTES)) {
        pthread_mutex_unlock(&session_entry->lock);
        return ll_error(LL_INTERRUPTED, "the session was parked, busy or large");
    }
    ll_status status = wake(session_entry, task);
    LL_THEN(status, catch_up(session_entry, task));
    *session = session_entry->session;
    return status;
}

void ll_session_entry_leave(ll_session_entry *session_entry)
{
    ll_session_entry_update_stats(session_entry);
    pthread_mutex_unlock(&session_entry->lock);
    ll_session_entry_notify(session_entry);
}
