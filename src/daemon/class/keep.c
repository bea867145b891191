/* Classes in the store. A change is made to a copy, which takes the place of the class when it is stored;
 * when the store fails, the copy is dropped. While one copy is written, the next gathers what comes: so
 * thirty votes at once take a few commits. A request that waits holds no lock. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "daemon/class/internal.h"
#include "daemon/support/access.h"
#include "daemon/support/log.h"

#define USE_NS (60 * LL_SECOND) /* between two notes of the last use */

/* The name stays when its line is missing, so that the class counts again when that is back. */
static void set_key(ll_class_entry *entry, const char *name)
{
    if (!name)
        return;
    snprintf(entry->key_name, sizeof entry->key_name, "%s", name);
    entry->class_key = ll_access_named_key(ll_host_get_config(entry->classes->host)->access, name);
}

/* As it is stored; the caller frees it. */
static char *text_of(const ll_class_entry *entry, const ll_class *c)
{
    cJSON *json = ll_class_save(c);
    cJSON_AddStringToObject(json, "code", entry->code);
    if (entry->key_name[0])
        cJSON_AddStringToObject(json, "class_key", entry->key_name);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    return text;
}

/* ---- writing; locked ---- */

static void drop(ll_class **c)
{
    if (*c)
        ll_class_end(*c);
    free(*c);
    *c = NULL;
}

static void publish(ll_class_entry *entry, ll_class **c)
{
    ll_class before = entry->values;
    entry->values = **c;
    entry->values.serial = before.serial;
    **c = before;
    drop(c);
}

/* The requests that waited continue. */
static void finish(const ll_class_entry *entry, class_wait **waits, const ll_status *status)
{
    while (*waits) {
        class_wait *w = *waits;
        *waits = w->next;
        w->status = *status;
        w->done = true;
    }
    pthread_cond_broadcast(&entry->classes->settled);
}

static void end_writing(ll_class_entry *entry)
{
    entry->writing = false;
    atomic_fetch_sub(&entry->classes->writing, 1);
}

static void give_up(ll_class_entry *entry, const ll_status *why)
{
    end_writing(entry);
    drop(&entry->sent);
    drop(&entry->draft);
    finish(entry, &entry->sent_waits, why);
    finish(entry, &entry->draft_waits, why);
    entry->ending = NULL;
    entry->stored = 0;
    entry->touched = true;
    if (entry->stored_at == 0)
        entry->ended = "it was not stored";
}

static void take_over(ll_class_entry *entry)
{
    const ll_status good = ll_ok();
    if (entry->sent)
        publish(entry, &entry->sent);
    else
        entry->ended = entry->ending;
    finish(entry, &entry->sent_waits, &good);
    if (entry->ended)
        finish(entry, &entry->draft_waits, &good);
}

/* The ticket; 0: the store fails. */
static uint64_t write_sent(ll_class_entry *entry, const char *text)
{
    ll_store *store = entry->classes->store;
    int64_t idle_ms = (ll_now_ns() - entry->used) / LL_MS;
    if (!text)
        return ll_store_delete_text(store, LL_STORE_CLASS, entry->id);
    return ll_store_put_text(store, LL_STORE_CLASS, entry->id, ll_unix_ms() - (idle_ms > 0 ? idle_ms : 0),
                             text);
}

void ll_classes_wake(ll_classes *classes)
{
    classes->news = true;
    pthread_cond_signal(&classes->wake);
}

/* Begins to write the draft, or the end, unless something is being written. */
static void send_on(ll_class_entry *entry)
{
    ll_classes *classes = entry->classes;
    if (entry->writing || entry->ended || !(entry->draft || entry->ending))
        return;
    entry->sent_waits = entry->draft_waits;
    entry->draft_waits = NULL;
    if (entry->ending) {
        drop(&entry->draft);
    } else {
        entry->sent = entry->draft;
        entry->draft = NULL;
    }
    char *text = entry->sent ? text_of(entry, entry->sent) : NULL;
    uint64_t hash = text ? ll_hash(1, text, strlen(text)) : 0;
    if (classes->store && (!text || hash != entry->stored)) {
        ll_status why;
        entry->stored = hash;
        entry->writing = true;
        atomic_fetch_add(&classes->writing, 1); /* before the writer thread can see it */
        entry->ticket = write_sent(entry, text);
        if (entry->ticket == 0 && ll_store_failing(classes->store, &why))
            give_up(entry, &why);
    } else {
        take_over(entry);
    }
    free(text);
}

/* By the writer thread, after each commit and failure. A class that was being written when the store failed
 * is no longer in its queue. */
void ll_classes_on_commit(void *context)
{
    ll_classes *classes = context;
    ll_status why;
    if (atomic_load(&classes->writing) == 0)
        return;
    bool failing = ll_store_failing(classes->store, &why);
    uint64_t durable = ll_store_durable(classes->store);
    pthread_mutex_lock(&classes->lock);
    for (ll_class_entry *entry = classes->first; entry; entry = entry->next) {
        if (!entry->writing || (entry->ticket > durable && !failing))
            continue;
        if (entry->ticket > durable) {
            give_up(entry, &why);
            continue;
        }
        end_writing(entry);
        entry->stored_at = ll_now_ns();
        take_over(entry);
        send_on(entry);
    }
    ll_classes_wake(classes);
    pthread_mutex_unlock(&classes->lock);
}

static ll_class *copy_latest(const ll_class_entry *entry)
{
    return ll_class_copy(entry->draft ? entry->draft : entry->sent ? entry->sent : &entry->values);
}

/* `c`, which it takes, is the next to be written. */
static void set_draft(ll_class_entry *entry, ll_class *c)
{
    drop(&entry->draft);
    entry->draft = c;
}

void ll_class_entry_keep(ll_class_entry *entry, ll_time now)
{
    const ll_class *c = &entry->values;
    bool used = entry->used > entry->stored_at && now - entry->stored_at > USE_NS;
    entry->touched = entry->touched || c->changed || c->stirred;
    if (!entry->classes->store || !(entry->touched || used) || entry->writing ||
        ll_store_failing(entry->classes->store, NULL))
        return;
    set_draft(entry, copy_latest(entry));
    if (used)
        entry->stored = 0;
    entry->touched = false;
    send_on(entry);
}

/* ---- changes ---- */

void ll_class_entry_begin_end(ll_class_entry *entry, const char *reason)
{
    if (entry->ending || ll_store_failing(entry->classes->store, NULL))
        return;
    entry->ending = reason;
    send_on(entry);
}

/* Waits for the draft or the end; unlocked meanwhile. */
static ll_status wait_for_it(ll_class_entry *entry)
{
    class_wait wait = {.next = entry->draft_waits};
    entry->draft_waits = &wait;
    send_on(entry);
    while (!wait.done)
        pthread_cond_wait(&entry->classes->settled, &entry->classes->lock);
    return wait.status;
}

ll_status ll_class_entry_end(ll_class_entry *entry, const char *reason)
{
    ll_classes *classes = entry->classes;
    LL_TRY(ll_store_check(classes->store));
    pthread_mutex_lock(&classes->lock);
    ll_status status = ll_ok();
    if (!entry->ended) {
        entry->ending = entry->ending ? entry->ending : reason;
        status = wait_for_it(entry);
    }
    ll_classes_close_ended(classes);
    pthread_mutex_unlock(&classes->lock);
    return status;
}

ll_status ll_class_entry_store_new(ll_class_entry *entry)
{
    set_draft(entry, copy_latest(entry));
    return entry->draft ? wait_for_it(entry) : ll_error(LL_NO_MEMORY, "out of memory: class");
}

ll_status ll_class_entry_begin(ll_class_entry *entry, ll_class **c)
{
    ll_status status = ll_store_check(entry->classes->store);
    *c = NULL;
    pthread_mutex_lock(&entry->classes->lock);
    entry->used = ll_now_ns();
    if (!ll_failed(&status) && (entry->ended || entry->ending))
        status = ll_error(LL_NOT_FOUND, "The class has ended.");
    if (!ll_failed(&status) && !(entry->edited = copy_latest(entry)))
        status = ll_error(LL_NO_MEMORY, "out of memory: class");
    if (ll_failed(&status))
        pthread_mutex_unlock(&entry->classes->lock);
    else
        *c = entry->edited;
    return status;
}

ll_status ll_class_entry_store(ll_class_entry *entry, const ll_status *made)
{
    ll_status status = *made;
    if (ll_failed(&status)) {
        drop(&entry->edited);
    } else {
        set_draft(entry, entry->edited);
        entry->edited = NULL;
        status = wait_for_it(entry);
    }
    ll_classes_wake(entry->classes);
    pthread_mutex_unlock(&entry->classes->lock);
    return status;
}

/* ---- reading ---- */

static ll_status make_entry(ll_classes *classes, const char *id, int64_t idle_ms, const cJSON *json,
                            ll_class_entry **result)
{
    ll_class_entry *entry = calloc(1, sizeof *entry);
    const char *code = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "code"));
    ll_time now = ll_now_ns();
    if (!entry)
        return ll_error(LL_NO_MEMORY, "out of memory: class");
    ll_status status = ll_is_id(id) && code && ll_is_code(code)
                           ? ll_class_load(&entry->values, (int)classes->config.max_class_members, json, now)
                           : ll_error(LL_BAD_INPUT, "a stored class has no code");
    if (ll_failed(&status)) {
        free(entry);
        return status;
    }
    atomic_init(&entry->references, 1);
    entry->classes = classes;
    set_key(entry, cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "class_key")));
    entry->used = now - (idle_ms > 0 ? idle_ms : 0) * LL_MS;
    entry->stored_at = now;
    snprintf(entry->id, sizeof entry->id, "%s", id);
    snprintf(entry->code, sizeof entry->code, "%s", code);
    *result = entry;
    return status;
}

typedef struct reading {
    ll_classes *classes;
    char (*old)[LL_ID_LENGTH + 1]; /* ids to be deleted, after the list has been read */
    size_t count;
} reading;

static void forget(reading *r, const char *id)
{
    char(*more)[LL_ID_LENGTH + 1] = realloc(r->old, (r->count + 1) * sizeof *more);
    if (!more)
        return;
    r->old = more;
    snprintf(r->old[r->count++], sizeof *r->old, "%s", id);
}

static void restore(void *context, const char *id, int64_t seen_ms, const char *text)
{
    reading *r = context;
    ll_classes *classes = r->classes;
    if ((double)(ll_unix_ms() - seen_ms) > classes->config.class_ttl_s * 1e3) {
        forget(r, id);
        return;
    }
    ll_class_entry *entry = NULL;
    cJSON *json = cJSON_Parse(text);
    ll_status status = make_entry(classes, id, ll_unix_ms() - seen_ms, json, &entry);
    cJSON_Delete(json);
    if (!ll_failed(&status)) {
        pthread_mutex_lock(&classes->lock);
        status = ll_class_entry_list(entry);
        pthread_mutex_unlock(&classes->lock);
        ll_class_entry_release(entry);
    }
    if (ll_failed(&status))
        ll_log_write("warn", "stored class left out", "%s: %s", id, status.text);
}

ll_status ll_classes_restore(ll_classes *classes)
{
    reading r = {.classes = classes};
    ll_status status = ll_store_list_texts(classes->store, LL_STORE_CLASS, restore, &r);
    for (size_t i = 0; i < r.count; i++)
        ll_store_delete_text(classes->store, LL_STORE_CLASS, r.old[i]);
    free(r.old);
    return status;
}
