/* Memory of the states of sessions: blocks of some hundred KiB, of which a tick touches a few lines in many
 * pages.
 *
 * With thousands of sessions each of these pages costs a walk through the page tables in every frame. Blocks
 * therefore lie side by side in huge pages where the system has them, and one of many MiB has huge pages of
 * its own. What is free goes back to the system in whole huge pages. Any thread. */
#pragma once

#include <stddef.h>

void *ll_state_memory_new(size_t size);       /* not initialised, as of malloc; NULL without memory */
void *ll_state_memory_new_pages(size_t size); /* the same in pages of its own, also if it is small */
void ll_state_memory_free(void *block);       /* NULL: no effect */
