/* The counterpart of ll_rows_encode, as a viewer in any other language has one. */
#pragma once

#include "record/rows.h"

/* LL_BAD_INPUT: the message says what is wrong with the bytes; LL_NO_MEMORY. */
ll_status ll_rows_decode(const ll_record *record, const ll_rows *base, const void *bytes, size_t size,
                         ll_rows **rows);

/* The counterpart of ll_zigzag. */
static inline int64_t unzigzag(uint64_t value)
{
    return (int64_t)(value >> 1) ^ -(int64_t)(value & 1);
}
