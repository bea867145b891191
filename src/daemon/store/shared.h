/* A store in PostgreSQL that several equal daemons share: who runs which session.
 *
 * Each daemon has a row with a lease: an incarnation, with a random token. It renews the row, and owns
 * sessions by its number. A daemon that finds the lease over, or the port refusing connections, marks the
 * row as dead; then any daemon may claim its sessions. Each commit holds the daemon's own row FOR SHARE and
 * requires that it is not dead: a daemon that wakes from a freeze cannot write, nor can a commit that was
 * under way be overtaken by a claim. Marking as dead waits for such commits; the lines are therefore read by
 * a later statement than the one that marked or claimed. The database's clock alone decides.
 *
 * A daemon that cannot renew its lease freezes before it is over, by its own monotonic clock: a share
 * LL_LEASE_SAFE of the lease after the last good renewal was sent. One that was marked as dead has lost what
 * it had not stored yet; it continues as another incarnation without sessions.
 *
 * An engine continues only sessions of its own kind: states of another one might differ. Its fingerprint is
 * of the engine's sources, so that a change of the daemon or the page does not count, and one that might
 * change a state always does.
 *
 * Functions that ask the database may block for some seconds while it does not answer: not on threads of the
 * network or of streams. Any of them fails with LL_UNAVAILABLE. */
#pragma once

#include "daemon/store/store.h"

#define LL_LEASE_SAFE 0.6

/* Of this build, 12 hexadecimal digits: a fingerprint of the sources of the rooms of
 * cmake/engine_rooms.cmake. cmake/version.cmake makes it. */
extern const char ll_engine[];

enum { LL_STORE_URL_MAX = 255, LL_STORE_ENGINE_MAX = 31 };

typedef struct ll_shared_config {
    const char *url;     /* postgresql://USER@HOST/DATABASE */
    const char *address; /* where other daemons reach this one, http://HOST:PORT; empty: not at all */
    const char *engine;  /* NULL: ll_engine; another one for tests */
    double lease_s;
} ll_shared_config;

/* Registers a new incarnation, and renews its lease from here on. LL_BAD_INPUT: the URL is invalid, the
 * database is of a newer laglab, or this build has no PostgreSQL. */
ll_status ll_store_open_shared(const ll_shared_config *config, ll_store **store);

bool ll_store_is_shared(const ll_store *store); /* false for NULL */

/* The incarnation that sessions are claimed for; 0: none now, or the store is not shared. */
int64_t ll_store_daemon(ll_store *store);

/* Seconds until the daemon must freeze; negative: frozen. Infinity in a store of one daemon. Cheap. */
double ll_store_lease_left_s(ll_store *store);
ll_status ll_store_check_lease(ll_store *store); /* LL_UNAVAILABLE: frozen */

/* ---- sessions ---- */

typedef enum ll_claim_result {
    LL_CLAIM_DONE,
    LL_CLAIM_UNKNOWN, /* there is no such session */
    LL_CLAIM_HELD,    /* another daemon has it, or claimed it just now */
    LL_CLAIM_ENGINE,  /* it is of another engine */
    LL_CLAIM_CLASS,   /* it was made for a class, which this daemon has to have first */
    LL_CLAIM_REFUSED, /* this daemon drains or has lost its lease */
} ll_claim_result;

typedef enum ll_claim_why {
    LL_CLAIM_FREE,
    LL_CLAIM_OWN,
    LL_CLAIM_DEAD,
    LL_CLAIM_GIVEN,
    LL_CLAIM_WHYS
} ll_claim_why;
extern const char *const ll_claim_whys[LL_CLAIM_WHYS];

typedef struct ll_claim {
    ll_claim_result result;
    ll_claim_why why;                /* of LL_CLAIM_DONE: not GIVEN, which the caller knows */
    ll_stored row;                   /* of LL_CLAIM_DONE, of a session */
    int64_t daemon;                  /* of LL_CLAIM_DONE, of a class: the incarnation that has it now */
    int64_t idle_ms;                 /* and the time since it was used */
    char *text;                      /* and what was stored of it; the caller frees it */
    char class_id[LL_ID_LENGTH + 1]; /* of LL_CLAIM_CLASS */
    int64_t owner;                   /* of LL_CLAIM_HELD; 0: it has none any more */
    bool over;                       /* and whether the owner's lease is over */
    char url[LL_STORE_URL_MAX + 1];
    char engine[LL_STORE_ENGINE_MAX + 1]; /* of LL_CLAIM_ENGINE */
} ll_claim;

/* Takes a session that has no owner, whose owner is dead, or that is this daemon's already. Nothing may be
 * queued for it: see ll_store_release. */
ll_status ll_store_claim(ll_store *store, const char *id, ll_claim *claim);

/* Queued behind what is queued of the session: it has no owner then. The session must not be claimed before
 * the ticket is durable. */
uint64_t ll_store_release(ll_store *store, ll_store_place place);
/* The same for a session that the store says is this daemon's, and that it does not hold. */
ll_status ll_store_release_id(ll_store *store, const char *id);

/* Marks an incarnation as dead: if its lease is over, or, with `gone`, because its process is known to have
 * ended. Its sessions may then be claimed. *marked (may be NULL): by this call. */
ll_status ll_store_mark_dead(ll_store *store, int64_t daemon, bool gone, bool *marked);

/* Asks the owner to release a session: a hint that may get lost. `asked` is called by the lease thread. */
ll_status ll_store_ask(ll_store *store, int64_t owner, const char *id);
void ll_store_on_asked(ll_store *store, void (*asked)(void *context, const char *id), void *context);

/* Limits of the sessions with a stem, and of those of a class key, whichever daemon makes them: those that
 * have a code count. */
typedef struct ll_session_quota {
    char stem[LL_STEM_LENGTH + 1]; /* empty: none */
    int64_t most;
    const char *class_key; /* its name; empty: none */
    int64_t most_of_key;   /* -1: no limit */
    bool full, key_full;   /* result: a limit is reached, and nothing was reserved */
} ll_session_quota;

/* Codes are unique in the store. *taken: another session has it. `quota` may be NULL. */
ll_status ll_store_reserve_code(ll_store *store, int64_t number, const char *code, ll_session_quota *quota,
                                bool *taken);

/* ---- class keys ---- */

/* What was made with a class key, by all daemons together. */
typedef struct ll_key_use {
    char name[LL_KEY_NAME_MAX + 1];
    int64_t sessions, log_bytes, classes;
} ll_key_use;

/* Size of the log of a session of this daemon. */
typedef struct ll_log_size {
    int64_t number, bytes;
    bool noted; /* result */
} ll_log_size;

/* Notes the sizes of logs, then calls `each` for every class key that something was made with. */
ll_status ll_store_count_keys(ll_store *store, ll_log_size *sizes, int64_t count,
                              void (*each)(void *context, const ll_key_use *use), void *context);
ll_status ll_store_find_code(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1]);

/* Deletes sessions without a living owner that were not used for `ttl_s`. */
ll_status ll_store_expire(ll_store *store, double ttl_s, int64_t *deleted);

/* ---- states ---- */

/* A state of a session that saves a replay of its log up to there; each takes the place of the one before.
 * The bytes are the caller's own. */
typedef struct ll_stored_state {
    char *bytes; /* NULL: none is stored */
    size_t size;
} ll_stored_state;

/* Queued. Nothing is lost with it but time. */
uint64_t ll_store_put_state(ll_store *store, ll_store_place place, const ll_stored_state *state);
ll_status ll_store_read_state(ll_store *store, int64_t number,
                              ll_stored_state *state); /* caller frees its bytes */

/* ---- classes ---- */

/* A class is claimed and released as a session is. Sessions that were made for it have the stem of its id
 * (LL_STEM_LENGTH): while it is there, only the daemon that has the class can claim them. */

typedef struct ll_new_class {
    const char *id, *code, *text;
    const char *client; /* who opens it, for the quota */
    int64_t most, most_client;
    const char *class_key; /* its name: the quota is the key's then, not the client's; empty: none */
    int64_t most_of_key;   /* -1: no limit */
} ll_new_class;

typedef struct ll_opened_class {
    bool taken, full, client_full, key_full; /* by its names; by the quotas, which hold for all daemons
                                                together */
    int64_t daemon;                          /* the incarnation that has it */
} ll_opened_class;

ll_status ll_store_open_class(ll_store *store, const ll_new_class *wanted, ll_opened_class *opened);
ll_status ll_store_claim_class(ll_store *store, const char *id, ll_claim *claim);
ll_status ll_store_find_class(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1]);
uint64_t ll_store_release_class(ll_store *store, int64_t daemon, const char *id); /* as ll_store_release */

/* ---- answers to requests that may be repeated ---- */

/* A request that makes a session may have a key. Its name, which the store keeps, belongs to the incarnation
 * that works on the request, until the answer is stored in the transaction that makes the session. A dead one
 * can make no session any more: its names are free to be taken. */
enum { LL_ANSWER_NAME = 32, LL_ANSWER_HEX = 2 * LL_ANSWER_NAME + 1 };

typedef struct ll_answer_key {
    char name[LL_ANSWER_HEX], body[LL_ANSWER_HEX]; /* hashes of the key and of the request, hexadecimal */
    int64_t daemon;                                /* incarnation whose the name is; set by the claim */
} ll_answer_key;

typedef enum ll_answer_state {
    LL_ANSWER_FIRST, /* the name is this daemon's: it makes the session, or gives the name back */
    LL_ANSWER_SAME,  /* the request was answered */
    LL_ANSWER_OTHER, /* the name stands for another request */
    LL_ANSWER_BUSY,  /* it is being worked on */
} ll_answer_state;

typedef struct ll_answer_claim {
    ll_answer_state state;
    char *text;    /* of LL_ANSWER_SAME, as it was stored; the caller frees it */
    int64_t owner; /* of LL_ANSWER_BUSY */
    bool over;     /* and whether the owner's lease is over */
    char url[LL_STORE_URL_MAX + 1];
} ll_answer_claim;

ll_status ll_store_claim_answer(ll_store *store, ll_answer_key *key, ll_answer_claim *claim);
/* To be stored with the batch's session, which has to be of the incarnation that has the name. `text`:
 * characters that need no quoting. */
void ll_store_batch_answer(ll_store_batch *batch, const ll_answer_key *key, const char *text);
/* Queued: gives the name back, unless its answer is stored. */
uint64_t ll_store_release_answer(ll_store *store, const ll_answer_key *key);

/* ---- start and end ---- */

/* This daemon listens on its address: earlier incarnations with that address are dead. */
ll_status ll_store_replace(ll_store *store);
ll_status ll_store_drain(ll_store *store); /* no more claims */
