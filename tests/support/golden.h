/* A line of tests/golden/hashes.csv, recomputed from a scenario of the library. */
#pragma once

#include <stddef.h>

#include "base/status.h"

enum { GOLDEN_LINE_MAX = 512 };

/* `scenario,tick,hash,metric=value;...`: with the scenario's own seed, after its whole duration. LL_BAD_INPUT
 * when an expectation is missing or not met: a scenario without events proves nothing. */
ll_status golden_line(const char *id, char line[GOLDEN_LINE_MAX]);
