/* Memory for the block of a session. */
#pragma once

#include <stddef.h>

/* Not initialised; NULL without memory. For free(). */
void *ll_session_block_new(size_t size);
