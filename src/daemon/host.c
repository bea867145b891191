#include "daemon/host.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cjson/cJSON.h>

#include "base/assert.h"
#include "base/hash.h"
#include "daemon/hosted.h"
#include "daemon/log.h"

static const double mebi = 1 << 20;

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
    hosted->tick_ns = 10000;
    hosted->inputs_end = &hosted->inputs;
    atomic_init(&hosted->references, 1);
    atomic_init(&hosted->touched, ll_host_now());
    atomic_init(&hosted->status, -1);
    pthread_mutex_init(&hosted->lock, NULL);
    pthread_mutex_init(&hosted->inbox_lock, NULL);
    return hosted;
}

void ll_hosted_retain(ll_hosted *hosted)
{
    atomic_fetch_add(&hosted->references, 1);
}

void ll_hosted_release(ll_hosted *hosted)
{
    if (!hosted || atomic_fetch_sub(&hosted->references, 1) > 1)
        return;
    ll_viewers_forget(hosted);
    if (hosted->session)
        ll_session_destroy(hosted->session);
    atomic_fetch_sub(&hosted->host->memory, hosted->memory);
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
    return role;
}

void ll_hosted_on_line(void *context, const char *line, size_t length)
{
    ll_hosted *hosted = context;
    if (hosted->restoring)
        return;
    /* `rewind` and `restart`: the head of the stored row no longer holds, see ll_viewers_apply. */
    hosted->rewound = hosted->rewound || (length > 9 && memcmp(line, "{\"op\":\"re", 9) == 0);
    hosted->ticket = ll_store_line(hosted->host->store, hosted->stored.number, hosted->lines++, line, length);
}

static void count_memory(ll_hosted *hosted, int64_t bytes)
{
    atomic_fetch_add(&hosted->host->memory, bytes - hosted->memory);
    hosted->memory = bytes;
}

void ll_hosted_note(ll_hosted *hosted)
{
    ll_session_info info = ll_session_get_info(hosted->session);
    atomic_store(&hosted->status, (int)info.status);
    atomic_store(&hosted->parked, info.parked);
    count_memory(hosted, (int64_t)(info.parked ? info.bytes : info.awake_bytes));
}

ll_status ll_hosted_fits(ll_hosted *hosted)
{
    ll_host *host = hosted->host;
    int64_t others = atomic_load(&host->memory) - hosted->memory;
    int64_t wanted = (int64_t)ll_session_get_info(hosted->session).awake_bytes;
    if (others + wanted <= host->memory_max) {
        count_memory(hosted, wanted); /* before it catches up, which may take long */
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

static void control_number(ll_session *session, ll_time wall, const char *op, const char *name, double value)
{
    cJSON *control = cJSON_CreateObject();
    cJSON_AddStringToObject(control, "op", op);
    if (name)
        cJSON_AddNumberToObject(control, name, value);
    ll_session_control(session, wall, control); /* what was possible before the restart is possible now */
    cJSON_Delete(control);
}

/* As it was when its clock was last stored, or at the last stamped command when that is later. A playing
 * session went on from the daemon's start. */
static void resume(ll_hosted *hosted)
{
    const ll_stored *row = &hosted->stored;
    ll_session *session = hosted->session;
    ll_time wall = hosted->host->started;
    if (ll_session_get_info(session).head_tick < row->head_tick)
        ll_session_run_to(session, row->head_tick); /* an error is the session's own, it shows as `failed` */
    if (row->tick < row->head_tick && ll_session_get_info(session).head_tick == row->head_tick)
        control_number(session, wall, "seek", "tick", (double)row->tick);
    if (row->speed > 0 && ll_session_get_info(session).speed != row->speed)
        control_number(session, wall, "speed", "speed", row->speed);
    if (row->playing && ll_session_get_info(session).status == LL_SESSION_PAUSED)
        control_number(session, wall, "play", NULL, 0);
    hosted->wall = wall;
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

int64_t ll_hosted_advance(ll_hosted *hosted, ll_time wall, double max_ms)
{
    if (wall < hosted->wall)
        wall = hosted->wall;
    hosted->wall = wall;
    double chunk = max_ms * 1e6 / hosted->tick_ns;
    int64_t most = chunk < 1 ? 1 : chunk > 100000 ? 100000 : (int64_t)chunk;
    ll_session_info before = ll_session_get_info(hosted->session);
    int64_t from = cpu_now_ns();
    ll_session_meter(hosted->session, ll_viewers_any(hosted) ? cpu_now_ns : NULL); /* a page shows it */
    int64_t due = ll_session_advance(hosted->session, wall, most);
    int64_t ticks = ll_session_get_info(hosted->session).tick - before.tick;
    if (ticks > 0) {
        int64_t ns = cpu_now_ns() - from;
        ll_session_account(hosted->session, ns, ticks);
        hosted->tick_ns += ((double)ns / (double)ticks - hosted->tick_ns) * (ticks > 16 ? 0.5 : 0.1);
        if (hosted->tick_ns < 10)
            hosted->tick_ns = 10;
        atomic_fetch_add(&hosted->host->ticks, (uint64_t)ticks);
    }
    hosted->behind = due > 0;
    return due;
}

ll_status ll_hosted_enter(ll_hosted *hosted, ll_session **session, bool *was_parked)
{
    atomic_store(&hosted->touched, ll_host_now());
    pthread_mutex_lock(&hosted->lock);
    bool parked = hosted->session && ll_session_get_info(hosted->session).parked, loaded = !hosted->session;
    ll_status status =
        hosted->deleted ? ll_error(LL_NOT_FOUND, "There is no such session.") : ll_hosted_load(hosted);
    if (!ll_failed(&status) && (parked || loaded))
        status = ll_hosted_fits(hosted);
    if (ll_failed(&status)) {
        if (hosted->session && loaded)
            ll_session_park(hosted->session);
        if (hosted->session)
            ll_hosted_note(hosted);
        pthread_mutex_unlock(&hosted->lock);
        return status;
    }
    if (was_parked)
        *was_parked = parked;
    while (ll_hosted_advance(hosted, ll_host_now(), 2) > 0) {
        pthread_mutex_unlock(&hosted->lock); /* a worker or another request may want it between two chunks */
        pthread_mutex_lock(&hosted->lock);
        if (hosted->deleted) {
            pthread_mutex_unlock(&hosted->lock);
            return ll_error(LL_NOT_FOUND, "There is no such session.");
        }
    }
    *session = hosted->session;
    return ll_ok();
}

void ll_hosted_leave(ll_hosted *hosted)
{
    ll_hosted_note(hosted);
    pthread_mutex_unlock(&hosted->lock);
    ll_hosted_nudge(hosted);
}

/* ---- changes ---- */

ll_status ll_host_storable(ll_host *host)
{
    ll_status why;
    if (!ll_store_failing(host->store, &why))
        return ll_ok();
    atomic_fetch_add(&host->refused_store, 1);
    return ll_error(LL_IO, "Changes cannot be stored now, hence none is made: %.180s", why.text);
}

static ll_status apply(ll_hosted *hosted, ll_host_change *change, void *context, uint64_t *ticket)
{
    ll_session *session;
    ll_status status = ll_hosted_enter(hosted, &session, NULL);
    if (ll_failed(&status))
        return status;
    ll_time now = ll_host_now();
    double rate = hosted->host->config.max_commands_per_s;
    if (!ll_bucket_take(&hosted->commands, rate, rate * 2, now)) {
        atomic_fetch_add(&hosted->host->refused_commands, 1);
        status = ll_error(LL_LIMIT, "This session takes at most %g commands a second.", rate);
    } else {
        if (now > hosted->wall)
            hosted->wall = now;
        int64_t lines = hosted->lines;
        status = change(context, session, hosted->wall);
        if (!ll_failed(&status) || lines != hosted->lines)
            ll_hosted_save(hosted);
        *ticket = hosted->ticket;
    }
    ll_hosted_leave(hosted);
    return status;
}

ll_status ll_host_command(ll_host *host, ll_hosted *hosted, ll_host_change *change, void *context)
{
    ll_status status = ll_host_storable(host);
    if (ll_failed(&status))
        return status;
    uint64_t ticket = 0;
    status = apply(hosted, change, context, &ticket);
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
    if (first) {
        if (hosted->session)
            ll_session_destroy(hosted->session);
        hosted->session = NULL;
        count_memory(hosted, 0);
        atomic_store(&hosted->status, -1);
        *ticket = ll_store_delete(host->store, hosted->stored.number);
        ll_ws_stream_close(hosted->stream, LL_WS_NO_SESSION, "the session was deleted");
    }
    pthread_mutex_unlock(&hosted->lock);
    if (first)
        ll_host_unregister(host, hosted);
    return first;
}

ll_status ll_host_delete(ll_host *host, ll_hosted *hosted)
{
    ll_status status = ll_host_storable(host);
    if (ll_failed(&status))
        return status;
    uint64_t ticket = 0;
    if (!ll_host_discard(host, hosted, &ticket))
        return ll_error(LL_NOT_FOUND, "There is no such session.");
    atomic_fetch_add(&host->deleted, 1);
    return ll_store_wait(host->store, ticket);
}
