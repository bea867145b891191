#include "record/buffer.h"

#include <stdlib.h>
#include <string.h>

#include "base/assert.h"

char *ll_buffer_grow(ll_buffer *b, size_t size)
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
    char *at = b->bytes + b->size;
    b->size = needed;
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
    char bytes[8];
    size_t n = 0;
    LL_ASSERT(value < UINT64_C(1) << 53);
    for (; value >= 128; value >>= 7)
        bytes[n++] = (char)((value & 127) | 128);
    bytes[n++] = (char)value;
    ll_buffer_add(b, bytes, n);
}
