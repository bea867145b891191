/* Shared by entry.c (references), work.c (what is done to sessions), stream.c (messages) and classes.c (the
 * list). Not for other rooms. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "daemon/class/classes.h"
#include "daemon/support/rate_limits.h"
#include "daemon/support/tasks.h"
#include "threads/clock.h"

/* A connection to the stream of a class. */
typedef struct class_viewer {
    struct class_viewer *next;
    ll_ws_viewer id;
    bool hello_sent, teacher;
    int place; /* of its member; -1: none */
    uint32_t number;
} class_viewer;

/* A request that waits until its change is stored, or refused; on its stack. */
typedef struct class_wait {
    struct class_wait *next;
    bool done;
    ll_status status;
} class_wait;

struct ll_class_entry {
    ll_class_entry *next;
    ll_classes *classes;
    atomic_int references;
    char id[LL_ID_LENGTH + 1], code[LL_CODE_LENGTH + 1];
    ll_class_key *class_key;            /* or the key; NULL: none, or its line is missing now */
    char key_name[LL_KEY_NAME_MAX + 1]; /* empty: none */
    int nth;                            /* of the classes that its address had open; with a key 1 */

    /* guarded by the lock of `classes` */
    ll_class values;  /* as it is stored: what all others see */
    ll_class *sent;   /* with the changes that the store is writing; NULL: none */
    ll_class *draft;  /* with the changes that come after these; NULL: none */
    ll_class *edited; /* by the thread with the lock, from begin to store */
    class_wait *sent_waits, *draft_waits;
    bool writing;       /* `sent`, or that it has ended */
    uint64_t ticket;    /* of what is written */
    const char *ending; /* why it ends, once that is stored; NULL: it lasts */
    class_viewer *viewers;
    ll_ws_stream *stream;
    const char *ended; /* why; NULL: it lasts */
    ll_time used, sent_at, looked_at,
        pinged_at;    /* times of the last request, broadcast, check of the board, pings */
    bool working;     /* a task runs */
    ll_time retry_at; /* of a task that failed */
    bool touched;     /* by what the daemon saw, since it was stored */
    uint64_t stored;  /* hash of the text that was sent to the store last; 0: none, or it was not stored */
    ll_time stored_at;
};

struct ll_classes {
    ll_classes_config config;
    ll_host *host;
    ll_tasks *tasks;
    ll_ws *ws;
    ll_store *store; /* NULL: in memory only */
    ll_rate_limits *lookups;
    pthread_t thread;
    bool started;
    pthread_mutex_t lock;
    pthread_cond_t wake, settled;
    ll_class_entry *first;
    int64_t count;
    atomic_int writing; /* entries that the store is writing */
    bool stopping, news;
};

/* ---- entry.c ---- */

void ll_class_entry_retain(ll_class_entry *entry);
/* Adds an entry that has its names to the list, with a stream. Locked. */
ll_status ll_class_entry_list(ll_class_entry *entry);

/* The class as stored (0), as the store is writing it (1) and as it is to be written next (2); NULL: there is
 * none of that. What the daemon itself sees, as a connection or the board's clock, goes to all. Locked. */
enum { LL_CLASS_VERSIONS = 3 };
ll_class *ll_class_entry_version(ll_class_entry *entry, int i);

ll_class_entry *ll_classes_find_entry(const ll_classes *classes, const char *name, bool by_code); /* locked */
void ll_classes_close_ended(ll_classes *classes); /* takes ended classes off the list; locked */

/* ---- keep.c ---- */

/* Writes what the daemon saw, and the time of the last use once a minute. No request waits for it. Locked. */
void ll_class_entry_keep(ll_class_entry *entry, ll_time now);
/* Ends it for `reason` as soon as that is stored. Locked. */
void ll_class_entry_begin_end(ll_class_entry *entry, const char *reason);
/* Waits until a new entry is stored. Locked; unlocked meanwhile. On an error it has ended. */
ll_status ll_class_entry_store_new(ll_class_entry *entry);
void ll_classes_on_commit(void *classes);  /* hook of the store */
void ll_classes_wake(ll_classes *classes); /* its thread, for news; locked */
/* The stored classes, each with its stream; those that are too old are deleted. Before the thread starts. */
ll_status ll_classes_restore(ll_classes *classes);

/* ---- work.c ---- */

/* Starts the task if there is something to do. Locked. */
void ll_class_entry_work(ll_class_entry *entry, ll_time now);
/* Sees what the board is doing. Locked. */
void ll_class_entry_look(ll_class_entry *entry);

/* ---- stream.c ---- */

ll_ws_hooks ll_classes_hooks(ll_classes *classes);
void ll_class_entry_tell(ll_class_entry *entry, ll_time now); /* sends what changed; locked */
