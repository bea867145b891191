/* Stored sessions: their rows and all lines of their logs; and classes and measurements, a text each. A
 * SQLite database in the folder of one daemon.
 *
 * One writer thread commits everything that is queued at once. Queueing returns a ticket. A caller that must
 * not answer before its line is durable waits for the ticket; others can use ll_store_on_commit. After `kill
 * -9` every line whose ticket was durable is there (WAL, synchronous=NORMAL: a power cut may lose the last
 * commits).
 *
 * When a commit fails, the records of sessions are kept in order and tried again every second; texts,
 * and deletions that a client waits for, are dropped: what they change changes when they are stored.
 * Until then ll_store_wait fails and ll_store_check too: changes are refused before they are applied, so that
 * a session is never further ahead of its stored log than by the lines in flight at the first failure. The
 * log gets one line when the store begins to fail, with the cause, and one when it works again.
 *
 * Any thread; a NULL store means "in memory only". */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "daemon/support/class_keys.h"
#include "daemon/support/keys.h"
#include "input/action.h"

#define LL_STORE_KEYS (1 + LL_PLAYERS_MAX) /* the owner's, then one per player */

typedef struct ll_store ll_store;

typedef enum ll_store_text { LL_STORE_CLASS, LL_STORE_MEASUREMENT } ll_store_text;

typedef struct ll_stored {
    int64_t number; /* of its row, never used again */
    char id[LL_ID_LENGTH + 1];
    char code[LL_CODE_LENGTH + 1];
    int64_t created_ms, seen_ms; /* Unix time */
    int key_count;
    ll_key_hash keys[LL_STORE_KEYS];
    bool playing;
    double speed;
    int64_t tick, head_tick;
    char class_key[LL_KEY_NAME_MAX + 1]; /* name of that it was made with; empty: none. Of a new row */
    int64_t lines, log_bytes;            /* of the log; bytes: as read */
} ll_stored;

enum { LL_STORE_TIMES = 12 };
/* Upper limits of the histogram's bins, seconds; the last one is open. */
extern const double ll_store_time_limits[LL_STORE_TIMES - 1];

typedef struct ll_store_stats {
    int64_t queued, commits, failures, refused; /* refused: changes, while it failed */
    int64_t times[LL_STORE_TIMES];              /* histogram of the time of a commit */
    double commit_s;                            /* sum of these times */
} ll_store_stats;

/* Opens or creates DIRECTORY/laglab.db and takes DIRECTORY/lock. Messages of errors (LL_IO) name the
 * directory. */
ll_status ll_store_open(const char *directory, ll_store **store);

/* Commits the queue (one attempt when the store is failing) and closes. Returns the result of that commit. */
ll_status ll_store_close(ll_store *store);

/* All stored sessions, in order of creation. Call before anything is queued. */
ll_status ll_store_list(ll_store *store, void (*each)(void *context, const ll_stored *stored), void *context);

/* The lines of a session's log separated by newlines; caller frees `*text`. */
ll_status ll_store_read_log(ll_store *store, int64_t number, char **text, size_t *length);

/* All stored texts of a kind: what ll_store_put_text was given. Call before any of them is queued. */
ll_status ll_store_list_texts(ll_store *store, ll_store_text kind,
                              void (*each)(void *context, const char *id, int64_t seen_ms, const char *text),
                              void *context);

int64_t ll_store_new_number(ll_store *store); /* of a new session */

/* ---- queueing; returns a ticket ---- */

uint64_t ll_store_put(ll_store *store,
                      const ll_stored *stored); /* a new row, or a new clock of a stored one */
uint64_t ll_store_line(ll_store *store, int64_t number, int64_t index, const char *line, size_t length);
uint64_t ll_store_delete(ll_store *store, int64_t number);
uint64_t ll_store_try_delete(ll_store *store, int64_t number); /* as of a class; see ll_store_wait_tried */
/* In place of what was stored of it. `id`: at most LL_ID_LENGTH characters; `seen_ms`: Unix time.
 * 0: the store fails; a ticket that is not durable when it fails was dropped. */
uint64_t ll_store_put_text(ll_store *store, ll_store_text kind, const char *id, int64_t seen_ms,
                           const char *text);
uint64_t ll_store_delete_text(ll_store *store, ll_store_text kind, const char *id);

/* Records that are stored together or not at all: a new session's first lines and its row. {0}: empty. */
typedef struct ll_store_batch {
    struct ll_store_record *first, *last;
    int64_t count;
} ll_store_batch;

void ll_store_batch_line(ll_store_batch *batch, int64_t number, int64_t index, const char *line,
                         size_t length);
void ll_store_batch_put(ll_store_batch *batch, const ll_stored *stored);
void ll_store_batch_free(ll_store_batch *batch);
uint64_t ll_store_submit(ll_store *store, ll_store_batch *batch); /* empties the batch */

/* Waits until the ticket is durable; LL_IO when the store fails. */
ll_status ll_store_wait(ll_store *store, uint64_t ticket);
/* The same for ll_store_try_delete: on an error its record was dropped. */
ll_status ll_store_wait_tried(ll_store *store, uint64_t ticket);

bool ll_store_failing(ll_store *store, ll_status *why); /* `why` may be NULL */
ll_status ll_store_check(ll_store *store); /* before a change: LL_IO while it fails, and counts the refusal */
uint64_t ll_store_durable(ll_store *store); /* the last durable ticket */
ll_store_stats ll_store_get_stats(ll_store *store);

/* The writer thread calls `notify` after each commit and each failure, without a lock. For at most two,
 * before they queue. */
void ll_store_on_commit(ll_store *store, void (*notify)(void *context), void *context);
