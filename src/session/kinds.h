/* The kinds of simulations, each with a room of its own: their headers are not for one file. */
#pragma once

#include "sim/core/sim.h"

extern const ll_sim_kind ll_sim_netgame, ll_sim_motion, ll_sim_rigid, ll_sim_fluid;
