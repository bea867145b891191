/* What an operator sees of all sessions, and what class keys have of them. */
#include <stdlib.h>
#include <string.h>

#include "daemon/hosting/session_entry.h"
#include "daemon/support/access.h"

static int by_serial(const void *a, const void *b)
{
    int64_t x = ((const ll_host_entry *)a)->serial, y = ((const ll_host_entry *)b)->serial;
    return (x > y) - (x < y);
}

static void fill(ll_host_entry *entry, ll_session_entry *session_entry, ll_time now)
{
    *entry = (ll_host_entry){.serial = session_entry->identity.serial,
                             .status = atomic_load(&session_entry->shared.status),
                             .parked = atomic_load(&session_entry->shared.parked),
                             .viewers = ll_session_entry_viewers(session_entry),
                             .created_ms = session_entry->identity.created_ms,
                             .log_bytes = atomic_load(&session_entry->shared.log_bytes),
                             .class_key = atomic_load(&session_entry->shared.class_key)};
    ll_time last_used = atomic_load(&session_entry->shared.last_used);
    entry->idle_s = now > last_used ? ll_to_s(now - last_used) : 0;
    memcpy(entry->id, session_entry->identity.id, sizeof entry->id);
    memcpy(entry->code, session_entry->identity.code, sizeof entry->code);
}

ll_status ll_host_list(ll_host *host, int64_t after, int most, ll_host_entry **entries, int *count)
{
    ll_time now = ll_host_now();
    int64_t found = 0;
    pthread_mutex_lock(&host->registry.lock);
    ll_host_entry *all = malloc((size_t)(host->registry.sessions + 1) * sizeof *all);
    for (int i = 0; all && i < LL_HOST_BUCKETS; i++) {
        for (ll_session_entry *session_entry = host->registry.by_id[i]; session_entry;
             session_entry = session_entry->next_by_id) {
            if (session_entry->identity.serial > after)
                fill(&all[found++], session_entry, now);
        }
    }
    pthread_mutex_unlock(&host->registry.lock);
    if (!all)
        return ll_error(LL_NO_MEMORY, "out of memory: list of sessions");
    qsort(all, (size_t)found, sizeof *all, by_serial);
    *entries = all;
    *count = found < most ? (int)found : most;
    return ll_ok();
}

/* ---- class keys in a shared store ---- */

/* In a store of one daemon they are counted as sessions come and go. In one that daemons share the database
 * counts them, and each daemon notes the sizes of its logs there. */

bool ll_host_has_keys(const ll_host *host)
{
    const ll_access *access = host->config.access;
    return ll_store_is_shared(host->store) && access && access->class_keys.count > 0 &&
           access->class_keys.keys[0].name[0] != '\0';
}

/* Of sessions whose logs have grown since they were noted; these come first in `all` then. */
static int64_t list_sizes(ll_session_entry **all, int64_t count, ll_log_size *sizes)
{
    int64_t listed = 0;
    for (int64_t i = 0; i < count; i++) {
        ll_session_entry *one = all[i];
        int64_t bytes = atomic_load(&one->shared.log_bytes);
        if (!atomic_load(&one->shared.claimed) || !atomic_load(&one->shared.class_key) ||
            bytes == atomic_load(&one->shared.noted_bytes))
            continue;
        all[i] = all[listed];
        all[listed] = one;
        sizes[listed++] = (ll_log_size){.number = one->stored.place.number, .bytes = bytes};
    }
    return listed;
}

typedef struct counted {
    const ll_access *access;
    int64_t (*used)[LL_KEY_USES]; /* of each key */
} counted;

static void add_use(void *context, const ll_key_use *use)
{
    counted *c = context;
    const ll_class_key *key = ll_access_named_key(c->access, use->name);
    if (!key)
        return;
    int64_t *used = c->used[key - c->access->class_keys.keys];
    used[LL_KEY_SESSIONS] = use->sessions;
    used[LL_KEY_LOGS] = use->log_bytes;
    used[LL_KEY_CLASSES] = use->classes;
}

static void take_over(const counted *c)
{
    static const ll_key_quota counts[] = {LL_KEY_SESSIONS, LL_KEY_LOGS, LL_KEY_CLASSES};
    const ll_class_keys *keys = &c->access->class_keys;
    for (int i = 0; i < keys->count; i++) {
        for (size_t k = 0; k < sizeof counts / sizeof counts[0]; k++)
            atomic_store(&keys->keys[i].used[counts[k]], c->used[i][counts[k]]);
    }
}

/* Sizes that were not noted are so later. */
static void keep_noted(ll_session_entry **all, const ll_log_size *sizes, int64_t listed)
{
    for (int64_t i = 0; i < listed; i++)
        atomic_store(&all[i]->shared.noted_bytes, sizes[i].noted ? sizes[i].bytes : -1);
}

ll_status ll_host_count_keys(ll_host *host)
{
    if (!ll_host_has_keys(host))
        return ll_ok();
    ll_session_entry **all;
    int64_t count = ll_host_all(host, &all);
    counted c = {.access = host->config.access};
    c.used = calloc((size_t)c.access->class_keys.count, sizeof *c.used);
    ll_log_size *sizes = malloc((size_t)(count + 1) * sizeof *sizes);
    int64_t listed = sizes ? list_sizes(all, count, sizes) : 0;
    ll_status status = c.used && sizes ? ll_store_count_keys(host->store, sizes, listed, add_use, &c)
                                       : ll_error(LL_NO_MEMORY, "out of memory: class keys");
    if (!ll_failed(&status)) {
        keep_noted(all, sizes, listed);
        take_over(&c);
    }
    for (int64_t i = 0; i < count; i++)
        ll_session_entry_release(all[i]);
    free(all);
    free(c.used);
    free(sizes);
    return status;
}
