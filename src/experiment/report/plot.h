/* A scatter plot as SVG, with a table of its data. Of many points, those that would overlap share a mark,
 * which is larger the more there are, and the table has only some; a note says so. */
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"
#include "experiment/format/points.h"
#include "experiment/report/html.h"

enum {
    LL_PLOT_COLOURS = 8,      /* with four shapes, 32 series can be distinguished */
    LL_PLOT_MARKS_MAX = 1500, /* above that, points share marks */
    LL_PLOT_ROWS_MAX = 100,   /* rows of the table */
};

typedef struct ll_plot_point {
    double x, y;
    double low, high; /* bounds of y's interval; NaN or infinite: none */
    int64_t point;    /* number of the point, for `write_name` */
    int series;
    int line;    /* of a series' points only those of the same line are joined */
    bool front;  /* on the front: drawn in another colour, and joined by a line */
    bool chosen; /* drawn with a ring */
} ll_plot_point;

typedef struct ll_plot {
    const char *title, *x_name, *y_name;
    const ll_plot_point *points; /* sorted by x */
    int count;
    const char *const *choices; /* names of x = 0, 1, ...; NULL: x is numeric */
    int choice_count;
    const char *const *series; /* names; NULL: a single series without a name */
    int series_count;
    const char *series_name;
    bool log_x, log_y; /* if all values are above 0; otherwise linear */
    bool apart;        /* the front is not joined by a line: it includes points that are not drawn */
    bool joined; /* points of a series are joined by a line, in order of their numbers, if each has a mark */
    int width, height;
    int marks_max, rows_max; /* at most the constants; 0: these */
    void (*write_name)(const void *context, int64_t point,
                       FILE *file); /* writes the name of a point, as HTML */
    /* Writes the address that a point leads to; NULL: none. */
    void (*write_address)(const void *context, int64_t point, FILE *file);
    const void *context;
    const double *levels; /* of y: drawn as lines */
    int level_count;
    const char *where; /* HTML: where to find all points */
} ll_plot;

ll_status ll_plot_write(const ll_plot *plot, FILE *file);

/* Only the drawing, without key and table, as an element at (x, y) of another one; its style is
 * ll_html_plot_style. A drawing without points is left out. */
ll_status ll_plot_draw_at(const ll_plot *plot, double x, double y, FILE *file);

/* The mark of a series, for keys. */
void ll_plot_draw_mark(int series, double x, double y, FILE *file);

/* Writes what part is shown: `100 of 2,000 points: ...`; nothing when all are. */
void ll_plot_shown(const ll_choice *choice, int count, const char *where, FILE *file);
