/* Runs the daemon, from its settings to its end. */
#pragma once

#include "daemon/class/classes.h"
#include "daemon/hosting/host.h"
#include "daemon/net/config.h"
#include "daemon/support/access.h"

typedef struct ll_serve_config {
    ll_web_server_config web_server;
    ll_host_config host;
    ll_access_config access;
    ll_classes_config classes;
} ll_serve_config;

/* Returns the exit status, after a signal has ended it or if it could not start. */
int ll_serve(const ll_serve_config *config);
