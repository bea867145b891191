#include "experiment/store/read_only.h"

#include <sqlite3.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum { PATH_MOST = 4096 };

/* `file:` with the path, whose signs with a meaning there are escaped. */
static void write_uri(const char *path, char uri[3 * PATH_MOST + 32])
{
    size_t n = (size_t)snprintf(uri, 8, "file:");
    for (const char *at = path; *at && n < 3 * PATH_MOST; at++)
        if (strchr("%?#", *at))
            n += (size_t)snprintf(uri + n, 4, "%%%02X", (unsigned)*at);
        else
            uri[n++] = *at;
    snprintf(uri + n, 24, "?immutable=1");
}

/* A log is read with an index in memory, which exclusive locking has; the locks themselves are not taken.
 * Without a log the file is read as it is, since SQLite would make one. */
bool ll_open_read_only(const char *path, sqlite3 **db)
{
    char log[PATH_MOST + 8], uri[3 * PATH_MOST + 32];
    struct stat found;
    snprintf(log, sizeof log, "%.*s-wal", PATH_MOST, path);
    if (stat(log, &found) == 0 && found.st_size > 0)
        return sqlite3_open_v2(path, db, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, "unix-none") ==
                   SQLITE_OK &&
               sqlite3_exec(*db, "PRAGMA locking_mode=EXCLUSIVE", NULL, NULL, NULL) == SQLITE_OK;
    write_uri(path, uri);
    return sqlite3_open_v2(uri, db, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_URI, NULL) ==
           SQLITE_OK;
}

bool ll_is_unwritable(sqlite3 *db)
{
    int code = db ? sqlite3_errcode(db) & 0xff : SQLITE_OK;
    return code == SQLITE_FULL || code == SQLITE_READONLY || code == SQLITE_IOERR ||
           code == SQLITE_CANTOPEN || code == SQLITE_PERM;
}
