#include "netcode/snapshot/priority.h"

#include "base/assert.h"

static bool precedes(const ll_candidate *a, const ll_candidate *b)
{
    return a->accumulated != b->accumulated ? a->accumulated > b->accumulated : a->turn < b->turn;
}

static void sink(ll_candidate *heap, int count, int i)
{
    const ll_candidate moved = heap[i];
    for (int child = 2 * i + 1; child < count; child = 2 * i + 1) {
        if (child + 1 < count && precedes(&heap[child + 1], &heap[child]))
            child++;
        if (!precedes(&heap[child], &moved))
            break;
        heap[i] = heap[child];
        i = child;
    }
    heap[i] = moved;
}

void ll_candidates_order(ll_candidate *heap, int count)
{
    for (int i = count / 2 - 1; i >= 0; i--)
        sink(heap, count, i);
}

ll_candidate ll_candidates_take(ll_candidate *heap, int *count)
{
    LL_ASSERT(*count > 0);
    const ll_candidate first = heap[0];
    heap[0] = heap[--*count];
    if (*count > 0)
        sink(heap, *count, 0);
    return first;
}
