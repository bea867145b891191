/* The threads that pace sessions to the wall clock and publish their frames.
 *
 * A frame's 16.7 ms have LL_SLOTS slots at absolute times that all workers share; a session belongs to one of
 * them. Time between slots is used to catch up sessions that are behind, a chunk of about a millisecond at a
 * time. A worker whose sessions are all parked or paused waits for a nudge and uses no CPU. */
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "daemon/hosting/session_entry.h"

enum { SLOT_HZ = LL_FRAME_HZ * LL_SLOTS };

static const double chunk_ms = 1.0; /* of one session at a time */
/* A session that catches up shows where it is this often; one whose ticks fill a chunk shows each: a frame
 * costs little beside them. */
static const ll_time behind_frame_ns = 100 * LL_MS;
/* One that nobody looks at is looked after this often, until it is parked. */
static const ll_time unobserved_ns = 250 * LL_MS;

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

/* Takes what viewers want of the present tick, and leaves the session as it is. */
static bool take(ll_session_entry *session_entry, uint32_t generation, ll_record_request *request)
{
    ll_frame *frame;
    if (generation != session_entry->published_generation)
        ll_frame_state_clear(&session_entry->last);
    request->wall_ns = (uint64_t)ll_host_now();
    ll_status status =
        ll_frame_take(session_entry->session, request, session_entry->seq + 1, &session_entry->last, &frame);
    if (ll_failed(&status))
        return false;
    ll_ws_publish(session_entry->stream, frame);
    ll_frame_release(frame);
    session_entry->seq++;
    return true;
}

/* One frame if somebody looks and there is something new or asked for. */
static bool publish(ll_session_entry *session_entry, bool asked)
{
    ll_session_info info = ll_session_get_info(session_entry->session);
    bool playing = info.status == LL_SESSION_PLAYING;
    ll_record_request request = {0};
    ll_ws_wants(session_entry->stream, session_entry->seq + 1, info.generation, !playing, &request);
    int viewers = (int)request.viewers;
    bool news = playing || info.tick != session_entry->published_tick ||
                info.status != session_entry->published_status ||
                info.params_version != session_entry->published_params ||
                info.generation != session_entry->published_generation ||
                viewers != session_entry->published_viewers;
    bool wait = session_entry->behind && session_entry->tick_ns < chunk_ms * 1e6 &&
                session_entry->wall - session_entry->published_wall < behind_frame_ns;
    if (!(asked || news) || wait || viewers == 0)
        return false;
    if (request.channels == 0) {
        session_entry->seq++; /* of slower viewers it is not the turn */
        return false;
    }
    if (!take(session_entry, info.generation, &request))
        return false;
    session_entry->published_tick = info.tick;
    session_entry->published_status = info.status;
    session_entry->published_params = info.params_version;
    session_entry->published_generation = info.generation;
    session_entry->published_viewers = viewers;
    session_entry->published_wall = session_entry->wall;
    atomic_fetch_add_explicit(&session_entry->host->frames, 1, memory_order_relaxed);
    return true;
}

/* ---- one session in its slot ---- */

typedef enum verdict { KEEP, KEEP_SENT, LET_GO } verdict;

/* How long a session stays awake that nobody looks at: the less, the more of the memory is taken, and not at
 * all beyond three quarters, so that one client's sessions do not keep others from theirs. */
static ll_time park_after(ll_host *host)
{
    double taken = (double)atomic_load(&host->memory) / (double)host->memory_max;
    double share = taken < 0.5 ? 1 : taken < 0.75 ? 4 * (0.75 - taken) : 0;
    return (ll_time)(host->config.park_after_s * 1e9 * share);
}

/* One that is parked has nothing to wait for: who wakes it notifies. */
static verdict unobserved(ll_session_entry *session_entry)
{
    if (!session_entry->session || ll_session_get_info(session_entry->session).parked)
        return LET_GO;
    ll_time now = ll_host_now();
    if (now - atomic_load(&session_entry->touched) < park_after(session_entry->host)) {
        atomic_store(&session_entry->rests_until, session_entry->behind ? now : now + unobserved_ns);
        return KEEP;
    }
    if (ll_session_get_info(session_entry->session).seeking)
        return KEEP; /* whoever asked for it takes it there */
    ll_session_entry_save(session_entry);
    ll_frame_state_clear(&session_entry->last);
    ll_session_park(session_entry->session);
    ll_session_entry_note(session_entry);
    return LET_GO;
}

static verdict serve_locked(ll_session_entry *session_entry, ll_time deadline)
{
    bool asked = atomic_exchange(&session_entry->pending,
                                 false); /* of one that is deleted, too: else it is never let go */
    atomic_store(&session_entry->rests_until, 0);
    if (session_entry->deleted)
        return LET_GO;
    if (!ll_viewers_any(session_entry))
        return unobserved(session_entry);
    if (!session_entry->session || ll_session_get_info(session_entry->session).parked) {
        ll_session_entry_carry(session_entry);
        return LET_GO;
    }
    atomic_store(&session_entry->touched, ll_host_now());
    ll_viewers_greet(session_entry);
    if (!session_entry->ahead) /* else whoever makes the tick does, behind it */
        ll_viewers_apply(session_entry, deadline > session_entry->wall ? deadline : session_entry->wall);
    if (!ll_session_entry_is_heavy(session_entry) && !session_entry->ahead)
        ll_session_entry_advance(session_entry, deadline, chunk_ms);
    else if (ll_session_due(session_entry->session, deadline) > 0)
        ll_session_entry_carry(session_entry);
    if (ll_session_get_info(session_entry->session).parked) { /* a tick or a change took too long */
        ll_session_entry_carry(session_entry);
        return LET_GO;
    }
    bool sent = publish(session_entry, asked);
    ll_session_status status = ll_session_get_info(session_entry->session).status;
    if (session_entry->wall - session_entry->saved_wall >
            (ll_time)(session_entry->host->config.save_every_s * 1e9) &&
        status == LL_SESSION_PLAYING)
        ll_session_entry_save(session_entry);
    ll_session_entry_note(session_entry);
    if (status != LL_SESSION_PLAYING && !session_entry->behind)
        return LET_GO; /* until something changes */
    return sent ? KEEP_SENT : KEEP;
}

/* ---- the list of active sessions ---- */

/* Unless it was nudged in the meantime. */
static void let_go(ll_worker *worker, ll_session_entry *session_entry)
{
    bool gone = false;
    pthread_mutex_lock(&worker->lock);
    if (session_entry->active && !atomic_load(&session_entry->pending)) {
        for (int i = 0; i < worker->count; i++) {
            if (worker->active[i] == session_entry) {
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

typedef struct round {
    ll_session_entry **members; /* of the slot; each with a reference */
    int count, capacity;
} round;

/* Copies the slot's members out of the list, so that nothing waits for the worker while it computes. */
static void gather(ll_worker *worker, round *r, int slot)
{
    r->count = 0;
    ll_time now = ll_host_now();
    pthread_mutex_lock(&worker->lock);
    if (r->capacity < worker->count) {
        ll_session_entry **bigger = realloc(r->members, (size_t)worker->capacity * sizeof *bigger);
        if (bigger) {
            r->members = bigger;
            r->capacity = worker->capacity;
        }
    }
    for (int i = 0; i < worker->count && r->count < r->capacity; i++) {
        ll_session_entry *session_entry = worker->active[i];
        bool rests = atomic_load(&session_entry->rests_until) > now && !atomic_load(&session_entry->pending);
        if (rests || (slot >= 0 && session_entry->slot != slot))
            continue;
        ll_session_entry_retain(session_entry);
        r->members[r->count++] = session_entry;
    }
    pthread_mutex_unlock(&worker->lock);
}

static void serve_slot(ll_worker *worker, round *r, int slot, ll_time deadline)
{
    bool sent = false;
    gather(worker, r, slot);
    for (int i = 0; i < r->count; i++) {
        ll_session_entry *session_entry = r->members[i];
        /* Whoever computes for it holds the lock for some milliseconds: its session misses a frame, no other
         * does. */
        if (pthread_mutex_trylock(&session_entry->lock) == 0) {
            verdict v = serve_locked(session_entry, deadline);
            pthread_mutex_unlock(&session_entry->lock);
            sent = sent || v == KEEP_SENT;
            if (v == LET_GO) {
                sent = true; /* it may have published its last frame */
                let_go(worker, session_entry);
            }
        }
        ll_session_entry_release(session_entry);
    }
    if (sent)
        ll_ws_flush(worker->host->ws);
}

/* Spends the time until `end` on sessions that are behind, in turns. */
static void catch_up(ll_worker *worker, round *r, ll_time end)
{
    bool more = true;
    while (more && ll_host_now() + LL_MS < end) {
        more = false;
        gather(worker, r, -1);
        for (int i = 0; i < r->count; i++) {
            ll_session_entry *session_entry = r->members[i];
            if (ll_host_now() + LL_MS < end && pthread_mutex_trylock(&session_entry->lock) == 0) {
                if (session_entry->behind && session_entry->session && !session_entry->deleted &&
                    !session_entry->ahead && !ll_session_entry_is_heavy(session_entry) &&
                    !ll_session_get_info(session_entry->session).parked)
                    more = ll_session_entry_advance(session_entry, session_entry->wall, chunk_ms) > 0 || more;
                pthread_mutex_unlock(&session_entry->lock);
            }
            ll_session_entry_release(session_entry);
        }
    }
}

/* ---- the thread ---- */

/* Sleeps until `until`; without active sessions until one is nudged. False at the end. */
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
    round r = {0};
    int64_t n = slot_at(ll_host_now());
    for (;;) {
        bool idle;
        int64_t late = slot_at(ll_host_now()) - ++n;
        n += late >= LL_SLOTS ? late / LL_SLOTS * LL_SLOTS
                              : 0; /* whole frames are left out, so that each slot has its turn */
        if (!sleep_until(worker, slot_time(n), &idle))
            break;
        if (idle)
            n = slot_at(ll_host_now());
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
    return worker->started ? ll_ok() : ll_error(LL_NO_MEMORY, "A worker's thread cannot be started.");
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
    pthread_mutex_lock(&worker->lock); /* requests may nudge still, in vain */
    for (int i = 0; i < worker->count; i++)
        worker->active[i]->active = false;
    pthread_mutex_unlock(&worker->lock);
    for (int i = 0; i < worker->count; i++)
        ll_session_entry_release(worker->active[i]);
    worker->count = worker->capacity = 0;
    free(worker->active);
    worker->active = NULL;
}
