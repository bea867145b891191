/* What page and image share: the points of a problem and a cost. */
#pragma once

#include "experiment/report/plot.h"
#include "experiment/report/tradeoff_page.h"

enum { LL_TRADEOFF_METHODS_MAX = 64 };

typedef struct ll_tradeoff_drawing {
    const ll_tradeoff *tradeoff;
    const char *address;
    ll_plot_point *points; /* sorted by cost; `point` is the index of the row */
    int count, rows;       /* those of the problem */
    const char *methods[LL_TRADEOFF_METHODS_MAX];
    int method_count;
    double levels[LL_FRONT_LEVELS];
    int level_count;
    ll_plot plot; /* without title, size and `where` */
} ll_tradeoff_drawing;

/* Fills it; `points` has room for all rows. */
void ll_tradeoff_draw(ll_tradeoff_drawing *drawing, int problem, int cost);
