/* What class keys have: sessions and their logs. In a store of one daemon they are counted as they come and
 * go. In one that daemons share the database counts them; each daemon notes the sizes of its logs there. */
#include <stdlib.h>

#include "daemon/hosting/session_entry.h"
#include "daemon/support/access.h"

ll_class_key *ll_host_named_key(const ll_host *host, const char *name)
{
    return ll_access_named_key(host->config.access, name);
}

bool ll_host_has_keys(const ll_host *host)
{
    const ll_access *access = host->config.access;
    return ll_store_is_shared(host->store) && access && access->class_keys.count > 0 &&
           access->class_keys.keys[0].name[0] != '\0';
}

void ll_session_entry_set_class_key(ll_session_entry *session_entry, ll_class_key *key)
{
    atomic_store(&session_entry->shared.class_key, key);
    atomic_store(&session_entry->shared.noted_bytes, -1);
    if (key && !ll_store_is_shared(session_entry->host->store))
        atomic_fetch_add(&key->used[LL_KEY_SESSIONS], 1);
}

void ll_session_entry_leave_class_key(ll_session_entry *session_entry)
{
    ll_class_key *key = atomic_exchange(&session_entry->shared.class_key, NULL);
    if (key && !ll_store_is_shared(session_entry->host->store))
        atomic_fetch_sub(&key->used[LL_KEY_SESSIONS], 1);
}

/* ---- in a shared store ---- */

/* Of sessions whose logs have grown since they were noted. */
static int64_t list_sizes(ll_session_entry **all, int64_t count, ll_log_size *sizes)
{
    int64_t listed = 0;
    for (int64_t i = 0; i < count; i++) {
        ll_entry_shared *shared = &all[i]->shared;
        int64_t bytes = atomic_load(&shared->log_bytes);
        if (!atomic_load(&shared->claimed) || !atomic_load(&shared->class_key) ||
            bytes == atomic_load(&shared->noted_bytes))
            continue;
        atomic_store(&shared->noted_bytes, bytes);
        sizes[listed++] = (ll_log_size){all[i]->stored.place.number, bytes};
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

/* Sizes that could not be noted are so again. */
static void note_again(ll_session_entry **all, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        atomic_store(&all[i]->shared.noted_bytes, -1);
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
    ll_status status =
        c.used && sizes ? ll_store_count_keys(host->store, sizes, list_sizes(all, count, sizes), add_use, &c)
                        : ll_error(LL_NO_MEMORY, "out of memory: class keys");
    if (ll_failed(&status))
        note_again(all, count);
    else
        take_over(&c);
    for (int64_t i = 0; i < count; i++)
        ll_session_entry_release(all[i]);
    free(all);
    free(c.used);
    free(sizes);
    return status;
}
