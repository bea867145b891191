#include "netcode/snapshot/bits.h"

#include "base/assert.h"

#define GROUP 3   /* bits of a number in a group */
#define GROUPS 22 /* of 64 bits */

static uint64_t low(uint64_t value, int bits)
{
    return bits < 64 ? value & ((UINT64_C(1) << bits) - 1) : value;
}

void ll_bits_put_bytes(ll_bit_writer *w, uint64_t value, int bits)
{
    int64_t end = w->count + bits;
    LL_ASSERT(bits >= 0 && bits <= 64);
    if (end > w->capacity) {
        w->count = end;
        return;
    }
    value = low(value, bits);
    while (w->count < end) {
        int used = (int)(w->count & 7), room = 8 - used;
        int n = end - w->count < room ? (int)(end - w->count) : room;
        uint8_t *byte = &w->bytes[w->count >> 3];
        *byte = (uint8_t)((used == 0 ? 0 : *byte) | low(value, n) << used);
        value >>= n;
        w->count += n;
    }
}

void ll_bits_append(ll_bit_writer *w, const uint8_t *bytes, int64_t count)
{
    enum { most = 56 }; /* whole bytes, which fit a word behind seven bits */
    uint64_t word;
    for (; count > 0; count -= most, bytes += most / 8) {
        memcpy(&word, bytes, sizeof word);
        ll_bits_put(w, word, count < most ? (int)count : most);
    }
}

uint64_t ll_bits_get_bytes(ll_bit_reader *r, int bits)
{
    uint64_t value = 0;
    LL_ASSERT(bits >= 0 && bits <= 64 && r->at >= 0);
    if (bits > r->size - r->at) {
        r->at = r->size + 1;
        return 0;
    }
    for (int got = 0; got < bits;) {
        int used = (int)(r->at & 7), room = 8 - used;
        int n = bits - got < room ? bits - got : room;
        value |= low((uint64_t)r->bytes[r->at >> 3] >> used, n) << got;
        got += n;
        r->at += n;
    }
    return value;
}

/* ---- numbers ---- */

void ll_bits_put_number(ll_bit_writer *w, uint64_t n)
{
    uint64_t groups = 0;
    int bits = 0;
    while (n >> GROUP != 0) {
        groups |= (low(n, GROUP) | UINT64_C(1) << GROUP) << bits;
        bits += GROUP + 1;
        n >>= GROUP;
        if (bits == 48) {
            ll_bits_put(w, groups, bits);
            groups = 0;
            bits = 0;
        }
    }
    ll_bits_put(w, groups | n << bits, bits + GROUP + 1);
}

static uint64_t get_groups(ll_bit_reader *r)
{
    uint64_t n = 0;
    for (int i = 0; i < GROUPS; i++) {
        uint64_t group = ll_bits_get(r, GROUP + 1), part = low(group, GROUP);
        if (i == GROUPS - 1 && part > 1)
            break; /* 64 = 21 * 3 + 1 */
        n |= part << (i * GROUP);
        if (group >> GROUP == 0)
            return n;
    }
    r->overlong = true;
    return 0;
}

#define MORE                                                                                                 \
    UINT64_C(0x0088888888888888) /* continuation bits of the 14 groups that any word contains completely */

/* Most numbers end within a word: at the first group whose continuation bit is 0. */
uint64_t ll_bits_get_number(ll_bit_reader *r)
{
    uint64_t word, n = 0;
    int used = (int)(r->at & 7);
    if (r->at - used + 64 > r->size)
        return get_groups(r);
    memcpy(&word, &r->bytes[r->at >> 3], sizeof word);
    word >>= used;
    uint64_t ends = ~word & MORE;
    if (ends == 0)
        return get_groups(r);
    int last = __builtin_ctzll(ends);
    for (int from = 0, to = 0; from < last; from += GROUP + 1, to += GROUP)
        n |= low(word >> from, GROUP) << to;
    r->at += last + 1;
    return n;
}

bool ll_bits_ended_well(ll_bit_reader *r)
{
    int64_t left = r->size - r->at;
    return left >= 0 && left < 8 && !r->overlong && ll_bits_get(r, (int)left) == 0;
}
