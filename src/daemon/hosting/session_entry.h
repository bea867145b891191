/* Inside of hosting: what host.c, command.c, create.c, worker.c, carrier.c and viewers.c share. Nobody else
 * includes it.
 *
 * Locks, in the order in which they may be taken: hosted.lock, then one of hosted.inbox_lock, worker.lock,
 * host.lock, host.replies_lock. The store's, the streams' and the tasks' own locks come last. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "daemon/hosting/host.h"
#include "daemon/support/rate_limits.h"
#include "daemon/support/tasks.h"

enum { LL_SLOTS = 4 }; /* of a frame's 16.7 ms: sessions wake in groups, so that threads wake seldom */

typedef struct ll_viewer {
    struct ll_viewer *next;
    ll_ws_viewer id;
    ll_frame_format format;
    int role; /* since its {"auth":...} */
    bool greeted;
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
    uint64_t ticket; /* send it when this is durable */
    ll_ws_viewer viewer;
    char *good;  /* message to send then */
    char id[40]; /* for the error when the store fails */
} ll_reply;

struct ll_session_entry {
    ll_host *host;
    char id[LL_ID_LENGTH + 1], code[LL_CODE_LENGTH + 1];
    int64_t created_ms, serial;
    int key_count;
    ll_key_hash keys[LL_STORE_KEYS];
    int worker, slot;
    ll_ws_stream *stream;
    atomic_int references;
    _Atomic ll_time touched; /* last request or viewer */
    _Atomic int status;      /* ll_session_status as last seen, or -1: not in memory; for the statistics */
    atomic_bool parked;
    _Atomic int64_t log_bytes; /* of its stored lines */
    _Atomic int64_t *share;    /* of its maker's; NULL: nobody knows any more who that was */
    atomic_bool pending;       /* something to do for the worker */
    ll_session_entry *next_by_id, *next_by_code; /* host.lock */
    bool active;                                 /* worker.lock: in the worker's list */
    _Atomic ll_time rests_until; /* its worker looks at it then, or when something is pending */
    atomic_bool carried;         /* a task of the daemon's own runs it */
    _Atomic uint32_t stops;      /* counts what makes a tick that is being made of no use */

    pthread_mutex_t lock; /* all below, and the calls that publish */
    ll_session *session;  /* NULL while unloaded */
    ll_stored stored;     /* the row as last queued */
    bool deleted, restoring;
    bool rewound; /* the log was cut or begun anew since the row was queued */
    int64_t lines;
    int64_t memory;  /* its share of the host's */
    uint64_t ticket; /* of the last queued line or row */
    ll_time wall, saved_wall, published_wall;
    double tick_ns;  /* running mean cost; 0: not known */
    uint32_t orders; /* counts commands */
    bool behind;
    bool ahead; /* a task makes a tick of it, unlocked */
    pthread_cond_t ahead_over;
    uint32_t seq, published_params, published_generation;
    int64_t published_tick;
    ll_frame_state last; /* what was published of each record */
    ll_session_status published_status;
    int published_viewers;
    ll_bucket commands;

    pthread_mutex_t inbox_lock; /* what the stream's thread left for the worker */
    ll_viewer *viewers;
    ll_stream_input *inputs, **inputs_end;
};

typedef struct ll_worker {
    ll_host *host;
    int index;
    pthread_t thread;
    bool started;
    pthread_mutex_t lock;
    pthread_cond_t wake;
    ll_session_entry **active; /* each with a reference */
    int count, capacity;
    bool stopping;
} ll_worker;

enum { LL_HOST_BUCKETS = 4096 };

struct ll_host {
    ll_host_config config;
    ll_store *store;
    ll_ws *ws;
    ll_time started;
    ll_worker *workers;
    int worker_count;
    ll_tasks *tasks;
    ll_rate_limits *creations, *lookups;

    pthread_t reaper;
    bool reaper_started;

    pthread_mutex_t lock; /* the registry */
    pthread_cond_t stop;
    bool stopping;
    ll_session_entry *by_id[LL_HOST_BUCKETS], *by_code[LL_HOST_BUCKETS];
    int64_t sessions, serials;
    unsigned next_place; /* spreads sessions over workers and slots */

    pthread_mutex_t replies_lock;
    ll_reply *replies, **replies_end;

    _Atomic uint64_t created, deleted, expired, ticks, frames, commands, inputs;
    _Atomic uint64_t refused_sessions, refused_creations, refused_lookups, refused_commands, refused_store;
    _Atomic uint64_t refused_memory, refused_logs;
    _Atomic int64_t log_bytes;               /* of all sessions */
    _Atomic int64_t shares[LL_HOST_BUCKETS]; /* of those by their maker's address; some share one */
    _Atomic int64_t memory;                  /* that awake sessions may come to hold */
    int64_t memory_max;
};

/* ---- inbox.c ---- */

bool ll_viewers_any(ll_session_entry *session_entry);
void ll_viewers_dismiss(ll_session_entry *session_entry, const char *reason); /* closes them all */
void ll_viewers_forget(ll_session_entry *session_entry);                      /* at the end */

/* ---- notify.c ---- */

void ll_session_entry_retain(ll_session_entry *session_entry);
void ll_session_entry_notify(
    ll_session_entry *session_entry); /* the worker looks at it in its next slot; any thread */

/* ---- host.c ---- */

ll_status ll_host_storable(ll_host *host);             /* LL_IO while the store fails */
ll_session_entry *ll_session_entry_new(ll_host *host); /* one reference; not registered */
void ll_session_entry_count_log(ll_session_entry *session_entry,
                                int64_t bytes); /* of its lines, more or fewer */
void ll_session_entry_on_line(void *context, const char *line, size_t length); /* an ll_log_line */
void ll_session_entry_save(ll_session_entry *session_entry);                   /* queues the row; locked */
ll_status ll_session_entry_load(ll_session_entry *session_entry);              /* locked */
void ll_session_entry_count_memory(ll_session_entry *session_entry, int64_t bytes);
void ll_session_entry_note(
    ll_session_entry *session_entry); /* status and memory for the statistics; locked */
/* LL_NO_MEMORY when the other sessions leave too little for this one awake; else it is counted. Locked. */
ll_status ll_session_entry_fits(ll_session_entry *session_entry);
bool ll_session_entry_is_heavy(
    const ll_session_entry *session_entry); /* a tick is, or may be, too long for a worker; locked */
/* Locks within a few milliseconds, or with a task's patience. LL_INTERRUPTED: not. */
ll_status ll_session_entry_lock(ll_session_entry *session_entry, ll_task *task);
/* Runs at most `max_ms` worth of ticks that are due at `wall`. Returns how many still are. Locked. One that
 * takes far longer than those before it is broken off; the session is then half awake, and heavy. */
int64_t ll_session_entry_advance(ll_session_entry *session_entry, ll_time wall, double max_ms);
/* The same for a task, up to now: a tick of a heavy session is made while it is unlocked, of a copy, and as
 * the task has its turns, and given up after `most_ms` (0: never). Whoever needs it, changes or deletes it
 * meanwhile does not wait. Returns -1 when it is gone; locked also then. */
int64_t ll_hosted_work(ll_session_entry *session_entry, ll_task *task, double most_ms);
/* Calls `change`; what it makes anew, as the whole run of a motion, is left to tasks when it takes long. */
ll_status ll_hosted_change(ll_session_entry *session_entry, const ll_create_requests *orders,
                           ll_session *session);
/* Before a change: a tick that is being made is given a moment to be finished, and then given up. Locked. */
void ll_hosted_stop_work(ll_session_entry *session_entry);

/* ---- registry.c ---- */

bool ll_host_register(ll_host *host,
                      ll_session_entry *session_entry); /* gives it a code if it has none; false when full */
void ll_host_unregister(ll_host *host, ll_session_entry *session_entry);

/* ---- command.c ---- */

bool ll_host_discard(ll_host *host, ll_session_entry *session_entry,
                     uint64_t *ticket); /* false when it was done before */

/* ---- worker.c ---- */

void ll_worker_init(ll_host *host, ll_worker *worker, int index);
ll_status ll_worker_start(ll_worker *worker);
void ll_worker_stop(ll_worker *worker);

/* ---- carrier.c ---- */

/* Any thread. A task wakes the session, brings it to the present, and stays with it while it is heavy and
 * watched; its worker is notified whenever there is something new. */
void ll_session_entry_carry(ll_session_entry *session_entry);

/* ---- viewers.c ---- */

void ll_viewers_greet(ll_session_entry *session_entry);               /* hellos to those who wait; locked */
void ll_viewers_apply(ll_session_entry *session_entry, ll_time wall); /* their inputs; locked */
void ll_host_send_replies(void *host); /* those that are durable; the store's hook */
