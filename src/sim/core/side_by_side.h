/* Simulations listed in `side_by_side`: they run side by side with a first one from the same start. */
#pragma once

#define LL_SIDE_BY_SIDE_MAX 3 /* including the first */

#include "record/trace.h"

struct cJSON;

/* The report of the first simulation in `block` by `tell`, with those of the others in its list
 * `side_by_side`, if there are any. */
struct cJSON *ll_side_by_side_report(const void *block, int count,
                                     struct cJSON *(*tell)(const void *block, int place));

/* Prefix of the columns of a trace: none for the first simulation, `side_by_side0_`, `side_by_side1_`, ...
 * for the others. */
void ll_side_by_side_trace(ll_trace_line *trace, int place);
