/* What is stored: rows, logs, classes. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "daemon/store/internal.h"

static void read_text(sqlite3_stmt *s, int column, char *text, size_t size)
{
    const unsigned char *value = sqlite3_column_text(s, column);
    snprintf(text, size, "%s", value ? (const char *)value : "");
}

static void read_row(sqlite3_stmt *s, ll_stored *row)
{
    memset(row, 0, sizeof *row);
    row->number = sqlite3_column_int64(s, 0);
    read_text(s, 1, row->id, sizeof row->id);
    read_text(s, 2, row->code, sizeof row->code);
    row->created_ms = sqlite3_column_int64(s, 3);
    row->seen_ms = sqlite3_column_int64(s, 4);
    const void *keys = sqlite3_column_blob(s, 5);
    int bytes = sqlite3_column_bytes(s, 5);
    row->key_count = bytes / (int)sizeof row->keys[0];
    if (row->key_count > LL_STORE_KEYS)
        row->key_count = LL_STORE_KEYS;
    if (row->key_count > 0)
        memcpy(row->keys, keys, (size_t)row->key_count * sizeof row->keys[0]);
    row->playing = sqlite3_column_int(s, 6) != 0;
    row->speed = sqlite3_column_double(s, 7);
    row->tick = sqlite3_column_int64(s, 8);
    row->head_tick = sqlite3_column_int64(s, 9);
    row->lines = sqlite3_column_int64(s, 10);
    row->log_bytes = sqlite3_column_int64(s, 11);
}

ll_status ll_store_list(ll_store *store, void (*each)(void *context, const ll_stored *stored), void *context)
{
    if (!store)
        return ll_ok();
    static const char sql[] =
        "SELECT *, (SELECT coalesce(max(line_index) + 1, 0) FROM log WHERE session = number),"
        " (SELECT coalesce(sum(length(CAST(line AS BLOB)) + 1), 0) FROM log WHERE session = number)"
        " FROM sessions ORDER BY number";
    sqlite3_stmt *s = NULL;
    pthread_mutex_lock(&store->reader_lock);
    int result = sqlite3_prepare_v2(store->reader_db, sql, -1, &s, NULL);
    while (result == SQLITE_OK || result == SQLITE_ROW) {
        result = sqlite3_step(s);
        if (result != SQLITE_ROW)
            break;
        ll_stored row;
        read_row(s, &row);
        each(context, &row);
    }
    ll_status status = result == SQLITE_DONE ? ll_ok() : ll_store_error(store, store->reader_db, "Reading");
    sqlite3_finalize(s);
    pthread_mutex_unlock(&store->reader_lock);
    return status;
}

ll_status ll_store_list_classes(ll_store *store,
                                void (*each)(void *context, const char *id, int64_t seen_ms,
                                             const char *text),
                                void *context)
{
    if (!store)
        return ll_ok();
    sqlite3_stmt *s = NULL;
    pthread_mutex_lock(&store->reader_lock);
    int result = sqlite3_prepare_v2(store->reader_db, "SELECT id, seen_ms, state FROM classes", -1, &s, NULL);
    while (result == SQLITE_OK || result == SQLITE_ROW) {
        result = sqlite3_step(s);
        if (result != SQLITE_ROW)
            break;
        const unsigned char *id = sqlite3_column_text(s, 0), *text = sqlite3_column_text(s, 2);
        if (id && text)
            each(context, (const char *)id, sqlite3_column_int64(s, 1), (const char *)text);
    }
    ll_status status = result == SQLITE_DONE ? ll_ok() : ll_store_error(store, store->reader_db, "Reading");
    sqlite3_finalize(s);
    pthread_mutex_unlock(&store->reader_lock);
    return status;
}

static bool add_line(char **text, size_t *length, size_t *capacity, const void *line, size_t size)
{
    if (*length + size + 2 > *capacity) {
        size_t wanted = (*length + size + 2) * 2;
        char *bigger = realloc(*text, wanted);
        if (!bigger)
            return false;
        *text = bigger;
        *capacity = wanted;
    }
    memcpy(*text + *length, line, size);
    *length += size;
    (*text)[(*length)++] = '\n';
    (*text)[*length] = '\0';
    return true;
}

ll_status ll_store_read_log(ll_store *store, int64_t number, char **text, size_t *length)
{
    LL_ASSERT(store);
    *text = NULL;
    *length = 0;
    size_t capacity = 0;
    sqlite3_stmt *s = NULL;
    pthread_mutex_lock(&store->reader_lock);
    ll_status status = ll_ok();
    int result = sqlite3_prepare_v2(
        store->reader_db, "SELECT line FROM log WHERE session=?1 ORDER BY line_index", -1, &s, NULL);
    if (result == SQLITE_OK)
        sqlite3_bind_int64(s, 1, number);
    while ((result == SQLITE_OK || result == SQLITE_ROW) && !ll_failed(&status)) {
        result = sqlite3_step(s);
        if (result != SQLITE_ROW)
            break;
        const void *line = sqlite3_column_text(s, 0);
        if (!add_line(text, length, &capacity, line, (size_t)sqlite3_column_bytes(s, 0)))
            status = ll_error(LL_NO_MEMORY, "out of memory: log of a stored session");
    }
    if (!ll_failed(&status) && result != SQLITE_DONE)
        status = ll_store_error(store, store->reader_db, "Reading");
    sqlite3_finalize(s);
    pthread_mutex_unlock(&store->reader_lock);
    if (!ll_failed(&status) && !*text)
        status = ll_error(LL_IO, "Log of a stored session in %s is empty.", store->directory);
    if (ll_failed(&status)) {
        free(*text);
        *text = NULL;
    }
    return status;
}
