/* A scatter plot as SVG, with its table of data. */
#pragma once

#include <stdbool.h>
#include <stdio.h>

typedef struct ll_plot_point {
    double x, y;
    double low, high;  /* of y's interval; NaN or infinite: there is none */
    bool front;        /* on the front: drawn in the other colour, and joined */
    const char *label; /* of a choice on the x axis; NULL: x is a number */
    const char *name;  /* told when a pointer rests on it */
} ll_plot_point;

typedef struct ll_plot {
    const char *title, *x_name, *y_name;
    const ll_plot_point *points; /* of a front: in the order of x */
    int count;
    bool log_x, log_y; /* where all values are above 0; otherwise the axis is linear */
    bool apart;        /* the front is not joined: it is of more than what is drawn */
    int width, height;
} ll_plot;

void ll_plot_write(const ll_plot *plot, FILE *file);

void ll_html_text(const char *text, FILE *file); /* with & < > " written so that a page shows them */
