#include "record/rows.h"

#include <stdlib.h>
#include <string.h>

#include "base/assert.h"

ll_rows *ll_rows_new(const ll_record *record, int capacity)
{
    ll_rows *rows = calloc(1, sizeof *rows);
    if (rows == NULL)
        return NULL;
    rows->record = record;
    rows->capacity = capacity;
    rows->values = malloc(((size_t)capacity * (size_t)record->count + 1) * sizeof *rows->values);
    if (rows->values == NULL) {
        free(rows);
        return NULL;
    }
    return rows;
}

/* A copy is one block: itself, values, planes. Frames copy many small ones. */
static int64_t *values_of_copy(const ll_rows *rows)
{
    return (int64_t *)(rows + 1);
}

static size_t value_bytes_of(const ll_rows *rows)
{
    return (size_t)rows->count * (size_t)rows->record->count * sizeof *rows->values;
}

size_t ll_rows_copy_bytes(const ll_rows *from)
{
    return sizeof *from + value_bytes_of(from) + from->plane_bytes;
}

void ll_rows_copy_to(ll_rows *rows, const ll_rows *from)
{
    size_t value_bytes = value_bytes_of(from);
    *rows = (ll_rows){.record = from->record,
                      .count = from->count,
                      .capacity = from->count,
                      .first = from->first,
                      .plane_bytes = from->plane_bytes};
    rows->values = values_of_copy(rows);
    rows->planes = (uint8_t *)rows->values + value_bytes;
    memcpy(rows->values, from->values, value_bytes);
    if (from->plane_bytes > 0)
        memcpy(rows->planes, from->planes, from->plane_bytes);
}

void ll_rows_clear(ll_rows *rows, const ll_record *record)
{
    rows->capacity = (int)((size_t)rows->capacity * (size_t)rows->record->count / (size_t)record->count);
    rows->record = record;
    rows->count = 0;
    rows->first = 0;
    rows->plane_bytes = 0;
}

void ll_rows_free(ll_rows *rows)
{
    if (rows == NULL)
        return;
    LL_ASSERT(rows->values != values_of_copy(rows));
    free(rows->values);
    free(rows->planes);
    free(rows);
}

size_t ll_rows_bytes(const ll_rows *rows)
{
    return sizeof *rows + (size_t)rows->capacity * (size_t)rows->record->count * sizeof *rows->values +
           rows->plane_bytes;
}

static bool reserve(ll_rows *rows, int count)
{
    if (rows->count + count <= rows->capacity)
        return true;
    LL_ASSERT(rows->values != values_of_copy(rows));
    size_t capacity = 2 * ((size_t)rows->count + (size_t)count);
    int64_t *values = realloc(rows->values, capacity * (size_t)rows->record->count * sizeof *values);
    if (values == NULL)
        return false;
    rows->values = values;
    rows->capacity = (int)capacity;
    return true;
}

bool ll_rows_add(ll_rows *rows, const void *structs, int count)
{
    const ll_record *record = rows->record;
    if (!reserve(rows, count))
        return false;
    int64_t *to = ll_rows_at(rows, rows->count);
    if (record->integers != NULL)
        record->integers(structs, count, to);
    for (int i = 0; i < count && record->integers == NULL; i++) {
        const char *from = (const char *)structs + (size_t)i * record->size;
        for (int k = 0; k < record->count; k++)
            *to++ = ll_field_integer(&record->fields[k], from);
    }
    rows->count += count;
    return true;
}

bool ll_rows_add_plane(ll_rows *rows, const void *row, const uint8_t *plane)
{
    LL_ASSERT(rows->record->form == LL_FORM_GRID);
    if (!ll_rows_add(rows, row, 1))
        return false;
    size_t size = ll_rows_plane(rows, rows->count - 1);
    uint8_t *planes = realloc(rows->planes, rows->plane_bytes + size + 1);
    if (planes == NULL) {
        rows->count--;
        return false;
    }
    memcpy(planes + rows->plane_bytes, plane, size);
    rows->planes = planes;
    rows->plane_bytes += size;
    return true;
}

/* A record has at least LL_KEYS_MAX fields, and keys come first: the other compared fields only order rows
 * with equal keys. */
static int by_keys(const void *a, const void *b)
{
    const int64_t *left = a, *right = b;
    for (int k = 0; k < LL_KEYS_MAX; k++)
        if (left[k] != right[k])
            return left[k] < right[k] ? -1 : 1;
    return 0;
}

void ll_rows_sort(ll_rows *rows)
{
    if (rows->record->form != LL_FORM_KEYED)
        return;
    int i = 1;
    while (i < rows->count && by_keys(ll_rows_at(rows, i - 1), ll_rows_at(rows, i)) <= 0)
        i++;
    if (i < rows->count)
        qsort(rows->values, (size_t)rows->count, (size_t)rows->record->count * sizeof *rows->values, by_keys);
}

bool ll_rows_equal(const ll_rows *a, const ll_rows *b)
{
    size_t size = (size_t)a->count * (size_t)a->record->count * sizeof *a->values;
    return a->record == b->record && a->count == b->count && a->first == b->first &&
           a->plane_bytes == b->plane_bytes && memcmp(a->values, b->values, size) == 0 &&
           (a->plane_bytes == 0 || memcmp(a->planes, b->planes, a->plane_bytes) == 0);
}
