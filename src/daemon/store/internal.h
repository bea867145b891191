/* Shared by store.c (opening, the queue, the writer thread) and read.c. Not for other rooms. */
#pragma once

#include <pthread.h>
#include <sqlite3.h>

#include "daemon/store/store.h"

typedef enum record_type {
    RECORD_ROW,
    RECORD_LINE,
    RECORD_DELETE,
    RECORD_CLASS,
    RECORD_DELETE_CLASS
} record_type;

typedef struct record {
    struct record *next;
    record_type type;
    int64_t number, index;
    size_t size;
    char bytes[]; /* an ll_stored, a line, or a class: its id, NUL, its text */
} record;

typedef enum statement {
    PUT_ROW,
    PUT_LINE,
    DELETE_ROW,
    DELETE_LOG,
    PUT_CLASS,
    DELETE_CLASS,
    STATEMENTS
} statement;

struct ll_store {
    char *directory;
    int lock_file;
    sqlite3 *writer_db; /* of the writer thread */
    sqlite3_stmt *prepared[STATEMENTS];
    sqlite3 *reader_db;
    pthread_mutex_t reader_lock;
    pthread_t thread;
    bool started;

    pthread_mutex_t lock; /* guards all members below */
    pthread_cond_t queued, done;
    record *first, *last;
    uint64_t ticket, durable;
    int64_t next_number;
    int64_t commits, failures, waiting;
    bool closing, failing;
    ll_status why;
    void (*notify)(void *context);
    void *notify_context;
};

/* What SQLite said last, with the name of the folder. */
ll_status ll_store_error(const ll_store *store, sqlite3 *db, const char *doing);
