/* Hints which memory is read soon. They change nothing, and an address may be stale. */
#pragma once

#include <stddef.h>

#define LL_LINE 64 /* bytes of a cache line */

/* Into the second level of cache: the first has no room for what comes next. */
static inline void ll_prefetch(const void *from, size_t bytes)
{
    for (const char *line = from, *end = line + bytes; line < end; line += LL_LINE)
        __builtin_prefetch(line, 0, 2);
}
