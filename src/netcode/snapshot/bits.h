/* Reads and writes bits in bytes, the lowest bit of a byte first.
 *
 * A number takes groups of four bits: three of the number, the lowest first, and one that indicates another
 * group. A signed number n is coded as 2n or -2n - 1 (zig-zag), so that a small one is short. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/assert.h"

typedef struct ll_bit_writer {
    uint8_t *bytes;
    int64_t capacity; /* bits */
    int64_t count;    /* bits; bits beyond the capacity are counted and not written */
} ll_bit_writer;

typedef struct ll_bit_reader {
    const uint8_t *bytes;
    int64_t size;  /* bits */
    int64_t at;    /* beyond `size` after a read past the end, which gives zeros */
    bool overlong; /* a number did not fit 64 bits */
} ll_bit_reader;

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "words must be little-endian");

void ll_bits_put_bytes(ll_bit_writer *w, uint64_t value, int bits); /* near the end, byte by byte */
uint64_t ll_bits_get_bytes(ll_bit_reader *r, int bits);

/* Appends the lowest `bits` of value, 0 to 64. The writer's bytes after them are not in use yet. */
static inline void ll_bits_put(ll_bit_writer *w, uint64_t value, int bits)
{
    int used = (int)(w->count & 7);
    if (used + bits > 63 || w->count - used + 64 > w->capacity) {
        ll_bits_put_bytes(w, value, bits);
        return;
    }
    LL_VALIDATE(bits >= 0 && w->count >= 0);
    uint8_t *at = w->bytes + (w->count >> 3);
    uint64_t word = (*at & ((UINT64_C(1) << used) - 1)) | (value & ((UINT64_C(1) << bits) - 1)) << used;
    memcpy(at, &word, sizeof word);
    w->count += bits;
}

static inline uint64_t ll_bits_get(ll_bit_reader *r, int bits)
{
    int used = (int)(r->at & 7);
    if (used + bits > 63 || r->at - used + 64 > r->size)
        return ll_bits_get_bytes(r, bits);
    uint64_t word;
    LL_VALIDATE(bits >= 0 && r->at >= 0);
    memcpy(&word, r->bytes + (r->at >> 3), sizeof word);
    r->at += bits;
    return word >> used & ((UINT64_C(1) << bits) - 1);
}

/* Appends `count` bits, and may read 7 bytes beyond them. */
void ll_bits_append(ll_bit_writer *w, const uint8_t *bytes, int64_t count);

void ll_bits_put_number(ll_bit_writer *w, uint64_t n);
uint64_t ll_bits_get_number(ll_bit_reader *r);

static inline void ll_bits_put_signed(ll_bit_writer *w, int64_t n)
{
    ll_bits_put_number(w, n < 0 ? ~((uint64_t)n << 1) : (uint64_t)n << 1);
}

static inline int64_t ll_bits_get_signed(ll_bit_reader *r)
{
    uint64_t n = ll_bits_get_number(r);
    return (int64_t)(n >> 1 ^ (~(n & 1) + 1));
}

/* Whether the reader has read everything without passing the end: at most 7 bits are left, all zero. */
bool ll_bits_ended_well(ll_bit_reader *r);
