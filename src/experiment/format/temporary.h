/* Files without a name, which are gone when they are closed. */
#pragma once

#include <stdio.h>

/* In the folder; in memory where that cannot be written. NULL: no memory. */
FILE *ll_temporary_open(const char *folder);
