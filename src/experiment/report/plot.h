/* A scatter plot as SVG, with its table of data. Of many points those that would cover each other are drawn
 * as one mark, larger the more there are, and the table has some of them; both say so. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"
#include "experiment/format/points.h"
#include "experiment/report/html.h"

enum {
    LL_PLOT_COLOURS = 8,      /* with four shapes 32 series are told apart */
    LL_PLOT_MARKS_MAX = 1500, /* more points than so many are drawn together */
    LL_PLOT_ROWS_MAX = 100,   /* of the table */
};

typedef struct ll_plot_point {
    double x, y;
    double low, high; /* of y's interval; NaN or infinite: there is none */
    int64_t point;    /* which it is, for `tell` */
    int series;
    bool front; /* on the front: drawn in the other colour, and joined */
} ll_plot_point;

typedef struct ll_plot {
    const char *title, *x_name, *y_name;
    const ll_plot_point *points; /* in the order of x */
    int count;
    const char *const *choices; /* names of x = 0, 1, ...; NULL: x is a number */
    int choice_count;
    const char *const *series; /* names; NULL: there is one series without a name */
    int series_count;
    const char *series_name;
    bool log_x, log_y; /* where all values are above 0; otherwise the axis is linear */
    bool apart;        /* the front is not joined: it is of more than what is drawn */
    bool joined;       /* the points of a series are, in the order of their numbers, where each has a mark */
    int width, height;
    void (*tell)(const void *context, int64_t point, FILE *file); /* names a point, as HTML */
    const void *context;
    const char *where; /* HTML: where all points are */
} ll_plot;

ll_status ll_plot_write(const ll_plot *plot, FILE *file);

/* What is shown of what: `100 of 2,000 points: ...`. Nothing where all are. */
void ll_plot_shown(const ll_choice *choice, int count, const char *where, FILE *file);
