/* Sessions of a store that several daemons share: a request that arrives makes its daemon claim the session.
 *
 * A session that is not here is first registered by its id alone, so that viewers can already be accepted:
 * their hello follows when it is claimed. Only tasks ask the store. The first one claims; the others
 * wait for the session's lock.
 *
 * When a daemon has died, the others claim hundreds of sessions at once, of which many wait for an owner. So
 * a task that claims holds no turn of the tasks, only a few ask the store at once, first for those with
 * viewers, and the more wait for owners, the rarer each looks. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "daemon/hosting/session_entry.h"

#define ASK_NS (100 * LL_MS)     /* between two requests to the owner, and two looks whether it is there */
#define LOOK_NS (10 * LL_MS)     /* between two looks whether an owner has given a session, at least */
#define LOOK_EACH_NS (2 * LL_MS) /* of all sessions together */
#define LOOK_LONGEST_NS (200 * LL_MS)
#define WATCHED_NS                                                                                           \
    (50 * LL_MS) /* between two looks whether a session that waits for its turn has viewers                  \
                  */

enum {
    CLAIMS = 2,    /* at once: one is at the store, which has one connection for it, and the next is ready */
    REQUESTS = 32, /* that wait for claims: a part of the tasks that may be started */
};

/* ---- claiming; the session is locked ---- */

static ll_status adopt(ll_session_entry *session_entry, const ll_claim *claim, ll_claim_why why)
{
    const ll_stored *row = &claim->row;
    ll_entry_stored *stored = &session_entry->stored;
    if (row->lines == 0 || row->key_count < 1 || !ll_is_code(row->code))
        return ll_error(LL_IO, "Stored session has no log or no key.");
    if (!ll_session_entry_set_keys(session_entry, row->keys, row->key_count))
        return ll_error(LL_NO_MEMORY, "out of memory: session");
    stored->place = row->place;
    stored->playing = row->playing;
    stored->speed = row->speed;
    stored->tick = row->tick;
    stored->head_tick = row->head_tick;
    stored->lines = row->lines;
    stored->hash_tick = row->hash_tick;
    stored->hash_lines = row->hash_lines;
    stored->hash = row->hash;
    session_entry->wall = ll_host_now();
    session_entry->claimed_at = why == LL_CLAIM_OWN ? 0 : session_entry->wall;
    ll_session_entry_set_class_key(session_entry, ll_host_named_key(session_entry->host, row->class_key));
    ll_session_entry_count_log(session_entry, row->log_bytes);
    ll_host_name(session_entry->host, session_entry, row->code, row->created_ms);
    atomic_fetch_add(&session_entry->host->counts.claims[why], 1);
    ll_viewers_begin(session_entry);
    return ll_ok();
}

ll_status ll_claim_refusal(const ll_claim *claim)
{
    switch (claim->result) {
    case LL_CLAIM_UNKNOWN:
        return ll_error(LL_NOT_FOUND, "Session not found.");
    case LL_CLAIM_CLASS:
    case LL_CLAIM_ENGINE:
        return ll_error(
            LL_CONFLICT,
            "The session is of engine %s, and this daemon has engine %s, whose states may differ.",
            claim->engine, ll_engine);
    case LL_CLAIM_HELD:
        return ll_error(LL_UNAVAILABLE, "The session is at another daemon %.120s; try again.", claim->url);
    case LL_CLAIM_REFUSED:
    case LL_CLAIM_DONE:
        break;
    }
    return ll_error(LL_UNAVAILABLE, "This daemon takes no sessions now; try again.");
}

static void rest(ll_time ns)
{
    nanosleep(&(struct timespec){.tv_nsec = (long)ns}, NULL);
}

/* What was given away is stored before it can be claimed back. */
static ll_status wait_for_release(ll_host *host)
{
    uint64_t ticket = atomic_load(&host->sharing.released);
    ll_status status = ll_store_wait(host->store, ticket);
    return ll_store_get_outcome(host->store, ticket) == LL_STORE_LOST ? ll_ok() : status;
}

/* ---- turns at the store ---- */

static struct timespec from_now(ll_time ns)
{
    ll_time until = ll_host_now() + ns;
    return (struct timespec){.tv_sec = until / LL_SECOND, .tv_nsec = until % LL_SECOND};
}

static void take_claim_turn(ll_session_entry *session_entry)
{
    ll_host_sharing *sharing = &session_entry->host->sharing;
    bool watched = false;
    pthread_mutex_lock(&sharing->turn);
    for (;;) {
        if (!watched && ll_viewers_any(session_entry)) {
            watched = true;
            sharing->watched++;
        }
        if (sharing->claiming < CLAIMS && (watched || sharing->watched == 0))
            break;
        struct timespec deadline = from_now(WATCHED_NS);
        pthread_cond_timedwait(watched ? &sharing->watched_turn : &sharing->other_turn, &sharing->turn,
                               &deadline);
    }
    sharing->watched -= watched;
    sharing->claiming++;
    pthread_mutex_unlock(&sharing->turn);
}

static void end_claim_turn(ll_host_sharing *sharing)
{
    pthread_mutex_lock(&sharing->turn);
    sharing->claiming--;
    pthread_cond_signal(sharing->watched > 0 ? &sharing->watched_turn : &sharing->other_turn);
    pthread_mutex_unlock(&sharing->turn);
}

static ll_status claim_in_turn(ll_session_entry *session_entry, ll_claim *claim)
{
    ll_host *host = session_entry->host;
    take_claim_turn(session_entry);
    ll_status status = ll_store_check_lease(host->store);
    LL_THEN(status, ll_host_check_group(host, session_entry->identity.id));
    LL_THEN(status, ll_store_claim(host->store, session_entry->identity.id, claim));
    end_claim_turn(&host->sharing);
    return status;
}

/* ---- sessions of other owners ---- */

/* Until the next look. */
static void wait_for_owner(ll_host_sharing *sharing)
{
    ll_time ns = LOOK_EACH_NS * (atomic_fetch_add(&sharing->pursued, 1) + 1);
    rest(ns < LOOK_NS ? LOOK_NS : ns > LOOK_LONGEST_NS ? LOOK_LONGEST_NS : ns);
    atomic_fetch_sub(&sharing->pursued, 1);
}

ll_status ll_pursuit_press(ll_host *host, const char *id, const ll_claim *claim, ll_pursuit *p)
{
    ll_store *store = host->store;
    ll_time now = ll_host_now();
    if (claim->owner == 0 || (now < p->next_look && !claim->over))
        return ll_ok();
    p->next_look = now + ASK_NS;
    bool gone;
    ll_status status = ll_neighbour_judge(store, claim->owner, claim->url, claim->over, &gone);
    if (ll_failed(&status) || gone || p->quiet)
        return status;
    p->asked = true;
    return ll_store_ask(store, claim->owner, id);
}

static ll_status take_over(ll_session_entry *session_entry, ll_task *task)
{
    ll_host *host = session_entry->host;
    ll_claim claim;
    ll_pursuit p = {0};
    ll_task_step_aside(task);
    LL_TRY(wait_for_release(host));
    for (;;) {
        LL_TRY(claim_in_turn(session_entry, &claim));
        if (claim.result == LL_CLAIM_DONE)
            return adopt(session_entry, &claim,
                         p.asked && claim.why == LL_CLAIM_FREE ? LL_CLAIM_GIVEN : claim.why);
        if (p.give_up == 0)
            p.give_up = ll_host_now() + LL_PURSUIT_NS;
        if ((claim.result != LL_CLAIM_HELD && claim.result != LL_CLAIM_CLASS) || ll_host_now() > p.give_up)
            return ll_claim_refusal(&claim);
        if (ll_task_end_reason(task) != LL_TASK_RUNNING)
            return ll_error(LL_INTERRUPTED, "the session was not claimed yet");
        LL_TRY(claim.result == LL_CLAIM_CLASS
                   ? ll_host_obtain_group(host, claim.class_id, task)
                   : ll_pursuit_press(host, session_entry->identity.id, &claim, &p));
        if (!claim.over)
            wait_for_owner(&host->sharing);
    }
}

/* ---- registering by the id alone ---- */

static ll_status register_id(ll_host *host, const char *id, ll_session_entry **result)
{
    ll_session_entry *session_entry = ll_session_entry_new(host);
    if (!session_entry)
        return ll_error(LL_NO_MEMORY, "out of memory: session");
    memcpy(session_entry->identity.id, id, sizeof session_entry->identity.id);
    if (!ll_host_register_id(host, session_entry)) {
        ll_session_entry_release(session_entry);
        atomic_fetch_add(&host->refused.sessions, 1);
        return ll_error(LL_UNAVAILABLE, "Session limit of %lld reached.",
                        (long long)host->config.max_sessions);
    }
    ll_session_entry_retain(session_entry); /* for the stream */
    ll_status status =
        ll_ws_stream_open(host->ws, LL_STREAM_SESSION, id, session_entry, &session_entry->stream);
    if (ll_failed(&status)) {
        ll_session_entry_release(session_entry);
        ll_host_unregister(host, session_entry);
        ll_session_entry_release(session_entry);
        return ll_error(LL_UNAVAILABLE, "The session is just leaving this daemon; try again.");
    }
    *result = session_entry;
    return status;
}

/* The entry of this id, which is made if there is none. */
static ll_status find_or_register(ll_host *host, const char *id, bool *made, ll_session_entry **result)
{
    ll_status status = ll_ok();
    pthread_mutex_lock(&host->sharing.adding);
    *result = ll_host_find(host, id);
    if (*result && atomic_load(&(*result)->shared.dropped)) {
        ll_host_unregister(host, *result); /* who dropped it would do so in a moment */
        ll_session_entry_release(*result);
        *result = NULL;
    }
    *made = *result == NULL;
    if (*made)
        status = register_id(host, id, result);
    pthread_mutex_unlock(&host->sharing.adding);
    return status;
}

static int close_code(const ll_status *status)
{
    return status->code == LL_NOT_FOUND || status->code == LL_CONFLICT ? LL_WS_NO_SESSION : LL_WS_TRY_LATER;
}

static void run_claim(void *context, ll_task *task);

static ll_status start_claim(ll_session_entry *session_entry)
{
    ll_task_spec spec = {.client = "the daemon", .own = true, .run = run_claim, .context = session_entry};
    memcpy(spec.session, session_entry->identity.id, LL_ID_LENGTH + 1);
    ll_session_entry_retain(session_entry);
    ll_status status = ll_tasks_add(session_entry->host->tasks, &spec, NULL);
    if (ll_failed(&status))
        ll_session_entry_release(session_entry);
    return status;
}

/* The client of a request left while its task claimed; viewers may still wait. Locked. */
static bool goes_on_without(ll_session_entry *session_entry, const ll_status *status)
{
    if (status->code != LL_INTERRUPTED || !ll_viewers_any(session_entry))
        return false;
    ll_status started = start_claim(session_entry);
    return !ll_failed(&started);
}

static ll_status lock_to_claim(ll_session_entry *session_entry, ll_task *task)
{
    ll_status status = ll_session_entry_lock(session_entry, NULL);
    while (status.code == LL_INTERRUPTED && ll_task_end_reason(task) == LL_TASK_RUNNING) {
        ll_task_step_aside(task);
        status = ll_session_entry_lock(session_entry, NULL);
    }
    return status;
}

/* *again: the entry was dropped before it could be locked; another one may do. */
static ll_status settle(ll_session_entry *session_entry, ll_task *task, bool *again)
{
    bool dropped = false;
    ll_status status = lock_to_claim(session_entry, task);
    *again = ll_failed(&status) && status.code != LL_INTERRUPTED;
    if (ll_failed(&status))
        return status;
    if (!atomic_load(&session_entry->shared.claimed)) {
        status = take_over(session_entry, task);
        if (ll_failed(&status) && !goes_on_without(session_entry, &status)) {
            session_entry->moved = true;
            dropped = ll_session_entry_drop(session_entry, close_code(&status), status.text);
        }
    }
    pthread_mutex_unlock(&session_entry->lock);
    if (dropped)
        ll_host_unregister(session_entry->host, session_entry);
    else if (!ll_failed(&status))
        ll_session_entry_notify(session_entry);
    return status;
}

/* ---- for viewers ---- */

static void run_claim(void *context, ll_task *task)
{
    bool again;
    settle(context, task, &again);
    ll_session_entry_release(context);
}

static ll_status start_first_claim(ll_host *host, ll_session_entry *session_entry)
{
    ll_status status = start_claim(session_entry);
    if (ll_failed(&status))
        ll_host_forget(host, session_entry, status.text);
    return status;
}

ll_ws_known ll_host_expect(ll_host *host, const char *id)
{
    bool made;
    ll_session_entry *session_entry = NULL;
    if (!ll_store_is_shared(host->store) || !ll_is_id(id))
        return LL_WS_UNKNOWN;
    ll_status status = find_or_register(host, id, &made, &session_entry);
    if (ll_failed(&status))
        return LL_WS_LATER;
    if (made)
        status = start_first_claim(host, session_entry);
    ll_session_entry_release(session_entry);
    return ll_failed(&status) ? LL_WS_LATER : LL_WS_OPEN;
}

static ll_ws_known on_unknown(void *context, ll_stream_kind kind, const char *id)
{
    (void)kind;
    return ll_host_expect(context, id);
}

ll_ws_hooks ll_host_hooks(ll_host *host)
{
    ll_ws_hooks hooks = ll_viewers_hooks(host);
    hooks.unknown = on_unknown;
    return hooks;
}

/* ---- for requests ---- */

/* Whether it was claimed for an incarnation of this daemon that has lost its lease. */
static bool is_stale(ll_session_entry *session_entry)
{
    return session_entry->stored.place.daemon != ll_store_daemon(session_entry->host->store);
}

/* With what is here: false if the store has to be asked. */
static bool is_ready(ll_session_entry *session_entry)
{
    return session_entry && atomic_load(&session_entry->shared.claimed) && !is_stale(session_entry);
}

/* Waits for the claim; with too many that wait, the client is asked to come again, and the claim goes on. */
static ll_status wait_for_claim(ll_host *host, ll_session_entry *session_entry, bool made, ll_task *task,
                                bool *again)
{
    ll_status status =
        ll_error(LL_UNAVAILABLE, "This daemon takes over many sessions, and this one soon; try again.");
    *again = false;
    if (atomic_fetch_add(&host->sharing.requests, 1) < REQUESTS) {
        status = settle(session_entry, task, again);
    } else if (made) {
        ll_status started = start_first_claim(host, session_entry);
        status = ll_failed(&started) ? started : status;
    }
    atomic_fetch_sub(&host->sharing.requests, 1);
    return status;
}

static ll_status obtain(ll_host *host, const char *id, ll_task *task, ll_session_entry **result)
{
    bool made, again = true;
    ll_status status = ll_ok();
    for (int attempt = 0; attempt < 4 && again; attempt++) {
        status = find_or_register(host, id, &made, result);
        if (ll_failed(&status))
            return status;
        if (is_ready(*result))
            return status;
        if (atomic_load(&(*result)->shared.claimed)) {
            ll_host_forget(host, *result, "the daemon lost its lease");
            status = ll_error(LL_UNAVAILABLE, "This daemon has lost its lease on the session; try again.");
        } else {
            status = wait_for_claim(host, *result, made, task, &again);
        }
        if (!ll_failed(&status))
            return status;
        ll_session_entry_release(*result);
        *result = NULL;
    }
    return status;
}

ll_status ll_host_obtain(ll_host *host, const char *id, ll_task *task, ll_session_entry **result)
{
    *result = ll_host_find(host, id);
    if (!ll_store_is_shared(host->store) || !ll_is_id(id))
        return *result ? ll_ok() : ll_error(LL_NOT_FOUND, "Session not found.");
    ll_status status = ll_store_check_lease(host->store);
    if (!ll_failed(&status) && is_ready(*result))
        return status;
    ll_session_entry_release(*result);
    *result = NULL;
    LL_THEN(status, task ? obtain(host, id, task, result)
                         : ll_error(LL_INTERRUPTED, "the session is not at this daemon"));
    return status;
}

ll_status ll_host_find_code_id(ll_host *host, const char *code, char id[LL_ID_LENGTH + 1])
{
    ll_session_entry *session_entry = ll_host_find_code(host, code);
    if (session_entry) {
        memcpy(id, session_entry->identity.id, LL_ID_LENGTH + 1);
        ll_session_entry_release(session_entry);
        return ll_ok();
    }
    if (!ll_store_is_shared(host->store) || !ll_is_code(code))
        return ll_error(LL_NOT_FOUND, "Code not found.");
    return ll_store_find_code(host->store, code, id);
}
