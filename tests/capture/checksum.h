/* A receiver's check of headers, shared by the tests of this room. */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* Sum of all 16-bit words with the carries added: 0xFFFF for anything with a right checksum in it (RFC 1071).
 */
static inline uint32_t folded(const uint8_t *bytes, size_t size)
{
    uint32_t sum = 0;
    for (size_t i = 0; i < size; i++)
        sum += i & 1 ? bytes[i] : (uint32_t)bytes[i] << 8;
    while (sum > 0xFFFF)
        sum = (sum >> 16) + (sum & 0xFFFF);
    return sum;
}
