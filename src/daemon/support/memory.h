/* Memory of the process: what the daemon holds, and what the C library keeps for later use. */
#pragma once

#include <stdint.h>

typedef struct ll_memory_stats {
    int64_t used; /* bytes of allocated blocks */
    int64_t kept; /* bytes that the C library holds for blocks, free ones included */
} ll_memory_stats;

/* Before the first thread: makes the C library return memory that is free. */
void ll_memory_prepare(void);

/* Any thread; locks each arena for a moment. */
ll_memory_stats ll_memory_get_stats(void);
