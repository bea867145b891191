/* Compression of answers: gzip (RFC 1952), quick rather than small. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/status.h"

struct ll_task;

/* Media types that get much smaller by it: text, JSON, YAML. */
bool ll_gzip_compresses(const char *type);

/* Both ask `task` (NULL: nobody) now and then whether to go on; else LL_INTERRUPTED. */
/* `out` is malloc'ed. */
ll_status ll_gzip_bytes(const void *bytes, size_t size, struct ll_task *task, char **out, size_t *out_size);
/* From the beginning of `in` to `out`, where it stands. */
ll_status ll_gzip_file(FILE *in, FILE *out, struct ll_task *task);
