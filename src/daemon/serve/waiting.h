/* What a daemon answers while it waits for its store: that it is alive and not ready. */
#pragma once

#include "daemon/listener/web_server.h"

/* /healthz is 200, /readyz 404, everything else 503. ll_web_server_open_after ends it. */
ll_status ll_waiting_open(const ll_web_server_config *config, ll_web_server **web_server);
