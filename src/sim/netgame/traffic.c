/* Reports of a player's connection and its traffic: bandwidth, snapshots, and the measured behaviour of the
 * links; and its traffic, streamed. */
#include <cjson/cJSON.h>
#include <math.h>

#include "base/detmath.h"
#include "record/integers.h"
#include "sim/netgame/parts.h"
#include "sim/netgame/transport.h"

static double ratio(double a, double b)
{
    return ll_netgame_ratio(a, b);
}

const char *const ll_netgame_message_names[LL_MESSAGES + 1] = {
    "", "input", "state", "refusal", "relay", "connect", "accept", "ping", "pong", NULL};

/* ---- bandwidth ---- */

#define MESSAGES(X)                                                                                          \
    X(rate, messages_per_s, "1/s", ratio((double)in->traffic.messages[type], seconds),                       \
      "messages of this type sent per second", "The run has not reached warmup_s.")                          \
    X(rate, packets_per_s, "1/s", ratio((double)in->traffic.packets[type], seconds),                         \
      "packets per second in which messages of this type were sent", "The run has not reached warmup_s.")    \
    X(rate, payload_bytes_per_s, "B/s", ratio((double)in->traffic.bytes[type], seconds),                     \
      "payload bytes per second of messages of this type", "The run has not reached warmup_s.")              \
    X(rate, wire_bytes_per_s, "B/s", ratio((double)in->traffic.wire_bytes[type], seconds),                   \
      "bytes per second on the wire of messages of this type: each packet with 28 bytes of IPv4 and UDP "    \
      "headers, each fragment with 4 more",                                                                  \
      "The run has not reached warmup_s.")

#define TOTALS(X)                                                                                            \
    X(rate, up_bytes_per_s, "B/s", ratio(up, seconds),                                                       \
      "bandwidth to the server: bytes per second of all messages, headers included",                         \
      "The run has not reached warmup_s.")                                                                   \
    X(rate, down_bytes_per_s, "B/s", ratio(down, seconds),                                                   \
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
    static const bool ups[LL_MESSAGES] = {
        [LL_MESSAGE_INPUT] = true, [LL_MESSAGE_CONNECT] = true, [LL_MESSAGE_PING] = true};
    const ll_client_metrics *in = ll_netgame_client_metrics(g, self);
    double seconds = ll_netgame_measured_s(g, in), up = 0, down = 0;
    cJSON *o = cJSON_AddObjectToObject(player, "bandwidth");
    for (int type = LL_MESSAGE_INPUT; type < LL_MESSAGES; type++) {
        LL_METRICS_PUT(cJSON_AddObjectToObject(o, ll_netgame_message_names[type]), &ll_netgame_message_table,
                       MESSAGES);
        *(ups[type] ? &up : &down) += (double)in->traffic.wire_bytes[type];
    }
    if (ll_netgame_transport(g, self)) {
        const ll_transport_metrics *m = ll_netgame_transport_metrics_of(g, self);
        up += (double)m->flow[LL_CLIENT_SIDE].ack_bytes;
        down += (double)m->flow[LL_SERVER_SIDE].ack_bytes;
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

#define RECKONINGS(X)                                                                                        \
    X(count, updates, NULL, updates,                                                                         \
      "states of others that the server sent to the player, from warmup_s on", NULL)                         \
    X(number, updates_per_s, "Hz", ratio((double)updates, s *others),                                        \
      "how often the state of another entity was sent, on average", "There are no others.")                  \
    X(count, by_threshold, NULL, m->by_threshold, "of these, because the model was too far off", NULL)       \
    X(count, by_heartbeat, NULL, m->by_heartbeat, "of these, because the heartbeat was due", NULL)           \
    X(count, suppressed, NULL, m->suppressed, "states that updates left out", NULL)                          \
    X(distribution, model_error_m, "m", ll_netgame_distribution(ll_histogram_summary(&m->model_error)),      \
      "distance of an entity from the model of what was last sent, at each update, before the decision to "  \
      "send it again",                                                                                       \
      "Nothing was sent.")

const ll_metric_table ll_netgame_reckoning_table = {
    LL_OF_PLAYERS(".reckoning"), .when = "Only with dead reckoning.",
    .help = "Dead reckoning: what the server sent to the player, from warmup_s on.",
    LL_METRICS_FROM(RECKONINGS)};

static void reckonings(cJSON *player, const ll_netgame *g, int self)
{
    if (!ll_netgame_reckoning(g))
        return;
    const ll_reckoning_counts *m = ll_reckoning_counted(ll_netgame_reckoning(g), self);
    int64_t updates = m->by_threshold + m->by_heartbeat + m->first;
    double s = ll_to_s(g->now) - g->config.warmup_s, others = ll_netgame_entities(g) - 1;
    s = s > 0 ? s : 0;
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "reckoning"), &ll_netgame_reckoning_table, RECKONINGS);
}

static void snapshots(cJSON *player, const ll_netgame *g, int self)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, self);
    const ll_snapshot_cost *sent = &ll_netgame_server(g)->client_slots[self].counts.sent;
    double states = (double)in->traffic.messages[LL_MESSAGE_SNAPSHOT], entities = (double)sent->entities;
    size_t full = sizeof(ll_snapshot_message) + ll_world_size(ll_server_world_const(ll_netgame_server(g)));
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "snapshot"), &ll_netgame_snapshot_table, SNAPSHOTS);
}

/* ---- snapshots of some of the entities ---- */

#define SELECTION(X)                                                                                         \
    X(count, snapshots, NULL, n->snapshots, "snapshots sent", NULL)                                          \
    X(number, lost_ratio, NULL, ratio((double)n->lost, (double)n->snapshots),                                \
      "share of snapshots that were lost or not acknowledged in time", "No snapshot was sent.")              \
    X(number, choked_ratio, NULL, ratio((double)n->choked, (double)n->snapshots),                            \
      "share of snapshots in which changed entities had no room", "No snapshot was sent.")                   \
    X(number, in_scope, NULL, ratio((double)n->in_scope, (double)n->snapshots),                              \
      "mean number of other entities in the area of interest, or of all", "No snapshot was sent.")           \
    X(number, update_interval_ms, "ms", tick_ms *ratio(n->interval_ticks, (double)n->intervals),             \
      "mean time between two states of an entity that were sent", "No entity was sent twice.")               \
    X(number, update_interval_max_ms, "ms", n->intervals > 0 ? tick_ms * n->interval_ticks_max : NAN,        \
      "longest time between two states of an entity that were sent; it includes times at rest",              \
      "No entity was sent twice.")                                                                           \
    X(number, near_error_m, "m", ratio(near->sum[0], (double)near->count[0]),                                \
      "mean error of the entities nearer than a quarter of interest_radius_m, as drawn", "None was near.")   \
    X(number, far_error_m, "m", ratio(near->sum[1], (double)near->count[1]),                                 \
      "mean error of the entities farther than a quarter of interest_radius_m, as drawn", "None was far.")

const ll_metric_table ll_netgame_selection_table = {
    LL_OF_PLAYERS(".selection"), .when = "Only where snapshots contain some of the entities.",
    .help = "Snapshots of some of the entities, from warmup_s on.", LL_METRICS_FROM(SELECTION)};

void ll_netgame_selection_metrics(const ll_netgame *g, int player, cJSON *metrics)
{
    const ll_server *server = ll_netgame_server(g);
    if (!ll_server_replicas(server))
        return;
    const ll_replica_counts *n = &ll_replicas_of(ll_server_replicas(server), player)->counts;
    const ll_nearness *near = ll_netgame_nearness(g, player);
    const double tick_ms = 1e6 / (double)server->clock.freq; /* mHz */
    LL_METRICS_PUT(cJSON_AddObjectToObject(metrics, "selection"), &ll_netgame_selection_table, SELECTION);
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
      "packets dropped because the queue of the rate limit was full", NULL)                                  \
    X(count, marked, NULL, profiled ? profiled->marked : 0,                                                  \
      "packets marked by ECN instead of dropped, duplicates included", NULL)                                 \
    X(count, trace_lost, NULL, profiled ? profiled->trace_lost : 0,                                          \
      "packets lost by the trace of the link's profile, duplicates included", NULL)

const ll_metric_table ll_netgame_up_table = {
    LL_OF_PLAYERS(".link_up"),
    .help = "Measured behaviour of the player's link to the server, from time 0 on.", LL_METRICS_FROM(LINK)};

const ll_metric_table ll_netgame_down_table = {
    LL_OF_PLAYERS(".link_down"),
    .help = "Measured behaviour of the player's link from the server, from time 0 on.",
    LL_METRICS_FROM(LINK)};

static const ll_profile_state *profiled_by(const ll_netgame *g, int way)
{
    const ll_profile_shelf *shelf = ll_netgame_profiles(g);
    return shelf ? ll_profile_shelf_state(shelf, way) : NULL;
}

static void link_report(cJSON *o, const ll_metric_table *table, const ll_link *link,
                        const ll_profile_state *profiled)
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
    reckonings(o, g, player);
    link_report(cJSON_AddObjectToObject(o, "link_up"), &ll_netgame_up_table, ll_netgame_up(g, player),
                profiled_by(g, 2 * player));
    link_report(cJSON_AddObjectToObject(o, "link_down"), &ll_netgame_down_table, ll_netgame_down(g, player),
                profiled_by(g, 2 * player + 1));
}

/* ---- connection, with the measured clock ---- */

/* Includes the time of the lobby, before time 0. */
static double in_state_s(const ll_netgame *g, const ll_connection *n, int state)
{
    return ll_to_s(n->in_state[state] + (n->state == state ? g->now - n->since : 0));
}

/* Offset in use minus the true offset of the clocks. */
static double clock_error_ms(const ll_netgame *g, int player)
{
    ll_client_setup s = {.config = &g->config.players[player]};
    const ll_clock_sync *clock = &ll_netgame_client(g, player)->connection.clock;
    return ll_to_ms(clock->offset + ll_client_local(&s, g->now) - g->now);
}

#define CONNECTION(X)                                                                                        \
    X(text, state, NULL, ll_connection_state_names[n->state],                                                \
      "state of the connection, as the client has it", NULL)                                                 \
    X(flag, connected, NULL, client_slot->connection.connected,                                              \
      "whether the server has the player as connected", NULL)                                                \
    X(count, joins, NULL, n->joins, "times that the client joined the game", NULL)                           \
    X(events, time_outs, NULL, n->time_outs, "connections that the client gave up after a time-out", NULL)   \
    X(events, drops, NULL, client_slot->connection.drops, "times that the server dropped the player", NULL)  \
    X(by_name, seconds, "s",                                                                                 \
      ((ll_metric_reading){                                                                                  \
          .number = LL_CONNECTION_STATES, .numbers = seconds, .names = ll_connection_state_names}),          \
      "time that the client spent in each state of the connection", NULL)                                    \
    X(number, round_trip_ms, "ms", ll_to_ms(ll_clock_sync_round_trip(&n->clock)),                            \
      "longest round-trip time of the last eight pings", NULL)                                               \
    X(number, clock_error_ms, "ms", clock_error_ms(g, player),                                               \
      "error of clock synchronisation: the client's estimate of the server's clock less that clock", NULL)   \
    X(events, clock_snaps, NULL, n->clock.snaps,                                                             \
      "times that the client's estimate of the server's clock jumped", NULL)

const ll_metric_table ll_netgame_connection_table = {LL_OF_PLAYERS(".connection"),
                                                     .help = "The player's connection, the lobby included.",
                                                     LL_METRICS_FROM(CONNECTION)};

void ll_netgame_connection_metrics(const ll_netgame *g, int player, cJSON *metrics)
{
    const ll_connection *n = &ll_netgame_client(g, player)->connection;
    const ll_client_slot *client_slot = &ll_netgame_server(g)->client_slots[player];
    double seconds[LL_CONNECTION_STATES];
    for (int state = 0; state < LL_CONNECTION_STATES; state++)
        seconds[state] = in_state_s(g, n, state);
    LL_METRICS_PUT(cJSON_AddObjectToObject(metrics, "connection"), &ll_netgame_connection_table, CONNECTION);
}

/* ---- streamed: messages by type ----
 *
 * Counts, not rates: a viewer takes the difference over any period. */

typedef struct traffic_row {
    uint8_t player, message;
    int64_t messages, packets, bytes, wire_bytes;
} traffic_row;

static const ll_record_field traffic_fields[] = {
    LL_INT(traffic_row, player, NULL, "index of the player"),
    LL_ENUM(traffic_row, message, ll_netgame_message_names,
            "type; input, connect and ping go to the server, the others to the player"),
    LL_INT(traffic_row, messages, NULL, "messages sent"),
    LL_INT(traffic_row, packets, NULL, "packets in which they were sent, repetitions included"),
    LL_INT(traffic_row, bytes, "B", "payload"),
    LL_INT(traffic_row, wire_bytes, "B", "the same on the wire: with all headers"),
};

LL_INTEGERS(traffic_integers, traffic_row, traffic_fields)

const ll_record ll_netgame_traffic_record = {
    .id = 13,
    .name = "traffic",
    .channel = LL_CHANNEL_TRAFFIC,
    .help =
        "Messages of each player by type, from the warm-up on; no row for a type of which there was none.",
    .form = LL_FORM_KEYED,
    .keys = 2,
    LL_ROWS_OF(traffic_row, traffic_fields),
    .integers = traffic_integers};

static void fill_messages(const ll_netgame *g, int player, ll_row_set *rows)
{
    const ll_traffic *t = &ll_netgame_client_metrics(g, player)->traffic;
    traffic_row all[LL_MESSAGES];
    int count = 0;
    for (int type = LL_MESSAGE_INPUT; type < LL_MESSAGES; type++)
        if (t->messages[type] > 0)
            all[count++] = (traffic_row){.player = (uint8_t)player,
                                         .message = (uint8_t)type,
                                         .messages = t->messages[type],
                                         .packets = t->packets[type],
                                         .bytes = t->bytes[type],
                                         .wire_bytes = t->wire_bytes[type]};
    ll_row_set_put(rows, &ll_netgame_traffic_record, all, count);
}

/* ---- streamed: links ---- */

typedef struct link_row {
    uint8_t player;
    int64_t up_sent, up_lost, down_sent, down_lost, up_ack_bytes, down_ack_bytes, snapshots, choked;
    float ping_ms;
} link_row;

static const ll_record_field link_fields[] = {
    LL_INT(link_row, player, NULL, "index of the player"),
    LL_INT(link_row, up_sent, NULL, "messages on the link to the server; of a transport its packets"),
    LL_INT(link_row, up_lost, NULL, "those that did not arrive completely, for any cause"),
    LL_INT(link_row, down_sent, NULL, "the same on the link to the player"),
    LL_INT(link_row, down_lost, NULL, "those that did not arrive completely, for any cause"),
    LL_INT(link_row, up_ack_bytes, "B", "acknowledgements of a transport to the server, on the wire"),
    LL_INT(link_row, down_ack_bytes, "B", "the same to the player"),
    LL_INT(link_row, snapshots, NULL, "snapshots sent, where they contain some of the entities; else 0"),
    LL_INT(link_row, choked, NULL, "those in which changed entities had no room"),
    LL_STEP(link_row, ping_ms, LL_BITS_MS, "ms", "round trip of the newest ping; null: none yet"),
};

LL_INTEGERS(link_integers, link_row, link_fields)

const ll_record ll_netgame_link_record = {.id = 14,
                                          .name = "links",
                                          .channel = LL_CHANNEL_TRAFFIC,
                                          .help = "Losses of each player's links, from the warm-up on.",
                                          .form = LL_FORM_BY_INDEX,
                                          LL_ROWS_OF(link_row, link_fields),
                                          .integers = link_integers};

static float ping_ms(const ll_clock_sync *clock)
{
    if (clock->count == 0)
        return NAN;
    return (float)ll_to_ms(clock->sample[(clock->count - 1) % LL_CLOCK_SAMPLES].round_trip);
}

static link_row link_of(const ll_netgame *g, int player)
{
    const ll_link_stats *up = ll_link_get_stats(ll_netgame_up(g, player)),
                        *down = ll_link_get_stats(ll_netgame_down(g, player));
    link_row row = {.player = (uint8_t)player,
                    .up_sent = ll_link_messages(up),
                    .up_lost = up->messages_lost,
                    .down_sent = ll_link_messages(down),
                    .down_lost = down->messages_lost,
                    .ping_ms = ping_ms(&ll_netgame_client(g, player)->connection.clock)};
    const ll_replicas *replicas = ll_server_replicas(ll_netgame_server(g));
    if (replicas) {
        const ll_replica_counts *n = &ll_replicas_of(replicas, player)->counts;
        row.snapshots = n->snapshots;
        row.choked = n->choked;
    }
    if (ll_netgame_transport(g, player)) {
        const ll_transport_metrics *m = ll_netgame_transport_metrics_of(g, player);
        row.up_ack_bytes = m->flow[LL_CLIENT_SIDE].ack_bytes;
        row.down_ack_bytes = m->flow[LL_SERVER_SIDE].ack_bytes;
    }
    return row;
}

void ll_netgame_fill_traffic(const ll_netgame *g, ll_row_set *rows)
{
    link_row all[LL_PLAYERS_MAX];
    for (int i = 0; i < g->config.player_count; i++) {
        fill_messages(g, i, rows);
        all[i] = link_of(g, i);
    }
    ll_row_set_put(rows, &ll_netgame_link_record, all, g->config.player_count);
}
