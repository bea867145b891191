#include "record/buffer.h"

#include <stdlib.h>
#include <string.h>

char *ll_buffer_reserve(ll_buffer *b, size_t size)
{
    size_t needed = b->size + size;
    if (needed > b->capacity) {
        size_t capacity = needed + needed / 2 + 64;
        char *bytes = realloc(b->bytes, capacity);
        if (bytes == NULL) {
            b->failed = true;
            return NULL;
        }
        b->bytes = bytes;
        b->capacity = capacity;
    }
    return b->bytes + b->size;
}

char *ll_buffer_grow(ll_buffer *b, size_t size)
{
    char *at = ll_buffer_reserve(b, size);
    if (at != NULL)
        b->size += size;
    return at;
}

void ll_buffer_add(ll_buffer *b, const void *bytes, size_t size)
{
    char *at = size > 0 ? ll_buffer_grow(b, size) : NULL;
    if (at != NULL)
        memcpy(at, bytes, size);
}

void ll_buffer_text(ll_buffer *b, const char *text)
{
    ll_buffer_add(b, text, strlen(text));
}

void ll_buffer_varint(ll_buffer *b, uint64_t value)
{
    char *at = ll_buffer_reserve(b, LL_VARINT_BYTES_MAX);
    if (at != NULL)
        b->size += (size_t)(ll_varint_write(at, value) - at);
}

void ll_buffer_insert_varint(ll_buffer *b, size_t at, uint64_t value)
{
    char bytes[LL_VARINT_BYTES_MAX];
    size_t size = (size_t)(ll_varint_write(bytes, value) - bytes), behind = b->size - at;
    LL_ASSERT(at <= b->size);
    if (ll_buffer_grow(b, size) == NULL)
        return;
    memmove(b->bytes + at + size, b->bytes + at, behind);
    memcpy(b->bytes + at, bytes, size);
}

void ll_buffer_set_varint(ll_buffer *b, size_t at, uint64_t value)
{
    if (b->failed)
        return;
    LL_ASSERT(at < b->size && b->bytes[at] == 0);
    b->bytes[at] = (char)((value & 127) | (value >= 128 ? 128 : 0));
    if (value >= 128)
        ll_buffer_insert_varint(b, at + 1, value >> 7);
}
