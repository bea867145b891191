/* SHA-256 (FIPS 180-4), for the stored hashes of keys. Its vectors are checked by tests/daemon/test_keys.c.
 */
#pragma once

#include <stddef.h>
#include <stdint.h>

#define LL_SHA256_SIZE 32

typedef struct ll_sha256 {
    uint32_t state[8];
    uint64_t length; /* bytes so far */
    unsigned char block[64];
} ll_sha256;

void ll_sha256_init(ll_sha256 *hash);
void ll_sha256_add(ll_sha256 *hash, const void *bytes, size_t size);
void ll_sha256_end(ll_sha256 *hash, unsigned char digest[LL_SHA256_SIZE]);
