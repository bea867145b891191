#include <string.h>

#include "base/assert.h"
#include "record/rows.h"

static const int64_t zeros[LL_FIELDS_MAX];

/* ---- matching rows with those of the base ---- */

typedef enum op { COPY, DROP, NEW, END } op;

/* State of the merge of the rows with those of the base. */
typedef struct merge {
    const ll_rows *rows, *base; /* base NULL: all rows are new */
    int row, was;
} merge;

/* Next step of merging two lists that are sorted by key; without keys, rows with equal index match. */
static op next(const merge *m)
{
    bool more = m->row < m->rows->count, old = m->base != NULL && m->was < m->base->count;
    if (!more || !old)
        return more ? NEW : old ? DROP : END;
    const int64_t *a = ll_rows_at(m->base, m->was), *b = ll_rows_at(m->rows, m->row);
    for (int k = 0; k < m->rows->record->keys; k++)
        if (a[k] != b[k])
            return a[k] < b[k] ? DROP : NEW;
    return COPY;
}

static void pass(merge *m, op what)
{
    m->row += what != DROP;
    m->was += what != NEW;
}

static uint64_t run(merge *m, op what)
{
    uint64_t length = 0;
    for (; next(m) == what; length++)
        pass(m, what);
    return length;
}

static void put_runs(const ll_rows *rows, const ll_rows *base, ll_buffer *out)
{
    size_t begin = out->size;
    uint64_t runs = 0;
    for (merge m = {rows, base, 0, 0}; next(&m) != END; runs++)
        for (op what = COPY; what <= NEW; what++)
            ll_buffer_varint(out, run(&m, what));
    ll_buffer_insert_varint(out, begin, runs);
}

/* ---- changed fields ---- */

/* From the last field on: compilers would make vectors of a loop that sets each bit at its place, which has
 * several times the instructions for the few fields of a record. */
static inline uint64_t changes(const ll_record *record, const int64_t *from, const int64_t *to)
{
    uint64_t mask = 0;
#pragma GCC unroll 4
    for (int k = record->count - 1; k >= 0; k--)
        mask = 2 * mask + (from[k] != to[k]);
    return mask;
}

static char *write_changes(char *at, uint64_t mask, const int64_t *from, const int64_t *to)
{
    at = ll_varint_write(at, mask);
    for (; mask != 0; mask &= mask - 1) {
        int k = __builtin_ctzll(mask);
        at = ll_varint_write(at, ll_zigzag(to[k] - from[k]));
    }
    return at;
}

enum { ROW_BYTES_MAX = (LL_FIELDS_MAX + 2) * LL_VARINT_BYTES_MAX }; /* skipped rows, mask, values */

static void put_changes(uint64_t mask, const int64_t *from, const int64_t *to, ll_buffer *out)
{
    char *at = ll_buffer_reserve(out, ROW_BYTES_MAX);
    if (at != NULL)
        out->size += (size_t)(write_changes(at, mask, from, to) - at);
}

static void put_row(uint64_t skipped, uint64_t mask, const int64_t *from, const int64_t *to, ll_buffer *out)
{
    char *at = ll_buffer_reserve(out, ROW_BYTES_MAX);
    if (at != NULL)
        out->size += (size_t)(write_changes(ll_varint_write(at, skipped), mask, from, to) - at);
}

/* The values that a row's differences refer to. */
static const int64_t *start_of(const merge *m, op what)
{
    return what == COPY ? ll_rows_at(m->base, m->was) : m->row > 0 ? ll_rows_at(m->rows, m->row - 1) : zeros;
}

static void put_rows(const ll_rows *rows, const ll_rows *base, ll_buffer *out)
{
    size_t begin = out->size;
    uint64_t changed = 0, skipped = 0;
    op what;
    ll_buffer_varint(out, 0);
    for (merge m = {rows, base, 0, 0}; (what = next(&m)) != END; pass(&m, what)) {
        if (what == DROP)
            continue;
        const int64_t *from = start_of(&m, what), *to = ll_rows_at(rows, m.row);
        uint64_t mask = changes(rows->record, from, to);
        if (mask == 0) {
            skipped++;
            continue;
        }
        put_row(skipped, mask, from, to, out);
        skipped = 0;
        changed++;
    }
    ll_buffer_set_varint(out, begin, changed);
}

/* ---- planes ---- */

/* Each cell's difference from the base, as a difference from that of the cell on the left. */
static void put_plane_change(const uint8_t *plane, const uint8_t *before, size_t width, size_t size,
                             ll_buffer *out)
{
    uint8_t *to = (uint8_t *)ll_buffer_grow(out, size);
    uint8_t left = 0;
    for (size_t i = 0; to != NULL && i < size; i++) {
        uint8_t change = (uint8_t)(plane[i] - before[i]);
        to[i] = (uint8_t)(change - (i % width == 0 ? 0 : left));
        left = change;
    }
}

static void put_planes(const ll_rows *rows, const ll_rows *base, ll_buffer *out)
{
    const uint8_t *plane = rows->planes, *before = base != NULL ? base->planes : NULL;
    for (int i = 0; i < rows->count; i++) {
        const int64_t *shape = ll_rows_at(rows, i);
        const int64_t *was = base != NULL && i < base->count ? ll_rows_at(base, i) : NULL;
        size_t size = ll_rows_plane(rows, i);
        char coding = was != NULL && shape[0] == was[0] && shape[1] == was[1];
        ll_buffer_add(out, &coding, 1);
        if (coding)
            put_plane_change(plane, before, (size_t)shape[0], size, out);
        else
            ll_buffer_add(out, plane, size);
        plane += size;
        before += was != NULL ? ll_rows_plane(base, i) : 0;
    }
}

/* ---- logs ---- */

static void put_log(const ll_rows *rows, const ll_rows *base, ll_buffer *out)
{
    int64_t end = rows->first + rows->count, wanted = base != NULL ? base->first + base->count : rows->first;
    int64_t lost = rows->first > wanted ? rows->first - wanted : 0;
    int skipped = wanted > rows->first ? (int)(wanted - rows->first) : 0;
    const int64_t *from = zeros;
    LL_ASSERT(wanted <= end);
    ll_buffer_varint(out, (uint64_t)lost);
    ll_buffer_varint(out, (uint64_t)(rows->first + skipped));
    ll_buffer_varint(out, (uint64_t)(rows->count - skipped));
    for (int i = skipped; i < rows->count; i++) {
        const int64_t *to = ll_rows_at(rows, i);
        put_changes(changes(rows->record, from, to), from, to, out);
        from = to;
    }
}

void ll_rows_encode(const ll_rows *rows, const ll_rows *base, ll_buffer *out)
{
    LL_ASSERT(base == NULL || base->record == rows->record);
    if (rows->record->form == LL_FORM_LOG) {
        put_log(rows, base, out);
        return;
    }
    if (rows->record->form == LL_FORM_KEYED)
        put_runs(rows, base, out);
    else
        ll_buffer_varint(out, (uint64_t)rows->count);
    put_rows(rows, base, out);
    if (rows->record->form == LL_FORM_GRID)
        put_planes(rows, base, out);
}
