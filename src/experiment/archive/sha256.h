/* SHA-256 of parts of files, by OpenSSL's libcrypto. */
#pragma once

#include <stdint.h>
#include <stdio.h>

#include "base/status.h"

enum { LL_SHA256_HEX = 64 };

/* Of `size` bytes from `offset` on, as small hexadecimal digits. LL_IO: the file has fewer bytes. */
ll_status ll_sha256_file(FILE *file, int64_t offset, int64_t size, char hex[LL_SHA256_HEX + 1]);
