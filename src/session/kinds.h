/* The kinds of simulations, each with a room of its own: their headers are not for one file. */
#pragma once

#include "sim/core/sim.h"

#define LL_SIM_DECLARE(NAME) extern const ll_sim_kind ll_sim_##NAME;
LL_SIM_KINDS(LL_SIM_DECLARE)
#undef LL_SIM_DECLARE
