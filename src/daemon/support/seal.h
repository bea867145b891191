/* Texts that only who has the key can read: AES-256-GCM of OpenSSL's libcrypto. */
#pragma once

#include <stddef.h>

#include "daemon/support/digest.h"

/* The text under this key as hexadecimal digits; NULL: no memory, or no random numbers. The caller frees it.
 */
char *ll_seal(const unsigned char key[LL_DIGEST_SIZE], const char *text);
/* And back; NULL: another key, or not a sealed text. */
char *ll_unseal(const unsigned char key[LL_DIGEST_SIZE], const char *sealed);
