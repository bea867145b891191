/* Shared by entry.c (references), work.c (what is done to sessions), stream.c (messages) and classes.c (the
 * list). Not for other rooms. */
#pragma once

#include <pthread.h>
#include <stdatomic.h>

#include "daemon/class/classes.h"
#include "daemon/support/rate_limits.h"
#include "daemon/support/tasks.h"

/* A connection to the stream of a class. */
typedef struct class_viewer {
    struct class_viewer *next;
    ll_ws_viewer id;
    bool hello_sent, teacher;
    int place; /* of its member; -1: none */
    uint32_t number;
} class_viewer;

struct ll_class_entry {
    ll_class_entry *next;
    ll_classes *classes;
    atomic_int references;
    char id[LL_ID_LENGTH + 1], code[LL_CODE_LENGTH + 1];
    uint64_t client;                    /* hash of the address that opened it, for the quota */
    ll_class_key *class_key;            /* or the key; NULL: none, or its line is missing now */
    char key_name[LL_KEY_NAME_MAX + 1]; /* empty: none */
    int64_t daemon;                     /* incarnation of this daemon that has it in a shared store; else 0 */
    ll_time claimed_at;

    /* guarded by the lock of `classes` */
    ll_class values;
    class_viewer *viewers;
    ll_ws_stream *stream;
    const char *ended; /* why; NULL: it lasts */
    bool leaving;      /* it is being given to another daemon */
    bool moved;        /* with `ended`: it goes on at another daemon, or will */
    ll_time used, sent_at, looked_at,
        pinged_at;    /* times of the last request, broadcast, check of the board, pings */
    bool working;     /* a task runs */
    ll_time retry_at; /* of a task that failed */
    bool touched;     /* by a request, since it was stored */
    uint64_t stored;  /* hash of the text that was stored last; 0: none was */
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
    pthread_cond_t wake;
    ll_class_entry *first;
    int64_t count;
    bool stopping, news;

    /* of a store that several daemons share */
    ll_host_group group;
    pthread_mutex_t claiming;  /* taken before `lock`, from a claim until the class is on the list */
    _Atomic uint64_t released; /* ticket of the last class that was given away */
};

/* ---- entry.c ---- */

void ll_class_entry_retain(ll_class_entry *entry);
/* Adds an entry that has its names to the list, with a stream. Locked. */
ll_status ll_class_entry_list(ll_class_entry *entry);
/* The member of this place, unless it has gone; -1. Locked. */
int ll_class_viewer_place(const ll_class_entry *entry, const class_viewer *viewer);

ll_class_entry *ll_classes_find_entry(const ll_classes *classes, const char *name, bool by_code); /* locked */
void ll_classes_close_ended(ll_classes *classes); /* takes ended classes off the list; locked */

/* ---- share.c ---- */

/* Whether this daemon still has it: its lease may be lost. Any thread. */
bool ll_class_entry_is_held(const ll_class_entry *entry);
/* Ends here what is held no more. Locked. */
void ll_class_entry_check(ll_class_entry *entry);
/* The class of a shared store, claimed from no owner, a dead one or, if it is `asked` for, from a living one.
 */
ll_status ll_classes_obtain(ll_classes *classes, const char *id, bool ask, ll_task *task,
                            ll_class_entry **entry);
/* Writes a new class with its names to the shared store. */
ll_status ll_class_entry_open_shared(ll_class_entry *entry, ll_opened_class *opened);
/* A viewer wants one that is not here: it is claimed, for when the viewer comes again. */
ll_ws_known ll_classes_expect(void *context, ll_stream_kind kind, const char *id);
void ll_classes_share(ll_classes *classes); /* at the start */

/* ---- keep.c ---- */

char *ll_class_entry_text(const ll_class_entry *entry); /* as it is stored; the caller frees it */
/* A class as stored, not listed yet. */
ll_status ll_class_entry_make(ll_classes *classes, const char *id, int64_t idle_ms, const char *text,
                              ll_class_entry **entry);

/* Queues what has changed for the store, and the time of the last use once a minute. Locked. */
void ll_class_entry_store(ll_class_entry *entry, ll_time now);
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
