/* Rows of a record as integers, for comparing, encoding and sharing. */
#pragma once

#include "record/buffer.h"
#include "record/record.h"

/* Made by ll_rows_new. */
typedef struct ll_rows {
    const ll_record *record;
    int count, capacity;
    int64_t first;   /* LOG: number of the first row; also without rows */
    int64_t *values; /* row by row, one value per field */
    uint8_t *planes; /* GRID: one after the other */
    size_t plane_bytes;
} ll_rows;

/* NULL without memory. */
ll_rows *ll_rows_new(const ll_record *record, int capacity);
void ll_rows_free(ll_rows *rows); /* NULL: no effect */
/* A copy in memory of the caller, aligned for ll_rows, of ll_rows_copy_bytes bytes: it has no memory of its
 * own, nothing can be added, and ll_rows_free must not be called. */
size_t ll_rows_copy_bytes(const ll_rows *rows);
void ll_rows_copy_to(ll_rows *copy, const ll_rows *rows);
/* Removes all rows, for rows of another record in the same memory. */
void ll_rows_clear(ll_rows *rows, const ll_record *record);
size_t ll_rows_bytes(const ll_rows *rows);

/* Adds `count` structs of the record; false without memory. */
bool ll_rows_add(ll_rows *rows, const void *structs, int count);
/* The same for one row of a GRID, with its plane of width x height bytes. */
bool ll_rows_add_plane(ll_rows *rows, const void *row, const uint8_t *plane);
/* Sorts the rows of a KEYED record by key. Call when all are added. */
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

/* Appends the section's body, whole if `base` is NULL, or as a delta against `base`: the same record's rows
 * as the reader has them.
 *
 *   ONE, BY_INDEX, GRID   varint rows
 *   KEYED                 varint runs, each: varint copied, dropped and new rows
 *   then                  varint changed rows, each: varint skipped rows | varint mask of fields | zigzag
 *                         varint of each difference, lowest bit first
 *   GRID                  for each row: u8 coding | its plane
 *                         coding 0: values; 1: less the base's, less the same for the cell on the left
 *   LOG                   varint lost rows | varint number of the first | varint rows, each: varint mask |
 *                         differences from the previous row
 *
 * Differences of a row that exists in the base are from its old values; those of a new row, and of all rows
 * of a LOG, from the previous row; those of the first from zeros. */
void ll_rows_encode(const ll_rows *rows, const ll_rows *base, ll_buffer *out);

/* Appends a JSON array with an object per row: field names, numbers as decoded from the bytes, names of
 * values and of set flags instead of their numbers. Of a LOG the rows numbered from `from` on, each with its
 * number as `id`; of a GRID each with its plane as `values`. */
void ll_rows_json(const ll_rows *rows, int64_t from, ll_buffer *out);
