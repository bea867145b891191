/* All kinds of simulations. Each has a room of its own; only this file includes all of their headers. */
#pragma once

#include "sim/core/sim.h"

extern const ll_sim_kind ll_sim_netgame, ll_sim_motion, ll_sim_rigid, ll_sim_fluid;
