/* Threads that pace sessions to the wall clock and publish their frames.
 *
 * A frame's 16.7 ms have LL_SLOTS slots at absolute times, the same for all workers; a session belongs to one
 * slot. The time between slots is used for sessions that are behind, about a millisecond for each in turn. A
 * worker whose sessions are all parked or paused waits for a notification and uses no CPU. */
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/prefetch.h"
#include "daemon/hosting/session_entry.h"

enum { SLOT_HZ = LL_FRAME_HZ * LL_SLOTS };

static const double chunk_ms = 1.0; /* of one session at a time */
/* Interval of frames of a session that is catching up. A session whose ticks fill a chunk publishes each
 * tick: a frame costs little compared with it. */
static const ll_time behind_frame_ns = 100 * LL_MS;
/* Interval of checks of a session without viewers, until it is parked. */
static const ll_time unwatched_check_ns = 250 * LL_MS;
static const size_t large_bytes = 4 << 20; /* a worker parks no larger session */

static ll_time slot_time(int64_t n)
{
    return n / SLOT_HZ * LL_SECOND + n % SLOT_HZ * LL_SECOND / SLOT_HZ;
}

static int64_t slot_at(ll_time t)
{
    int64_t n = t / LL_SECOND * SLOT_HZ + t % LL_SECOND * SLOT_HZ / LL_SECOND;
    return slot_time(n + 1) <= t ? n + 1 : n;
}

/* ---- frames ---- */

/* Takes the frame that viewers want of the present tick; the session does not change. */
static bool take_frame(ll_session_entry *session_entry, uint32_t generation, ll_record_request *request)
{
    ll_frame *frame;
    ll_row_set *space = &session_entry->host->workers[session_entry->identity.worker].space;
    if (generation != session_entry->published.generation)
        ll_frame_state_clear(&session_entry->published.last);
    request->wall_ns = (uint64_t)ll_now_ns();
    ll_status status = ll_frame_take(session_entry->session, request, session_entry->published.seq + 1,
                                     &session_entry->published.last, space, &frame);
    if (ll_failed(&status))
        return false;
    ll_ws_publish(session_entry->stream, frame);
    ll_ahead_note(&session_entry->work.ahead, session_entry->session, frame);
    ll_frame_release(frame);
    session_entry->published.seq++;
    return true;
}

/* Publishes one frame if there are viewers and something changed or was requested. */
static bool publish(ll_session_entry *session_entry, bool requested)
{
    ll_session_pulse now = ll_session_get_pulse(session_entry->session);
    bool playing = now.status == LL_SESSION_PLAYING;
    ll_record_request request = {0};
    ll_ws_wants(session_entry->stream, session_entry->published.seq + 1, now.generation, !playing, &request);
    int viewers = (int)request.viewers;
    bool news = playing || now.tick != session_entry->published.tick ||
                now.status != session_entry->published.status ||
                now.params_version != session_entry->published.params ||
                now.generation != session_entry->published.generation ||
                viewers != session_entry->published.viewers;
    bool wait = session_entry->work.behind && session_entry->work.tick_ns < chunk_ms * 1e6 &&
                session_entry->wall - session_entry->published.wall < behind_frame_ns;
    if (!(requested || news) || wait || viewers == 0)
        return false;
    if (request.channels == 0) {
        session_entry->published.seq++; /* no viewer is due: their rates are lower */
        return false;
    }
    if (!take_frame(session_entry, now.generation, &request))
        return false;
    session_entry->published.tick = now.tick;
    session_entry->published.status = now.status;
    session_entry->published.params = now.params_version;
    session_entry->published.generation = now.generation;
    session_entry->published.viewers = viewers;
    session_entry->published.wall = session_entry->wall;
    atomic_fetch_add_explicit(&session_entry->host->counts.frames, 1, memory_order_relaxed);
    return true;
}

/* ---- one session in its slot ---- */

typedef enum slot_result { ACTIVE, ACTIVE_SENT, INACTIVE } slot_result;

/* A parked session needs no visits: the thread that wakes it notifies the worker. The system takes
 * milliseconds to get the pages of a large state back: a task does that. */
static slot_result serve_unwatched(ll_session_entry *session_entry)
{
    if (!session_entry->session || ll_session_get_pulse(session_entry->session).parked)
        return INACTIVE;
    ll_time now = ll_now_ns();
    if (now - atomic_load(&session_entry->shared.last_used) < ll_host_park_after(session_entry->host)) {
        atomic_store(&session_entry->shared.next_visit,
                     session_entry->work.behind ? now : now + unwatched_check_ns);
        return ACTIVE;
    }
    if (!ll_session_entry_may_park(session_entry))
        return ACTIVE;
    if (ll_session_awake_bytes(session_entry->session) > large_bytes) {
        atomic_store(&session_entry->shared.next_visit, now + unwatched_check_ns);
        ll_session_entry_start_park(session_entry);
        return ACTIVE;
    }
    ll_session_entry_park(session_entry);
    return INACTIVE;
}

static slot_result serve_locked(ll_session_entry *session_entry, ll_time deadline)
{
    bool requested =
        atomic_exchange(&session_entry->shared.pending,
                        false); /* also of a deleted one, which would otherwise stay active without limit */
    atomic_store(&session_entry->shared.next_visit, 0);
    if (session_entry->deleted)
        return INACTIVE;
    if (!ll_viewers_any(session_entry))
        return serve_unwatched(session_entry);
    if (!session_entry->session || ll_session_get_pulse(session_entry->session).parked) {
        ll_session_entry_start_task(session_entry);
        return INACTIVE;
    }
    atomic_store(&session_entry->shared.last_used, ll_now_ns());
    ll_viewers_send_hellos(session_entry);
    if (!session_entry->work.background_tick) /* otherwise the task applies them after its tick */
        ll_viewers_apply(session_entry, deadline > session_entry->wall ? deadline : session_entry->wall);
    if (!ll_session_entry_is_heavy(session_entry) && !session_entry->work.background_tick)
        ll_session_entry_advance(session_entry, deadline, chunk_ms);
    else if (ll_session_due(session_entry->session, deadline) > 0)
        ll_session_entry_start_task(session_entry);
    if (ll_session_get_pulse(session_entry->session).parked) { /* a tick or a change took too long */
        ll_session_entry_start_task(session_entry);
        return INACTIVE;
    }
    bool sent = publish(session_entry, requested);
    ll_session_status status = ll_session_get_pulse(session_entry->session).status;
    if (session_entry->wall - session_entry->stored.saved_wall >
            (ll_time)(session_entry->host->config.save_every_s * 1e9) &&
        status == LL_SESSION_PLAYING && !ll_store_failing(session_entry->host->store, NULL))
        ll_session_entry_save(session_entry);
    if ((int)status != atomic_load(&session_entry->shared.status) ||
        session_entry->published.seq % LL_FRAME_HZ == 0) /* its memory grows slowly */
        ll_session_entry_update_stats(session_entry);
    if (status != LL_SESSION_PLAYING && !session_entry->work.behind)
        return INACTIVE; /* until something changes */
    return sent ? ACTIVE_SENT : ACTIVE;
}

/* ---- the list of active sessions ---- */

/* Unless it was notified meanwhile. */
static void deactivate(ll_worker *worker, ll_session_entry *session_entry)
{
    bool gone = false;
    pthread_mutex_lock(&worker->lock);
    if (session_entry->active && !atomic_load(&session_entry->shared.pending)) {
        for (int i = 0; i < worker->count; i++) {
            if (worker->active[i].session_entry == session_entry) {
                worker->active[i] = worker->active[--worker->count];
                break;
            }
        }
        session_entry->active = false;
        gone = true;
    }
    pthread_mutex_unlock(&worker->lock);
    if (gone)
        ll_session_entry_release(session_entry);
}

typedef struct slot_members {
    ll_session_entry **members; /* of the slot; each with a reference */
    int count, capacity;
} slot_members;

/* Copies the slot's members from the list, so that the list is not locked while the worker computes. */
static void copy_members(ll_worker *worker, slot_members *r, int slot)
{
    r->count = 0;
    ll_time now = ll_now_ns();
    pthread_mutex_lock(&worker->lock);
    if (r->capacity < worker->count) {
        ll_session_entry **bigger = realloc(r->members, (size_t)worker->capacity * sizeof *bigger);
        if (bigger) {
            r->members = bigger;
            r->capacity = worker->capacity;
        }
    }
    for (int i = 0; i < worker->count && r->count < r->capacity; i++) {
        ll_session_entry *session_entry = worker->active[i].session_entry;
        if (slot >= 0 && worker->active[i].slot != slot)
            continue;
        bool rests = atomic_load(&session_entry->shared.next_visit) > now &&
                     !atomic_load(&session_entry->shared.pending);
        if (rests)
            continue;
        ll_session_entry_retain(session_entry);
        r->members[r->count++] = session_entry;
    }
    pthread_mutex_unlock(&worker->lock);
}

/* While member `i` is served, what the next will touch comes into the cache. */
static void fetch_ahead(const slot_members *r, int i)
{
    if (i + 1 < r->count)
        ll_ahead_fetch(&r->members[i + 1]->work.ahead);
    if (i + 2 < r->count)
        ll_prefetch(r->members[i + 2], sizeof *r->members[i + 2]);
}

static void serve_slot(ll_worker *worker, slot_members *r, int slot, ll_time deadline)
{
    bool sent = false, behind = false;
    copy_members(worker, r, slot);
    for (int i = 0; i < r->count; i++) {
        ll_session_entry *session_entry = r->members[i];
        fetch_ahead(r, i);
        /* A task holds the lock for some milliseconds: then this session misses a frame, and no other session
         * waits. */
        if (pthread_mutex_trylock(&session_entry->lock) == 0) {
            slot_result v = serve_locked(session_entry, deadline);
            behind = behind || session_entry->work.behind;
            pthread_mutex_unlock(&session_entry->lock);
            sent = sent || v == ACTIVE_SENT;
            if (v == INACTIVE) {
                sent = true; /* it may have published its last frame */
                deactivate(worker, session_entry);
            }
        }
        ll_session_entry_release(session_entry);
    }
    worker->behind[slot] = behind;
    if (sent)
        ll_ws_flush(worker->host->ws);
}

static bool any_behind(const ll_worker *worker)
{
    for (int slot = 0; slot < LL_SLOTS; slot++)
        if (worker->behind[slot])
            return true;
    return false;
}

/* Spends the time until `end` on sessions that are behind, in turn. */
static void catch_up(ll_worker *worker, slot_members *r, ll_time end)
{
    bool more = any_behind(worker); /* else locking each session would be for nothing */
    while (more && ll_now_ns() + LL_MS < end) {
        more = false;
        copy_members(worker, r, -1);
        for (int i = 0; i < r->count; i++) {
            ll_session_entry *session_entry = r->members[i];
            if (ll_now_ns() + LL_MS < end && pthread_mutex_trylock(&session_entry->lock) == 0) {
                if (session_entry->work.behind && session_entry->session && !session_entry->deleted &&
                    !session_entry->work.background_tick && !ll_session_entry_is_heavy(session_entry) &&
                    !ll_session_get_pulse(session_entry->session).parked)
                    more = ll_session_entry_advance(session_entry, session_entry->wall, chunk_ms) > 0 || more;
                pthread_mutex_unlock(&session_entry->lock);
            }
            ll_session_entry_release(session_entry);
        }
    }
}

/* ---- the thread ---- */

/* Sleeps until `until`; without active sessions until a notification. False: the worker stops. */
static bool sleep_until(ll_worker *worker, ll_time until, bool *idle)
{
    struct timespec deadline = {.tv_sec = until / LL_SECOND, .tv_nsec = until % LL_SECOND};
    pthread_mutex_lock(&worker->lock);
    *idle = worker->count == 0;
    while (worker->count == 0 && !worker->stopping)
        pthread_cond_wait(&worker->wake, &worker->lock);
    bool stopping = worker->stopping;
    pthread_mutex_unlock(&worker->lock);
    while (!stopping && !*idle && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, NULL) != 0)
        ;
    return !stopping;
}

static void *work(void *argument)
{
    ll_worker *worker = argument;
    pthread_setname_np(pthread_self(), "worker");
    slot_members r = {0};
    int64_t n = slot_at(ll_now_ns());
    for (;;) {
        bool idle;
        int64_t late = slot_at(ll_now_ns()) - ++n;
        n += late >= LL_SLOTS ? late / LL_SLOTS * LL_SLOTS
                              : 0; /* skips whole frames, so that each slot has its turn */
        if (!sleep_until(worker, slot_time(n), &idle))
            break;
        if (idle)
            n = slot_at(ll_now_ns());
        serve_slot(worker, &r, (int)(n % LL_SLOTS), slot_time(n));
        catch_up(worker, &r, slot_time(n + 1));
    }
    free(r.members);
    return NULL;
}

void ll_worker_init(ll_host *host, ll_worker *worker, int index)
{
    worker->host = host;
    worker->index = index;
    pthread_mutex_init(&worker->lock, NULL);
    pthread_cond_init(&worker->wake, NULL);
}

ll_status ll_worker_start(ll_worker *worker)
{
    worker->started = pthread_create(&worker->thread, NULL, work, worker) == 0;
    return worker->started ? ll_ok() : ll_error(LL_NO_MEMORY, "cannot start worker thread");
}

void ll_worker_stop(ll_worker *worker)
{
    if (!worker->started)
        return;
    pthread_mutex_lock(&worker->lock);
    worker->stopping = true;
    pthread_cond_signal(&worker->wake);
    pthread_mutex_unlock(&worker->lock);
    pthread_join(worker->thread, NULL);
    worker->started = false;
    pthread_mutex_lock(&worker->lock); /* requests may still notify, without effect */
    for (int i = 0; i < worker->count; i++)
        worker->active[i].session_entry->active = false;
    pthread_mutex_unlock(&worker->lock);
    for (int i = 0; i < worker->count; i++)
        ll_session_entry_release(worker->active[i].session_entry);
    worker->count = worker->capacity = 0;
    free(worker->active);
    ll_row_set_free(&worker->space);
    worker->active = NULL;
}
