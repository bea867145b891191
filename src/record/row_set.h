/* The rows of several records at one instant: of those that are wanted. */
#pragma once

#include "record/rows.h"

#define LL_RECORDS_MAX 16

typedef struct ll_row_set {
    const ll_record *record[LL_RECORDS_MAX];
    ll_rows *rows[LL_RECORDS_MAX]; /* NULL: not wanted */
    int count;
    bool failed; /* no memory */
} ll_row_set;

/* Adds a record; wanted, with room for `capacity` rows, or not. Returns its place. */
int ll_row_set_add(ll_row_set *set, const ll_record *record, bool wanted, int capacity);
void ll_row_set_free(ll_row_set *set);

bool ll_row_set_wants(const ll_row_set *set, const ll_record *record);

/* Rows of a record; nothing where they are not wanted. */
void ll_row_set_put(ll_row_set *set, const ll_record *record, const void *structs, int count);
void ll_row_set_put_plane(ll_row_set *set, const ll_record *record, const void *row, const uint8_t *plane);
