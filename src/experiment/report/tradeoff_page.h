/* Speed against error of families: one page with an image and a table per problem and cost, and one image
 * per family. */
#pragma once

#include "experiment/advise/tradeoff.h"

/* The address at which the page opens a setting as a live session: `page` with scenario, parameters and seed.
 */
void ll_tradeoff_address(const ll_tradeoff *tradeoff, const ll_tradeoff_row *row, const char *page,
                         char *text, int size);

typedef struct ll_tradeoff_page {
    const ll_tradeoff *families;
    int count;
    const char *command; /* repeats the measurement */
    const char *address; /* of the page, for live sessions */
} ll_tradeoff_page;

ll_status ll_tradeoff_page_write(const ll_tradeoff_page *page, const char *path);

/* An SVG that needs nothing else: a drawing for each problem and cost, with a key for each problem. */
ll_status ll_tradeoff_image_write(const ll_tradeoff *tradeoff, const char *path);
