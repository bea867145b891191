/* Reports of a player's traffic: bandwidth, snapshots, and the measured behaviour of the links. */
#include <cjson/cJSON.h>
#include <math.h>

#include "base/detmath.h"
#include "sim/netgame/netgame.h"

static double ratio(double a, double b)
{
    return ll_netgame_ratio(a, b);
}

/* ---- bandwidth ---- */

#define MESSAGES(X)                                                                                          \
    X(number, messages_per_s, "1/s", ratio((double)in->traffic.messages[type], seconds),                     \
      "messages of this type sent per second", "The run has not reached warmup_s.")                          \
    X(number, packets_per_s, "1/s", ratio((double)in->traffic.packets[type], seconds),                       \
      "packets per second in which messages of this type were sent", "The run has not reached warmup_s.")    \
    X(number, payload_bytes_per_s, "B/s", ratio((double)in->traffic.bytes[type], seconds),                   \
      "payload bytes per second of messages of this type", "The run has not reached warmup_s.")              \
    X(number, wire_bytes_per_s, "B/s", ratio((double)in->traffic.wire_bytes[type], seconds),                 \
      "bytes per second on the wire of messages of this type: each packet with 28 bytes of IPv4 and UDP "    \
      "headers, each fragment with 4 more",                                                                  \
      "The run has not reached warmup_s.")

#define TOTALS(X)                                                                                            \
    X(number, up_bytes_per_s, "B/s", ratio(up, seconds),                                                     \
      "bandwidth to the server: bytes per second of all messages, headers included",                         \
      "The run has not reached warmup_s.")                                                                   \
    X(number, down_bytes_per_s, "B/s", ratio(down, seconds),                                                 \
      "bandwidth from the server: bytes per second of all messages, headers included",                       \
      "The run has not reached warmup_s.")

const ll_metric_table ll_netgame_message_table = {LL_OF_PLAYERS(".bandwidth.*"),
                                                  .help = "Messages of one type as sent, from warmup_s on.",
                                                  LL_METRICS_FROM(MESSAGES)};

const ll_metric_table ll_netgame_bandwidth_table = {
    LL_OF_PLAYERS(".bandwidth"), .help = "Bandwidth of all messages of the player, from warmup_s on.",
    LL_METRICS_FROM(TOTALS)};

static void bandwidth(cJSON *player, const ll_netgame *g, int self)
{
    static const char *const names[LL_MESSAGES] = {NULL,      "input",  "state", "refusal", "relay",
                                                   "connect", "accept", "ping",  "pong"};
    static const bool ups[LL_MESSAGES] = {
        [LL_MESSAGE_INPUT] = true, [LL_MESSAGE_CONNECT] = true, [LL_MESSAGE_PING] = true};
    const ll_client_metrics *in = ll_netgame_client_metrics(g, self);
    double seconds = ll_netgame_measured_s(g, in), up = 0, down = 0;
    cJSON *o = cJSON_AddObjectToObject(player, "bandwidth");
    for (int type = LL_MESSAGE_INPUT; type < LL_MESSAGES; type++) {
        LL_METRICS_PUT(cJSON_AddObjectToObject(o, names[type]), &ll_netgame_message_table, MESSAGES);
        *(ups[type] ? &up : &down) += (double)in->traffic.wire_bytes[type];
    }
    LL_METRICS_PUT(o, &ll_netgame_bandwidth_table, TOTALS);
}

/* ---- snapshots ---- */

#define SNAPSHOTS(X)                                                                                         \
    X(number, bits_per_entity, "bit", ratio((double)sent->entity_bits, entities),                            \
      "mean size of an entity in a snapshot, the receiver's own entity included", "No snapshot was sent.")   \
    X(number, tail_bits, "bit", ratio((double)sent->tail_bits, states),                                      \
      "mean size of the game's own state in a snapshot", "No snapshot was sent.")                            \
    X(number, unchanged_ratio, NULL, ratio((double)sent->unchanged, entities),                               \
      "share of entities that snapshots leave out as unchanged", "No snapshot was sent.")                    \
    X(number, at_rest_ratio, NULL, ratio((double)sent->resting, entities),                                   \
      "share of entities that snapshots encode as at rest", "No snapshot was sent.")                         \
    X(number, full_ratio, NULL, ratio((double)sent->whole, states),                                          \
      "share of full snapshots, which have no baseline", "No snapshot was sent.")                            \
    X(number, bytes_over_full, NULL,                                                                         \
      ratio((double)in->traffic.bytes[LL_MESSAGE_SNAPSHOT], states *(double)full),                           \
      "payload of the snapshots divided by the payload with the encoding `full`", "No snapshot was sent.")   \
    X(count, undecodable, NULL, ll_netgame_client(g, self)->snapshots.unreadable,                            \
      "snapshots that arrived and could not be decoded", NULL)

const ll_metric_table ll_netgame_snapshot_table = {LL_OF_PLAYERS(".snapshot"),
                                                   .help = "Snapshots that the server sent to the player.",
                                                   LL_METRICS_FROM(SNAPSHOTS)};

static void snapshots(cJSON *player, const ll_netgame *g, int self)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, self);
    const ll_snapshot_cost *sent = &ll_netgame_server(g)->client_slots[self].counts.sent;
    double states = (double)in->traffic.messages[LL_MESSAGE_SNAPSHOT], entities = (double)sent->entities;
    size_t full = sizeof(ll_snapshot_message) + ll_world_size(ll_server_world_const(ll_netgame_server(g)));
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "snapshot"), &ll_netgame_snapshot_table, SNAPSHOTS);
}

/* ---- links ---- */

#define LINK(X)                                                                                              \
    X(count, sent, NULL, s->sent, "packets sent", NULL)                                                      \
    X(count, delivered, NULL, s->delivered, "messages delivered, duplicates included", NULL)                 \
    X(count, lost, NULL, s->lost, "packets lost by the loss model or in a blackout, duplicates included",    \
      NULL)                                                                                                  \
    X(number, loss_pct, "%", ll_link_loss_pct(s),                                                            \
      "share of packets lost by the loss model or in a blackout, duplicates included",                       \
      "No packet was sent.")                                                                                 \
    X(count, loss_bursts, NULL, s->loss_bursts, "bursts of loss: runs of successive lost packets", NULL)     \
    X(number, loss_burst_mean_packets, NULL,                                                                 \
      ratio((double)(s->lost - s->lost_copies), (double)s->loss_bursts),                                     \
      "mean number of packets in a burst of loss", "There was no loss.")                                     \
    X(count, lost_in_blackouts, NULL, s->lost_in_blackouts,                                                  \
      "packets lost in blackouts, duplicates included", NULL)                                                \
    X(count, rescued, NULL, s->rescued,                                                                      \
      "losses of one of two copies of a packet, while the other copy was sent on", NULL)                     \
    X(count, messages, NULL, messages, "messages sent", NULL)                                                \
    X(count, messages_lost, NULL, s->messages_lost,                                                          \
      "messages that did not arrive completely, for any cause", NULL)                                        \
    X(number, message_loss_pct, "%", 100 * ratio((double)s->messages_lost, messages),                        \
      "share of messages that did not arrive completely, for any cause", "No message was sent.")             \
    X(count, split, NULL, s->fragments.split, "messages sent in several fragments", NULL)                    \
    X(count, split_lost, NULL, s->fragments.split_lost,                                                      \
      "messages sent in several fragments that did not arrive completely", NULL)                             \
    X(count, fragments, NULL, s->fragments.count, "fragments sent of messages that were split", NULL)        \
    X(count, fragments_lost, NULL, s->fragments.lost, "fragments of which no copy arrived", NULL)            \
    X(count, duplicated, NULL, s->duplicated, "packets that were duplicated", NULL)                          \
    X(count, corrupted, NULL, s->corrupted, "packets that were corrupted, duplicates included", NULL)        \
    X(count, overflowed, NULL, s->overflowed,                                                                \
      "packets dropped because the link has no room for them, duplicates included", NULL)                    \
    X(count, reordered, NULL, s->reordered, "messages delivered after one that was sent later", NULL)        \
    X(count, reordered_ahead, NULL, s->reordered_ahead, "packets sent ahead of earlier ones by reorder_pct", \
      NULL)                                                                                                  \
    X(number, delay_mean_ms, "ms", mean, "mean delay of packets", "No packet was put on its way.")           \
    X(number, delay_sd_ms, "ms", variance > 0 ? ll_sqrt(variance) : 0 * variance,                            \
      "standard deviation of the delay of packets", "No packet was put on its way.")                         \
    X(number, delay_min_ms, "ms", n > 0 ? s->delay.min_ms : NAN, "shortest delay of a packet",               \
      "No packet was put on its way.")                                                                       \
    X(number, delay_max_ms, "ms", n > 0 ? s->delay.max_ms : NAN, "longest delay of a packet",                \
      "No packet was put on its way.")                                                                       \
    X(number, delay_corr_pct, "%", 100 * ll_link_delay_correlation(s),                                       \
      "correlation of the delays of successive packets",                                                     \
      "There were too few packets, or all delays are equal.")                                                \
    X(number, queue_mean_ms, "ms", ratio(s->queue.sum_ms, (double)s->queue.count),                           \
      "mean time of packets in the queue of the rate limit, waiting and transmission",                       \
      "No packet was queued.")                                                                               \
    X(number, queue_max_ms, "ms", s->queue.max_ms,                                                           \
      "longest time of a packet in the queue of the rate limit, waiting and transmission", NULL)             \
    X(count, queue_drops, NULL, s->queue_drops,                                                              \
      "packets dropped because the queue of the rate limit was full", NULL)

const ll_metric_table ll_netgame_up_table = {
    LL_OF_PLAYERS(".link_up"),
    .help = "Measured behaviour of the player's link to the server, from time 0 on.", LL_METRICS_FROM(LINK)};

const ll_metric_table ll_netgame_down_table = {
    LL_OF_PLAYERS(".link_down"),
    .help = "Measured behaviour of the player's link from the server, from time 0 on.",
    LL_METRICS_FROM(LINK)};

static void link_report(cJSON *o, const ll_metric_table *table, const ll_link *link)
{
    const ll_link_stats *s = ll_link_get_stats(link);
    double messages = (double)ll_link_messages(s), n = (double)ll_link_put_on_way(s);
    double mean = ratio(s->delay.sum_ms, n), variance = ratio(s->delay.sum_squares, n) - mean * mean;
    LL_METRICS_PUT(o, table, LINK);
}

void ll_netgame_traffic_metrics(const ll_netgame *g, int player, cJSON *o)
{
    bandwidth(o, g, player);
    snapshots(o, g, player);
    link_report(cJSON_AddObjectToObject(o, "link_up"), &ll_netgame_up_table, ll_netgame_up(g, player));
    link_report(cJSON_AddObjectToObject(o, "link_down"), &ll_netgame_down_table, ll_netgame_down(g, player));
}
