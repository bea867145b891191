/* An entry of the list: its references, its connections and its place there. */
#include <stdlib.h>

#include "daemon/class/internal.h"

int ll_class_viewer_place(const ll_class_entry *entry, const class_viewer *viewer)
{
    const ll_class *c = &entry->values;
    bool present = viewer->place >= 0 && c->members[viewer->place].used &&
                   c->members[viewer->place].number == viewer->number;
    return present ? viewer->place : -1;
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
    ll_class_end(&entry->values);
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
    entry->next = classes->first;
    classes->first = entry;
    classes->count++;
    return status;
}

const char *ll_class_entry_id(const ll_class_entry *entry)
{
    return entry->id;
}

const char *ll_class_entry_code(const ll_class_entry *entry)
{
    return entry->code;
}
