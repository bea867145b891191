#define _DEFAULT_SOURCE /* madvise */
#include "session/block.h"

#include <stdlib.h>
#include <sys/mman.h>

#define HUGE_PAGE ((size_t)2 << 20)
#define LARGE (16 * HUGE_PAGE)

/* A tick of a large block touches parts of all of it: of more pages of 4 KiB than a processor knows the
 * places of at once. */
void *ll_session_block_new(size_t size)
{
    if (size < LARGE)
        return malloc(size);
    void *block = aligned_alloc(HUGE_PAGE, (size + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE);
#ifdef MADV_HUGEPAGE
    if (block)
        madvise(block, size, MADV_HUGEPAGE); /* a wish: nothing depends on it */
#endif
    return block;
}
