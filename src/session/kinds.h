/* All kinds of simulations. Each has a room of its own; only this file includes all of their headers. */
#pragma once

#include "sim/core/sim.h"

#define LL_SIM_DECLARE(NAME) extern const ll_sim_kind ll_sim_##NAME;
LL_SIM_KINDS(LL_SIM_DECLARE)
#undef LL_SIM_DECLARE
