/* Mean and extremes of a value that needs no percentiles. */
#pragma once

#include <stdint.h>

typedef struct ll_running_stats {
    double sum, min, max;
    int64_t count;
} ll_running_stats;

static inline void ll_running_stats_add(ll_running_stats *g, double value)
{
    g->min = g->count == 0 || value < g->min ? value : g->min;
    g->max = g->count == 0 || value > g->max ? value : g->max;
    g->sum += value;
    g->count++;
}
