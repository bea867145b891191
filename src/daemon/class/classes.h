/* All classes of the daemon: codes, quotas, their streams, and what they do to sessions.
 *
 * A class is found by its code (limited per address) or its id, and held by a counted reference. Its values
 * (class.h) may be used only while it is locked, for microseconds. A thread sends what changed to the
 * members: what the teacher does at once, counts and measurements twice a second at most. Sessions are
 * paused, played and given to persons by a task of each class, which compares what the class wants with what
 * it did last.
 *
 * With a store a class outlives the daemon: code, keys, seats, votes, phase and board are there again, and
 * its connections are lost ones. Without one it ends with the daemon.
 *
 * A session that was made for a class has the stem of its id (LL_STEM_LENGTH), by which such sessions are
 * counted. Any thread. */
#pragma once

#include "daemon/class/class.h"
#include "daemon/hosting/host.h"
#include "daemon/store/store.h"
#include "daemon/stream/ws.h"

struct ll_tasks;

/* Every setting is a row of ll_classes_table. */
typedef struct ll_classes_config {
    int64_t max_classes, max_client_classes, max_class_members, max_class_sessions;
    double class_ttl_s; /* time without a connection or a request */
} ll_classes_config;

extern const ll_param_table ll_classes_table;

typedef struct ll_classes ll_classes;
typedef struct ll_class_entry ll_class_entry;

/* `host`, `tasks` and `store` must outlive it. `store` may be NULL: in memory only. */
ll_status ll_classes_start(const ll_classes_config *config, ll_host *host, ll_store *store,
                           struct ll_tasks *tasks, ll_ws *ws, ll_classes **classes);
void ll_classes_stop(ll_classes *classes); /* joins the thread; NULL: no effect */
void ll_classes_free(ll_classes *classes); /* after tasks, handlers and hooks have ended; NULL: no effect */

const ll_classes_config *ll_classes_get_config(const ll_classes *classes);
int64_t ll_classes_count(ll_classes *classes);

/* A new class with its teacher's key, which is not kept; `settings`: of ll_class_table. `class_key` (NULL:
 * none): its quota counts in place of the address's, now and for the class's sessions. LL_LIMIT: too many;
 * LL_IO: it was not stored. */
ll_status ll_classes_open(ll_classes *classes, const char *peer, ll_class_key *class_key,
                          const struct cJSON *settings, char key[LL_KEY_LENGTH + 1], ll_class_entry **entry);

/* By code, in letters of either case, or by id. LL_NOT_FOUND; LL_LIMIT: this address looked up too many codes
 * that do not exist. */
ll_status ll_classes_find(ll_classes *classes, const char *name, const char *peer, ll_class_entry **entry);
void ll_class_entry_release(ll_class_entry *entry); /* NULL: no effect */

uint64_t ll_class_client(const char *peer); /* hash of an address */

const char *ll_class_entry_id(const ll_class_entry *entry);
const char *ll_class_entry_code(const ll_class_entry *entry);
ll_host_class ll_class_entry_of_host(const ll_class_entry *entry);
ll_class_key *ll_class_entry_class_key(const ll_class_entry *entry); /* NULL: none */

/* For reading, as it is stored. NULL: the class has ended, and is not locked. */
const ll_class *ll_class_entry_lock(ll_class_entry *entry);
void ll_class_entry_unlock(ll_class_entry *entry);

/* A change: begin locks, and gives a copy with all changes before this one. The caller changes it by
 * functions of class.h, and passes the result to store, which unlocks. After an error the copy is dropped,
 * and with it all that was changed; else store returns when the copy is stored and has become the class.
 * LL_IO: the store fails; LL_NOT_FOUND: the class has ended. What follows from the change, as a revoked key
 * or a deleted session, comes after store. */
ll_status ll_class_entry_begin(ll_class_entry *entry, ll_class **c);
ll_status ll_class_entry_store(ll_class_entry *entry, const ll_status *made);

ll_status ll_class_entry_end(ll_class_entry *entry, const char *reason); /* as a change */
/* No key of a class counts any more on the streams of this session. */
void ll_classes_revoke(ll_classes *classes, const char *session);
