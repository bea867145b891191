/* Mean and extremes of a value, where percentiles are not worth a histogram. */
#pragma once

#include <stdint.h>

typedef struct ll_gauge {
    double sum, min, max;
    int64_t count;
} ll_gauge;

static inline void ll_gauge_add(ll_gauge *g, double value)
{
    g->min = g->count == 0 || value < g->min ? value : g->min;
    g->max = g->count == 0 || value > g->max ? value : g->max;
    g->sum += value;
    g->count++;
}
