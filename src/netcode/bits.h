/* Bits one behind the other in bytes, the lowest bit of a byte first.
 *
 * A number takes groups of four bits: three of the number, the lowest first, and one that says whether a
 * further group follows. A signed number goes as 2n or -2n - 1 (zig-zag), so that a small one is short. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct ll_bit_writer {
    uint8_t *bytes;
    int64_t capacity; /* bits */
    int64_t count;    /* bits; beyond the capacity they are counted and not written */
} ll_bit_writer;

typedef struct ll_bit_reader {
    const uint8_t *bytes;
    int64_t size;  /* bits */
    int64_t at;    /* beyond `size` after a read past the end, which gives zeros */
    bool overlong; /* a number did not fit 64 bits */
} ll_bit_reader;

void ll_bits_put(ll_bit_writer *w, uint64_t value, int bits); /* 0 to 64 */
void ll_bits_put_number(ll_bit_writer *w, uint64_t n);
void ll_bits_put_signed(ll_bit_writer *w, int64_t n);

uint64_t ll_bits_get(ll_bit_reader *r, int bits);
uint64_t ll_bits_get_number(ll_bit_reader *r);
int64_t ll_bits_get_signed(ll_bit_reader *r);

/* Whether all was read and was there: what is left is less than a byte, and zero. */
bool ll_bits_ended_well(ll_bit_reader *r);
