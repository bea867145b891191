#include "daemon/hosting/host.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cjson/cJSON.h>

#include "base/assert.h"
#include "base/hash.h"
#include "daemon/hosting/session_entry.h"
#include "daemon/support/access.h"
#include "daemon/support/log.h"

static const double mebi = 1 << 20;
static const double piece_ms = 2;     /* for which a session is locked */
static const double heavy_ms = 2;     /* a tick that is longer is not for a worker */
static const double patience_ms = 20; /* with a session that somebody works on */
static const double catch_up_ms = 50; /* what a request waits for at most */
static const double given_up_ms = 20; /* a tick that takes so long for once, where the lock is held */
static const double finish_ms = 20;   /* that a change waits for a tick which is being made */

ll_time ll_host_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (ll_time)now.tv_sec * LL_SECOND + now.tv_nsec;
}

static int64_t unix_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* ---- one session ---- */

ll_session_entry *ll_session_entry_new(ll_host *host)
{
    ll_session_entry *session_entry = calloc(1, sizeof *session_entry);
    if (!session_entry)
        return NULL;
    session_entry->host = host;
    session_entry->created_ms = unix_ms();
    session_entry->published_tick = -1;
    session_entry->inputs_end = &session_entry->inputs;
    atomic_init(&session_entry->references, 1);
    atomic_init(&session_entry->touched, ll_host_now());
    atomic_init(&session_entry->status, -1);
    pthread_mutex_init(&session_entry->lock, NULL);
    pthread_mutex_init(&session_entry->inbox_lock, NULL);
    pthread_cond_init(&session_entry->ahead_over, NULL);
    return session_entry;
}

void ll_session_entry_release(ll_session_entry *session_entry)
{
    if (!session_entry || atomic_fetch_sub(&session_entry->references, 1) > 1)
        return;
    ll_viewers_forget(session_entry);
    ll_frame_state_clear(&session_entry->last);
    if (session_entry->session)
        ll_session_destroy(session_entry->session);
    atomic_fetch_sub(&session_entry->host->memory, session_entry->memory);
    ll_session_entry_count_log(session_entry, -atomic_load(&session_entry->log_bytes));
    pthread_mutex_destroy(&session_entry->lock);
    pthread_mutex_destroy(&session_entry->inbox_lock);
    pthread_cond_destroy(&session_entry->ahead_over);
    free(session_entry);
}

const char *ll_session_entry_id(const ll_session_entry *session_entry)
{
    return session_entry->id;
}

const char *ll_session_entry_code(const ll_session_entry *session_entry)
{
    return session_entry->code;
}

int ll_session_entry_viewers(const ll_session_entry *session_entry)
{
    return session_entry->stream ? ll_ws_viewers(session_entry->stream) : 0;
}

int ll_session_entry_role(const ll_session_entry *session_entry, const char *key, size_t length)
{
    int role = LL_ROLE_NONE;
    for (int i = 0; i < session_entry->key_count;
         i++) { /* all of them, so that time does not tell whose key it nearly was */
        if (ll_key_matches(&session_entry->keys[i], key, length))
            role = i - 1;
    }
    return ll_access_is_operator(session_entry->host->config.access, key, length) ? LL_ROLE_OWNER : role;
}

void ll_session_entry_count_log(ll_session_entry *session_entry, int64_t bytes)
{
    atomic_fetch_add(&session_entry->log_bytes, bytes);
    atomic_fetch_add(&session_entry->host->log_bytes, bytes);
    if (session_entry->share)
        atomic_fetch_add(session_entry->share, bytes);
}

void ll_session_entry_on_line(void *context, const char *line, size_t length)
{
    ll_session_entry *session_entry = context;
    if (session_entry->restoring)
        return;
    /* `rewind` and `restart`: the head of the stored row no longer holds, see ll_viewers_apply. */
    session_entry->rewound = session_entry->rewound || (length > 9 && memcmp(line, "{\"op\":\"re", 9) == 0);
    ll_session_entry_count_log(session_entry, (int64_t)length + 1);
    session_entry->ticket = ll_store_line(session_entry->host->store, session_entry->stored.number,
                                          session_entry->lines++, line, length);
}

void ll_session_entry_count_memory(ll_session_entry *session_entry, int64_t bytes)
{
    atomic_fetch_add(&session_entry->host->memory, bytes - session_entry->memory);
    session_entry->memory = bytes;
}

void ll_session_entry_note(ll_session_entry *session_entry)
{
    ll_session_info info = ll_session_get_info(session_entry->session);
    atomic_store(&session_entry->status, (int)info.status);
    atomic_store(&session_entry->parked, info.parked);
    ll_session_entry_count_memory(session_entry, (int64_t)(info.parked ? info.bytes : info.awake_bytes));
}

ll_status ll_session_entry_fits(ll_session_entry *session_entry)
{
    ll_host *host = session_entry->host;
    int64_t others = atomic_load(&host->memory) - session_entry->memory;
    int64_t wanted = (int64_t)ll_session_get_info(session_entry->session).awake_bytes;
    if (others + wanted <= host->memory_max) {
        ll_session_entry_count_memory(session_entry, wanted); /* before it catches up, which may take long */
        return ll_ok();
    }
    atomic_fetch_add(&host->refused_memory, 1);
    return ll_error(
        LL_NO_MEMORY,
        "This session needs up to %.1f MiB; sessions that are awake need %.1f of the %.1f MiB that "
        "there are for all.",
        (double)wanted / mebi, (double)others / mebi, (double)host->memory_max / mebi);
}

void ll_session_entry_save(ll_session_entry *session_entry)
{
    if (!session_entry->session || session_entry->deleted)
        return;
    ll_session_info info = ll_session_get_info(session_entry->session);
    ll_stored *row = &session_entry->stored;
    memcpy(row->id, session_entry->id, sizeof row->id);
    memcpy(row->code, session_entry->code, sizeof row->code);
    memcpy(row->keys, session_entry->keys, sizeof row->keys);
    row->key_count = session_entry->key_count;
    row->created_ms = session_entry->created_ms;
    row->seen_ms = unix_ms();
    row->playing = info.status == LL_SESSION_PLAYING;
    row->speed = info.speed;
    row->tick = info.tick;
    row->head_tick = info.head_tick;
    row->lines = session_entry->lines;
    session_entry->saved_wall = session_entry->wall;
    session_entry->rewound = false;
    session_entry->ticket = ll_store_put(session_entry->host->store, row);
}

/* ---- loading ---- */

/* As it was when its clock was last stored, or at the last stamped command when that is later. A playing
 * session went on from the daemon's start. */
static void resume(ll_session_entry *session_entry)
{
    const ll_stored *row = &session_entry->stored;
    bool older = row->head_tick < ll_session_get_info(session_entry->session).head_tick;
    ll_session_place(session_entry->session, session_entry->host->started,
                     &(ll_session_place_at){.tick = older ? -1 : row->tick,
                                            .head = row->head_tick,
                                            .speed = row->speed,
                                            .playing = row->playing});
    session_entry->wall = session_entry->host->started;
}

ll_status ll_session_entry_load(ll_session_entry *session_entry)
{
    if (session_entry->session)
        return ll_ok();
    char *text = NULL;
    size_t length = 0;
    ll_status status =
        ll_store_read_log(session_entry->host->store, session_entry->stored.number, &text, &length);
    if (ll_failed(&status))
        return status;
    session_entry->restoring = true;
    status =
        ll_session_restore(text, length, ll_session_entry_on_line, session_entry, &session_entry->session);
    session_entry->restoring = false;
    free(text);
    if (ll_failed(&status)) {
        session_entry->session = NULL;
        ll_log_write("error", "session not restored", "Stored session %lld: %s",
                     (long long)session_entry->stored.number, status.text);
        return ll_error(LL_IO, "The stored log of this session cannot be replayed: %.180s", status.text);
    }
    resume(session_entry);
    ll_session_entry_note(session_entry);
    return ll_ok();
}

/* ---- the present ---- */

static int64_t cpu_now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * LL_SECOND + t.tv_nsec;
}

bool ll_session_entry_is_heavy(const ll_session_entry *session_entry)
{
    return session_entry->tick_ns == 0 ||
           session_entry->tick_ns > heavy_ms * 1e6; /* not known yet: it may be */
}

static void learn_cost(ll_session_entry *session_entry, int64_t ns, int64_t ticks)
{
    double each = (double)ns / (double)ticks, weight = session_entry->tick_ns == 0 ? 1
                                                       : ticks > 16                ? 0.5
                                                                                   : 0.1;
    session_entry->tick_ns += (each - session_entry->tick_ns) * weight;
    if (session_entry->tick_ns < 10)
        session_entry->tick_ns = 10;
}

/* By this thread's own processor time: what a busy machine takes is not the tick's. */
static bool within(void *until_ns)
{
    return cpu_now_ns() < *(const int64_t *)until_ns;
}

static void account(ll_session_entry *session_entry, const ll_session_info *before, int64_t ns)
{
    int64_t ticks = ll_session_get_info(session_entry->session).at_tick - before->at_tick;
    if (ticks <= 0)
        return;
    learn_cost(session_entry, ns, ticks);
    if (!before->parked)
        ll_session_account(session_entry->session, ns, ticks);
    atomic_fetch_add(&session_entry->host->ticks, (uint64_t)ticks);
}

static int64_t advance(ll_session_entry *session_entry, ll_time wall, double max_ms, bool safely)
{
    if (wall < session_entry->wall)
        wall = session_entry->wall;
    session_entry->wall = wall;
    double chunk = session_entry->tick_ns > 0 ? max_ms * 1e6 / session_entry->tick_ns : 1;
    int64_t most = chunk < 1 ? 1 : chunk > 100000 ? 100000 : (int64_t)chunk, due;
    ll_session_info before = ll_session_get_info(session_entry->session);
    bool broken_off = false;
    int64_t from = cpu_now_ns(), until = from + (int64_t)((max_ms + given_up_ms) * 1e6);
    ll_interrupt interrupt = {within, cpu_now_ns, &until};
    ll_session_step_profiler(session_entry->session,
                             ll_viewers_any(session_entry) ? cpu_now_ns : NULL); /* a page shows it */
    ll_session_set_patience(session_entry->session, &interrupt);
    if (safely)
        due = ll_session_advance_safely(session_entry->session, wall, most, &broken_off);
    else
        due = ll_session_advance(session_entry->session, wall, most);
    ll_session_set_patience(session_entry->session, NULL);
    broken_off = broken_off || (!before.parked && ll_session_get_info(session_entry->session).parked);
    if (broken_off && session_entry->tick_ns < given_up_ms * 1e6)
        session_entry->tick_ns = given_up_ms * 1e6;
    else if (!broken_off)
        account(session_entry, &before, cpu_now_ns() - from);
    session_entry->behind = due > 0;
    return due;
}

int64_t ll_session_entry_advance(ll_session_entry *session_entry, ll_time wall, double max_ms)
{
    return advance(session_entry, wall, max_ms, false);
}

typedef struct making {
    const ll_session_entry *session_entry;
    ll_task *task;
    ll_time until; /* 0: as long as it takes */
    uint32_t stops;
} making;

static bool is_wanted(void *context)
{
    const making *m = context;
    return atomic_load(&m->session_entry->stops) == m->stops && (m->until == 0 || ll_host_now() < m->until) &&
           ll_task_go_on(m->task);
}

/* Unlocks it meanwhile. */
static int64_t make_ahead(ll_session_entry *session_entry, ll_task *task, ll_ahead *ahead, double most_ms)
{
    ll_time until = most_ms > 0 ? ll_host_now() + (ll_time)(most_ms * 1e6) : 0;
    making m = {session_entry, task, until, atomic_load(&session_entry->stops)};
    ll_interrupt interrupt = {is_wanted, cpu_now_ns, &m};
    session_entry->ahead = true;
    pthread_mutex_unlock(&session_entry->lock);
    int64_t from = cpu_now_ns();
    ll_ahead_run(ahead, &interrupt);
    int64_t ns = cpu_now_ns() - from;
    pthread_mutex_lock(&session_entry->lock);
    session_entry->ahead = false;
    pthread_cond_broadcast(&session_entry->ahead_over);
    if (session_entry->deleted || !session_entry->session) {
        ll_ahead_free(ahead);
        return -1;
    }
    ll_session_info before = ll_session_get_info(session_entry->session);
    int64_t due = ll_session_end_ahead(session_entry->session, ahead, session_entry->wall);
    account(session_entry, &before, ns);
    if (ll_session_get_info(session_entry->session).at_tick == before.at_tick &&
        session_entry->tick_ns < (double)ns)
        session_entry->tick_ns = (double)ns; /* at least */
    session_entry->behind = due > 0;
    return due;
}

/* At most `ms`, while somebody makes a tick of it. */
static void await_ahead(ll_session_entry *session_entry, double ms)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    int64_t ns = until.tv_nsec + (int64_t)(ms * 1e6);
    until.tv_sec += ns / LL_SECOND;
    until.tv_nsec = ns % LL_SECOND;
    while (session_entry->ahead &&
           pthread_cond_timedwait(&session_entry->ahead_over, &session_entry->lock, &until) == 0)
        ;
}

int64_t ll_hosted_work(ll_session_entry *session_entry, ll_task *task, double most_ms)
{
    ll_ahead *ahead = NULL;
    ll_time now = ll_host_now();
    if (session_entry->ahead) {
        await_ahead(session_entry, patience_ms);
        return session_entry->deleted || !session_entry->session
                   ? -1
                   : ll_session_due(session_entry->session, session_entry->wall);
    }
    if (!ll_session_entry_is_heavy(session_entry))
        return advance(session_entry, now, piece_ms, true);
    if (now > session_entry->wall)
        session_entry->wall = now;
    ll_session_step_profiler(session_entry->session, ll_viewers_any(session_entry) ? cpu_now_ns : NULL);
    ll_status status = ll_session_begin_ahead(session_entry->session, session_entry->wall, &ahead);
    return ll_failed(&status) || !ahead ? advance(session_entry, now, piece_ms, true)
                                        : make_ahead(session_entry, task, ahead, most_ms);
}

ll_status ll_hosted_change(ll_session_entry *session_entry, const ll_create_requests *orders,
                           ll_session *session)
{
    int64_t until = cpu_now_ns() + (int64_t)(given_up_ms * 1e6);
    ll_interrupt interrupt = {within, cpu_now_ns, &until};
    ll_session_set_patience(session, &interrupt);
    ll_status status = orders->change(orders->context, session, session_entry->wall);
    ll_session_set_patience(session, NULL);
    if (ll_session_get_info(session).parked)
        session_entry->tick_ns = 0;
    return status;
}

void ll_hosted_stop_work(ll_session_entry *session_entry)
{
    await_ahead(session_entry, finish_ms);
    if (session_entry->ahead)
        atomic_fetch_add(&session_entry->stops, 1);
}

/* ---- entering ---- */

static bool try_lock(ll_session_entry *session_entry, double ms)
{
    struct timespec until;
    if (pthread_mutex_trylock(&session_entry->lock) == 0)
        return true;
    clock_gettime(CLOCK_REALTIME, &until);
    int64_t ns = until.tv_nsec + (int64_t)(ms * 1e6);
    until.tv_sec += ns / LL_SECOND;
    until.tv_nsec = ns % LL_SECOND;
    return pthread_mutex_timedlock(&session_entry->lock, &until) == 0;
}

ll_status ll_session_entry_lock(ll_session_entry *session_entry, ll_task *task)
{
    while (!try_lock(session_entry, patience_ms)) {
        if (!task || !ll_task_go_on(task))
            return ll_error(LL_INTERRUPTED, "the session was busy");
    }
    if (!session_entry->deleted)
        return ll_ok();
    pthread_mutex_unlock(&session_entry->lock);
    return ll_error(LL_NOT_FOUND, "There is no such session.");
}

/* Into memory, and on its way to be awake; locked. */
static ll_status stir(ll_session_entry *session_entry)
{
    bool loaded = !session_entry->session;
    ll_status status = ll_session_entry_load(session_entry);
    if (!ll_failed(&status))
        status = ll_session_entry_fits(session_entry);
    if (!ll_failed(&status))
        status = ll_session_begin_to_wake(session_entry->session);
    if (ll_failed(&status) && session_entry->session) {
        if (loaded)
            ll_session_park(session_entry->session);
        ll_session_entry_note(session_entry);
    }
    return status;
}

/* Lets others at the session, and the task's turn pass. Locked again unless it fails. */
static ll_status pause_between(ll_session_entry *session_entry, ll_task *task)
{
    pthread_mutex_unlock(&session_entry->lock);
    atomic_store(&session_entry->touched, ll_host_now());
    if (!ll_task_go_on(task))
        return ll_error(LL_INTERRUPTED, "the session was not awake yet");
    return ll_session_entry_lock(session_entry, task);
}

static ll_status wake(ll_session_entry *session_entry, ll_task *task)
{
    ll_status status = ll_ok();
    while (!session_entry->session || ll_session_get_info(session_entry->session).parked) {
        status = stir(session_entry);
        if (ll_failed(&status)) {
            pthread_mutex_unlock(&session_entry->lock);
            return status;
        }
        if (ll_hosted_work(session_entry, task, 0) < 0) {
            pthread_mutex_unlock(&session_entry->lock);
            return ll_error(LL_NOT_FOUND, "There is no such session.");
        }
        if (!ll_session_get_info(session_entry->session).parked)
            break;
        status = pause_between(session_entry, task);
        if (ll_failed(&status))
            return status;
    }
    return status;
}

/* How long it would take to bring it to the present; 0 when it is there, or is not meant to be. */
static double behind_ms(ll_session_entry *session_entry)
{
    bool seeking = ll_session_get_info(session_entry->session).seeking;
    int64_t due = seeking ? 0 : ll_session_due(session_entry->session, ll_host_now());
    double tick_ns = session_entry->tick_ns > 0 ? session_entry->tick_ns : 1000;
    return (double)due * tick_ns * 1e-6;
}

/* What can be brought to the present soon is. */
static ll_status catch_up(ll_session_entry *session_entry, ll_task *task)
{
    ll_status status = ll_ok();
    ll_time until = ll_host_now() + (ll_time)(2 * catch_up_ms * 1e6);
    double behind = behind_ms(session_entry);
    while (behind > 0 && behind < catch_up_ms && ll_host_now() < until && !session_entry->ahead) {
        if (!task && (behind > piece_ms || session_entry->tick_ns == 0)) {
            pthread_mutex_unlock(&session_entry->lock);
            return ll_error(LL_INTERRUPTED, "the session was not up to date");
        }
        if (!task)
            ll_session_entry_advance(session_entry, ll_host_now(), piece_ms);
        if (task && ll_hosted_work(session_entry, task, catch_up_ms) < 0) {
            pthread_mutex_unlock(&session_entry->lock);
            return ll_error(LL_NOT_FOUND, "There is no such session.");
        }
        behind = behind_ms(session_entry);
        if (!task || behind == 0)
            break;
        status = pause_between(session_entry, task);
        if (ll_failed(&status))
            return status;
    }
    return status;
}

ll_status ll_session_entry_enter(ll_session_entry *session_entry, ll_task *task, ll_session **session,
                                 bool *was_parked)
{
    atomic_store(&session_entry->touched, ll_host_now());
    ll_status status = ll_session_entry_lock(session_entry, task);
    if (ll_failed(&status))
        return status;
    bool parked = session_entry->session && ll_session_get_info(session_entry->session).parked;
    if (was_parked)
        *was_parked = parked;
    if (!task && (!session_entry->session || parked)) {
        pthread_mutex_unlock(&session_entry->lock);
        return ll_error(LL_INTERRUPTED, "the session was asleep");
    }
    status = wake(session_entry, task);
    if (!ll_failed(&status))
        status = catch_up(session_entry, task);
    *session = session_entry->session;
    return status;
}

void ll_session_entry_leave(ll_session_entry *session_entry)
{
    ll_session_entry_note(session_entry);
    pthread_mutex_unlock(&session_entry->lock);
    ll_session_entry_notify(session_entry);
}

/* ---- memory of requests ---- */

ll_status ll_host_reserve(ll_host *host, int64_t bytes)
{
    if (atomic_fetch_add(&host->memory, bytes) + bytes <= host->memory_max)
        return ll_ok();
    atomic_fetch_sub(&host->memory, bytes);
    atomic_fetch_add(&host->refused_memory, 1);
    return ll_error(LL_NO_MEMORY, "This needs %.1f MiB beside the session; there is no room for it now.",
                    (double)bytes / mebi);
}

void ll_host_give_back(ll_host *host, int64_t bytes)
{
    atomic_fetch_sub(&host->memory, bytes);
}

ll_status ll_host_storable(ll_host *host)
{
    ll_status why;
    if (!ll_store_failing(host->store, &why))
        return ll_ok();
    atomic_fetch_add(&host->refused_store, 1);
    return ll_error(LL_IO, "Changes cannot be stored now, hence none is made: %.180s", why.text);
}
