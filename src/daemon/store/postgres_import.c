/* Sessions and classes of a folder into the store in PostgreSQL, in one transaction. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "daemon/store/postgres.h"

enum { NUMBERS = 1000 /* as the sequence's increment */ };

typedef struct import_run {
    ll_store *from;
    postgres_store *to;
    ll_imported *imported;
    int64_t now_ms; /* the folder's times are of this machine's clock, the store's of the database's */
    int64_t next, past;
    ll_stored *rows;
    size_t count, capacity;
    char *buffer; /* a line, escaped */
    size_t buffer_size;
    ll_status status; /* of a list */
} import_run;

static ll_status import_failure(const import_run *im)
{
    return ll_pg_failure(im->to, &im->to->reader, "Importing");
}

static int64_t idle_ms(const import_run *im, int64_t seen_ms)
{
    return im->now_ms > seen_ms ? im->now_ms - seen_ms : 0;
}

/* ---- classes ---- */

/* The board of a class has to be at the daemon that has the class, which goes by its id. One that was made
 * for itself may be elsewhere: the class has no board then, and its teacher shows it again, which makes a
 * fork. */
static const char class_sql[] =
    "INSERT INTO class(id,stem,code,client,engine,owner,body,class_key,seen)"
    " SELECT $1,left($1,10),c.j->>'code',coalesce(c.j->>'client',''),$3,NULL,CASE WHEN"
    " coalesce(c.j->'board'->>'session','')='' OR left(c.j->'board'->>'session',10)=left($1,10) THEN c.body"
    " ELSE (c.body::jsonb||'{\"board\":null,\"driven\":[],\"script\":[]}')::text END,c.j->>'class_key',"
    "now()-$4::bigint*interval '1 millisecond' FROM (SELECT $2::text AS body, $2::text::json AS j) AS c"
    " ON CONFLICT DO NOTHING RETURNING body<>$2";

static void import_class(void *context, const char *id, int64_t seen_ms, const char *text)
{
    import_run *im = context;
    pg_link *link = &im->to->reader;
    if (ll_failed(&im->status))
        return;
    if (!ll_pg_query(link, class_sql, "ttti", id, text, im->to->engine, idle_ms(im, seen_ms)))
        im->status = import_failure(im);
    else if (ll_pg_changed(link) == 0)
        im->status = ll_error(LL_CONFLICT, "Class %s, or one with its code, is in the store %.120s already.",
                              id, im->to->name);
    else {
        im->imported->classes++;
        im->imported->boards += ll_pg_true(link, 0, 0);
    }
}

/* ---- sessions ---- */

/* The log of one is read while the list is not. */
static void keep_row(void *context, const ll_stored *row)
{
    import_run *im = context;
    if (row->lines == 0 || row->key_count < 1 || !ll_is_id(row->id) || !ll_is_code(row->code)) {
        im->imported->left_out++;
        return;
    }
    if (im->count == im->capacity) {
        size_t wanted = im->capacity * 2 + 64;
        ll_stored *more = realloc(im->rows, wanted * sizeof *more);
        if (!more) {
            im->status = ll_error(LL_NO_MEMORY, "out of memory: stored sessions");
            return;
        }
        im->rows = more;
        im->capacity = wanted;
    }
    im->rows[im->count++] = *row;
}

static bool take_number(import_run *im, int64_t *number)
{
    pg_link *link = &im->to->reader;
    if (im->next == im->past) {
        if (!ll_pg_run(link, "SELECT nextval('session_number')"))
            return false;
        im->next = ll_pg_whole(link, 0, 0);
        im->past = im->next + NUMBERS;
    }
    *number = im->next++;
    return true;
}

static const char session_sql[] =
    "INSERT INTO session(no,id,code,engine,created_ms,keys,owner,playing,speed,tick,head_tick,hash_tick,"
    "hash_lines,hash,seen) VALUES($1::bigint,$2,$3,$4,$5::bigint,decode($6,'hex'),NULL,$7::bigint<>0,"
    "$8::double precision,$9::bigint,$10::bigint,0,0,0,now()-$11::bigint*interval '1 millisecond')"
    " ON CONFLICT DO NOTHING";

/* Sessions of a class count for its limit, those of a class key for that key's. */
static const char code_sql[] =
    "INSERT INTO code(code,session,stem,class_key,log_bytes) VALUES($1,$2::bigint,(SELECT stem FROM class"
    " WHERE stem=left($3,10)),nullif($4,''),$5::bigint) ON CONFLICT DO NOTHING";

static ll_status import_row(import_run *im, const ll_stored *row, int64_t number)
{
    pg_link *link = &im->to->reader;
    const unsigned char *keys = (const unsigned char *)row->keys;
    char hex[2 * sizeof row->keys + 1];
    for (size_t i = 0; i < (size_t)row->key_count * sizeof row->keys[0]; i++)
        snprintf(hex + 2 * i, 3, "%02x", keys[i]);
    if (!ll_pg_query(link, session_sql, "itttitiriii", number, row->id, row->code, im->to->engine,
                     row->created_ms, hex, (int64_t)row->playing, row->speed, row->tick, row->head_tick,
                     idle_ms(im, row->seen_ms)))
        return import_failure(im);
    if (ll_pg_changed(link) == 0)
        return ll_error(LL_CONFLICT, "Session %s is in the store %.120s already.", row->id, im->to->name);
    if (!ll_pg_query(link, code_sql, "titti", row->code, number, row->id, row->class_key, row->log_bytes))
        return import_failure(im);
    if (ll_pg_changed(link) == 0)
        return ll_error(LL_CONFLICT, "Code %s of session %s is another session's in the store %.120s.",
                        row->code, row->id, im->to->name);
    return ll_ok();
}

/* ---- logs ---- */

/* A row of COPY's text format. False: no memory, or no connection. */
static bool put_line(import_run *im, int64_t number, int64_t index, const char *line, size_t length)
{
    size_t wanted = 2 * length + 64;
    if (wanted > im->buffer_size) {
        char *bigger = realloc(im->buffer, wanted);
        if (!bigger)
            return false;
        im->buffer = bigger;
        im->buffer_size = wanted;
    }
    char *to = im->buffer + snprintf(im->buffer, 64, "%" PRId64 "\t%" PRId64 "\t", number, index);
    for (size_t i = 0; i < length; i++) {
        const char c = line[i];
        const char escaped = c == '\t' ? 't' : c == '\r' ? 'r' : c == '\\' ? '\\' : '\0';
        if (escaped)
            *to++ = '\\';
        *to++ = escaped ? escaped : c;
    }
    *to++ = '\n';
    return PQputCopyData(im->to->reader.db, im->buffer, (int)(to - im->buffer)) == 1;
}

static bool put_log(import_run *im, int64_t number, const char *text, size_t length)
{
    pg_link *link = &im->to->reader;
    int64_t index = 0;
    if (!ll_pg_run(link, "COPY line(session,i,body) FROM STDIN"))
        return false;
    bool good = true;
    for (const char *p = text, *end = text + length; good && p < end; index++) {
        const char *newline = memchr(p, '\n', (size_t)(end - p));
        size_t size = (size_t)((newline ? newline : end) - p);
        good = put_line(im, number, index, p, size);
        p += size + 1;
    }
    good =
        PQputCopyEnd(link->db, good ? NULL : "out of memory") == 1 && ll_pg_keep(link, PQgetResult(link->db));
    for (PGresult *rest; good && (rest = PQgetResult(link->db));)
        PQclear(rest);
    im->imported->lines += index;
    im->imported->bytes += (int64_t)length;
    return good;
}

static ll_status import_session(import_run *im, const ll_stored *row)
{
    int64_t number;
    char *text = NULL;
    size_t length = 0;
    if (!take_number(im, &number))
        return import_failure(im);
    LL_TRY(import_row(im, row, number));
    LL_TRY(ll_store_read_log(im->from, row->place.number, &text, &length));
    ll_status status = put_log(im, number, text, length) ? ll_ok() : import_failure(im);
    free(text);
    im->imported->sessions += !ll_failed(&status);
    return status;
}

/* ---- all of it ---- */

static ll_status import_all(import_run *im)
{
    im->status = ll_ok();
    LL_TRY(ll_store_list(im->from, keep_row, im));
    LL_TRY(im->status);
    LL_TRY(ll_store_list_classes(im->from, import_class, im));
    LL_TRY(im->status);
    for (size_t i = 0; i < im->count; i++)
        LL_TRY(import_session(im, &im->rows[i]));
    return ll_ok();
}

/* Without the daemons' limit of a transaction's idle time: a long log is read in one. The end of the
 * connection undoes what was not committed. */
static ll_status import_into(import_run *im)
{
    pg_link *link = &im->to->reader;
    if (!ll_pg_run(link, "SET idle_in_transaction_session_timeout TO 0") || !ll_pg_run(link, "BEGIN"))
        return import_failure(im);
    LL_TRY(import_all(im));
    return ll_pg_run(link, "COMMIT") ? ll_ok() : import_failure(im);
}

ll_status ll_pg_import(const char *directory, const char *url, ll_imported *imported)
{
    import_run im = {.imported = imported};
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    im.now_ms = (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
    LL_TRY(ll_sqlite_open_source(directory, &im.from));
    ll_status status =
        ll_pg_open_tables(&(ll_shared_config){.url = url, .address = "", .lease_s = 60}, &im.to);
    LL_THEN(status, import_into(&im));
    if (im.to)
        ll_store_close(&im.to->base);
    ll_store_close(im.from);
    free(im.rows);
    free(im.buffer);
    if (ll_failed(&status))
        *imported = (ll_imported){0};
    return status;
}
