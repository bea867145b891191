/* Speed against error as JSON: for `laglab tradeoff --list` and for the API. */
#pragma once

#include "experiment/advise/tradeoff.h"

struct cJSON;

/* The address at which the page opens a setting as a live session: `page` with scenario, parameters and seed.
 */
void ll_tradeoff_address(const ll_tradeoff *tradeoff, const ll_tradeoff_row *row, const char *page,
                         char *text, int size);

/* [{"name","title","text","first":[...],"problems":[{"scenario","error","title"}],"costs":[{"path","title"}]}];
 * NULL without memory. The caller deletes it. */
struct cJSON *ll_tradeoff_families_json(void);

/* The family as above, with "rows" and "choices". A measured value is [value, low, high], each
 * null where it is not known. `row` and `check_cheapest` of a choice are places in "rows", or null. The
 * caller deletes it. */
struct cJSON *ll_tradeoff_json(const ll_tradeoff *tradeoff);
