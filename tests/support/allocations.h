/* Allocations of the whole program, counted by standing in for the C library's functions. */
#pragma once

/* Calls of malloc, calloc and realloc so far; always -1 under a sanitizer, which stands in for them itself.
 */
long allocations(void);
