#include "record/row_set.h"

#include <stdlib.h>

#include "base/assert.h"

enum { FIRST_ROWS = 8 };

void ll_row_set_clear(ll_row_set *set)
{
    set->count = 0;
    set->failed = false;
}

void ll_row_set_free(ll_row_set *set)
{
    for (int i = 0; i < LL_RECORDS_MAX; i++)
        ll_rows_free(set->kept[i]);
    free(set->bytes.bytes);
    *set = (ll_row_set){0};
}

static ll_rows *empty_rows(ll_rows **kept, const ll_record *record)
{
    if (*kept == NULL)
        *kept = ll_rows_new(record, FIRST_ROWS);
    else
        ll_rows_clear(*kept, record);
    return *kept;
}

int ll_row_set_add(ll_row_set *set, const ll_record *record, bool wanted)
{
    int place = set->count++;
    LL_ASSERT(place < LL_RECORDS_MAX);
    set->record[place] = record;
    set->rows[place] = wanted ? empty_rows(&set->kept[place], record) : NULL;
    set->failed = set->failed || (wanted && set->rows[place] == NULL);
    return place;
}

static ll_rows *rows_of(const ll_row_set *set, const ll_record *record)
{
    int i = 0;
    while (i < set->count && set->record[i] != record)
        i++;
    LL_ASSERT(i < set->count);
    return set->rows[i];
}

bool ll_row_set_wants(const ll_row_set *set, const ll_record *record)
{
    return rows_of(set, record) != NULL;
}

void ll_row_set_put(ll_row_set *set, const ll_record *record, const void *structs, int count)
{
    ll_rows *rows = rows_of(set, record);
    if (rows != NULL && !ll_rows_add(rows, structs, count))
        set->failed = true;
}

void ll_row_set_put_plane(ll_row_set *set, const ll_record *record, const void *row, const uint8_t *plane)
{
    ll_rows *rows = rows_of(set, record);
    if (rows != NULL && !ll_rows_add_plane(rows, row, plane))
        set->failed = true;
}
