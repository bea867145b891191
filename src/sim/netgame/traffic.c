/* A player's traffic: bandwidth, snapshots, and the links' measured behaviour. */
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
    X(number, messages_per_s, "1/s", ratio((double)in->messages[type], seconds), "messages sent",            \
      "It is before warmup_s.")                                                                              \
    X(number, packets_per_s, "1/s", ratio((double)in->packets[type], seconds),                               \
      "packets that they travel in", "It is before warmup_s.")                                               \
    X(number, payload_bytes_per_s, "B/s", ratio((double)in->bytes[type], seconds), "their payload",          \
      "It is before warmup_s.")                                                                              \
    X(number, wire_bytes_per_s, "B/s", ratio((double)in->wire_bytes[type], seconds),                         \
      "on the wire: each packet with 28 of IPv4 and UDP headers, each fragment with 4 more",                 \
      "It is before warmup_s.")

#define TOTALS(X)                                                                                            \
    X(number, up_bytes_per_s, "B/s", ratio(up, seconds), "on the wire, to the server",                       \
      "It is before warmup_s.")                                                                              \
    X(number, down_bytes_per_s, "B/s", ratio(down, seconds), "on the wire, from the server",                 \
      "It is before warmup_s.")

const ll_metric_table ll_netgame_message_table = {LL_OF_PLAYERS(".bandwidth.*"),
                                                  .help = "messages of one type, as sent, from warmup_s on.",
                                                  LL_METRICS_FROM(MESSAGES)};

const ll_metric_table ll_netgame_bandwidth_table = {LL_OF_PLAYERS(".bandwidth"),
                                                    .help = "all messages of the player, from warmup_s on.",
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
        *(ups[type] ? &up : &down) += (double)in->wire_bytes[type];
    }
    LL_METRICS_PUT(o, &ll_netgame_bandwidth_table, TOTALS);
}

/* ---- snapshots ---- */

#define SNAPSHOTS(X)                                                                                         \
    X(number, bits_per_entity, "bit", ratio((double)sent->entity_bits, entities),                            \
      "of an entity, the receiver's own included", "None was sent.")                                         \
    X(number, tail_bits, "bit", ratio((double)sent->tail_bits, states), "of the game's own part of a state", \
      "None was sent.")                                                                                      \
    X(number, unchanged_ratio, NULL, ratio((double)sent->unchanged, entities),                               \
      "share of entities that were left out as unchanged", "None was sent.")                                 \
    X(number, at_rest_ratio, NULL, ratio((double)sent->resting, entities), "share of entities at rest",      \
      "None was sent.")                                                                                      \
    X(number, full_ratio, NULL, ratio((double)sent->whole, states), "share of states without a baseline",    \
      "None was sent.")                                                                                      \
    X(number, bytes_over_full, NULL, ratio((double)in->bytes[LL_MESSAGE_SNAPSHOT], states *(double)full),    \
      "payload over that of the encoding `full`", "None was sent.")                                          \
    X(count, undecodable, NULL, ll_netgame_client(g, self)->unreadable,                                      \
      "states that came and could not be decoded", NULL)

const ll_metric_table ll_netgame_snapshot_table = {
    LL_OF_PLAYERS(".snapshot"), .help = "the states sent to the player.", LL_METRICS_FROM(SNAPSHOTS)};

static void snapshots(cJSON *player, const ll_netgame *g, int self)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, self);
    const ll_snapshot_cost *sent = &ll_netgame_server(g)->client_slots[self].sent;
    double states = (double)in->messages[LL_MESSAGE_SNAPSHOT], entities = (double)sent->entities;
    size_t full = sizeof(ll_snapshot_message) + ll_world_size(ll_server_world_const(ll_netgame_server(g)));
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "snapshot"), &ll_netgame_snapshot_table, SNAPSHOTS);
}

/* ---- links ---- */

#define LINK(X)                                                                                              \
    X(count, sent, NULL, s->sent, "packets", NULL)                                                           \
    X(count, delivered, NULL, s->delivered, "messages, copies too", NULL)                                    \
    X(count, lost, NULL, s->lost, "packets, copies too", NULL)                                               \
    X(number, loss_pct, "%", ll_link_loss_pct(s), "share of the loss's draws", "No packet was sent.")        \
    X(count, loss_bursts, NULL, s->loss_bursts, "losses in a row", NULL)                                     \
    X(number, loss_burst_mean_packets, NULL,                                                                 \
      ratio((double)(s->lost - s->lost_copies), (double)s->loss_bursts), "packets of such a burst",          \
      "There was none.")                                                                                     \
    X(count, lost_in_blackouts, NULL, s->lost_in_blackouts, "of the lost ones", NULL)                        \
    X(count, rescued, NULL, s->rescued, "losses that took one of two", NULL)                                 \
    X(count, messages, NULL, messages, "that were sent", NULL)                                               \
    X(count, messages_lost, NULL, s->messages_lost, "for any cause", NULL)                                   \
    X(number, message_loss_pct, "%", 100 * ratio((double)s->messages_lost, messages), "their share",         \
      "No message was sent.")                                                                                \
    X(count, split, NULL, s->split, "messages in several fragments", NULL)                                   \
    X(count, split_lost, NULL, s->split_lost, "of these the lost ones", NULL)                                \
    X(count, fragments, NULL, s->fragments, "of split messages", NULL)                                       \
    X(count, fragments_lost, NULL, s->fragments_lost, "of these the lost ones: no copy came either", NULL)   \
    X(count, duplicated, NULL, s->duplicated, "packets", NULL)                                               \
    X(count, corrupted, NULL, s->corrupted, "packets", NULL)                                                 \
    X(count, overflowed, NULL, s->overflowed, "packets beyond what the link holds", NULL)                    \
    X(count, reordered, NULL, s->reordered, "messages after a later one", NULL)                              \
    X(count, reordered_ahead, NULL, s->reordered_ahead, "packets, by reorder_pct", NULL)                     \
    X(number, delay_mean_ms, "ms", mean, "of packets", "None was delayed.")                                  \
    X(number, delay_sd_ms, "ms", variance > 0 ? ll_sqrt(variance) : 0 * variance, "its standard deviation",  \
      "None was delayed.")                                                                                   \
    X(number, delay_min_ms, "ms", n > 0 ? s->delay_min_ms : NAN, "the least", "None was delayed.")           \
    X(number, delay_max_ms, "ms", n > 0 ? s->delay_max_ms : NAN, "the most", "None was delayed.")            \
    X(number, delay_corr_pct, "%", 100 * ll_link_delay_correlation(s), "correlation of successive delays",   \
      "Too few packets, or all delays are alike.")                                                           \
    X(number, queue_mean_ms, "ms", ratio(s->queue_sum_ms, (double)s->queued),                                \
      "wait and transmission in the rate's queue", "None was queued.")                                       \
    X(number, queue_max_ms, "ms", s->queue_max_ms, "the most", NULL)                                         \
    X(count, queue_drops, NULL, s->queue_drops, "packets beyond the queue's limits", NULL)

const ll_metric_table ll_netgame_up_table = {LL_OF_PLAYERS(".link_up"),
                                             .help = "What the way to the server really did, from 0 on.",
                                             LL_METRICS_FROM(LINK)};

const ll_metric_table ll_netgame_down_table = {LL_OF_PLAYERS(".link_down"),
                                               .help = "What the way from the server really did, from 0 on.",
                                               LL_METRICS_FROM(LINK)};

static void link_report(cJSON *o, const ll_metric_table *table, const ll_link *link)
{
    const ll_link_stats *s = ll_link_get_stats(link);
    double messages = (double)ll_link_messages(s), n = (double)ll_link_put_on_way(s);
    double mean = ratio(s->delay_sum_ms, n), variance = ratio(s->delay_sum_squares, n) - mean * mean;
    LL_METRICS_PUT(o, table, LINK);
}

void ll_netgame_traffic_metrics(const ll_netgame *g, int player, cJSON *o)
{
    bandwidth(o, g, player);
    snapshots(o, g, player);
    link_report(cJSON_AddObjectToObject(o, "link_up"), &ll_netgame_up_table, ll_netgame_up(g, player));
    link_report(cJSON_AddObjectToObject(o, "link_down"), &ll_netgame_down_table, ll_netgame_down(g, player));
}
