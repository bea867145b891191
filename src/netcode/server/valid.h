/* Whether the server's block is sound: for tests, after any step. */
#pragma once

#include "netcode/server/server.h"

/* The first invariant that does not hold, as a sentence; NULL: all do. Nothing changes. Cost: the rings. */
const char *ll_server_broken(const ll_server *server);
