/* A database of SQLite where nothing can be written, as on a full or read-only disk: neither a lock nor
 * shared memory. The caller keeps other writers away. */
#pragma once

#include <stdbool.h>

struct sqlite3;

/* With what its write-ahead log has. On an error `*db` has the message, and is to be closed. */
bool ll_open_read_only(const char *path, struct sqlite3 **db);

/* Whether the last error of `db` says that it cannot be written, so that it can perhaps be read. */
bool ll_is_unwritable(struct sqlite3 *db);
