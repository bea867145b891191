/* Compression of answers: gzip (RFC 1952). */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/status.h"

struct ll_task;

/* Whether a media type compresses well: text, JSON, YAML. */
bool ll_gzip_compresses(const char *type);

enum { LL_GZIP_FAST = 1, LL_GZIP_SMALLEST = 9 }; /* for one answer; for one that is kept */

/* Both yield `task` (NULL: none) from time to time; LL_INTERRUPTED when it was stopped. */
/* `out` is malloc'ed. */
ll_status ll_gzip_bytes(const void *bytes, size_t size, int level, struct ll_task *task, char **out,
                        size_t *out_size);
/* Compresses `in` from its beginning, fast; writes to `out` at its position. */
ll_status ll_gzip_file(FILE *in, FILE *out, struct ll_task *task);
