/* Bodies that would pass through others within a step. */
#pragma once

#include "rigid/body/world_state.h"

size_t ll_toi_events_size(const ll_rigid_limits *limits); /* bytes of solver memory */
void ll_solve_continuous(ll_rigid *w, ll_team *team);
