/* Work against precision as one page: rungs are noted as they are measured, and drawn at the end, error
 * against processor time and against what was counted, with the front of both. */
#pragma once

#include "base/status.h"

typedef struct ll_refinement_series_page ll_refinement_series_page;

/* A rung as it is drawn. Texts that are pointers outlive the page. */
typedef struct ll_drawn_level {
    const void *refinement_series; /* which: those of one are drawn together */
    const char *title;             /* of it */
    char series[40];
    const char *setting; /* its name */
    double value;
    const char *counter, *error; /* their names */
    double cpu_s, count;
    double y, low, high; /* of the error; NaN: none, it is not drawn */
} ll_drawn_level;

ll_refinement_series_page *ll_refinement_series_page_make(void); /* NULL without memory */
void ll_refinement_series_page_free(ll_refinement_series_page *page);

void ll_refinement_series_page_add(ll_refinement_series_page *page,
                                   const ll_drawn_level *refinement_level); /* `page` may be NULL */

/* `title`: what was measured; `command`: what makes the rows again. */
ll_status ll_refinement_series_page_write(ll_refinement_series_page *page, const char *title,
                                          const char *command, const char *path);
