/* Internals of hosting; no other room includes it.
 *
 * Lock order: session_entry.lock first, then one of session_entry.inbox.lock, worker.lock,
 * host.registry.lock, host.replies.lock. The locks inside of store, streams and tasks come last. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "daemon/hosting/host.h"
#include "daemon/store/store.h"
#include "daemon/support/class_keys.h"
#include "daemon/support/rate_limits.h"
#include "daemon/support/tasks.h"
#include "session/frame.h"
#include "threads/clock.h"

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

typedef struct ll_reply {
    struct ll_reply *next;
    uint64_t ticket; /* send `good` when this ticket is durable */
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
    atomic_bool pending;               /* the worker has something to do */
    _Atomic ll_time next_visit;        /* time of the worker's next visit, unless something is pending */
    atomic_bool has_task;              /* a task of the daemon runs it */
    _Atomic uint32_t cancels;          /* counts events that make a background tick useless */
} ll_entry_shared;

/* What the store has of a session. */
typedef struct ll_entry_stored {
    int64_t number; /* of its row */
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
    int64_t memory; /* its part of the host's `memory` */
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
} ll_host_counts;

/* What was refused, by the limit that it met. */
typedef struct ll_host_refusals {
    _Atomic uint64_t sessions, creations, lookups, commands, memory, logs;
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

    pthread_t reaper;
    bool reaper_started;

    ll_host_registry registry;
    ll_host_replies replies;
    ll_host_counts counts;
    ll_host_refusals refused;
    ll_host_usage usage;
};

/* ---- entry.c ---- */

ll_session_entry *ll_session_entry_new(ll_host *host); /* one reference; not registered */
void ll_session_entry_retain(ll_session_entry *session_entry);
/* Once; false without memory. */
bool ll_session_entry_set_keys(ll_session_entry *session_entry, const ll_key_hash *keys, int count);
/* As ll_session_entry_role; `guest`: by another's key. */
int ll_session_entry_find_role(const ll_session_entry *session_entry, const char *key, size_t length,
                               bool *guest);
void ll_session_entry_count_log(ll_session_entry *session_entry, int64_t bytes); /* may be negative */
/* It counts for the key from here on; `key` may be NULL. Before it is registered. */
void ll_session_entry_set_class_key(ll_session_entry *session_entry, ll_class_key *key);
void ll_session_entry_leave_class_key(ll_session_entry *session_entry);        /* and no longer */
void ll_session_entry_on_line(void *context, const char *line, size_t length); /* an ll_log_line function */
void ll_session_entry_count_memory(ll_session_entry *session_entry, int64_t bytes);
void ll_session_entry_update_stats(ll_session_entry *session_entry); /* status and memory; locked */
/* Reserves the memory of the session when awake; LL_NO_MEMORY when other sessions leave too little.
 * Locked. */
ll_status ll_session_entry_fits(ll_session_entry *session_entry);
bool ll_viewers_any(ll_session_entry *session_entry);
void ll_viewers_close(ll_session_entry *session_entry, const char *reason); /* closes all viewers */
void ll_session_entry_notify(ll_session_entry *session_entry); /* the worker visits it in its next slot */

/* ---- host.c ---- */

bool ll_session_entry_is_heavy(
    const ll_session_entry *session_entry); /* a tick is, or may be, too long for a worker; locked */
ll_status ll_session_entry_gone(void);      /* LL_NOT_FOUND: it was deleted meanwhile */
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
void ll_host_unregister(ll_host *host, ll_session_entry *session_entry);
int64_t ll_host_count_stem(ll_host *host, const char *stem); /* sessions here with that stem */

/* ---- stored.c ---- */

void ll_session_entry_save(ll_session_entry *session_entry); /* queues the row; locked */
/* Of a session that is stored only; locked. */
ll_status ll_session_entry_load(ll_session_entry *session_entry);

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

ll_ws_hooks ll_viewers_hooks(ll_host *host);
void ll_viewers_send_hellos(
    ll_session_entry *session_entry); /* sends hello messages to new viewers; locked */
void ll_viewers_apply(ll_session_entry *session_entry, ll_time wall); /* applies their inputs; locked */
void ll_host_send_replies(void *host); /* replies that are durable; hook of the store */
