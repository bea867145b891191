/* Columns of numbers as text: doubles rounded to their leading bytes, stored byte plane by byte plane,
 * deflated and written in base64. The reader is www/report/data.js. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"

enum {
    LL_PACK_EXACT = 8, /* leading bytes that are kept: all */
    LL_PACK_8_DIGITS = 5,
    LL_PACK_6_DIGITS = 4,
    LL_PACK_4_DIGITS = 3,
};

typedef struct ll_pack {
    uint8_t *bytes; /* before deflation */
    size_t size, room;
    uint8_t *deflated;
    size_t deflated_size;
    bool short_of_memory;
} ll_pack;

/* Value k is `at(context, k)`; NaN: none. */
typedef double ll_pack_value(const void *context, int64_t k);

void ll_pack_add(ll_pack *pack, int planes, int64_t count, ll_pack_value *at, const void *context);
ll_status ll_pack_deflate(ll_pack *pack); /* after the last column */
void ll_pack_write(const ll_pack *pack, FILE *file);
size_t ll_pack_text_size(const ll_pack *pack); /* bytes that ll_pack_write writes */
void ll_pack_free(ll_pack *pack);
