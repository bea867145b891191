/* SHA-256 by OpenSSL's libcrypto: for the stored hashes of keys and the names of repeated requests. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#define LL_DIGEST_SIZE 32

/* Of `a` followed by `b`. False when libcrypto fails (no memory): the digest is then not to be used. Any
 * thread. */
bool ll_digest(const void *a, size_t a_size, const void *b, size_t b_size,
               unsigned char digest[LL_DIGEST_SIZE]);
