/* Rows of a record as integers: what is compared, encoded and shared. */
#pragma once

#include "record/buffer.h"
#include "record/record.h"

/* Made by ll_rows_new; never changed once it is filled. */
typedef struct ll_rows {
    const ll_record *record;
    int count, capacity;
    int64_t first;   /* of a LOG: the number of the first row; also when there is none */
    int64_t *values; /* a row behind the other, a value for each field */
    uint8_t *planes; /* of a GRID: one behind the other */
    size_t plane_bytes;
} ll_rows;

/* NULL without memory. */
ll_rows *ll_rows_new(const ll_record *record, int capacity);
void ll_rows_free(ll_rows *rows); /* NULL: nothing */
size_t ll_rows_bytes(const ll_rows *rows);

/* Adds `count` structs of the record; false without memory. */
bool ll_rows_add(ll_rows *rows, const void *structs, int count);
/* The same of one of a GRID, with its plane of width x height bytes. */
bool ll_rows_add_plane(ll_rows *rows, const void *row, const uint8_t *plane);
/* Brings those of a KEYED record into the order of their keys. To be called when all are there. */
void ll_rows_sort(ll_rows *rows);

static inline int64_t *ll_rows_at(const ll_rows *rows, int row)
{
    return rows->values + (size_t)row * (size_t)rows->record->count;
}

/* Bytes of the plane of a row. */
static inline size_t ll_rows_plane(const ll_rows *rows, int row)
{
    const int64_t *values = ll_rows_at(rows, row);
    return (size_t)values[0] * (size_t)values[1];
}

bool ll_rows_equal(const ll_rows *a, const ll_rows *b);

/* Appends the section's body: against `base`, the same record's rows as the reader has them, or whole when it
 * is NULL.
 *
 *   ONE, BY_INDEX, GRID   varint rows
 *   KEYED                 varint runs, each: varint copied, left out and new ones
 *   then                  varint changed rows, each: varint skipped rows | varint mask of fields | zigzag
 *                         varint of each difference, lowest bit first
 *   GRID                  for each row: u8 coding | its plane
 *                         coding 0: values; 1: less the base's, less what that is for the cell on the left
 *   LOG                   varint lost rows | varint number of the first | varint rows, each: varint mask |
 *                         differences against the row before
 *
 * A row that was there before starts from what it was; a new one, and any of a LOG, from the row before it;
 * the first from zeros. */
void ll_rows_encode(const ll_rows *rows, const ll_rows *base, ll_buffer *out);

/* The reverse. LL_BAD_INPUT says what is wrong with the bytes; LL_NO_MEMORY. */
ll_status ll_rows_decode(const ll_record *record, const ll_rows *base, const void *bytes, size_t size,
                         ll_rows **rows);

/* Appends a JSON array of an object for each row, by the names of the fields, numbers as a decoder of the
 * bytes has them, the names of values and of flags that are set instead of their numbers. Of a LOG those
 * numbered from `from` on, each with its number as `id`; of a GRID each with its plane as `values`. */
void ll_rows_json(const ll_rows *rows, int64_t from, ll_buffer *out);
