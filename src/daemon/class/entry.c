/* An entry of the list: its references, its connections and its place there. */
#include <stdlib.h>
#include <string.h>

#include "daemon/class/internal.h"

ll_class *ll_class_entry_version(ll_class_entry *entry, int i)
{
    return i == 0 ? &entry->values : i == 1 ? entry->sent : entry->draft;
}

static void free_viewers(ll_class_entry *entry)
{
    while (entry->viewers) {
        class_viewer *viewer = entry->viewers;
        entry->viewers = viewer->next;
        free(viewer);
    }
}

void ll_class_entry_retain(ll_class_entry *entry)
{
    atomic_fetch_add(&entry->references, 1);
}

void ll_class_entry_release(ll_class_entry *entry)
{
    if (!entry || atomic_fetch_sub(&entry->references, 1) > 1)
        return;
    free_viewers(entry);
    for (int i = 0; i < LL_CLASS_VERSIONS; i++)
        if (ll_class_entry_version(entry, i))
            ll_class_end(ll_class_entry_version(entry, i));
    free(entry->sent);
    free(entry->draft);
    free(entry);
}

ll_status ll_class_entry_list(ll_class_entry *entry)
{
    ll_classes *classes = entry->classes;
    ll_class_entry_retain(entry); /* for the stream */
    ll_status status = ll_ws_stream_open(classes->ws, LL_STREAM_CLASS, entry->id, entry, &entry->stream);
    if (ll_failed(&status)) {
        atomic_fetch_sub(&entry->references, 1);
        return status;
    }
    ll_class_entry_retain(entry); /* for the list */
    entry->nth = 1;
    for (const ll_class_entry *other = classes->first; other && !entry->key_name[0]; other = other->next)
        entry->nth += !other->key_name[0] && other->values.home == entry->values.home;
    entry->next = classes->first;
    classes->first = entry;
    classes->count++;
    if (entry->class_key)
        atomic_fetch_add(&entry->class_key->used[LL_KEY_CLASSES], 1);
    return status;
}

ll_host_class ll_class_entry_of_host(const ll_class_entry *entry)
{
    return (ll_host_class){.id = entry->id, .nth = entry->nth};
}

const char *ll_class_entry_id(const ll_class_entry *entry)
{
    return entry->id;
}

const char *ll_class_entry_code(const ll_class_entry *entry)
{
    return entry->code;
}

ll_class_key *ll_class_entry_class_key(const ll_class_entry *entry)
{
    return entry->class_key;
}

ll_class_entry *ll_classes_find_entry(const ll_classes *classes, const char *name, bool by_code)
{
    ll_class_entry *entry = classes->first;
    while (entry && (entry->ended || strcmp(by_code ? entry->code : entry->id, name) != 0))
        entry = entry->next;
    return entry;
}

void ll_classes_revoke(ll_classes *classes, const char *session)
{
    ll_session_entry *session_entry = ll_host_find(classes->host, session);
    if (session_entry)
        ll_session_entry_revoke_guests(session_entry, LL_ROLE_NONE);
    ll_session_entry_release(session_entry);
}

/* Takes ended classes off the list. The lock is released meanwhile: closing a stream may call its hooks. */
void ll_classes_close_ended(ll_classes *classes)
{
    ll_class_entry **link = &classes->first;
    while (*link) {
        ll_class_entry *entry = *link;
        if (!entry->ended) {
            link = &entry->next;
            continue;
        }
        *link = entry->next;
        classes->count--;
        if (entry->class_key)
            atomic_fetch_sub(&entry->class_key->used[LL_KEY_CLASSES], 1);
        pthread_mutex_unlock(&classes->lock);
        ll_classes_revoke(classes, entry->values.board.link.session);
        ll_ws_stream_close(entry->stream, LL_WS_NO_SESSION, entry->ended);
        ll_class_entry_release(entry);
        pthread_mutex_lock(&classes->lock);
        link = &classes->first;
    }
}
