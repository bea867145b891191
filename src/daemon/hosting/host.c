#include "daemon/hosting/host.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cjson/cJSON.h>

#include "base/assert.h"
#include "base/hash.h"
#include "daemon/support/access.h"
#include "daemon/hosting/hosted.h"
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

ll_hosted *ll_hosted_new(ll_host *host)
{
    ll_hosted *hosted = calloc(1, sizeof *hosted);
    if (!hosted)
        return NULL;
    hosted->host = host;
    hosted->created_ms = unix_ms();
    hosted->published_tick = -1;
    hosted->inputs_end = &hosted->inputs;
    atomic_init(&hosted->references, 1);
    atomic_init(&hosted->touched, ll_host_now());
    atomic_init(&hosted->status, -1);
    pthread_mutex_init(&hosted->lock, NULL);
    pthread_mutex_init(&hosted->inbox_lock, NULL);
    pthread_cond_init(&hosted->ahead_over, NULL);
    return hosted;
}

void ll_hosted_release(ll_hosted *hosted)
{
    if (!hosted || atomic_fetch_sub(&hosted->references, 1) > 1)
        return;
    ll_viewers_forget(hosted);
    ll_frame_state_clear(&hosted->last);
    if (hosted->session)
        ll_session_destroy(hosted->session);
    atomic_fetch_sub(&hosted->host->memory, hosted->memory);
    ll_hosted_count_log(hosted, -atomic_load(&hosted->log_bytes));
    pthread_mutex_destroy(&hosted->lock);
    pthread_mutex_destroy(&hosted->inbox_lock);
    pthread_cond_destroy(&hosted->ahead_over);
    free(hosted);
}

const char *ll_hosted_id(const ll_hosted *hosted)
{
    return hosted->id;
}

const char *ll_hosted_code(const ll_hosted *hosted)
{
    return hosted->code;
}

int ll_hosted_viewers(const ll_hosted *hosted)
{
    return hosted->stream ? ll_ws_viewers(hosted->stream) : 0;
}

int ll_hosted_role(const ll_hosted *hosted, const char *key, size_t length)
{
    int role = LL_ROLE_NONE;
    for (int i = 0; i < hosted->key_count;
         i++) { /* all of them, so that time does not tell whose key it nearly was */
        if (ll_key_matches(&hosted->keys[i], key, length))
            role = i - 1;
    }
    return ll_access_is_operator(hosted->host->config.access, key, length) ? LL_ROLE_OWNER : role;
}

void ll_hosted_count_log(ll_hosted *hosted, int64_t bytes)
{
    atomic_fetch_add(&hosted->log_bytes, bytes);
    atomic_fetch_add(&hosted->host->log_bytes, bytes);
    if (hosted->share)
        atomic_fetch_add(hosted->share, bytes);
}

void ll_hosted_on_line(void *context, const char *line, size_t length)
{
    ll_hosted *hosted = context;
    if (hosted->restoring)
        return;
    /* `rewind` and `restart`: the head of the stored row no longer holds, see ll_viewers_apply. */
    hosted->rewound = hosted->rewound || (length > 9 && memcmp(line, "{\"op\":\"re", 9) == 0);
    ll_hosted_count_log(hosted, (int64_t)length + 1);
    hosted->ticket = ll_store_line(hosted->host->store, hosted->stored.number, hosted->lines++, line, length);
}

void ll_hosted_count_memory(ll_hosted *hosted, int64_t bytes)
{
    atomic_fetch_add(&hosted->host->memory, bytes - hosted->memory);
    hosted->memory = bytes;
}

void ll_hosted_note(ll_hosted *hosted)
{
    ll_session_info info = ll_session_get_info(hosted->session);
    atomic_store(&hosted->status, (int)info.status);
    atomic_store(&hosted->parked, info.parked);
    ll_hosted_count_memory(hosted, (int64_t)(info.parked ? info.bytes : info.awake_bytes));
}

ll_status ll_hosted_fits(ll_hosted *hosted)
{
    ll_host *host = hosted->host;
    int64_t others = atomic_load(&host->memory) - hosted->memory;
    int64_t wanted = (int64_t)ll_session_get_info(hosted->session).awake_bytes;
    if (others + wanted <= host->memory_max) {
        ll_hosted_count_memory(hosted, wanted); /* before it catches up, which may take long */
        return ll_ok();
    }
    atomic_fetch_add(&host->refused_memory, 1);
    return ll_error(
        LL_NO_MEMORY,
        "This session needs up to %.1f MiB; sessions that are awake need %.1f of the %.1f MiB that "
        "there are for all.",
        (double)wanted / mebi, (double)others / mebi, (double)host->memory_max / mebi);
}

void ll_hosted_save(ll_hosted *hosted)
{
    if (!hosted->session || hosted->deleted)
        return;
    ll_session_info info = ll_session_get_info(hosted->session);
    ll_stored *row = &hosted->stored;
    memcpy(row->id, hosted->id, sizeof row->id);
    memcpy(row->code, hosted->code, sizeof row->code);
    memcpy(row->keys, hosted->keys, sizeof row->keys);
    row->key_count = hosted->key_count;
    row->created_ms = hosted->created_ms;
    row->seen_ms = unix_ms();
    row->playing = info.status == LL_SESSION_PLAYING;
    row->speed = info.speed;
    row->tick = info.tick;
    row->head_tick = info.head_tick;
    row->lines = hosted->lines;
    hosted->saved_wall = hosted->wall;
    hosted->rewound = false;
    hosted->ticket = ll_store_put(hosted->host->store, row);
}

/* ---- loading ---- */

/* As it was when its clock was last stored, or at the last stamped command when that is later. A playing
 * session went on from the daemon's start. */
static void resume(ll_hosted *hosted)
{
    const ll_stored *row = &hosted->stored;
    bool older = row->head_tick < ll_session_get_info(hosted->session).head_tick;
    ll_session_place(hosted->session, hosted->host->started,
                     &(ll_session_place_at){.tick = older ? -1 : row->tick,
                                            .head = row->head_tick,
                                            .speed = row->speed,
                                            .playing = row->playing});
    hosted->wall = hosted->host->started;
}

ll_status ll_hosted_load(ll_hosted *hosted)
{
    if (hosted->session)
        return ll_ok();
    char *text = NULL;
    size_t length = 0;
    ll_status status = ll_store_read_log(hosted->host->store, hosted->stored.number, &text, &length);
    if (ll_failed(&status))
        return status;
    hosted->restoring = true;
    status = ll_session_restore(text, length, ll_hosted_on_line, hosted, &hosted->session);
    hosted->restoring = false;
    free(text);
    if (ll_failed(&status)) {
        hosted->session = NULL;
        ll_log_write("error", "session not restored", "Stored session %lld: %s",
                     (long long)hosted->stored.number, status.text);
        return ll_error(LL_IO, "The stored log of this session cannot be replayed: %.180s", status.text);
    }
    resume(hosted);
    ll_hosted_note(hosted);
    return ll_ok();
}

/* ---- the present ---- */

static int64_t cpu_now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * LL_SECOND + t.tv_nsec;
}

bool ll_hosted_is_heavy(const ll_hosted *hosted)
{
    return hosted->tick_ns == 0 || hosted->tick_ns > heavy_ms * 1e6; /* not known yet: it may be */
}

static void learn_cost(ll_hosted *hosted, int64_t ns, int64_t ticks)
{
    double each = (double)ns / (double)ticks, weight = hosted->tick_ns == 0 ? 1 : ticks > 16 ? 0.5 : 0.1;
    hosted->tick_ns += (each - hosted->tick_ns) * weight;
    if (hosted->tick_ns < 10)
        hosted->tick_ns = 10;
}

/* By this thread's own processor time: what a busy machine takes is not the tick's. */
static bool within(void *until_ns)
{
    return cpu_now_ns() < *(const int64_t *)until_ns;
}

static void account(ll_hosted *hosted, const ll_session_info *before, int64_t ns)
{
    int64_t ticks = ll_session_get_info(hosted->session).at_tick - before->at_tick;
    if (ticks <= 0)
        return;
    learn_cost(hosted, ns, ticks);
    if (!before->parked)
        ll_session_account(hosted->session, ns, ticks);
    atomic_fetch_add(&hosted->host->ticks, (uint64_t)ticks);
}

static int64_t advance(ll_hosted *hosted, ll_time wall, double max_ms, bool safely)
{
    if (wall < hosted->wall)
        wall = hosted->wall;
    hosted->wall = wall;
    double chunk = hosted->tick_ns > 0 ? max_ms * 1e6 / hosted->tick_ns : 1;
    int64_t most = chunk < 1 ? 1 : chunk > 100000 ? 100000 : (int64_t)chunk, due;
    ll_session_info before = ll_session_get_info(hosted->session);
    bool broken_off = false;
    int64_t from = cpu_now_ns(), until = from + (int64_t)((max_ms + given_up_ms) * 1e6);
    ll_interrupt interrupt = {within, cpu_now_ns, &until};
    ll_session_meter(hosted->session, ll_viewers_any(hosted) ? cpu_now_ns : NULL); /* a page shows it */
    ll_session_set_patience(hosted->session, &interrupt);
    if (safely)
        due = ll_session_advance_safely(hosted->session, wall, most, &broken_off);
    else
        due = ll_session_advance(hosted->session, wall, most);
    ll_session_set_patience(hosted->session, NULL);
    broken_off = broken_off || (!before.parked && ll_session_get_info(hosted->session).parked);
    if (broken_off && hosted->tick_ns < given_up_ms * 1e6)
        hosted->tick_ns = given_up_ms * 1e6;
    else if (!broken_off)
        account(hosted, &before, cpu_now_ns() - from);
    hosted->behind = due > 0;
    return due;
}

int64_t ll_hosted_advance(ll_hosted *hosted, ll_time wall, double max_ms)
{
    return advance(hosted, wall, max_ms, false);
}

typedef struct making {
    const ll_hosted *hosted;
    ll_task *task;
    ll_time until; /* 0: as long as it takes */
    uint32_t stops;
} making;

static bool is_wanted(void *context)
{
    const making *m = context;
    return atomic_load(&m->hosted->stops) == m->stops && (m->until == 0 || ll_host_now() < m->until) &&
           ll_task_go_on(m->task);
}

/* Unlocks it meanwhile. */
static int64_t make_ahead(ll_hosted *hosted, ll_task *task, ll_ahead *ahead, double most_ms)
{
    ll_time until = most_ms > 0 ? ll_host_now() + (ll_time)(most_ms * 1e6) : 0;
    making m = {hosted, task, until, atomic_load(&hosted->stops)};
    ll_interrupt interrupt = {is_wanted, cpu_now_ns, &m};
    hosted->ahead = true;
    pthread_mutex_unlock(&hosted->lock);
    int64_t from = cpu_now_ns();
    ll_ahead_run(ahead, &interrupt);
    int64_t ns = cpu_now_ns() - from;
    pthread_mutex_lock(&hosted->lock);
    hosted->ahead = false;
    pthread_cond_broadcast(&hosted->ahead_over);
    if (hosted->deleted || !hosted->session) {
        ll_ahead_free(ahead);
        return -1;
    }
    ll_session_info before = ll_session_get_info(hosted->session);
    int64_t due = ll_session_end_ahead(hosted->session, ahead, hosted->wall);
    account(hosted, &before, ns);
    if (ll_session_get_info(hosted->session).at_tick == before.at_tick && hosted->tick_ns < (double)ns)
        hosted->tick_ns = (double)ns; /* at least */
    hosted->behind = due > 0;
    return due;
}

/* At most `ms`, while somebody makes a tick of it. */
static void await_ahead(ll_hosted *hosted, double ms)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    int64_t ns = until.tv_nsec + (int64_t)(ms * 1e6);
    until.tv_sec += ns / LL_SECOND;
    until.tv_nsec = ns % LL_SECOND;
    while (hosted->ahead && pthread_cond_timedwait(&hosted->ahead_over, &hosted->lock, &until) == 0)
        ;
}

int64_t ll_hosted_work(ll_hosted *hosted, ll_task *task, double most_ms)
{
    ll_ahead *ahead = NULL;
    ll_time now = ll_host_now();
    if (hosted->ahead) {
        await_ahead(hosted, patience_ms);
        return hosted->deleted || !hosted->session ? -1 : ll_session_due(hosted->session, hosted->wall);
    }
    if (!ll_hosted_is_heavy(hosted))
        return advance(hosted, now, piece_ms, true);
    if (now > hosted->wall)
        hosted->wall = now;
    ll_session_meter(hosted->session, ll_viewers_any(hosted) ? cpu_now_ns : NULL);
    ll_status status = ll_session_begin_ahead(hosted->session, hosted->wall, &ahead);
    return ll_failed(&status) || !ahead ? advance(hosted, now, piece_ms, true)
                                        : make_ahead(hosted, task, ahead, most_ms);
}

ll_status ll_hosted_change(ll_hosted *hosted, const ll_host_orders *orders, ll_session *session)
{
    int64_t until = cpu_now_ns() + (int64_t)(given_up_ms * 1e6);
    ll_interrupt interrupt = {within, cpu_now_ns, &until};
    ll_session_set_patience(session, &interrupt);
    ll_status status = orders->change(orders->context, session, hosted->wall);
    ll_session_set_patience(session, NULL);
    if (ll_session_get_info(session).parked)
        hosted->tick_ns = 0;
    return status;
}

void ll_hosted_stop_work(ll_hosted *hosted)
{
    await_ahead(hosted, finish_ms);
    if (hosted->ahead)
        atomic_fetch_add(&hosted->stops, 1);
}

/* ---- entering ---- */

static bool try_lock(ll_hosted *hosted, double ms)
{
    struct timespec until;
    if (pthread_mutex_trylock(&hosted->lock) == 0)
        return true;
    clock_gettime(CLOCK_REALTIME, &until);
    int64_t ns = until.tv_nsec + (int64_t)(ms * 1e6);
    until.tv_sec += ns / LL_SECOND;
    until.tv_nsec = ns % LL_SECOND;
    return pthread_mutex_timedlock(&hosted->lock, &until) == 0;
}

ll_status ll_hosted_lock(ll_hosted *hosted, ll_task *task)
{
    while (!try_lock(hosted, patience_ms)) {
        if (!task || !ll_task_go_on(task))
            return ll_error(LL_INTERRUPTED, "the session was busy");
    }
    if (!hosted->deleted)
        return ll_ok();
    pthread_mutex_unlock(&hosted->lock);
    return ll_error(LL_NOT_FOUND, "There is no such session.");
}

/* Into memory, and on its way to be awake; locked. */
static ll_status stir(ll_hosted *hosted)
{
    bool loaded = !hosted->session;
    ll_status status = ll_hosted_load(hosted);
    if (!ll_failed(&status))
        status = ll_hosted_fits(hosted);
    if (!ll_failed(&status))
        status = ll_session_begin_to_wake(hosted->session);
    if (ll_failed(&status) && hosted->session) {
        if (loaded)
            ll_session_park(hosted->session);
        ll_hosted_note(hosted);
    }
    return status;
}

/* Lets others at the session, and the task's turn pass. Locked again unless it fails. */
static ll_status pause_between(ll_hosted *hosted, ll_task *task)
{
    pthread_mutex_unlock(&hosted->lock);
    atomic_store(&hosted->touched, ll_host_now());
    if (!ll_task_go_on(task))
        return ll_error(LL_INTERRUPTED, "the session was not awake yet");
    return ll_hosted_lock(hosted, task);
}

static ll_status wake(ll_hosted *hosted, ll_task *task)
{
    ll_status status = ll_ok();
    while (!hosted->session || ll_session_get_info(hosted->session).parked) {
        status = stir(hosted);
        if (ll_failed(&status)) {
            pthread_mutex_unlock(&hosted->lock);
            return status;
        }
        if (ll_hosted_work(hosted, task, 0) < 0) {
            pthread_mutex_unlock(&hosted->lock);
            return ll_error(LL_NOT_FOUND, "There is no such session.");
        }
        if (!ll_session_get_info(hosted->session).parked)
            break;
        status = pause_between(hosted, task);
        if (ll_failed(&status))
            return status;
    }
    return status;
}

/* How long it would take to bring it to the present; 0 when it is there, or is not meant to be. */
static double behind_ms(ll_hosted *hosted)
{
    bool seeking = ll_session_get_info(hosted->session).seeking;
    int64_t due = seeking ? 0 : ll_session_due(hosted->session, ll_host_now());
    double tick_ns = hosted->tick_ns > 0 ? hosted->tick_ns : 1000;
    return (double)due * tick_ns * 1e-6;
}

/* What can be brought to the present soon is. */
static ll_status catch_up(ll_hosted *hosted, ll_task *task)
{
    ll_status status = ll_ok();
    ll_time until = ll_host_now() + (ll_time)(2 * catch_up_ms * 1e6);
    double behind = behind_ms(hosted);
    while (behind > 0 && behind < catch_up_ms && ll_host_now() < until && !hosted->ahead) {
        if (!task && (behind > piece_ms || hosted->tick_ns == 0)) {
            pthread_mutex_unlock(&hosted->lock);
            return ll_error(LL_INTERRUPTED, "the session was not up to date");
        }
        if (!task)
            ll_hosted_advance(hosted, ll_host_now(), piece_ms);
        if (task && ll_hosted_work(hosted, task, catch_up_ms) < 0) {
            pthread_mutex_unlock(&hosted->lock);
            return ll_error(LL_NOT_FOUND, "There is no such session.");
        }
        behind = behind_ms(hosted);
        if (!task || behind == 0)
            break;
        status = pause_between(hosted, task);
        if (ll_failed(&status))
            return status;
    }
    return status;
}

ll_status ll_hosted_enter(ll_hosted *hosted, ll_task *task, ll_session **session, bool *was_parked)
{
    atomic_store(&hosted->touched, ll_host_now());
    ll_status status = ll_hosted_lock(hosted, task);
    if (ll_failed(&status))
        return status;
    bool parked = hosted->session && ll_session_get_info(hosted->session).parked;
    if (was_parked)
        *was_parked = parked;
    if (!task && (!hosted->session || parked)) {
        pthread_mutex_unlock(&hosted->lock);
        return ll_error(LL_INTERRUPTED, "the session was asleep");
    }
    status = wake(hosted, task);
    if (!ll_failed(&status))
        status = catch_up(hosted, task);
    *session = hosted->session;
    return status;
}

void ll_hosted_leave(ll_hosted *hosted)
{
    ll_hosted_note(hosted);
    pthread_mutex_unlock(&hosted->lock);
    ll_hosted_notify(hosted);
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
