/* Bodies that would pass through others within a step. */
#pragma once

#include "rigid/body/world_state.h"

size_t ll_meetings_size(const ll_rigid_limits *limits); /* bytes of solver memory */
void ll_stop_at_first_touch(ll_rigid *w);
