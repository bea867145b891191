/* Internals of hosting; no other room includes it.
 *
 * Lock order: session_entry.lock first, then one of session_entry.inbox.lock, worker.lock,
 * host.registry.lock, host.replies.lock. The locks inside of store, streams and tasks come last. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "daemon/hosting/host.h"
#include "daemon/store/shared.h"
#include "daemon/support/class_keys.h"
#include "daemon/support/rate_limits.h"
#include "daemon/support/tasks.h"
#include "session/frame.h"

enum {
    LL_SLOTS = 4
}; /* of a frame's 16.7 ms: sessions are stepped in groups, so that threads wake less often */

typedef struct ll_viewer {
    struct ll_viewer *next;
    ll_ws_viewer id;
    ll_frame_format format;
    int role;   /* since its {"auth":...} */
    bool guest; /* by another's key: ll_host_set_guests */
    bool hello_sent;
} ll_viewer;

typedef struct ll_stream_input {
    struct ll_stream_input *next;
    ll_ws_viewer viewer;
    int player;
    ll_action action;
    char reply_id[40]; /* JSON of the message's `id`, or empty */
} ll_stream_input;

/* What a viewer of a session sent before it was claimed. */
typedef struct ll_early_message {
    struct ll_early_message *next;
    ll_ws_viewer viewer;
    size_t length;
    char text[];
} ll_early_message;

typedef struct ll_reply {
    struct ll_reply *next;
    uint64_t ticket; /* send `good` when this ticket is durable */
    ll_store_outcome outcome;
    ll_ws_viewer viewer;
    char *good;  /* message to send then */
    char id[40]; /* id for the error message when the store fails */
} ll_reply;

/* Who a session is: fixed from its registration on. */
typedef struct ll_entry_identity {
    char id[LL_ID_LENGTH + 1], code[LL_CODE_LENGTH + 1];
    int64_t created_ms, serial;
    int key_count;
    ll_key_hash *keys; /* as many; owned: most sessions have a few of the LL_STORE_KEYS that one may have */
    int worker, slot;
} ll_entry_identity;

/* What any thread reads and writes without a lock. */
typedef struct ll_entry_shared {
    atomic_int references;
    _Atomic ll_time last_used; /* time of the last request or viewer */
    _Atomic int status;        /* last seen ll_session_status, or -1: not in memory; for the statistics */
    atomic_bool parked;
    _Atomic int64_t log_bytes;     /* of its stored lines */
    _Atomic int64_t *client_bytes; /* log bytes of its creator; NULL: unknown since a restart, or a key's */
    _Atomic(ll_class_key *) class_key; /* that it was made with; NULL: none, or it was dropped */
    _Atomic int64_t noted_bytes;       /* size of its log that a shared store has for its key's quota */
    atomic_bool pending;               /* the worker has something to do */
    _Atomic ll_time next_visit;        /* time of the worker's next visit, unless something is pending */
    atomic_bool keeping;               /* a task stores a state of it */
    atomic_bool has_task;              /* a task of the daemon runs it */
    _Atomic uint32_t cancels;          /* counts events that make a background tick useless */
    atomic_bool
        claimed; /* it is known who the session is: false only of a shared store, until it is claimed */
    atomic_bool dropped; /* its stream is closed; it is about to leave the registry */
} ll_entry_shared;

/* What the store has of a session. */
typedef struct ll_entry_stored {
    ll_store_place place;
    /* While it is made: its lines, until its row is there too. */
    bool collecting;
    ll_store_batch collected;
    /* As last queued: */
    bool playing;
    double speed;
    int64_t tick, head_tick;
    bool rewound; /* the log was truncated or restarted since the row was queued */
    int64_t lines;
    uint64_t ticket; /* of the last queued line or row */
    ll_time saved_wall;
    /* Of a shared store: a hash that a replay is compared with, as in ll_stored. */
    int64_t hash_tick, hash_lines;
    uint64_t hash;
    ll_time hashed_wall;
    int64_t state_tick; /* of the newest stored state that the log leads to; 0: none */
} ll_entry_stored;

/* Ticks in the background, and how long one takes. */
typedef struct ll_entry_work {
    double tick_ns; /* running mean of the time of a tick; 0: unknown */
    bool doubtful;  /* the last ticks took longer than short ones do: the next are timed exactly */
    bool behind;
    bool background_tick; /* a task runs a background tick, unlocked */
    pthread_cond_t background_tick_done;
    ll_ahead ahead; /* of the worker's thread alone, unlocked */
} ll_entry_work;

/* What viewers were sent last. */
typedef struct ll_entry_published {
    ll_time wall;
    uint32_t seq, params, generation;
    int64_t tick;
    ll_frame_state last; /* section of each record */
    ll_session_status status;
    int viewers;
} ll_entry_published;

/* What the stream's thread left for the worker; guarded by `lock`. */
typedef struct ll_entry_inbox {
    /* So that a visit that finds nothing does not lock; changed under the lock. */
    atomic_int viewer_count, hellos; /* viewers, and those without their hello */
    atomic_bool waiting;             /* inputs */
    pthread_mutex_t lock;
    ll_viewer *viewers;
    ll_stream_input *inputs, **inputs_end;
    ll_early_message *early, **early_end;
    int early_count;
} ll_entry_inbox;

struct ll_session_entry {
    ll_host *host;
    ll_ws_stream *stream;
    ll_entry_identity identity;
    ll_entry_shared shared;
    ll_session_entry *next_by_id, *next_by_code; /* guarded by host.registry.lock */
    bool active;                                 /* worker.lock: in the worker's list */

    pthread_mutex_t lock; /* guards all members below but the inbox, and the publishing calls */
    ll_session *session;  /* NULL while unloaded */
    bool deleted, restoring;
    bool moved;         /* deleted here only: another daemon has it */
    bool differs;       /* its replay has another state than it had */
    ll_time claimed_at; /* 0: it was made here, or was this daemon's already */
    int64_t memory;     /* its part of the host's `memory` */
    ll_time wall;
    ll_entry_stored stored;
    ll_entry_work work;
    ll_entry_published published;
    uint32_t command_count; /* counts commands */
    ll_bucket commands;

    ll_entry_inbox inbox;
};

/* A session of a worker's list. Its slot stands here so that a look through the list reads no session's
 * memory. */
typedef struct ll_active {
    ll_session_entry *session_entry; /* with a reference */
    int slot;
} ll_active;

typedef struct ll_worker {
    ll_host *host;
    int index;
    pthread_t thread;
    bool started;
    pthread_mutex_t lock;
    pthread_cond_t wake;
    ll_active *active;
    int count, capacity;
    bool stopping;
    bool behind[LL_SLOTS]; /* of each slot: a session was behind when it was served last; of its thread only,
                              as `space` */
    ll_row_set space;      /* for taking frames */
} ll_worker;

enum { LL_HOST_BUCKETS = 4096 };

/* All sessions, by id and by code. */
typedef struct ll_host_registry {
    pthread_mutex_t lock; /* guards all of it */
    pthread_cond_t stop;
    bool stopping;
    ll_session_entry *by_id[LL_HOST_BUCKETS], *by_code[LL_HOST_BUCKETS];
    int64_t sessions, serials;
    unsigned next_place; /* distributes sessions over workers and slots */
} ll_host_registry;

/* Replies that wait until the store has what they confirm. */
typedef struct ll_host_replies {
    pthread_mutex_t lock;
    ll_reply *first, **end;
} ll_host_replies;

/* For the statistics. */
typedef struct ll_host_counts {
    _Atomic uint64_t created, deleted, expired, ticks, frames, commands, inputs;
    _Atomic uint64_t claims[LL_CLAIM_WHYS], given, mismatches, states_stored, states_used;
} ll_host_counts;

enum { LL_HOST_WISHES = 256 };

/* Of a store that several daemons share. */
typedef struct ll_host_sharing {
    pthread_mutex_t adding;     /* held while a session is registered by its id alone, with its stream */
    _Atomic uint64_t released;  /* ticket of the last session that was given away */
    _Atomic ll_time next_state; /* when the next state may be stored */
    _Atomic uint64_t unchecked; /* counts sessions that began from a state */
    atomic_bool ends;           /* no more states are stored: the host stops */
    atomic_int pursued;         /* sessions that wait for their owner */
    atomic_int requests;        /* that wait for a claim */
    pthread_mutex_t turn;       /* guards the members of this group: who may ask the store for a session */
    pthread_cond_t watched_turn, other_turn;
    int claiming, watched; /* sessions; `watched` of those that wait have viewers */
    pthread_t keeper;
    bool keeper_started;
    pthread_mutex_t lock; /* guards all members below */
    pthread_cond_t wake;
    bool stopping;
    char wishes[LL_HOST_WISHES][LL_ID_LENGTH + 1]; /* sessions that other daemons ask for */
    int wish_count;
} ll_host_sharing;

/* What was refused, by the limit that it met. */
typedef struct ll_host_refusals {
    _Atomic uint64_t sessions, creations, lookups, commands, store, memory, logs;
} ll_host_refusals;

/* What the sessions hold, bytes. */
typedef struct ll_host_usage {
    _Atomic int64_t log_bytes;                     /* of all sessions */
    _Atomic int64_t client_bytes[LL_HOST_BUCKETS]; /* of each creator's sessions, by hash of its address;
                                                addresses may collide */
    _Atomic int64_t memory;                        /* maximum that awake sessions may hold */
    int64_t memory_max;
} ll_host_usage;

struct ll_host {
    ll_host_config config;
    ll_store *store;
    ll_ws *ws;
    ll_time started;
    ll_worker *workers;
    int worker_count;
    ll_tasks *tasks;
    ll_rate_limits *creations, *lookups;
    ll_host_guest_role *guest_role;
    void *guest_context;
    _Atomic(const ll_host_group *) group;

    pthread_t reaper;
    bool reaper_started;

    ll_host_registry registry;
    ll_host_replies replies;
    ll_host_counts counts;
    ll_host_refusals refused;
    ll_host_usage usage;
    ll_host_sharing sharing;
};

/* As ll_session_entry_role; `guest`: by another's key. */
int ll_session_entry_find_role(const ll_session_entry *session_entry, const char *key, size_t length,
                               bool *guest);

/* ---- inbox.c ---- */

bool ll_viewers_any(ll_session_entry *session_entry);
void ll_viewers_close(ll_session_entry *session_entry, const char *reason); /* closes all viewers */
void ll_viewers_free(ll_session_entry *session_entry);                      /* when the session is freed */

/* ---- notify.c ---- */

void ll_session_entry_retain(ll_session_entry *session_entry);
void ll_session_entry_notify(
    ll_session_entry *session_entry); /* the worker visits it in its next slot; any thread */

/* ---- host.c ---- */

ll_status ll_host_check_store(ll_host *host);          /* LL_IO while the store fails */
ll_session_entry *ll_session_entry_new(ll_host *host); /* one reference; not registered */
bool ll_session_entry_set_keys(ll_session_entry *session_entry, const ll_key_hash *keys,
                               int count); /* once; false without memory */
void ll_session_entry_count_log(ll_session_entry *session_entry,
                                int64_t bytes);                         /* of its lines; may be negative */
ll_class_key *ll_host_named_key(const ll_host *host, const char *name); /* NULL: there is none */
/* It counts for the key from here on; `key` may be NULL. Before it is registered. */
void ll_session_entry_set_class_key(ll_session_entry *session_entry, ll_class_key *key);
void ll_session_entry_leave_class_key(ll_session_entry *session_entry);        /* and no longer */
void ll_session_entry_on_line(void *context, const char *line, size_t length); /* an ll_log_line function */
void ll_session_entry_count_memory(ll_session_entry *session_entry, int64_t bytes);
void ll_session_entry_update_stats(
    ll_session_entry *session_entry); /* updates status and memory for the statistics; locked */
/* Reserves the memory of the session when awake; LL_NO_MEMORY when other sessions leave too little.
 * Locked. */
ll_status ll_session_entry_fits(ll_session_entry *session_entry);
bool ll_session_entry_is_heavy(
    const ll_session_entry *session_entry); /* a tick is, or may be, too long for a worker; locked */
/* Why a dropped session cannot be used: LL_NOT_FOUND, or LL_UNAVAILABLE when it has only moved. Locked. */
ll_status ll_session_entry_gone(const ll_session_entry *session_entry);
/* Locks within a few milliseconds, or with a task until it is stopped; otherwise LL_INTERRUPTED. */
ll_status ll_session_entry_lock(ll_session_entry *session_entry, ll_task *task);
/* Runs due ticks for at most `max_ms`. Returns how many are still due. Locked. A tick that takes far longer
 * than the earlier ones is interrupted; the session then has to wake again, and is heavy. */
int64_t ll_session_entry_advance(ll_session_entry *session_entry, ll_time wall, double max_ms);
/* The same for a task, up to the present. A tick of a heavy session runs on a copy while the session is
 * unlocked, yields the task's turns, and is interrupted after `most_ms` (0: never); others can use, change or
 * delete the session meanwhile. Returns -1 when it was deleted; locked in any case at the return. */
int64_t ll_session_entry_work(ll_session_entry *session_entry, ll_task *task, double most_ms);
/* Calls `change`. If recomputing the run (as of a motion) takes long, it is left to tasks. */
ll_status ll_session_entry_change(ll_session_entry *session_entry, const ll_command_request *request,
                                  ll_session *session);
/* Before a change: waits a moment for a background tick, then cancels it. Locked. */
void ll_session_entry_stop_work(ll_session_entry *session_entry);

/* ---- registry.c ---- */

bool ll_host_register(ll_host *host,
                      ll_session_entry *session_entry); /* assigns a code if it has none; false: full */
/* By its id alone, without a code; false: full. */
bool ll_host_register_id(ll_host *host, ll_session_entry *session_entry);
/* Its code and when it was made, of a session that was registered by its id alone. */
void ll_host_name(ll_host *host, ll_session_entry *session_entry, const char *code, int64_t created_ms);
/* All sessions of the host, each with a reference; caller frees `*entries`. */
int64_t ll_host_all(ll_host *host, ll_session_entry ***entries);
void ll_host_unregister(ll_host *host, ll_session_entry *session_entry);
int64_t ll_host_count_stem(ll_host *host, const char *stem); /* sessions here with that stem */

/* ---- command.c ---- */

bool ll_host_discard(ll_host *host, ll_session_entry *session_entry,
                     uint64_t *ticket); /* false: it was already discarded */
/* Drops what is in memory of it and closes its stream. Locked; false: it was dropped already. The caller
 * unlocks and unregisters it. */
bool ll_session_entry_drop(ll_session_entry *session_entry, int code, const char *reason);
/* Drops it, and sends its viewers to where it is now; false: it is busy, or was dropped already. */
bool ll_host_forget(ll_host *host, ll_session_entry *session_entry, const char *reason);

/* ---- listing.c ---- */

bool ll_host_has_keys(const ll_host *host); /* class keys that are to be counted in a shared store */

/* ---- claim.c ---- */

/* The daemon gets a viewer of a session that is not here: registers it, so that it has a stream, and starts
 * the task that claims it. LL_WS_UNKNOWN: no session can have this id, or the store is not shared. */
ll_ws_known ll_host_expect(ll_host *host, const char *id);

/* ---- group.c ---- */

ll_status ll_host_obtain_group(ll_host *host, const char *id, ll_task *task);
/* LL_UNAVAILABLE while what this session goes with is being given away. */
ll_status ll_host_check_group(ll_host *host, const char *session);
bool ll_host_give_group(ll_host *host, const char *id); /* false: it is not here */

/* ---- keeper.c ---- */

/* Starts the thread that drops sessions whose lease was lost, gives those away that others ask for, and sends
 * viewers away while the store cannot be reached. No effect if the store is not shared. */
ll_status ll_keeper_start(ll_host *host);
void ll_keeper_stop(ll_host *host);
void ll_keeper_init(ll_host *host);
void ll_keeper_free(ll_host *host);

/* ---- neighbour.c ---- */

/* Whether nothing listens at http://HOST:PORT: the machine answers, and refuses the connection. */
bool ll_neighbour_refuses(const char *url);
bool ll_neighbour_is_url(const char *url);
/* Of a daemon that has what is wanted. *gone: its lease is over or its port refuses connections, and it was
 * marked as dead. */
ll_status ll_neighbour_judge(ll_store *store, int64_t daemon, const char *url, bool over, bool *gone);

/* ---- stored.c ---- */

void ll_session_entry_save(
    ll_session_entry *session_entry); /* queues the row, and a state if a replay takes long by now; locked */

/* Of a session that is stored only. LL_CONFLICT: its log leads to another state than it had. Locked. */
ll_status ll_session_entry_load(ll_session_entry *session_entry);
/* For a parked session that will wake: from its stored state, if it has one. Locked. */
void ll_session_entry_fetch_state(ll_session_entry *session_entry);

/* ---- worker.c ---- */

void ll_worker_init(ll_host *host, ll_worker *worker, int index);
ll_status ll_worker_start(ll_worker *worker);
void ll_worker_stop(ll_worker *worker);

/* ---- session_task.c ---- */

/* Starts a task that wakes the session and runs it up to the present, then as long as it is heavy and has
 * viewers. The task notifies the worker after each piece. Any thread. */
void ll_session_entry_start_task(ll_session_entry *session_entry);
ll_time ll_host_park_after(ll_host *host); /* how long a session without viewers stays awake */
/* Whether no client has used or watched it for so long that it is to be parked; locked. */
bool ll_session_entry_may_park(ll_session_entry *session_entry);
void ll_session_entry_park(ll_session_entry *session_entry); /* stores it first; locked */
/* Starts a task that parks it, if it may still be parked by then. */
void ll_session_entry_start_park(ll_session_entry *session_entry);

/* ---- viewers.c ---- */

void ll_viewers_send_hellos(
    ll_session_entry *session_entry); /* sends hello messages to new viewers; locked */
void ll_viewers_apply(ll_session_entry *session_entry, ll_time wall); /* applies their inputs; locked */
void ll_host_send_replies(void *host); /* replies that are durable; hook of the store */
ll_ws_hooks ll_viewers_hooks(ll_host *host);
/* The session is claimed: takes what its viewers have sent until now. */
void ll_viewers_begin(ll_session_entry *session_entry);
