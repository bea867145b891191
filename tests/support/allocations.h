/* Counts allocations of the whole program by replacing the C library's functions. */
#pragma once

/* Calls of malloc, calloc and realloc so far; always -1 under a sanitizer, which replaces them too. */
long allocations(void);
