/* Simulations side by side with a first one from the same start: those that a scenario lists in
 * `side_by_side`. */
#pragma once

#define LL_SIDE_BY_SIDE_MAX 3 /* with the first */

struct cJSON;

/* What `tell` says of the first in `block`, place 0, and in its list `side_by_side` of the others, if there
 * are. */
struct cJSON *ll_side_by_side_report(const void *block, int count,
                                     struct cJSON *(*tell)(const void *block, int place));

/* The name of a trace's column: for the first as it is, behind it with `side_by_side0_`, `side_by_side1_`
 * before it. */
void ll_side_by_side_column(char out[48], int place, const char *name);
