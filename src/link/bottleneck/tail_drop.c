#include "link/bottleneck/bottleneck.h"

static bool drops(ll_bottleneck *queue, ll_time now, ll_time served)
{
    (void)queue;
    (void)now;
    (void)served;
    return false; /* the queue's limit drops */
}

const ll_discipline_rule ll_discipline_tail_drop = {.name = "tail_drop", .drops = drops};
