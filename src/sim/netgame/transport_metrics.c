/* Metrics of the players' transports. */
#include "sim/netgame/transport_metrics.h"

#include <cjson/cJSON.h>

void ll_transport_metrics_init(ll_transport_metrics *m)
{
    for (int side = 0; side < LL_SIDES; side++) {
        ll_histogram_init(&m->flow[side].latency_ms, 0.1);
        ll_histogram_init(&m->flow[side].blocked_ms, 0.1);
    }
}

static void count_packet(ll_flow_metrics *m, const ll_transport_note *note)
{
    m->packets++;
    m->ack_packets += note->chunks == 0;
    m->ack_bytes += note->chunks == 0 ? note->wire_bytes : 0;
    m->resent_packets += note->resent > 0;
    m->resent_chunks += note->resent;
    m->wire_bytes += note->wire_bytes;
    m->header_bytes += note->header_bytes;
    ll_running_stats_add(&m->window, note->window);
}

void ll_flow_metrics_add(ll_flow_metrics *m, const ll_transport_note *note, ll_time now)
{
    if (note->event == LL_TRANSPORT_PACKET) {
        count_packet(m, note);
    } else if (note->event == LL_TRANSPORT_HANDED) {
        m->handed++;
        m->delayed += note->resent != 0 || note->complete < now;
        ll_histogram_add(&m->latency_ms, ll_to_ms(now - note->made));
        ll_histogram_add(&m->blocked_ms, ll_to_ms(now - note->complete));
    }
    m->lost += note->event == LL_TRANSPORT_LOST;
    m->refused += note->event == LL_TRANSPORT_REFUSED;
    m->timeouts += note->event == LL_TRANSPORT_TIMED_OUT;
    m->ended += note->event == LL_TRANSPORT_ENDED;
    m->dropped += note->event == LL_TRANSPORT_ENDED ? note->chunks : 0;
}

#define FLOW(X)                                                                                              \
    X(count, messages, NULL, m->sent, "messages that the transport took", NULL)                              \
    X(count, delivered, NULL, m->handed, "messages handed over to the receiver, each once", NULL)            \
    X(distribution, latency_ms, "ms", ll_netgame_distribution(ll_histogram_summary(&m->latency_ms)),         \
      "message latency: time from sending a message to handing it over to the receiver",                     \
      "No message was handed over.")                                                                         \
    X(distribution, blocked_ms, "ms", ll_netgame_distribution(ll_histogram_summary(&m->blocked_ms)),         \
      "head-of-line blocking: time that a message which had arrived waited for an earlier one; a value per " \
      "message, 0 if it did not wait",                                                                       \
      "No message was handed over.")                                                                         \
    X(number, delayed_ratio, NULL, ll_netgame_ratio((double)m->delayed, (double)m->handed),                  \
      "share of messages that were sent more than once, or waited for one that was",                         \
      "No message was handed over.")                                                                         \
    X(count, lost, NULL, m->lost, "messages that were lost and not sent again", NULL)                        \
    X(count, refused, NULL, m->refused,                                                                      \
      "messages that were not taken, because the send buffer was full or there was no connection", NULL)     \
    X(events, connections_ended, NULL, m->ended,                                                             \
      "connections that this side ended, or that ended on the other side", NULL)                             \
    X(count, dropped, NULL, m->dropped, "messages that were dropped with a connection", NULL)                \
    X(count, packets, NULL, m->packets, "packets sent", NULL)                                                \
    X(count, ack_packets, NULL, m->ack_packets, "of these, packets that only acknowledge", NULL)             \
    X(count, retransmissions, NULL, m->resent_packets, "packets with data that was sent before", NULL)       \
    X(count, retransmitted_chunks, NULL, m->resent_chunks, "chunks of messages in these packets", NULL)      \
    X(count, timeouts, NULL, m->timeouts, "times that the retransmission timer ended", NULL)                 \
    X(gauge, window_bytes, "B", ll_netgame_gauge(&m->window, 1),                                             \
      "congestion window; a value per packet sent", "No packet was sent.")                                   \
    X(rate, wire_bytes_per_s, "B/s", ll_netgame_ratio((double)m->wire_bytes, seconds),                       \
      "bytes per second on the wire, headers and acknowledgements included",                                 \
      "The run has not reached warmup_s.")                                                                   \
    X(rate, header_bytes_per_s, "B/s", ll_netgame_ratio((double)m->header_bytes, seconds),                   \
      "of these, bytes that are not of messages", "The run has not reached warmup_s.")

const ll_metric_table ll_netgame_transport_up_table = {
    LL_OF_PLAYERS(".transport_up"),
    .help = "The player's transport to the server, from warmup_s on; absent with udp.",
    LL_METRICS_FROM(FLOW)};

const ll_metric_table ll_netgame_transport_down_table = {
    LL_OF_PLAYERS(".transport_down"),
    .help = "The player's transport from the server, from warmup_s on; absent with udp.",
    LL_METRICS_FROM(FLOW)};

static void flow_report(cJSON *o, const ll_metric_table *table, const ll_flow_metrics *m, double seconds)
{
    LL_METRICS_PUT(o, table, FLOW);
}

void ll_netgame_transport_metrics(const ll_netgame *g, int player, cJSON *o)
{
    if (!ll_netgame_transport(g, player))
        return;
    const ll_transport_metrics *m = ll_netgame_transport_metrics_of(g, player);
    double seconds = ll_netgame_measured_s(g, ll_netgame_client_metrics(g, player));
    flow_report(cJSON_AddObjectToObject(o, "transport_up"), &ll_netgame_transport_up_table,
                &m->flow[LL_CLIENT_SIDE], seconds);
    flow_report(cJSON_AddObjectToObject(o, "transport_down"), &ll_netgame_transport_down_table,
                &m->flow[LL_SERVER_SIDE], seconds);
}
