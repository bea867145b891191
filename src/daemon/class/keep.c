/* Classes in the store: written when they have changed, read when the daemon starts. A change is on its way
 * to the disk before others receive it, and there some milliseconds later. */
#include <cjson/cJSON.h>
#include <inttypes.h>
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
static char *text_of(const ll_class_entry *entry)
{
    char client[17];
    snprintf(client, sizeof client, "%016" PRIx64, entry->values.home);
    cJSON *json = ll_class_save(&entry->values);
    cJSON_AddStringToObject(json, "code", entry->code);
    cJSON_AddStringToObject(json, "client", client);
    if (entry->key_name[0])
        cJSON_AddStringToObject(json, "class_key", entry->key_name);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    return text;
}

void ll_class_entry_store(ll_class_entry *entry, ll_time now)
{
    const ll_class *c = &entry->values;
    ll_store *store = entry->classes->store;
    bool used = entry->used > entry->stored_at && now - entry->stored_at > USE_NS;
    if (!store || !(entry->touched || c->changed || c->stirred || used))
        return;
    char *text = text_of(entry);
    uint64_t hash = text ? ll_hash(1, text, strlen(text)) : entry->stored;
    if (hash != entry->stored || used) {
        int64_t idle_ms = (now - entry->used) / LL_MS;
        ll_store_put_class(store, entry->id, ll_unix_ms() - (idle_ms > 0 ? idle_ms : 0), text ? text : "");
        entry->stored = hash;
        entry->stored_at = now;
    }
    entry->touched = false;
    free(text);
}

/* ---- reading ---- */

static ll_status make_entry(ll_classes *classes, const char *id, int64_t idle_ms, const cJSON *json,
                            ll_class_entry **result)
{
    ll_class_entry *entry = calloc(1, sizeof *entry);
    const char *code = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "code"));
    const char *client = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "client"));
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
    entry->values.home = client ? strtoull(client, NULL, 16) : 0;
    set_key(entry, cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, "class_key")));
    entry->used = now - (idle_ms > 0 ? idle_ms : 0) * LL_MS;
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
    ll_status status = ll_store_list_classes(classes->store, restore, &r);
    for (size_t i = 0; i < r.count; i++)
        ll_store_delete_class(classes->store, r.old[i]);
    free(r.old);
    return status;
}
