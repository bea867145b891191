/* Whether a client's block is sound: for tests, after any step. */
#pragma once

#include "netcode/state/client.h"

/* The first invariant that does not hold, as a sentence; NULL: all do. Nothing changes. Cost: the rings.
 * `in_order`: snapshots that come after a newer one are dropped. */
const char *ll_client_broken(const ll_client *client, bool in_order);
