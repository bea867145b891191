/* A growing row of bytes. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Starts with zeroes; `bytes` is the owner's to free at the end. */
typedef struct ll_buffer {
    char *bytes;
    size_t size, capacity;
    bool failed; /* no memory for something that was to be added: the rest is worth nothing */
} ll_buffer;

/* Room for `size` more bytes, to be filled by the caller; NULL without memory. */
char *ll_buffer_grow(ll_buffer *buffer, size_t size);
void ll_buffer_add(ll_buffer *buffer, const void *bytes, size_t size);
void ll_buffer_text(ll_buffer *buffer, const char *text);

/* LEB128: seven bits a byte, lowest first. Below 2^53, so at most 8 bytes. */
void ll_buffer_varint(ll_buffer *buffer, uint64_t value);

/* 0, -1, 1, -2 as 0, 1, 2, 3. */
static inline uint64_t ll_zigzag(int64_t value)
{
    return ((uint64_t)value << 1) ^ (uint64_t)(value >> 63);
}

static inline int64_t ll_unzigzag(uint64_t value)
{
    return (int64_t)(value >> 1) ^ -(int64_t)(value & 1);
}
