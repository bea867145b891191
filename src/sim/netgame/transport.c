/* Between the messages of a netgame and a player's transport: its links, its timers, and what its observer
 * notes. */
#include "sim/netgame/transport.h"

#include <cjson/cJSON.h>

#include "sim/netgame/parts.h"

#define ANSWERS_HZ 32 /* connects and pings, and their answers */

ll_transport_setup ll_netgame_transport_setup(const ll_netgame_config *c, int up_max, int down_max)
{
    const ll_server_config *server = &c->server;
    return (ll_transport_setup){.kind = server->transport,
                                .delivery = server->delivery,
                                .congestion = server->congestion,
                                .nagle = server->nagle,
                                .flow = {[LL_CLIENT_SIDE] = {c->tick_hz + ANSWERS_HZ, up_max},
                                         [LL_SERVER_SIDE] = {128 + ANSWERS_HZ, down_max}}};
}

/* ---- what the observer notes ---- */

typedef struct watcher {
    ll_netgame_run *run;
    int player;
    ll_packet_tap tap[LL_SIDES]; /* set while packets are recorded */
} watcher;

/* Of the message whose first chunk has this number; NULL: it is no longer known. */
static ll_sent_message *sent_message(ll_transport_metrics *m, int side, int64_t number)
{
    ll_sent_message *sent = &m->sent[side][number & (LL_NETGAME_SENT_RING - 1)];
    return sent->number == number && sent->event.type != 0 ? sent : NULL;
}

static void count_traffic(ll_client_metrics *in, const ll_transport_note *note)
{
    int type = note->type + 1;
    if (note->chunks == 0)
        return;
    in->traffic.packets[type] += note->sending.fragments;
    in->traffic.wire_bytes[type] += note->wire_bytes;
}

/* A packet that was lost, or that repeats what was lost. */
static void record_packet(const watcher *w, const ll_transport_note *note, ll_time now)
{
    bool lost = note->sending.fate != LL_FATE_DELIVERED;
    if (note->chunks == 0 || (!lost && note->resent == 0))
        return;
    uint8_t outcome = (uint8_t)((note->resent > 0 ? LL_SEGMENT_RESENT : 0) |
                                (note->side == LL_CLIENT_SIDE ? LL_SEGMENT_UP : 0));
    ll_netgame_record(w->run->recorder, (ll_event){.type = LL_EVENT_SEGMENT,
                                                   .player = (uint8_t)w->player,
                                                   .fate = (uint8_t)note->sending.fate,
                                                   .outcome = outcome,
                                                   .begin = now,
                                                   .end = lost ? now : note->sending.due,
                                                   .number = (uint32_t)note->number});
}

static void record_message(const watcher *w, ll_transport_metrics *m, const ll_transport_note *note,
                           ll_time now)
{
    bool came = note->event == LL_TRANSPORT_HANDED;
    const ll_sent_message *sent = sent_message(m, note->side, note->number);
    ll_event e =
        sent ? sent->event : (ll_event){.type = (uint8_t)(note->type + 1), .player = (uint8_t)w->player};
    e.begin = note->made;
    e.end = came ? now : note->made;
    e.fate = came ? LL_FATE_DELIVERED : LL_FATE_LOST;
    ll_netgame_record(w->run->recorder, e);
    if (!came || note->complete >= now)
        return;
    ll_netgame_record(w->run->recorder,
                      (ll_event){.type = LL_EVENT_BLOCKED,
                                 .player = (uint8_t)w->player,
                                 .outcome = note->side == LL_CLIENT_SIDE ? LL_SEGMENT_UP : 0,
                                 .begin = note->complete,
                                 .end = now,
                                 .number = e.number});
}

static void watch(void *context, const ll_transport_note *note, ll_time now)
{
    const watcher *w = context;
    ll_client_metrics *in = w->run->seat[w->player].metrics;
    ll_transport_metrics *m = ll_netgame_transport_metrics_of(w->run->game, w->player);
    if (now >= in->from) {
        ll_flow_metrics_add(&m->flow[note->side], note, now);
        if (note->event == LL_TRANSPORT_PACKET)
            count_traffic(in, note);
    }
    const ll_message_head *head = note->bytes;
    bool observed = w->run->observes & LL_OBSERVE_INPUTS;
    if (observed && note->event == LL_TRANSPORT_HANDED && head->type == LL_MESSAGE_INPUT)
        ll_input_history_sent(&in->input_history, head->seq, head->count, now);
    if (!w->run->recorder)
        return;
    if (note->event == LL_TRANSPORT_PACKET)
        record_packet(w, note, now);
    else if (note->event == LL_TRANSPORT_HANDED || note->event == LL_TRANSPORT_LOST)
        record_message(w, m, note, now);
}

static ll_transport_env env_of(watcher *w, ll_netgame_run *run, int player)
{
    ll_netgame_seat *seat = &run->seat[player];
    double timeout_s = run->game->config.server.timeout_s;
    bool tapped = ll_netgame_records_packets(run);
    seat->up_plan.ecn = seat->down_plan.ecn = ll_transport_ecn(run->game->config.server.transport);
    w->run = run;
    w->player = player;
    for (int side = 0; tapped && side < LL_SIDES; side++)
        ll_netgame_tap(run, player, side == LL_CLIENT_SIDE, &w->tap[side]);
    return (ll_transport_env){.link = {seat->up, seat->down},
                              .plan = {tapped ? &w->tap[LL_CLIENT_SIDE].plan : &seat->up_plan,
                                       tapped ? &w->tap[LL_SERVER_SIDE].plan : &seat->down_plan},
                              .timeout = timeout_s > 0 ? (ll_time)(timeout_s * 1e9) : LL_NEVER,
                              .watch = watch,
                              .context = w};
}

/* ---- messages ---- */

bool ll_netgame_transport_send(ll_netgame_run *run, int player, int side, const void *message, int bytes,
                               const ll_event *event)
{
    watcher w;
    ll_transport_env env = env_of(&w, run, player);
    ll_transport *t = run->seat[player].transport;
    ll_transport_metrics *m = ll_netgame_transport_metrics_of(run->game, player);
    int64_t number = ll_transport_next(t, side);
    ll_sent_message *sent = &m->sent[side][number & (LL_NETGAME_SENT_RING - 1)];
    ll_sent_message before = *sent;
    *sent = (ll_sent_message){number, *event};
    if (ll_transport_send(t, &env, side, event->type - 1, message, bytes, run->game->now)) {
        m->flow[side].sent += run->game->now >= run->seat[player].metrics->from;
        return true;
    }
    *sent = before;
    return false;
}

void ll_netgame_transport_arrive(ll_netgame_run *run, int player, int side)
{
    watcher w;
    ll_transport_env env = env_of(&w, run, player);
    ll_transport_arrive(run->seat[player].transport, &env, side, run->game->now);
}

int ll_netgame_transport_take(ll_netgame_run *run, int player, int side, void *message)
{
    watcher w;
    ll_transport_env env = env_of(&w, run, player);
    return ll_transport_take(run->seat[player].transport, &env, side, message, LL_NETGAME_PACKET_MAX,
                             run->game->now);
}

void ll_netgame_transport_settle(ll_netgame_run *run, int player, int side)
{
    watcher w;
    ll_transport_env env = env_of(&w, run, player);
    ll_transport_settle(run->seat[player].transport, &env, side, run->game->now);
}

__attribute__((noinline)) void ll_netgame_transport_timers(ll_netgame_run *run, int player)
{
    watcher w;
    ll_transport_env env = env_of(&w, run, player);
    ll_transport_run_timers(run->seat[player].transport, &env, run->game->now);
}

/* ---- metrics ---- */

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
