/* What the paper prints of a scenario. */
#pragma once

#include <stdio.h>

#include "session/scenario.h"

/* Runs a scenario of kind netgame, and writes what Figures 6 to 13 print of one. */
ll_status ll_paper_netgame(const ll_scenario *scenario, FILE *to);
