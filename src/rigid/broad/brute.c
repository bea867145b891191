/* Brute force: every box against every other. The reference for the other broad phases. */
#include "rigid/broad/broad.h"

typedef struct brute {
    int32_t end; /* one more than the largest proxy ever inserted */
    int32_t pad[15];
    uint8_t live[];
} brute;

static size_t size(int32_t capacity)
{
    return (sizeof(brute) + (size_t)capacity + 63) & ~(size_t)63;
}

static void init(void *state, int32_t capacity)
{
    (void)capacity;
    ((brute *)state)->end = 0;
}

static void insert(void *state, const ll_aabb *boxes, int32_t proxy)
{
    (void)boxes;
    brute *b = state;
    for (; b->end <= proxy; b->end++)
        b->live[b->end] = 0;
    b->live[proxy] = 1;
}

static void remove_proxy(void *state, int32_t proxy)
{
    ((brute *)state)->live[proxy] = 0;
}

static void move(void *state, const ll_aabb *boxes, int32_t proxy)
{
    (void)state, (void)boxes, (void)proxy;
}

static void query(const void *state, const ll_aabb *boxes, ll_aabb box, ll_broad_visit *visit, void *context)
{
    const brute *b = state;
    for (int32_t i = 0; i < b->end; i++)
        if (b->live[i] && ll_aabb_overlap(boxes[i], box))
            visit(context, i);
}

const ll_broad_phase ll_broad_brute = {.name = "brute",
                                       .help = "Every box that moved against every other: n^2.",
                                       .size = size,
                                       .init = init,
                                       .insert = insert,
                                       .remove = remove_proxy,
                                       .move = move,
                                       .query = query};
