/* The list of classes: opening, finding, ending, and whose keys count on which session. */
#include "daemon/class/classes.h"

#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "daemon/class/internal.h"

#define TICK_NS (100 * LL_MS) /* between two checks of the boards of classes with members */

#define ROW(name_, type_) LL_PARAM_ROW(#name_, type_, ll_classes_config, name_)

static const ll_param rows[] = {
    {ROW(max_classes, INT), .min = 0, .max = 10000, .default_value = 200,
     .help = "Classes that are open at once; 0: none may be opened."},
    {ROW(max_client_classes, INT), .min = 1, .max = 10000, .default_value = 20,
     .help = "Classes that one address has open at once."},
    {ROW(max_class_members, INT), .min = 1, .max = 1000, .default_value = 64,
     .help = "Members of a class; in a full one those without a connection, and those of the address with "
             "the most, make room."},
    {ROW(max_class_sessions, INT), .min = 1, .max = 10000, .default_value = 500,
     .help = "Sessions that were made for one class, boards and copies."},
    {ROW(class_ttl_s, REAL), .min = 1, .max = 1e9, .default_value = 14400, .unit = "s",
     .help = "A class ends after this time without connections and requests."},
};

const ll_param_table ll_classes_table = {
    .name = "classes", .help = "Classes and their limits.", LL_PARAM_ROWS(rows, ll_classes_config)};

/* ---- finding ---- */

uint64_t ll_class_client(const char *peer)
{
    return ll_hash(0, peer, strlen(peer));
}

/* Whether the code is known at this address already: the class was opened there, or has a member there.
 */
static bool is_known_at(const ll_class_entry *entry, uint64_t client)
{
    return entry && (entry->values.home == client || ll_class_at(&entry->values, client) > 0);
}

/* Looking up takes a token and finding gives it back, so that only codes that do not exist are counted: a
 * class of thirty joins at once from one address. A client that has guessed too often learns only what is
 * known at its address, so that who guesses keeps no other device behind the same router out of its class. */
ll_status ll_classes_find(ll_classes *classes, const char *name, const char *peer, ll_class_entry **result)
{
    char code[LL_CODE_LENGTH + 1];
    bool by_code = ll_code_read(name, code);
    ll_time now = ll_now_ns();
    *result = NULL;
    bool allowed = !by_code || ll_rate_limits_take(classes->lookups, peer, now);
    pthread_mutex_lock(&classes->lock);
    ll_class_entry *entry = ll_classes_find_entry(classes, by_code ? code : name, by_code);
    if (!allowed && !is_known_at(entry, ll_class_client(peer)))
        entry = NULL;
    if (entry) {
        ll_class_entry_retain(entry);
        entry->used = now;
    }
    pthread_mutex_unlock(&classes->lock);
    if (!entry && !allowed)
        return ll_error(LL_LIMIT, "Too many codes looked up from this address that do not exist.");
    if (!entry)
        return ll_error(LL_NOT_FOUND,
                        "Class not found. It has ended, or its daemon kept nothing over a restart.");
    if (by_code && allowed)
        ll_rate_limits_take_many(classes->lookups, peer, -1, now);
    *result = entry;
    return ll_ok();
}

/* ---- opening and ending ---- */

static ll_status check_quota(const ll_classes *classes, const ll_class_entry *entry)
{
    int64_t own = 0;
    ll_class_key *key = entry->class_key;
    for (const ll_class_entry *other = classes->first; other && !key; other = other->next)
        own += !other->key_name[0] && other->values.home == entry->values.home;
    if (classes->count >= classes->config.max_classes)
        return ll_error(LL_LIMIT, "classes: must be at most %lld at once (--max-classes)",
                        (long long)classes->config.max_classes);
    if (own >= classes->config.max_client_classes)
        return ll_error(LL_LIMIT,
                        "classes: must be at most %lld at once from one address "
                        "(--max-client-classes)",
                        (long long)classes->config.max_client_classes);
    if (!key || !ll_class_key_is_full(key, LL_KEY_CLASSES))
        return ll_ok();
    atomic_fetch_add(&key->refused, 1);
    return ll_error(LL_LIMIT, "The class key %s has as many classes as it may have (%lld); delete some.",
                    key->name, (long long)key->most[LL_KEY_CLASSES]);
}

static bool choose_names(const ll_classes *classes, ll_class_entry *entry)
{
    const char *shard = ll_host_get_config(classes->host)->shard;
    for (int attempt = 0; attempt < 1000; attempt++) {
        if (!ll_new_code(shard, entry->code) || !ll_new_id(shard, entry->id))
            return false;
        if (!ll_classes_find_entry(classes, entry->code, true))
            return true;
    }
    return false;
}

static ll_status add(ll_classes *classes, ll_class_entry *entry)
{
    LL_TRY(check_quota(classes, entry));
    if (classes->stopping || !choose_names(classes, entry))
        return ll_error(LL_UNAVAILABLE, "No class can be opened now.");
    LL_TRY(ll_class_entry_list(entry));
    ll_status status = ll_class_entry_store_new(entry);
    if (ll_failed(&status))
        ll_classes_close_ended(classes);
    return status;
}

ll_status ll_classes_open(ll_classes *classes, const char *peer, ll_class_key *class_key,
                          const struct cJSON *settings, char key[LL_KEY_LENGTH + 1], ll_class_entry **result)
{
    LL_TRY(ll_store_check(classes->store));
    ll_key_hash hash;
    ll_class_entry *entry = calloc(1, sizeof *entry);
    *result = NULL;
    if (!entry || !ll_new_key(key) || !ll_key_hash_make(key, &hash)) {
        free(entry);
        return ll_error(LL_NO_MEMORY, "out of memory: class");
    }
    atomic_init(&entry->references, 1);
    entry->classes = classes;
    entry->class_key = class_key;
    if (class_key)
        memcpy(entry->key_name, class_key->name, sizeof entry->key_name);
    entry->used = ll_now_ns();
    ll_status status = ll_class_init(&entry->values, (int)classes->config.max_class_members, &hash);
    LL_THEN(status, ll_class_change(&entry->values, settings));
    if (!ll_failed(&status)) {
        entry->values.home = ll_class_client(peer);
        pthread_mutex_lock(&classes->lock);
        status = add(classes, entry);
        pthread_mutex_unlock(&classes->lock);
    }
    if (ll_failed(&status))
        ll_class_entry_release(entry);
    else
        *result = entry;
    return status;
}

const ll_classes_config *ll_classes_get_config(const ll_classes *classes)
{
    return &classes->config;
}

int64_t ll_classes_count(ll_classes *classes)
{
    pthread_mutex_lock(&classes->lock);
    int64_t count = classes->count;
    pthread_mutex_unlock(&classes->lock);
    return count;
}

/* ---- the values of a class ---- */

const ll_class *ll_class_entry_lock(ll_class_entry *entry)
{
    pthread_mutex_lock(&entry->classes->lock);
    entry->used = ll_now_ns();
    if (!entry->ended)
        return &entry->values;
    pthread_mutex_unlock(&entry->classes->lock);
    return NULL;
}

void ll_class_entry_unlock(ll_class_entry *entry)
{
    pthread_mutex_unlock(&entry->classes->lock);
}

/* ---- keys ---- */

static int role_in(const ll_class *c, const char *session, const char *key, size_t length)
{
    if (strcmp(c->board.link.session, session) == 0) {
        if (ll_key_matches(&c->teacher, key, length))
            return LL_ROLE_OWNER;
        int place = ll_class_find(c, key, length);
        int player = place >= 0 ? c->members[place].player : -1;
        return player >= 0 && !c->board.script[player] ? player : LL_ROLE_NONE;
    }
    for (int i = 0; i < c->capacity; i++) {
        const ll_class_member *m = &c->members[i];
        if (m->used && strcmp(m->copy.session, session) == 0 && ll_key_matches(&m->token, key, length))
            return c->now.frozen ? LL_ROLE_NONE : LL_ROLE_OWNER;
    }
    return LL_ROLE_NONE;
}

/* A teacher's key counts as the owner's key of the board, a member's token as that of its player, and of its
 * copy while it is not frozen. */
static int guest_role(void *context, const char *session, const char *key, size_t length)
{
    ll_classes *classes = context;
    int role = LL_ROLE_NONE;
    pthread_mutex_lock(&classes->lock);
    for (const ll_class_entry *entry = classes->first; entry && role == LL_ROLE_NONE; entry = entry->next)
        role = entry->ended ? LL_ROLE_NONE : role_in(&entry->values, session, key, length);
    pthread_mutex_unlock(&classes->lock);
    return role;
}

/* ---- the thread ---- */

/* Returns whether it has to be visited again soon. */
static bool visit(ll_class_entry *entry, ll_time now)
{
    ll_classes *classes = entry->classes;
    const ll_class *c = &entry->values;
    bool active = entry->viewers || c->now.frozen || ll_class_runs(c) || now - entry->used < 10 * LL_SECOND;
    if (entry->viewers)
        entry->used = now;
    else if ((double)(now - entry->used) > classes->config.class_ttl_s * 1e9)
        ll_class_entry_begin_end(entry, "the class was not used for too long (--class-ttl-s)");
    if (entry->ended)
        return false;
    for (int i = 0; i < LL_CLASS_VERSIONS; i++) {
        ll_class *each = ll_class_entry_version(entry, i);
        if (each)
            ll_class_pass_time(each, now);
    }
    if (active && now - entry->looked_at >= TICK_NS) {
        entry->looked_at = now;
        ll_class_entry_look(entry);
    }
    ll_class_entry_work(entry, now);
    ll_class_entry_keep(entry, now);
    ll_class_entry_tell(entry, now);
    return active || entry->working || now < entry->retry_at;
}

static void wait_for_news(ll_classes *classes, bool active)
{
    struct timespec deadline = ll_deadline(CLOCK_MONOTONIC, active ? TICK_NS : LL_SECOND);
    while (!classes->stopping && !classes->news &&
           pthread_cond_timedwait(&classes->wake, &classes->lock, &deadline) == 0)
        ;
    classes->news = false;
}

static void *serve(void *context)
{
    ll_classes *classes = context;
    pthread_setname_np(pthread_self(), "classes");
    pthread_mutex_lock(&classes->lock);
    while (!classes->stopping) {
        bool active = false;
        ll_time now = ll_now_ns();
        for (ll_class_entry *entry = classes->first; entry; entry = entry->next)
            if (!entry->ended)
                active = visit(entry, now) || active;
        ll_classes_close_ended(classes);
        wait_for_news(classes, active);
    }
    pthread_mutex_unlock(&classes->lock);
    return NULL;
}

/* ---- start and stop ---- */

ll_status ll_classes_start(const ll_classes_config *config, ll_host *host, ll_store *store, ll_tasks *tasks,
                           ll_ws *ws, ll_classes **result)
{
    double lookups = ll_host_get_config(host)->max_code_lookups_per_min;
    ll_classes *classes = *result = calloc(1, sizeof *classes);
    if (!classes)
        return ll_error(LL_NO_MEMORY, "out of memory: classes");
    *classes = (ll_classes){.config = *config, .host = host, .tasks = tasks, .ws = ws, .store = store};
    pthread_mutex_init(&classes->lock, NULL);
    ll_cond_init(&classes->wake);
    ll_cond_init(&classes->settled);
    classes->lookups = ll_rate_limits_new(lookups / 60, lookups);
    ll_ws_hooks hooks = ll_classes_hooks(classes);
    ll_ws_set_hooks(ws, LL_STREAM_CLASS, &hooks);
    ll_host_set_guests(host, guest_role, classes);
    ll_store_on_commit(store, ll_classes_on_commit, classes);
    LL_TRY(ll_classes_restore(classes));
    classes->started = classes->lookups && pthread_create(&classes->thread, NULL, serve, classes) == 0;
    return classes->started ? ll_ok() : ll_error(LL_NO_MEMORY, "cannot start the thread of classes");
}

void ll_classes_stop(ll_classes *classes)
{
    if (!classes)
        return;
    pthread_mutex_lock(&classes->lock);
    classes->stopping = true;
    pthread_cond_signal(&classes->wake);
    pthread_mutex_unlock(&classes->lock);
    if (classes->started)
        pthread_join(classes->thread, NULL);
    classes->started = false;
}

void ll_classes_free(ll_classes *classes)
{
    if (!classes)
        return;
    while (classes->first) {
        ll_class_entry *entry = classes->first;
        classes->first = entry->next;
        atomic_fetch_sub(&entry->references, 1); /* the stream's: it was closed with the web server */
        ll_class_entry_release(entry);
    }
    ll_rate_limits_free(classes->lookups);
    pthread_cond_destroy(&classes->wake);
    pthread_cond_destroy(&classes->settled);
    pthread_mutex_destroy(&classes->lock);
    free(classes);
}
