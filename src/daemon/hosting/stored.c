/* A session and the store: its row and its log. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "daemon/hosting/session_entry.h"
#include "daemon/support/log.h"

/* ---- the row ---- */

void ll_session_entry_save(ll_session_entry *session_entry)
{
    if (!session_entry->session || session_entry->deleted)
        return;
    ll_session_info info = ll_session_get_info(session_entry->session);
    ll_entry_stored *stored = &session_entry->stored;
    const ll_entry_identity *identity = &session_entry->identity;
    ll_stored row = {.number = stored->number,
                     .created_ms = identity->created_ms,
                     .seen_ms = ll_unix_ms(),
                     .key_count = identity->key_count,
                     .playing = info.status == LL_SESSION_PLAYING,
                     .speed = info.speed,
                     .tick = info.tick + (info.status == LL_SESSION_FAILED), /* ll_session_position */
                     .head_tick = info.head_tick,
                     .lines = stored->lines};
    const ll_class_key *key = atomic_load(&session_entry->shared.class_key);
    if (key)
        memcpy(row.class_key, key->name, sizeof row.class_key);
    memcpy(row.id, identity->id, sizeof row.id);
    memcpy(row.code, identity->code, sizeof row.code);
    memcpy(row.keys, identity->keys, (size_t)identity->key_count * sizeof *row.keys);
    stored->playing = row.playing;
    stored->speed = row.speed;
    stored->tick = row.tick;
    stored->head_tick = row.head_tick;
    stored->saved_wall = session_entry->wall;
    stored->rewound = false;
    if (stored->collecting) {
        ll_store_batch_put(&stored->collected, &row);
        stored->ticket = ll_store_submit(session_entry->host->store, &stored->collected);
        stored->collecting = false;
    } else {
        stored->ticket = ll_store_put(session_entry->host->store, &row);
    }
}

/* ---- loading ---- */

/* Restores the clock as last stored, or at the last command when that is later. A playing session continues
 * from the daemon's start. */
static void resume(ll_session_entry *session_entry)
{
    const ll_entry_stored *row = &session_entry->stored;
    ll_time from = session_entry->host->started;
    bool older = row->head_tick < ll_session_get_info(session_entry->session).head_tick;
    ll_session_set_position(session_entry->session, from,
                            &(ll_session_position){.tick = older ? -1 : row->tick,
                                                   .head = row->head_tick,
                                                   .speed = row->speed,
                                                   .playing = row->playing});
    session_entry->wall = from;
}

ll_status ll_session_entry_load(ll_session_entry *session_entry)
{
    char *log = NULL;
    size_t length = 0;
    LL_ASSERT(!session_entry->session && !session_entry->restoring); /* one thread loads it */
    LL_TRY(ll_store_read_log(session_entry->host->store, session_entry->stored.number, &log, &length));
    session_entry->restoring = true;
    ll_status status =
        ll_session_restore(log, length, ll_session_entry_on_line, session_entry, &session_entry->session);
    session_entry->restoring = false;
    free(log);
    if (ll_failed(&status)) {
        ll_log_write("error", "session not restored", "Stored session %" PRId64 ": %s",
                     session_entry->stored.number, status.text);
        return ll_error(LL_IO, "Stored log of this session cannot be replayed: %.180s", status.text);
    }
    resume(session_entry);
    ll_session_entry_update_stats(session_entry);
    return status;
}
