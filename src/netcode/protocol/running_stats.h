/* Mean and extremes of a value that needs no percentiles. */
#pragma once

#include <stdint.h>

typedef struct ll_running_stats {
    double sum, min, max;
    int64_t count;
} ll_running_stats;

static inline void ll_running_stats_add(ll_running_stats *g, double value)
{
    if (g->count == 0)
        g->min = g->max = value;
    if (value < g->min)
        g->min = value;
    if (value > g->max)
        g->max = value;
    g->sum += value;
    g->count++;
}
