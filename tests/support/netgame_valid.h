/* Whether a netgame's block is sound, after any step. */
#pragma once

#include "sim/netgame/netgame.h"

/* The first invariant that does not hold, as a sentence; NULL: all do. Nothing changes. Cost: the rings. */
const char *netgame_broken(const ll_netgame *game);
