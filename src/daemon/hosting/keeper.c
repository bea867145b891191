/* The thread that keeps the sessions of this daemon in step with its lease on them.
 *
 * Lost: all sessions of the dead incarnation are dropped, and their viewers sent away with 1012; the store
 * accepts nothing more of them meanwhile. Not renewed in time: nothing is stepped or changed (which the
 * worker and each request check for themselves), viewers are sent away with 1013; it all goes on when the
 * store is back. Asked for a session by another daemon: it is stored, released and dropped, in that order,
 * unless it was claimed only just now, since two proxies that disagree would move it to and fro. */
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "daemon/hosting/session_entry.h"
#include "daemon/support/log.h"

#define LOOK_NS (50 * LL_MS)
#define KEEP_UNWATCHED_NS (500 * LL_MS) /* without viewers: those are at the daemon that asks */
/* Between two sessions at the end, so that the others do not get all at once. */
#define EACH_NS (10 * LL_MS)
#define LONGEST_NS (5 * LL_SECOND)

/* ---- one session ---- */

/* False: it is busy. */
static bool give(ll_session_entry *session_entry)
{
    ll_host *host = session_entry->host;
    ll_status status = ll_session_entry_lock(session_entry, NULL);
    if (ll_failed(&status))
        return status.code != LL_INTERRUPTED;
    if (!atomic_load(&session_entry->shared.claimed)) {
        pthread_mutex_unlock(&session_entry->lock);
        return false;
    }
    session_entry->moved = true;
    ll_session_entry_save(session_entry);
    atomic_store(&host->sharing.released, ll_store_release(host->store, session_entry->stored.place));
    bool dropped = ll_session_entry_drop(session_entry, LL_WS_RESTART, "the session moves to another daemon");
    pthread_mutex_unlock(&session_entry->lock);
    if (dropped) {
        ll_host_unregister(host, session_entry);
        atomic_fetch_add(&host->counts.given, 1);
    }
    return true;
}

/* ---- what the thread does ---- */

static void free_all(ll_session_entry **all, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        ll_session_entry_release(all[i]);
    free(all);
}

static bool is_stale(ll_session_entry *session_entry, int64_t daemon)
{
    return atomic_load(&session_entry->shared.claimed) && session_entry->stored.place.daemon != daemon;
}

/* False: some are busy. */
static bool drop_stale(ll_host *host, int64_t daemon)
{
    ll_session_entry **all;
    bool good = true;
    int64_t count = ll_host_all(host, &all), dropped = 0;
    for (int64_t i = 0; i < count; i++) {
        if (!is_stale(all[i], daemon))
            continue;
        bool gone = ll_host_forget(host, all[i], "the daemon lost its lease");
        dropped += gone;
        good = good && gone;
    }
    free_all(all, count);
    if (dropped > 0)
        ll_log_write("warn", "lease lost", "%lld sessions dropped.", (long long)dropped);
    return good;
}

static void freeze(ll_host *host, bool frozen)
{
    ll_session_entry **all;
    int64_t count = ll_host_all(host, &all);
    ll_log_write("warn", frozen ? "frozen" : "not frozen any more", "The store %s.",
                 frozen ? "does not answer" : "answers again");
    for (int64_t i = 0; i < count; i++) {
        if (frozen)
            ll_viewers_close(all[i], "the store does not answer; the session waits until it does");
        else
            ll_session_entry_notify(all[i]);
    }
    free_all(all, count);
}

static bool was_kept(ll_session_entry *session_entry)
{
    ll_time keep = ll_viewers_any(session_entry) ? LL_KEEP_NS : KEEP_UNWATCHED_NS;
    return ll_host_now() - session_entry->claimed_at >= keep;
}

/* A session that the store says is here, but is not, is claimed first: then it is here, and the next wish is
 * fulfilled. */
static void fulfil(ll_host *host, const char *id)
{
    if (ll_host_give_group(host, id))
        return;
    ll_session_entry *session_entry = ll_host_find(host, id);
    if (!session_entry)
        ll_host_expect(host, id);
    else if (atomic_load(&session_entry->shared.claimed) && was_kept(session_entry))
        give(session_entry); /* it is asked for again if it is busy */
    ll_session_entry_release(session_entry);
}

static void on_asked(void *context, const char *id)
{
    ll_host *host = context;
    ll_host_sharing *sharing = &host->sharing;
    if (!ll_is_id(id))
        return;
    pthread_mutex_lock(&sharing->lock);
    if (sharing->wish_count < LL_HOST_WISHES)
        memcpy(sharing->wishes[sharing->wish_count++], id, LL_ID_LENGTH + 1);
    pthread_cond_signal(&sharing->wake);
    pthread_mutex_unlock(&sharing->lock);
}

/* Waits a moment for wishes, and takes them. False: the host stops. */
static bool next_wishes(ll_host_sharing *sharing, char (*wishes)[LL_ID_LENGTH + 1], int *count)
{
    ll_time until = ll_host_now() + LOOK_NS;
    struct timespec deadline = {.tv_sec = until / LL_SECOND, .tv_nsec = until % LL_SECOND};
    pthread_mutex_lock(&sharing->lock);
    while (!sharing->stopping && sharing->wish_count == 0 &&
           pthread_cond_timedwait(&sharing->wake, &sharing->lock, &deadline) == 0)
        ;
    *count = sharing->wish_count;
    memcpy(wishes, sharing->wishes, (size_t)*count * sizeof *wishes);
    sharing->wish_count = 0;
    bool goes_on = !sharing->stopping;
    pthread_mutex_unlock(&sharing->lock);
    return goes_on;
}

static void *keep(void *argument)
{
    ll_host *host = argument;
    char wishes[LL_HOST_WISHES][LL_ID_LENGTH + 1];
    int64_t daemon = ll_store_daemon(host->store);
    bool frozen = false;
    int count;
    pthread_setname_np(pthread_self(), "keeper");
    while (next_wishes(&host->sharing, wishes, &count)) {
        int64_t now = ll_store_daemon(host->store);
        if (now != daemon && drop_stale(host, now))
            daemon = now;
        bool late = ll_store_lease_left_s(host->store) <= 0;
        if (late != frozen)
            freeze(host, late);
        frozen = late;
        for (int i = 0; i < count && !frozen; i++)
            fulfil(host, wishes[i]);
    }
    return NULL;
}

/* ---- start and end ---- */

void ll_keeper_init(ll_host *host)
{
    pthread_condattr_t monotonic;
    pthread_mutex_init(&host->sharing.adding, NULL);
    pthread_mutex_init(&host->sharing.lock, NULL);
    pthread_mutex_init(&host->sharing.turn, NULL);
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&host->sharing.wake, &monotonic);
    pthread_cond_init(&host->sharing.watched_turn, &monotonic);
    pthread_cond_init(&host->sharing.other_turn, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

void ll_keeper_free(ll_host *host)
{
    pthread_mutex_destroy(&host->sharing.adding);
    pthread_mutex_destroy(&host->sharing.lock);
    pthread_cond_destroy(&host->sharing.wake);
    pthread_mutex_destroy(&host->sharing.turn);
    pthread_cond_destroy(&host->sharing.watched_turn);
    pthread_cond_destroy(&host->sharing.other_turn);
}

ll_status ll_keeper_start(ll_host *host)
{
    if (!ll_store_is_shared(host->store))
        return ll_ok();
    ll_store_on_asked(host->store, on_asked, host);
    host->sharing.keeper_started = pthread_create(&host->sharing.keeper, NULL, keep, host) == 0;
    return host->sharing.keeper_started ? ll_ok() : ll_error(LL_NO_MEMORY, "cannot start keeper thread");
}

void ll_keeper_stop(ll_host *host)
{
    if (!host->sharing.keeper_started)
        return;
    ll_store_on_asked(host->store, NULL, NULL);
    pthread_mutex_lock(&host->sharing.lock);
    host->sharing.stopping = true;
    pthread_cond_signal(&host->sharing.wake);
    pthread_mutex_unlock(&host->sharing.lock);
    pthread_join(host->sharing.keeper, NULL);
    host->sharing.keeper_started = false;
}

static void rest(ll_time ns)
{
    nanosleep(&(struct timespec){.tv_sec = ns / LL_SECOND, .tv_nsec = ns % LL_SECOND}, NULL);
}

static void give_within(ll_session_entry *session_entry, ll_time most)
{
    ll_time until = ll_host_now() + most;
    while (!give(session_entry) && ll_host_now() < until)
        rest(EACH_NS);
}

void ll_host_give_stem(ll_host *host, const char *stem)
{
    ll_session_entry **all;
    int64_t count = ll_host_all(host, &all);
    for (int64_t i = 0; i < count; i++) {
        if (strncmp(all[i]->identity.id, stem, LL_STEM_LENGTH) == 0 && atomic_load(&all[i]->shared.claimed))
            give_within(all[i], LL_SECOND);
    }
    free_all(all, count);
}

void ll_host_hand_over(ll_host *host, double pause_s)
{
    ll_session_entry **all;
    ll_status status = ll_store_drain(host->store); /* from here on nothing is claimed */
    int64_t count = ll_host_all(host, &all);
    ll_time each = count * EACH_NS > LONGEST_NS ? LONGEST_NS / count : EACH_NS;
    if (count > 0)
        rest((ll_time)(pause_s * 1e9)); /* proxies see /readyz meanwhile */
    for (int64_t i = 0; i < count; i++) {
        give_within(all[i], LL_SECOND);
        rest(each);
    }
    free_all(all, count);
    LL_THEN(status, ll_store_wait(host->store, atomic_load(&host->sharing.released)));
    if (ll_failed(&status))
        ll_log_write("error", "sessions not handed over", "%s", status.text);
}
