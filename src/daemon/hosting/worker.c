/* The threads that pace sessions to the wall clock and publish their frames.
 *
 * A frame's 16.7 ms have LL_SLOTS slots at absolute times that all workers share; a session belongs to one of
 * them. Time between slots is used to catch up sessions that are behind, a chunk of about a millisecond at a
 * time. A worker whose sessions are all parked or paused waits for a nudge and uses no CPU. */
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "daemon/hosting/hosted.h"

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
static bool take(ll_hosted *hosted, uint32_t generation, ll_record_request *request)
{
    ll_frame *frame;
    if (generation != hosted->published_generation)
        ll_frame_state_clear(&hosted->last);
    request->wall_ns = (uint64_t)ll_host_now();
    ll_status status = ll_frame_take(hosted->session, request, hosted->seq + 1, &hosted->last, &frame);
    if (ll_failed(&status))
        return false;
    ll_ws_publish(hosted->stream, frame);
    ll_frame_release(frame);
    hosted->seq++;
    return true;
}

/* One frame if somebody looks and there is something new or asked for. */
static bool publish(ll_hosted *hosted, bool asked)
{
    ll_session_info info = ll_session_get_info(hosted->session);
    bool playing = info.status == LL_SESSION_PLAYING;
    ll_record_request request = {0};
    ll_ws_wants(hosted->stream, hosted->seq + 1, info.generation, !playing, &request);
    int viewers = (int)request.viewers;
    bool news = playing || info.tick != hosted->published_tick || info.status != hosted->published_status ||
                info.params_version != hosted->published_params ||
                info.generation != hosted->published_generation || viewers != hosted->published_viewers;
    bool wait = hosted->behind && hosted->tick_ns < chunk_ms * 1e6 &&
                hosted->wall - hosted->published_wall < behind_frame_ns;
    if (!(asked || news) || wait || viewers == 0)
        return false;
    if (request.channels == 0) {
        hosted->seq++; /* of slower viewers it is not the turn */
        return false;
    }
    if (!take(hosted, info.generation, &request))
        return false;
    hosted->published_tick = info.tick;
    hosted->published_status = info.status;
    hosted->published_params = info.params_version;
    hosted->published_generation = info.generation;
    hosted->published_viewers = viewers;
    hosted->published_wall = hosted->wall;
    atomic_fetch_add_explicit(&hosted->host->frames, 1, memory_order_relaxed);
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
static verdict unobserved(ll_hosted *hosted)
{
    if (!hosted->session || ll_session_get_info(hosted->session).parked)
        return LET_GO;
    ll_time now = ll_host_now();
    if (now - atomic_load(&hosted->touched) < park_after(hosted->host)) {
        atomic_store(&hosted->rests_until, hosted->behind ? now : now + unobserved_ns);
        return KEEP;
    }
    if (ll_session_get_info(hosted->session).seeking)
        return KEEP; /* whoever asked for it takes it there */
    ll_hosted_save(hosted);
    ll_frame_state_clear(&hosted->last);
    ll_session_park(hosted->session);
    ll_hosted_note(hosted);
    return LET_GO;
}

static verdict serve_locked(ll_hosted *hosted, ll_time deadline)
{
    bool asked =
        atomic_exchange(&hosted->pending, false); /* of one that is deleted, too: else it is never let go */
    atomic_store(&hosted->rests_until, 0);
    if (hosted->deleted)
        return LET_GO;
    if (!ll_viewers_any(hosted))
        return unobserved(hosted);
    if (!hosted->session || ll_session_get_info(hosted->session).parked) {
        ll_hosted_carry(hosted);
        return LET_GO;
    }
    atomic_store(&hosted->touched, ll_host_now());
    ll_viewers_greet(hosted);
    if (!hosted->ahead) /* else whoever makes the tick does, behind it */
        ll_viewers_apply(hosted, deadline > hosted->wall ? deadline : hosted->wall);
    if (!ll_hosted_is_heavy(hosted) && !hosted->ahead)
        ll_hosted_advance(hosted, deadline, chunk_ms);
    else if (ll_session_due(hosted->session, deadline) > 0)
        ll_hosted_carry(hosted);
    if (ll_session_get_info(hosted->session).parked) { /* a tick or a change took too long */
        ll_hosted_carry(hosted);
        return LET_GO;
    }
    bool sent = publish(hosted, asked);
    ll_session_status status = ll_session_get_info(hosted->session).status;
    if (hosted->wall - hosted->saved_wall > (ll_time)(hosted->host->config.save_every_s * 1e9) &&
        status == LL_SESSION_PLAYING)
        ll_hosted_save(hosted);
    ll_hosted_note(hosted);
    if (status != LL_SESSION_PLAYING && !hosted->behind)
        return LET_GO; /* until something changes */
    return sent ? KEEP_SENT : KEEP;
}

/* ---- the list of active sessions ---- */

/* Unless it was nudged in the meantime. */
static void let_go(ll_worker *worker, ll_hosted *hosted)
{
    bool gone = false;
    pthread_mutex_lock(&worker->lock);
    if (hosted->active && !atomic_load(&hosted->pending)) {
        for (int i = 0; i < worker->count; i++) {
            if (worker->active[i] == hosted) {
                worker->active[i] = worker->active[--worker->count];
                break;
            }
        }
        hosted->active = false;
        gone = true;
    }
    pthread_mutex_unlock(&worker->lock);
    if (gone)
        ll_hosted_release(hosted);
}

typedef struct round {
    ll_hosted **members; /* of the slot; each with a reference */
    int count, capacity;
} round;

/* Copies the slot's members out of the list, so that nothing waits for the worker while it computes. */
static void gather(ll_worker *worker, round *r, int slot)
{
    r->count = 0;
    ll_time now = ll_host_now();
    pthread_mutex_lock(&worker->lock);
    if (r->capacity < worker->count) {
        ll_hosted **bigger = realloc(r->members, (size_t)worker->capacity * sizeof *bigger);
        if (bigger) {
            r->members = bigger;
            r->capacity = worker->capacity;
        }
    }
    for (int i = 0; i < worker->count && r->count < r->capacity; i++) {
        ll_hosted *hosted = worker->active[i];
        bool rests = atomic_load(&hosted->rests_until) > now && !atomic_load(&hosted->pending);
        if (rests || (slot >= 0 && hosted->slot != slot))
            continue;
        ll_hosted_retain(hosted);
        r->members[r->count++] = hosted;
    }
    pthread_mutex_unlock(&worker->lock);
}

static void serve_slot(ll_worker *worker, round *r, int slot, ll_time deadline)
{
    bool sent = false;
    gather(worker, r, slot);
    for (int i = 0; i < r->count; i++) {
        ll_hosted *hosted = r->members[i];
        /* Whoever computes for it holds the lock for some milliseconds: its session misses a frame, no other
         * does. */
        if (pthread_mutex_trylock(&hosted->lock) == 0) {
            verdict v = serve_locked(hosted, deadline);
            pthread_mutex_unlock(&hosted->lock);
            sent = sent || v == KEEP_SENT;
            if (v == LET_GO) {
                sent = true; /* it may have published its last frame */
                let_go(worker, hosted);
            }
        }
        ll_hosted_release(hosted);
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
            ll_hosted *hosted = r->members[i];
            if (ll_host_now() + LL_MS < end && pthread_mutex_trylock(&hosted->lock) == 0) {
                if (hosted->behind && hosted->session && !hosted->deleted && !hosted->ahead &&
                    !ll_hosted_is_heavy(hosted) && !ll_session_get_info(hosted->session).parked)
                    more = ll_hosted_advance(hosted, hosted->wall, chunk_ms) > 0 || more;
                pthread_mutex_unlock(&hosted->lock);
            }
            ll_hosted_release(hosted);
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
        ll_hosted_release(worker->active[i]);
    worker->count = worker->capacity = 0;
    free(worker->active);
    worker->active = NULL;
}
