/* What the observer counts of a player's transport: per direction, from warmup_s on. */
#pragma once

#include "base/histogram.h"
#include "netcode/protocol/event.h"
#include "netcode/protocol/running_stats.h"
#include "sim/netgame/netgame.h"

#define LL_NETGAME_SENT_RING                                                                                 \
    256 /* messages on their way that are remembered, by the number of their first chunk */

typedef struct ll_flow_metrics {
    ll_histogram latency_ms, blocked_ms;
    ll_running_stats window;
    int64_t sent, handed, delayed, lost, refused, dropped; /* messages */
    int64_t packets, ack_packets, resent_packets, resent_chunks, timeouts, ended;
    int64_t wire_bytes, ack_bytes, header_bytes;
} ll_flow_metrics;

/* A message on its way, with its event. */
typedef struct ll_sent_message {
    int64_t number;
    ll_event event;
} ll_sent_message;

typedef struct ll_transport_metrics {
    ll_flow_metrics flow[LL_SIDES];
    ll_sent_message sent[LL_SIDES][LL_NETGAME_SENT_RING];
} ll_transport_metrics;

static inline ll_transport_metrics *ll_netgame_transport_metrics_of(const ll_netgame *g, int i)
{
    return (ll_transport_metrics *)((char *)g + ll_netgame_parts_of(g, i)->transport_metrics);
}

void ll_transport_metrics_init(ll_transport_metrics *m);
void ll_flow_metrics_add(ll_flow_metrics *m, const ll_transport_note *note, ll_time now);
