/* Shared by store.c (the queue, the writer thread) and database.c. Not for other rooms. */
#pragma once

#include "daemon/store/store.h"

typedef enum record_type {
    RECORD_ROW,
    RECORD_LINE,
    RECORD_DELETE,
    RECORD_TRY_DELETE,
    RECORD_TEXT,
    RECORD_DELETE_TEXT
} record_type;

typedef struct ll_store_record {
    struct ll_store_record *next;
    record_type type;
    int64_t number,
        index; /* of the session's row and of the line; of a text: its kind, and when it was seen */
    size_t size;
    char bytes[]; /* an ll_stored, a line, or a text: its id, NUL, the text */
} record;

typedef struct ll_database ll_database;

/* Of a folder, which is made if it is missing, with its lock. What is there is read also where nothing can be
 * written, as on a full or read-only disk. */
ll_status ll_database_open(const char *directory, ll_database **database);
void ll_database_close(ll_database *database);
ll_status ll_database_writable(const ll_database *database);     /* when it was opened */
int64_t ll_database_highest_number(const ll_database *database); /* of a row when it was opened; 0: none */

/* By the writer thread. All or nothing; the same batch may be written again. */
ll_status ll_database_commit(ll_database *database, const record *batch);

/* By the writer thread: whether as many bytes, and some more, can be written. Opens for writing what could
 * only be read. */
ll_status ll_database_try_room(ll_database *database, int64_t bytes);

/* As the functions of store.h. */
ll_status ll_database_list(ll_database *database, void (*each)(void *context, const ll_stored *stored),
                           void *context);
ll_status ll_database_read_log(ll_database *database, int64_t number, char **text, size_t *length);
ll_status ll_database_list_texts(ll_database *database, ll_store_text kind,
                                 void (*each)(void *context, const char *id, int64_t seen_ms,
                                              const char *text),
                                 void *context);
