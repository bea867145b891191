/* Viewers of a session, and their messages that the worker has not applied yet. */
#include <stdlib.h>

#include "daemon/hosting/session_entry.h"

bool ll_viewers_any(ll_session_entry *session_entry)
{
    return atomic_load(&session_entry->inbox.viewer_count) > 0;
}

void ll_viewers_close(ll_session_entry *session_entry, const char *reason)
{
    pthread_mutex_lock(&session_entry->inbox.lock);
    for (ll_viewer *v = session_entry->inbox.viewers; v; v = v->next)
        ll_ws_close(session_entry->host->ws, v->id, LL_WS_TRY_LATER, reason);
    pthread_mutex_unlock(&session_entry->inbox.lock);
}

void ll_session_entry_revoke_guests(ll_session_entry *session_entry, int role)
{
    pthread_mutex_lock(&session_entry->inbox.lock);
    for (ll_viewer *v = session_entry->inbox.viewers; v; v = v->next) {
        if (v->guest && v->role == role)
            v->role = LL_ROLE_NONE;
    }
    pthread_mutex_unlock(&session_entry->inbox.lock);
}

void ll_viewers_free(ll_session_entry *session_entry)
{
    while (session_entry->inbox.viewers) {
        ll_viewer *viewer = session_entry->inbox.viewers;
        session_entry->inbox.viewers = viewer->next;
        free(viewer);
    }
    while (session_entry->inbox.inputs) {
        ll_stream_input *input = session_entry->inbox.inputs;
        session_entry->inbox.inputs = input->next;
        free(input);
    }
    session_entry->inbox.inputs_end = &session_entry->inbox.inputs;
}
