#include "daemon/support/memory.h"

#include <malloc.h>
#include <unistd.h>

/* A state of a simulation and a large answer are mappings of their own, which end when they are freed. By
 * default the limit rises up to 32 MiB with what is freed, and such blocks then lie between small ones that
 * stay. */
enum { MAPPED_BYTES = 128 << 10, TOP_BYTES = 1 << 20 };

/* An arena keeps what its busiest moment needed. By default there are up to eight for each core. */
void ll_memory_prepare(void)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    mallopt(M_ARENA_MAX, cores > 2 ? (int)cores : 2);
    mallopt(M_MMAP_THRESHOLD, MAPPED_BYTES);
    mallopt(M_TRIM_THRESHOLD, TOP_BYTES);
}

ll_memory_stats ll_memory_get_stats(void)
{
    struct mallinfo2 all = mallinfo2();
    return (ll_memory_stats){.used = (int64_t)(all.uordblks + all.hblkhd),
                             .kept = (int64_t)(all.arena + all.hblkhd)};
}
