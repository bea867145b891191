/* SHA-256 of OpenSSL's libcrypto: for stored hashes of keys and for idempotency keys. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#define LL_DIGEST_SIZE 32

/* Digest of `a` followed by `b`. False when libcrypto fails (no memory): the digest must not be used then.
 * Any thread. */
bool ll_digest(const void *a, size_t a_size, const void *b, size_t b_size,
               unsigned char digest[LL_DIGEST_SIZE]);
/* In constant time. */
bool ll_digest_equal(const unsigned char a[LL_DIGEST_SIZE], const unsigned char b[LL_DIGEST_SIZE]);
