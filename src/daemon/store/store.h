/* Sessions on disk: their rows and every line of their logs, in one SQLite database.
 *
 * One writer thread takes all that has been queued and commits it at once. Queueing gives a ticket; a caller
 * that must not answer before its line is safe waits for it, others may ask to be told (ll_store_on_commit).
 * After `kill -9` every line whose ticket was durable is there (WAL, synchronous=NORMAL: a power cut may lose
 * the last commits).
 *
 * When a commit fails, what is queued stays queued in its order and is tried again every second; until then
 * ll_store_wait fails and ll_store_failing is true: the host then refuses changes before it applies them, so
 * that a session never runs ahead of its stored log by more than what was in flight at the first failure.
 *
 * All functions may be called from any thread and take a NULL store for "in memory only". */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "daemon/support/keys.h"
#include "input/action.h"

#define LL_STORE_KEYS (1 + LL_PLAYERS_MAX) /* the owner's, then one per player */

typedef struct ll_store ll_store;

typedef struct ll_stored {
    int64_t number; /* of the row; never used again */
    char id[LL_ID_LENGTH + 1];
    char code[LL_CODE_LENGTH + 1];
    int64_t created_ms, seen_ms; /* Unix time */
    int key_count;
    ll_key_hash keys[LL_STORE_KEYS];
    bool playing;
    double speed;
    int64_t tick, head_tick;
    int64_t lines, log_bytes; /* of the log; the bytes as they were read */
} ll_stored;

typedef struct ll_store_stats {
    int64_t queued, commits, failures;
} ll_store_stats;

/* Opens or makes DIRECTORY/laglab.db and takes DIRECTORY/lock. Errors (LL_IO) are sentences that name the
 * directory. */
ll_status ll_store_open(const char *directory, ll_store **store);

/* Commits what is queued (one attempt when the store is failing) and closes. Returns how that went. */
ll_status ll_store_close(ll_store *store);

/* All stored sessions, in the order of their making. Call before anything is queued. */
ll_status ll_store_list(ll_store *store, void (*each)(void *context, const ll_stored *stored), void *context);

/* The lines of a session's log separated by newlines; caller frees `*text`. */
ll_status ll_store_read_log(ll_store *store, int64_t number, char **text, size_t *length);

int64_t ll_store_new_number(ll_store *store);

/* ---- queueing; the result is a ticket ---- */

uint64_t ll_store_put(ll_store *store, const ll_stored *stored); /* a new row, or the clock of an old one */
uint64_t ll_store_line(ll_store *store, int64_t number, int64_t index, const char *line, size_t length);
uint64_t ll_store_delete(ll_store *store, int64_t number);

/* Waits until the ticket is durable; LL_IO when the store fails. */
ll_status ll_store_wait(ll_store *store, uint64_t ticket);

bool ll_store_failing(ll_store *store, ll_status *why); /* `why` may be NULL */
uint64_t ll_store_durable(ll_store *store);             /* the last durable ticket */
ll_store_stats ll_store_get_stats(ll_store *store);

/* `told` is called by the writer thread after each commit and each failure, without a lock. Set once, before
 * queueing. */
void ll_store_on_commit(ll_store *store, void (*told)(void *context), void *context);
