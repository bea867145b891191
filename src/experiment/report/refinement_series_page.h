/* Work-precision diagrams as one page. Levels are added when they are measured and drawn at the end: error
 * against processor time and against counted cost, with the Pareto front of both. */
#pragma once

#include "base/status.h"

typedef struct ll_refinement_series_page ll_refinement_series_page;

/* A refinement level to be drawn. Texts that are pointers must outlive the page. */
typedef struct ll_drawn_level {
    const void *refinement_series; /* its series: levels of one series are drawn together */
    const char *title;             /* title of the series */
    char series[40];
    const char *setting; /* name of the setting */
    double value;
    const char *counter, *error; /* their names */
    double cpu_s, count;
    double y, low, high; /* of the error; NaN: none, not drawn */
} ll_drawn_level;

ll_refinement_series_page *ll_refinement_series_page_make(void); /* NULL without memory */
void ll_refinement_series_page_free(ll_refinement_series_page *page);

void ll_refinement_series_page_add(ll_refinement_series_page *page,
                                   const ll_drawn_level *refinement_level); /* `page` may be NULL */

/* `title`: what was measured; `command`: repeats the measurement. */
ll_status ll_refinement_series_page_write(ll_refinement_series_page *page, const char *title,
                                          const char *command, const char *path);
