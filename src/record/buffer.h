/* A growing array of bytes. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/assert.h"

/* Initially all zero; the owner frees `bytes` at the end. */
typedef struct ll_buffer {
    char *bytes;
    size_t size, capacity;
    bool failed; /* out of memory while adding: the content is incomplete */
} ll_buffer;

/* Space for `size` more bytes at the end, which do not belong to the content yet; NULL without memory. */
char *ll_buffer_reserve(ll_buffer *buffer, size_t size);
/* Adds `size` bytes, which the caller fills; NULL without memory. */
char *ll_buffer_grow(ll_buffer *buffer, size_t size);
void ll_buffer_add(ll_buffer *buffer, const void *bytes, size_t size);
void ll_buffer_text(ll_buffer *buffer, const char *text);

/* LEB128: seven bits per byte, lowest first. Below 2^53, so at most 8 bytes. */
void ll_buffer_varint(ll_buffer *buffer, uint64_t value);
/* The same before the bytes from `at` on: a count or a size that is known only after them. */
void ll_buffer_insert_varint(ll_buffer *buffer, size_t at, uint64_t value);
/* The same instead of the varint 0 at `at`, which stands for it: nothing moves while one byte suffices. */
void ll_buffer_set_varint(ll_buffer *buffer, size_t at, uint64_t value);

enum { LL_VARINT_BYTES_MAX = 8 };

/* Writes a varint at `to`, which has space for it. Returns the end. */
static inline char *ll_varint_write(char *to, uint64_t value)
{
    LL_ASSERT(value < UINT64_C(1) << 53);
    for (; value >= 128; value >>= 7)
        *to++ = (char)((value & 127) | 128);
    *to++ = (char)value;
    return to;
}

/* Maps 0, -1, 1, -2 to 0, 1, 2, 3. */
static inline uint64_t ll_zigzag(int64_t value)
{
    return ((uint64_t)value << 1) ^ (uint64_t)(value >> 63);
}
