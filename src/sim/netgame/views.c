/* Reports of the players' views: inconsistency, smoothness and buffers, and their buffers, streamed. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stddef.h>

#include "base/detmath.h"
#include "record/integers.h"
#include "sim/netgame/netgame.h"

static double ratio(double a, double b)
{
    return ll_netgame_ratio(a, b);
}

#define SMOOTHNESS(X)                                                                                        \
    X(number, acceleration_rms_mps2, "m/s^2", ll_sqrt(ratio(sum.acceleration, frames)),                      \
      "root mean square of the acceleration of drawn positions", "No frame was counted.")                    \
    X(number, jerk_rms_mps3, "m/s^3", ll_sqrt(ratio(sum.jerk, frames)),                                      \
      "root mean square of the jerk (change of acceleration per second) of drawn positions",                 \
      "No frame was counted.")                                                                               \
    X(number, freeze_ratio, NULL, ratio((double)sum.frozen, moving),                                         \
      "share of frames in which the drawn position does not move, among the frames in which the ground "     \
      "truth moves",                                                                                         \
      "No frame in which the ground truth moves was counted.")                                               \
    X(number, reversals_per_s, "1/s", ratio((double)sum.reversals, sum.seconds),                             \
      "reversals of the drawn motion per second: steps in the direction opposite to the step before",        \
      "No frame was counted.")                                                                               \
    X(events, hitches, NULL, sum.hitches,                                                                    \
      "hitches: an entity is drawn in the same place for more than 2 frames in a row, while the ground "     \
      "truth is elsewhere than when the drawn position last moved; a longer pause counts once",              \
      NULL)                                                                                                  \
    X(number, step_max_m, "m", frames > 0 ? sum.step_max : NAN,                                              \
      "largest distance that a drawn position moves between two frames", "No frame was counted.")            \
    X(number, step_max_over_mean, NULL, ratio(sum.step_max, ratio(sum.truth_step_sum, moving)),              \
      "largest distance that a drawn position moves between two frames, divided by the mean distance that "  \
      "the ground truth moves",                                                                              \
      "No frame in which the ground truth moves was counted.")

#define ANIMATION(X)                                                                                         \
    X(number, rms, "px", in->corrections.pixel_m > 0 ? animation.rms : NAN,                                  \
      "root mean square of the animation error", "The scene has no width, or no frame was counted.")         \
    X(number, p99, "px", in->corrections.pixel_m > 0 ? animation.p99 : NAN,                                  \
      "99th percentile of the animation error", "The scene has no width, or no frame was counted.")          \
    X(count, count, NULL, animation.count,                                                                   \
      "values of the animation error: one per frame and other entity, from the entity's second frame on",    \
      NULL)

const ll_metric_table ll_netgame_smoothness_table = {
    LL_OF_PLAYERS(".smoothness"),
    .help = "Smoothness of the drawn positions of other entities, from warmup_s on: each frame and entity, "
            "from the entity's fourth frame on.",
    LL_METRICS_FROM(SMOOTHNESS)};

const ll_metric_table ll_netgame_animation_table = {
    LL_OF_PLAYERS(".smoothness.animation_error_px"),
    .help = "Animation error of other entities: |drawn step since the previous frame - drawn velocity times "
            "the time since then|.",
    LL_METRICS_FROM(ANIMATION)};

/* Over all entities of others together. */
static void smoothness(cJSON *player, const ll_client_metrics *in)
{
    ll_smoothness sum = {0};
    for (int i = 0; i < in->entities; i++) {
        const ll_smoothness *s = &in->track[i].smooth;
        sum.acceleration += s->acceleration;
        sum.jerk += s->jerk;
        sum.frames += s->frames;
        sum.seconds += s->seconds;
        sum.moving += s->moving;
        sum.frozen += s->frozen;
        sum.reversals += s->reversals;
        sum.hitches += s->hitches;
        sum.step_max = s->step_max > sum.step_max ? s->step_max : sum.step_max;
        sum.truth_step_sum += s->truth_step_sum;
    }
    double frames = (double)sum.frames, moving = (double)sum.moving;
    ll_summary animation = ll_histogram_summary(&in->animation_error);
    cJSON *o = cJSON_AddObjectToObject(player, "smoothness");
    LL_METRICS_PUT(o, &ll_netgame_smoothness_table, SMOOTHNESS);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "animation_error_px"), &ll_netgame_animation_table, ANIMATION);
}

#define BUFFER(X)                                                                                            \
    X(events, underruns, NULL, in->buffer.underruns, "times that the interpolation buffer became empty",     \
      NULL)                                                                                                  \
    X(events, overruns, NULL, in->buffer.overruns,                                                           \
      "times that the interpolation buffer was so full that the render time jumped", NULL)                   \
    X(number, held_ratio, NULL, ratio((double)in->buffer.held_frames, (double)in->buffer.frames),            \
      "share of frames that repeat the frame before", "No frame was drawn.")                                 \
    X(number, extrapolated_ratio, NULL,                                                                      \
      ratio((double)in->buffer.extrapolated_frames, (double)in->buffer.frames),                              \
      "share of frames that draw other entities by extrapolation", "No frame was drawn.")                    \
    X(count, stale_states, NULL, client->snapshots.stale,                                                    \
      "snapshots that the client dropped because it had them or newer ones; counted from time 0 on", NULL)   \
    X(gauge, depth_states, NULL, ll_netgame_gauge(&in->buffer.depth, 1),                                     \
      "snapshots in the interpolation buffer that are newer than the drawn one", "No frame was drawn.")      \
    X(gauge, delay_ms, "ms", ll_netgame_gauge(&in->buffer.delay_ms, 1),                                      \
      "interpolation delay: newest server time that the client could know less the render time",             \
      "No frame was drawn.")                                                                                 \
    X(gauge, time_scale, NULL, ll_netgame_gauge(&in->buffer.time_scale, 1),                                  \
      "rate of the render time: seconds of it per second of virtual time; 0 while it is held, 1 where it "   \
      "jumps",                                                                                               \
      "No frame was drawn.")

const ll_metric_table ll_netgame_interpolation_table = {
    LL_OF_PLAYERS(".buffer"), .help = "The interpolation buffer, from warmup_s on.", LL_METRICS_FROM(BUFFER)};

static void buffer(cJSON *player, const ll_client_metrics *in, const ll_client *client)
{
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "buffer"), &ll_netgame_interpolation_table, BUFFER);
}

#define DEJITTER(X)                                                                                          \
    X(count, states, NULL, s->pushed, "snapshots that arrived at the de-jitter buffer", NULL)                \
    X(count, late, NULL, s->late,                                                                            \
      "snapshots that arrived at the de-jitter buffer after the time of their play-out", NULL)               \
    X(number, late_ratio, NULL, ratio((double)s->late, held),                                                \
      "share of late snapshots among those that the de-jitter buffer did not drop",                          \
      "No snapshot entered the de-jitter buffer.")                                                           \
    X(events, underruns, NULL, s->underruns,                                                                 \
      "late snapshots that arrived while the de-jitter buffer was empty", NULL)                              \
    X(count, overflowed, NULL, s->overflowed, "snapshots dropped because the de-jitter buffer was full",     \
      NULL)                                                                                                  \
    X(number, delay_ms, "ms", ll_to_ms(ll_dejitter_delay(buffer)),                                           \
      "delay that the de-jitter buffer uses now", NULL)                                                      \
    X(number, added_mean_ms, "ms", ratio(s->added_sum_ms, held),                                             \
      "mean delay that the de-jitter buffer added to a snapshot",                                            \
      "No snapshot entered the de-jitter buffer.")                                                           \
    X(number, added_max_ms, "ms", s->added_max_ms,                                                           \
      "longest delay that the de-jitter buffer added to a snapshot", NULL)                                   \
    X(number, depth_mean, NULL, ratio((double)s->depth_sum, held),                                           \
      "mean number of snapshots in the de-jitter buffer after an arrival",                                   \
      "No snapshot entered the de-jitter buffer.")                                                           \
    X(count, depth_max, NULL, s->depth_max, "largest number of snapshots in the de-jitter buffer", NULL)

const ll_metric_table ll_netgame_dejitter_table = {
    LL_OF_PLAYERS(".dejitter"), .help = "The de-jitter buffer, from time 0 on.", LL_METRICS_FROM(DEJITTER)};

static void dejitter(cJSON *player, const ll_dejitter *buffer)
{
    const ll_dejitter_stats *s = ll_dejitter_get_stats(buffer);
    double held = (double)(s->pushed - s->overflowed);
    LL_METRICS_PUT(cJSON_AddObjectToObject(player, "dejitter"), &ll_netgame_dejitter_table, DEJITTER);
}

#define EXCURSIONS(X)                                                                                        \
    X(number, sum_m_s_per_min, "m s/min", ratio(total->sum / entities, seconds / 60),                        \
      "distance during divergence episodes, integrated over time, per minute; mean of the entities",         \
      "No frame was drawn.")                                                                                 \
    X(number, time_ratio, NULL, ratio(ll_to_s(total->time) / entities, seconds),                             \
      "share of time in divergence episodes, mean of the entities", "No frame was drawn.")                   \
    X(count, episodes, NULL, total->episodes, "divergence episodes of all entities", NULL)

const ll_metric_table ll_netgame_excursion_table = {
    LL_OF_PLAYERS(".inconsistency.*"),
    .help = "Divergence episodes: an entity is drawn more than 0.1 m away for at least 0.1 s. server: away "
            "from the ground truth now, own entity included. clients: away from the farthest drawn position "
            "of the entity at any other client that has it.",
    LL_METRICS_FROM(EXCURSIONS)};

static void episodes(cJSON *o, const ll_inconsistency *total, double entities, double seconds)
{
    LL_METRICS_PUT(o, &ll_netgame_excursion_table, EXCURSIONS);
}

void ll_netgame_view_metrics(const ll_netgame *g, int player, cJSON *object)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    double seconds = ll_to_s(in->measured);
    smoothness(object, in);
    buffer(object, in, ll_netgame_client(g, player));
    dejitter(object, ll_netgame_dejitter(g, player));
    cJSON *o = cJSON_AddObjectToObject(object, "inconsistency");
    episodes(cJSON_AddObjectToObject(o, "server"), &in->server, in->entities, seconds);
    episodes(cJSON_AddObjectToObject(o, "clients"), &in->clients, in->entities, seconds);
}

/* ---- the buffers, streamed ---- */

enum { BUFFERED_MAX = 16 /* per buffer */ };

typedef struct buffer_row {
    uint8_t player, state;
    float delay_ms, behind_ms, time_scale, dejitter_ms;
    uint32_t underruns, overruns, late;
    double drawn_s;
} buffer_row;

static const char *const view_states[] = {"newest",  "normal",        "catching_up", "slowing",
                                          "starved", "extrapolating", NULL};

static const ll_record_field buffer_fields[] = {
    LL_INT(buffer_row, player, NULL, "index of the player"),
    LL_ENUM(buffer_row, state, view_states,
            "newest: draws the newest snapshot; starved: held, the buffer is empty"),
    LL_STEP(buffer_row, delay_ms, LL_BITS_MS, "ms",
            "interpolation delay in use; 0 when the newest snapshot is drawn"),
    LL_STEP(buffer_row, behind_ms, LL_BITS_MS, "ms", "newest time that could be known, minus render time"),
    LL_STEP(buffer_row, time_scale, LL_BITS_RATIO, NULL, "rate of render time"),
    LL_STEP(buffer_row, dejitter_ms, LL_BITS_MS, "ms", "delay of the de-jitter buffer in use; 0: off"),
    LL_INT(buffer_row, underruns, NULL, "times that it ran empty"),
    LL_INT(buffer_row, overruns, NULL, "times that it was too full"),
    LL_INT(buffer_row, late, NULL, "packets too late for the de-jitter buffer"),
    LL_STEP(buffer_row, drawn_s, LL_BITS_S, "s", "render time"),
};

LL_INTEGERS(buffer_integers, buffer_row, buffer_fields)

const ll_record ll_netgame_buffer_record = {
    .id = 6,
    .name = "buffers",
    .channel = LL_CHANNEL_GAUGES,
    .help = "The interpolation buffer and the de-jitter buffer of each player's view.",
    .form = LL_FORM_BY_INDEX,
    LL_ROWS_OF(buffer_row, buffer_fields),
    .integers = buffer_integers};

static double dejitter_ms(const ll_netgame *g, int player)
{
    bool on = g->config.players[player].dejitter != LL_DEJITTER_NONE;
    return on ? ll_to_ms(ll_dejitter_delay(ll_netgame_dejitter(g, player))) : 0;
}

/* Without interpolation the newest snapshot is drawn. */
static ll_time drawn_time(const ll_client *c)
{
    return c->view.state != LL_VIEW_NEWEST ? c->view.render : c->latest.time;
}

static buffer_row buffer_of(const ll_netgame *g, int player)
{
    const ll_client *c = ll_netgame_client(g, player);
    const ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    bool by_time = c->view.state != LL_VIEW_NEWEST;
    return (buffer_row){.player = (uint8_t)player,
                        .state = c->view.state,
                        .delay_ms = by_time ? (float)ll_to_ms(c->view.delay) : 0,
                        .behind_ms = by_time ? (float)ll_to_ms(g->now + c->view.offset - c->view.render) : 0,
                        .time_scale = by_time ? (float)c->drawing.time_scale : 1,
                        .dejitter_ms = (float)dejitter_ms(g, player),
                        .underruns = (uint32_t)in->buffer.underruns,
                        .overruns = (uint32_t)in->buffer.overruns,
                        .late = (uint32_t)ll_dejitter_get_stats(ll_netgame_dejitter(g, player))->late,
                        .drawn_s = ll_to_s(drawn_time(c))};
}

void ll_netgame_fill_buffers(const ll_netgame *g, ll_row_set *rows)
{
    buffer_row all[LL_PLAYERS_MAX];
    for (int i = 0; i < g->config.player_count; i++)
        all[i] = buffer_of(g, i);
    ll_row_set_put(rows, &ll_netgame_buffer_record, all, g->config.player_count);
}

/* ---- and the snapshots in them ---- */

typedef struct buffered_row {
    uint8_t player, place;
    uint32_t tick;
    double time_s, arrived_s, due_s;
} buffered_row;

static const char *const places[] = {"snapshot", "dejitter", NULL};

static const ll_record_field buffered_fields[] = {
    LL_INT(buffered_row, player, NULL, "index of the player"),
    LL_ENUM(buffered_row, place, places, "buffer"),
    LL_INT(buffered_row, tick, NULL, "the server's, of the snapshot"),
    LL_STEP(buffered_row, time_s, LL_BITS_S, "s", "server time of the snapshot, when it was sent"),
    LL_STEP(buffered_row, arrived_s, LL_BITS_S, "s", "when it arrived"),
    LL_STEP(buffered_row, due_s, LL_BITS_S, "s", "when the de-jitter buffer plays it out"),
};

const ll_record ll_netgame_buffered_record = {
    .id = 10,
    .name = "buffered",
    .channel = LL_CHANNEL_BUFFERED,
    .help = "Snapshots in these buffers, at most 16 per buffer, from the one that is drawn on.",
    .form = LL_FORM_KEYED,
    .keys = 3,
    LL_ROWS_OF(buffered_row, buffered_fields)};

/* The snapshots from the one that is drawn, or just passed, to the newest. */
static int list_buffered(const ll_netgame *g, int player, buffered_row *rows)
{
    ll_client *c = ll_netgame_client(g, player);
    int n = 0;
    for (int64_t i = c->snapshots.received - 1 - c->drawing.depth;
         c->snapshots.received > 0 && i < c->snapshots.received && n < BUFFERED_MAX; i++) {
        const ll_snapshot_entry *state = ll_client_state(c, i);
        rows[n++] = (buffered_row){.player = (uint8_t)player,
                                   .tick = (uint32_t)state->tick,
                                   .time_s = ll_to_s(state->time),
                                   .arrived_s = ll_to_s(state->arrived),
                                   .due_s = ll_to_s(state->arrived)};
    }
    return n;
}

/* Snapshots that are still held back. */
static int list_held(const ll_netgame *g, int player, buffered_row *rows)
{
    const ll_dejitter *buffer = ll_netgame_dejitter(g, player);
    const ll_dejitter_packet *packets = ll_dejitter_packets(buffer);
    int n = 0;
    for (; n < ll_dejitter_depth(buffer) && n < BUFFERED_MAX; n++)
        rows[n] = (buffered_row){.player = (uint8_t)player,
                                 .place = 1,
                                 .tick = (uint32_t)packets[n].id,
                                 .time_s = ll_to_s(packets[n].sent),
                                 .arrived_s = ll_to_s(packets[n].arrived),
                                 .due_s = ll_to_s(packets[n].due)};
    return n;
}

void ll_netgame_fill_buffered(const ll_netgame *g, ll_row_set *rows)
{
    buffered_row all[BUFFERED_MAX];
    for (int i = 0; i < g->config.player_count; i++) {
        ll_row_set_put(rows, &ll_netgame_buffered_record, all, list_buffered(g, i, all));
        ll_row_set_put(rows, &ll_netgame_buffered_record, all, list_held(g, i, all));
    }
}
