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
static const double piece_ms = 2;      /* for which a session is locked */
static const double heavy_ms = 2;      /* a tick that is longer is not for a worker */
static const double patience_ms = 20;  /* with a session that somebody works on */
static const double catch_up_ms = 250; /* what a request waits for at most */

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
    return hosted;
}

void ll_hosted_release(ll_hosted *hosted)
{
    if (!hosted || atomic_fetch_sub(&hosted->references, 1) > 1)
        return;
    ll_viewers_forget(hosted);
    if (hosted->session)
        ll_session_destroy(hosted->session);
    atomic_fetch_sub(&hosted->host->memory, hosted->memory);
    ll_hosted_count_log(hosted, -atomic_load(&hosted->log_bytes));
    pthread_mutex_destroy(&hosted->lock);
    pthread_mutex_destroy(&hosted->inbox_lock);
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

int64_t ll_hosted_advance(ll_hosted *hosted, ll_time wall, double max_ms)
{
    if (wall < hosted->wall)
        wall = hosted->wall;
    hosted->wall = wall;
    double chunk = hosted->tick_ns > 0 ? max_ms * 1e6 / hosted->tick_ns : 1;
    int64_t most = chunk < 1 ? 1 : chunk > 100000 ? 100000 : (int64_t)chunk;
    ll_session_info before = ll_session_get_info(hosted->session);
    int64_t from = cpu_now_ns();
    ll_session_meter(hosted->session, ll_viewers_any(hosted) ? cpu_now_ns : NULL); /* a page shows it */
    int64_t due = ll_session_advance(hosted->session, wall, most);
    int64_t ticks = ll_session_get_info(hosted->session).at_tick - before.at_tick;
    if (ticks > 0) {
        int64_t ns = cpu_now_ns() - from;
        learn_cost(hosted, ns, ticks);
        if (!before.parked)
            ll_session_account(hosted->session, ns, ticks);
        atomic_fetch_add(&hosted->host->ticks, (uint64_t)ticks);
    }
    hosted->behind = due > 0;
    return due;
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
        ll_hosted_advance(hosted, ll_host_now(), piece_ms);
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
    while (behind > 0 && behind < catch_up_ms && ll_host_now() < until) {
        if (!task && (behind > piece_ms || hosted->tick_ns == 0)) {
            pthread_mutex_unlock(&hosted->lock);
            return ll_error(LL_INTERRUPTED, "the session was not up to date");
        }
        ll_hosted_advance(hosted, ll_host_now(), piece_ms);
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
