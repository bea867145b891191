#include "record/row_set.h"

#include "base/assert.h"

int ll_row_set_add(ll_row_set *set, const ll_record *record, bool wanted, int capacity)
{
    int place = set->count++;
    LL_ASSERT(place < LL_RECORDS_MAX);
    set->record[place] = record;
    set->rows[place] = wanted ? ll_rows_new(record, capacity) : NULL;
    set->failed = set->failed || (wanted && set->rows[place] == NULL);
    return place;
}

void ll_row_set_free(ll_row_set *set)
{
    for (int i = 0; i < set->count; i++)
        ll_rows_free(set->rows[i]);
    *set = (ll_row_set){0};
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
