/* A daemon without sessions: it passes the streams of another daemon, the owner, on to any number of viewers.
 *
 * Of each session that is watched it reads the stream once, as a viewer does (upstream.h), decodes the frames
 * and publishes them to viewers of its own, by the same code as the owner. Its viewers are paced, get deltas
 * against what they have, and may subscribe to less; none of them costs the owner anything. REST requests are
 * passed on to the owner (forward.h), and so are keys and inputs of viewers, and the streams of classes and
 * experiments, over a connection for each such viewer (tunnel.c). The owner of a relay may be a relay. */
#pragma once

#include "daemon/net/config.h"

/* Every setting is a row of ll_relay_table. */
typedef struct ll_relay_config {
    char of[512];      /* http://HOST[:PORT][/PATH] */
    char ca_file[512]; /* of certificate authorities; empty: the system's */
    int64_t max_streams;
    int64_t max_tunnels;
    double linger_s;
    double cache_s;
    int64_t max_answer_mib;
} ll_relay_config;

extern const ll_param_table ll_relay_table;

/* Runs until a signal. Returns the exit status. */
int ll_relay(const ll_relay_config *config, const ll_web_server_config *web_server);
