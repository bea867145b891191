/* Classes of a store that several daemons share: claimed when they are asked for, given away when another
 * daemon asks, dropped when the lease is lost. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/hash.h"
#include "daemon/class/internal.h"
#include "daemon/support/log.h"

#define LOOK_NS (10 * LL_MS) /* between two claims */

static const char moves[] = "the class moves to another daemon";

bool ll_class_entry_is_held(const ll_class_entry *entry)
{
    return entry->daemon == ll_store_daemon(entry->classes->store);
}

/* Locked. */
static void end_here(ll_class_entry *entry)
{
    entry->ended = moves;
    entry->moved = true;
    entry->classes->news = true;
    pthread_cond_signal(&entry->classes->wake);
}

void ll_class_entry_check(ll_class_entry *entry)
{
    if (!entry->ended && !ll_class_entry_is_held(entry))
        end_here(entry);
}

bool ll_class_entry_has_moved(ll_class_entry *entry)
{
    pthread_mutex_lock(&entry->classes->lock);
    bool moved = entry->moved || entry->leaving || !ll_class_entry_is_held(entry);
    pthread_mutex_unlock(&entry->classes->lock);
    return moved;
}

/* ---- opening ---- */

ll_status ll_class_entry_open_shared(ll_class_entry *entry, ll_opened_class *opened)
{
    ll_classes *classes = entry->classes;
    char client[24], *text = ll_class_entry_text(entry);
    snprintf(client, sizeof client, "%016llx", (unsigned long long)entry->client);
    const ll_class_key *key = entry->class_key;
    ll_new_class wanted = {.id = entry->id,
                           .code = entry->code,
                           .text = text,
                           .client = client,
                           .most = classes->config.max_classes,
                           .most_client = classes->config.max_client_classes,
                           .class_key = entry->key_name,
                           .most_of_key = key ? key->most[LL_KEY_CLASSES] : -1};
    ll_status status = text ? ll_store_open_class(classes->store, &wanted, opened)
                            : ll_error(LL_NO_MEMORY, "out of memory: class");
    entry->stored = text ? ll_hash(1, text, strlen(text)) : 0;
    entry->stored_at = ll_host_now();
    free(text);
    return status;
}

/* ---- claiming ---- */

/* The class, if it is here. What is here and not held any more is taken off the list first. */
static ll_class_entry *take_here(ll_classes *classes, const char *id)
{
    pthread_mutex_lock(&classes->lock);
    ll_class_entry *entry = ll_classes_find_entry(classes, id, false);
    if (entry)
        ll_class_entry_check(entry);
    bool here = entry && !entry->ended && !entry->leaving;
    if (here)
        ll_class_entry_retain(entry);
    ll_classes_close_ended(classes);
    pthread_mutex_unlock(&classes->lock);
    return here ? entry : NULL;
}

static bool on_gives(void *context, const char *session)
{
    ll_classes *classes = context;
    bool leaving = false;
    pthread_mutex_lock(&classes->lock);
    for (const ll_class_entry *entry = classes->first; entry && !leaving; entry = entry->next)
        leaving = entry->leaving && strncmp(entry->id, session, LL_STEM_LENGTH) == 0;
    pthread_mutex_unlock(&classes->lock);
    return leaving;
}

static ll_status adopt(ll_classes *classes, const char *id, const ll_claim *claim, ll_class_entry **result)
{
    ll_class_entry *entry = NULL;
    LL_TRY(ll_class_entry_make(classes, id, claim->idle_ms, claim->text, &entry));
    entry->daemon = claim->daemon;
    entry->claimed_at = claim->why == LL_CLAIM_OWN ? 0 : ll_host_now();
    pthread_mutex_lock(&classes->lock);
    ll_status status = classes->stopping
                           ? ll_error(LL_UNAVAILABLE, "This daemon takes no sessions now; try again.")
                           : ll_class_entry_list(entry);
    classes->news = true;
    pthread_cond_signal(&classes->wake);
    pthread_mutex_unlock(&classes->lock);
    if (ll_failed(&status)) {
        ll_class_entry_release(entry);
        /* Its stream here has viewers that are just leaving. */
        return ll_error(LL_UNAVAILABLE, "The class is just leaving this daemon; try again.");
    }
    *result = entry;
    return status;
}

/* *result NULL: the claim says why. */
static ll_status claim(ll_classes *classes, const char *id, ll_claim *got, ll_class_entry **result)
{
    ll_store *store = classes->store;
    uint64_t released = atomic_load(&classes->released);
    ll_status status = ll_store_wait(store, released); /* what was given away is stored before */
    if (ll_failed(&status) && ll_store_get_outcome(store, released) != LL_STORE_LOST)
        return status;
    *result = take_here(classes, id);
    if (*result)
        return ll_ok();
    if (on_gives(classes, id))
        return ll_error(LL_UNAVAILABLE, "The class is just leaving this daemon; try again.");
    LL_TRY(ll_store_claim_class(store, id, got));
    if (got->result != LL_CLAIM_DONE)
        return ll_ok();
    status = adopt(classes, id, got, result);
    free(got->text);
    if (ll_failed(&status))
        atomic_store(&classes->released, ll_store_release_class(store, got->daemon, id));
    return status;
}

static void rest(void)
{
    nanosleep(&(struct timespec){.tv_nsec = LOOK_NS}, NULL);
}

ll_status ll_classes_obtain(ll_classes *classes, const char *id, bool ask, ll_task *task,
                            ll_class_entry **entry)
{
    ll_pursuit p = {.give_up = ll_host_now() + LL_PURSUIT_NS};
    for (;;) {
        ll_claim got = {.result = LL_CLAIM_REFUSED};
        LL_TRY(ll_store_check_lease(classes->store));
        pthread_mutex_lock(&classes->claiming);
        ll_status status = claim(classes, id, &got, entry);
        pthread_mutex_unlock(&classes->claiming);
        if (ll_failed(&status) || *entry)
            return status;
        if (got.result == LL_CLAIM_UNKNOWN)
            return ll_error(LL_NOT_FOUND, "Class not found.");
        bool elsewhere = p.next_look > 0 && !ask && !got.over; /* its owner was checked, and lives */
        if (got.result != LL_CLAIM_HELD || elsewhere || ll_host_now() > p.give_up)
            return ll_claim_refusal(&got);
        if (ll_task_end_reason(task) != LL_TASK_RUNNING)
            return ll_error(LL_INTERRUPTED, "the class was not claimed yet");
        p.quiet = !ask;
        LL_TRY(ll_pursuit_press(classes->host, id, &got, &p));
        if (!got.over)
            rest();
    }
}

/* ---- giving ---- */

/* The sessions first: while the class is leaving, none of them is claimed back. Their lines, the class and
 * its release are stored in this order. */
static void give(ll_class_entry *entry)
{
    ll_classes *classes = entry->classes;
    ll_host_give_stem(classes->host, entry->id);
    pthread_mutex_lock(&classes->lock);
    if (!entry->ended) {
        entry->touched = true;
        ll_class_entry_store(entry, ll_host_now());
        atomic_store(&classes->released, ll_store_release_class(classes->store, entry->daemon, entry->id));
        end_here(entry);
        ll_classes_close_ended(classes);
    }
    pthread_mutex_unlock(&classes->lock);
}

/* Locked. False: it was claimed just now, or leaves already. */
static bool begin_leaving(ll_class_entry *entry, ll_time keep)
{
    if (entry->ended || entry->leaving || ll_host_now() - entry->claimed_at < keep)
        return false;
    ll_class_entry_retain(entry);
    entry->leaving = true;
    return true;
}

static bool on_asked(void *context, const char *id)
{
    ll_classes *classes = context;
    pthread_mutex_lock(&classes->lock);
    ll_class_entry *entry = ll_classes_find_entry(classes, id, false);
    bool found = entry != NULL, leaves = found && begin_leaving(entry, LL_KEEP_NS);
    pthread_mutex_unlock(&classes->lock);
    if (leaves) {
        give(entry);
        ll_class_entry_release(entry);
    }
    return found;
}

static ll_status on_obtain(void *context, const char *id, ll_task *task)
{
    ll_class_entry *entry = NULL;
    ll_status status = ll_classes_obtain(context, id, true, task, &entry);
    ll_class_entry_release(entry);
    /* It may have ended just now: then its session can be claimed. */
    return status.code == LL_NOT_FOUND ? ll_ok() : status;
}

/* ---- for viewers ---- */

typedef struct expected {
    ll_classes *classes;
    char id[LL_ID_LENGTH + 1];
} expected;

static void run_claim(void *context, ll_task *task)
{
    expected *e = context;
    ll_class_entry *entry = NULL;
    ll_classes_obtain(e->classes, e->id, true, task, &entry);
    ll_class_entry_release(entry);
    free(e);
}

ll_ws_known ll_classes_expect(void *context, ll_stream_kind kind, const char *id)
{
    ll_classes *classes = context;
    expected *e = ll_store_is_shared(classes->store) && ll_is_id(id) ? malloc(sizeof *e) : NULL;
    (void)kind;
    if (!e)
        return LL_WS_UNKNOWN;
    ll_task_spec spec = {.client = "the daemon", .own = true, .run = run_claim, .context = e};
    e->classes = classes;
    snprintf(e->id, sizeof e->id, "%s", id);
    memcpy(spec.session, e->id, sizeof e->id);
    ll_status status = ll_tasks_add(classes->tasks, &spec, NULL);
    if (ll_failed(&status))
        free(e);
    return LL_WS_LATER;
}

void ll_classes_hand_over(ll_classes *classes)
{
    if (!classes || !ll_store_is_shared(classes->store))
        return;
    for (;;) {
        pthread_mutex_lock(&classes->lock);
        ll_class_entry *entry = classes->first;
        while (entry && !begin_leaving(entry, 0))
            entry = entry->next;
        pthread_mutex_unlock(&classes->lock);
        if (!entry)
            break;
        give(entry);
        ll_class_entry_release(entry);
    }
    uint64_t released = atomic_load(&classes->released);
    ll_status status = ll_store_wait(classes->store, released);
    if (ll_failed(&status) && ll_store_get_outcome(classes->store, released) != LL_STORE_LOST)
        ll_log_write("error", "classes not handed over", "%s", status.text);
}

void ll_classes_share(ll_classes *classes)
{
    classes->group =
        (ll_host_group){.context = classes, .obtain = on_obtain, .gives = on_gives, .give = on_asked};
    if (ll_store_is_shared(classes->store))
        ll_host_set_group(classes->host, &classes->group);
}
