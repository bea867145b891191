/* The rows of several records at one instant; only of records that are wanted. */
#pragma once

#include "record/rows.h"

#define LL_RECORDS_MAX 18

/* Initially all zero. */
typedef struct ll_row_set {
    const ll_record *record[LL_RECORDS_MAX];
    ll_rows *rows[LL_RECORDS_MAX]; /* NULL: not wanted */
    ll_rows *kept[LL_RECORDS_MAX]; /* memory of the rows; the next instant uses it again */
    int count;
    bool failed;     /* no memory */
    ll_buffer bytes; /* for the caller: what is made of the rows; freed with them */
} ll_row_set;

/* Removes all records, for another instant. */
void ll_row_set_clear(ll_row_set *set);
void ll_row_set_free(ll_row_set *set);

/* Adds a record, without rows. Returns its index. */
int ll_row_set_add(ll_row_set *set, const ll_record *record, bool wanted);

bool ll_row_set_wants(const ll_row_set *set, const ll_record *record);

/* Adds rows of a record; no effect if it is not wanted. */
void ll_row_set_put(ll_row_set *set, const ll_record *record, const void *structs, int count);
void ll_row_set_put_plane(ll_row_set *set, const ll_record *record, const void *row, const uint8_t *plane);
