/* Packets travel in whole cells, each with its own overhead, as netem's `rate` has it for ATM: the queue
 * sends ceil((size + overhead) / cell) * (cell + cell overhead) bytes. */
#include "link/stages/stage.h"

void ll_stage_cells(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    (void)m;
    (void)stats;
    int64_t cell = p->profile->cell_bytes, size = p->size + p->params->packet_overhead_bytes;
    int64_t cells = (size + cell - 1) / cell;
    p->size = (int32_t)(cells * (cell + p->profile->cell_overhead_bytes) - p->params->packet_overhead_bytes);
}
