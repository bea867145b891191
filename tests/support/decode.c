#include "support/decode.h"

#include <stdlib.h>
#include <string.h>

enum { ROWS_BYTES_MAX = 16 << 20 };

typedef struct reader {
    const uint8_t *at, *end;
    ll_status status;
} reader;

static uint64_t bad(reader *r, const char *what)
{
    if (!ll_failed(&r->status))
        r->status = ll_error(LL_BAD_INPUT, "%s", what);
    r->at = r->end;
    return 0;
}

static uint64_t varint(reader *r)
{
    uint64_t value = 0;
    for (int shift = 0; shift < 56; shift += 7) {
        if (r->at == r->end)
            return bad(r, "the bytes end within a number");
        uint8_t byte = *r->at++;
        value |= (uint64_t)(byte & 127) << shift;
        if (byte < 128)
            return value < UINT64_C(1) << 53 ? value : bad(r, "number too large: 2^53 or more");
    }
    return bad(r, "number longer than 8 bytes");
}

/* Checks the number of rows: at most as many as fit. */
static int rows_of(reader *r, const ll_record *record, uint64_t count)
{
    size_t most = ROWS_BYTES_MAX / ((size_t)record->count * sizeof(int64_t));
    return count <= most ? (int)count : (int)bad(r, "more rows than fit in 16 MiB");
}

/* ---- rows ---- */

static void add_rows(ll_rows *rows, int count, const int64_t *from, reader *r)
{
    size_t width = (size_t)rows->record->count;
    if (rows_of(r, rows->record, (uint64_t)rows->count + (uint64_t)count) > rows->capacity)
        bad(r, "runs have more rows than announced");
    if (ll_failed(&r->status))
        return;
    if (from != NULL)
        memcpy(ll_rows_at(rows, rows->count), from, (size_t)count * width * sizeof *from);
    rows->count += count;
}

/* Starting values of the rows: copies of the base's, or those of the previous row, which `fresh` marks. */
static void read_runs(reader *r, const ll_rows *base, ll_rows *rows, uint8_t *fresh)
{
    uint64_t runs = varint(r), was = 0, old = base != NULL ? (uint64_t)base->count : 0;
    for (; runs > 0 && !ll_failed(&r->status); runs--) {
        uint64_t copied = varint(r), dropped = varint(r), added = varint(r);
        if (copied > old - was || dropped > old - was - copied || added > (uint64_t)rows->capacity ||
            copied + dropped + added == 0) {
            bad(r, "empty run, or more rows than exist");
            return;
        }
        if (copied > 0)
            add_rows(rows, (int)copied, ll_rows_at(base, (int)was), r);
        was += copied + dropped;
        if (!ll_failed(&r->status) && rows->count + (int)added <= rows->capacity)
            memset(fresh + rows->count, 1, (size_t)added);
        add_rows(rows, (int)added, NULL, r);
    }
    if (was != old)
        bad(r, "runs do not cover all rows of the base");
}

static void apply(reader *r, const ll_record *record, int64_t *row)
{
    uint64_t mask = varint(r);
    for (int k = 0; mask != 0; k++, mask >>= 1) {
        if (!(mask & 1))
            continue;
        int64_t change = unzigzag(varint(r));
        if (k >= record->count) /* a field that this table does not have yet */
            continue;
        row[k] += change;
        if (row[k] < LL_INTEGER_NONE || row[k] > LL_INTEGER_MAX) {
            row[k] = 0;
            bad(r, "value outside of +-2^51");
        }
    }
}

static void read_changes(reader *r, ll_rows *rows, const uint8_t *fresh)
{
    size_t width = (size_t)rows->record->count * sizeof(int64_t);
    uint64_t changed = varint(r), skip = changed > 0 ? varint(r) : 0;
    for (int i = 0; i < rows->count && !ll_failed(&r->status); i++) {
        int64_t *row = ll_rows_at(rows, i);
        if (fresh[i] && i > 0)
            memcpy(row, ll_rows_at(rows, i - 1), width);
        else if (fresh[i])
            memset(row, 0, width);
        if (changed == 0)
            continue;
        if (skip-- == 0) {
            apply(r, rows->record, row);
            skip = --changed > 0 ? varint(r) : 0;
        }
    }
    if (changed > 0)
        bad(r, "more changed rows than rows");
}

static void read_log(reader *r, ll_rows *rows)
{
    size_t width = (size_t)rows->record->count * sizeof(int64_t);
    for (int i = 0; i < rows->count && !ll_failed(&r->status); i++) {
        int64_t *row = ll_rows_at(rows, i);
        if (i > 0)
            memcpy(row, ll_rows_at(rows, i - 1), width);
        else
            memset(row, 0, width);
        apply(r, rows->record, row);
    }
}

/* ---- planes ---- */

/* before: the base's plane of that size; NULL: there is none. */
static void read_plane(reader *r, const uint8_t *before, int row, ll_rows *rows, uint8_t *to)
{
    const int64_t *shape = ll_rows_at(rows, row);
    size_t width = (size_t)shape[0], size = ll_rows_plane(rows, row);
    if (r->end - r->at < (ptrdiff_t)size + 1) {
        bad(r, "incomplete plane");
        return;
    }
    uint8_t coding = *r->at++;
    if (coding > 1 || (coding == 1 && before == NULL)) {
        bad(r, "unknown coding of a plane, or base missing");
        return;
    }
    uint8_t change = 0;
    for (size_t i = 0; i < size; i++) {
        change = (uint8_t)(r->at[i] + (coding == 1 && i % width != 0 ? change : 0));
        to[i] = coding == 1 ? (uint8_t)(before[i] + change) : r->at[i];
    }
    r->at += size;
}

static void read_planes(reader *r, const ll_rows *base, ll_rows *rows)
{
    size_t total = 0;
    for (int i = 0; i < rows->count; i++) {
        const int64_t *shape = ll_rows_at(rows, i);
        if (shape[0] < 0 || shape[1] < 0 || shape[0] > 65536 || shape[1] > 65536)
            bad(r, "invalid size of a plane");
        else
            total += ll_rows_plane(rows, i);
        if (total > ROWS_BYTES_MAX)
            bad(r, "planes larger than 16 MiB");
    }
    if (ll_failed(&r->status))
        return;
    rows->planes = calloc(1, total + 1);
    if (rows->planes == NULL) {
        r->status = ll_error(LL_NO_MEMORY, "out of memory: planes");
        return;
    }
    size_t at = 0; /* of the base's plane */
    for (int i = 0; i < rows->count && !ll_failed(&r->status); i++) {
        bool has = base != NULL && base->planes != NULL && i < base->count;
        size_t size = ll_rows_plane(rows, i), old = has ? ll_rows_plane(base, i) : 0;
        read_plane(r, has && old == size ? base->planes + at : NULL, i, rows,
                   rows->planes + rows->plane_bytes);
        rows->plane_bytes += size;
        at += old;
    }
}

/* ---- sections ---- */

static void read_body(reader *r, const ll_record *record, const ll_rows *base, ll_rows *rows, uint8_t *fresh)
{
    int old = base != NULL ? base->count : 0;
    switch (record->form) {
    case LL_FORM_LOG:
        rows->count = rows->capacity;
        read_log(r, rows);
        return;
    case LL_FORM_KEYED:
        read_runs(r, base, rows, fresh);
        break;
    default:
        rows->count = rows->capacity;
        old = old < rows->count ? old : rows->count;
        if (old > 0)
            memcpy(rows->values, base->values, (size_t)old * (size_t)record->count * sizeof(int64_t));
        memset(fresh + old, 1, (size_t)(rows->count - old));
    }
    if (!ll_failed(&r->status))
        read_changes(r, rows, fresh);
    if (record->form == LL_FORM_GRID && !ll_failed(&r->status))
        read_planes(r, base, rows);
}

/* Counts the rows of a KEYED section before its runs are decoded. */
static uint64_t count_runs(reader copy)
{
    uint64_t runs = varint(&copy), rows = 0;
    for (; runs > 0 && !ll_failed(&copy.status) && rows < ROWS_BYTES_MAX; runs--) {
        rows += varint(&copy);
        varint(&copy);
        rows += varint(&copy);
    }
    return rows;
}

ll_status ll_rows_decode(const ll_record *record, const ll_rows *base, const void *bytes, size_t size,
                         ll_rows **result)
{
    reader r = {bytes, (const uint8_t *)bytes + size, ll_ok()};
    int64_t first = 0;
    if (record->form == LL_FORM_LOG) {
        varint(&r); /* number of lost rows */
        first = (int64_t)varint(&r);
    }
    int count = rows_of(&r, record, record->form == LL_FORM_KEYED ? count_runs(r) : varint(&r));
    if (ll_failed(&r.status))
        return r.status;
    ll_rows *rows = ll_rows_new(record, count);
    uint8_t *fresh = calloc(1, (size_t)count + 1);
    if (rows != NULL && fresh != NULL) {
        rows->first = first;
        read_body(&r, record, base, rows, fresh);
        if (r.at != r.end)
            bad(&r, "bytes after the end");
    } else {
        r.status = ll_error(LL_NO_MEMORY, "out of memory: rows");
    }
    free(fresh);
    if (ll_failed(&r.status))
        ll_rows_free(rows);
    else
        *result = rows;
    return r.status;
}
