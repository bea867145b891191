/* Reports of the players' views: inconsistency, smoothness and buffers, and their buffers, streamed. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stddef.h>

#include "base/detmath.h"
#include "sim/netgame/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    ll_netgame_number(object, name, value);
}

static double ratio(double a, double b)
{
    return ll_netgame_ratio(a, b);
}

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
    cJSON *o = cJSON_AddObjectToObject(player, "smoothness");
    number(o, "acceleration_rms_mps2", ll_sqrt(ratio(sum.acceleration, frames)));
    number(o, "jerk_rms_mps3", ll_sqrt(ratio(sum.jerk, frames)));
    number(o, "freeze_ratio", ratio((double)sum.frozen, moving));
    number(o, "reversals_per_s", ratio((double)sum.reversals, sum.seconds));
    number(o, "hitches", (double)sum.hitches);
    number(o, "step_max_m", frames > 0 ? sum.step_max : NAN);
    number(o, "step_max_over_mean", ratio(sum.step_max, ratio(sum.truth_step_sum, moving)));
    ll_summary animation = ll_histogram_summary(&in->animation_error);
    cJSON *error = cJSON_AddObjectToObject(o, "animation_error_px");
    number(error, "rms", in->pixel_m > 0 ? animation.rms : NAN);
    number(error, "p99", in->pixel_m > 0 ? animation.p99 : NAN);
    number(error, "count", (double)animation.count);
}

void ll_netgame_running_stats(cJSON *object, const char *name, const ll_running_stats *g, double scale)
{
    cJSON *o = cJSON_AddObjectToObject(object, name);
    number(o, "mean", scale * ratio(g->sum, (double)g->count));
    number(o, "min", g->count > 0 ? scale * g->min : NAN);
    number(o, "max", g->count > 0 ? scale * g->max : NAN);
    number(o, "count", (double)g->count);
}

static void buffer(cJSON *player, const ll_client_metrics *in, const ll_client *client)
{
    cJSON *o = cJSON_AddObjectToObject(player, "buffer");
    number(o, "underruns", (double)in->underruns);
    number(o, "overruns", (double)in->overruns);
    number(o, "held_ratio", ratio((double)in->held_frames, (double)in->frames));
    number(o, "extrapolated_ratio", ratio((double)in->extrapolated_frames, (double)in->frames));
    number(o, "stale_states", (double)client->stale);
    ll_netgame_running_stats(o, "depth_states", &in->depth, 1);
    ll_netgame_running_stats(o, "delay_ms", &in->delay_ms, 1);
    ll_netgame_running_stats(o, "time_scale", &in->time_scale, 1);
}

/* Counted from the start, as the link's own counters. */
static void dejitter(cJSON *player, const ll_dejitter *buffer)
{
    const ll_dejitter_stats *s = ll_dejitter_get_stats(buffer);
    double held = (double)(s->pushed - s->overflowed);
    cJSON *o = cJSON_AddObjectToObject(player, "dejitter");
    number(o, "states", (double)s->pushed);
    number(o, "late", (double)s->late);
    number(o, "late_ratio", ratio((double)s->late, held));
    number(o, "underruns", (double)s->underruns);
    number(o, "overflowed", (double)s->overflowed);
    number(o, "delay_ms", ll_to_ms(ll_dejitter_delay(buffer)));
    number(o, "added_mean_ms", ratio(s->added_sum_ms, held));
    number(o, "added_max_ms", s->added_max_ms);
    number(o, "depth_mean", ratio((double)s->depth_sum, held));
    number(o, "depth_max", (double)s->depth_max);
}

/* The mean of all entities. */
static void episodes(cJSON *object, const char *name, const ll_inconsistency *total, double entities,
                     double seconds)
{
    cJSON *o = cJSON_AddObjectToObject(object, name);
    number(o, "sum_m_s_per_min", ratio(total->sum / entities, seconds / 60));
    number(o, "time_ratio", ratio(ll_to_s(total->time) / entities, seconds));
    number(o, "excursions", (double)total->episodes);
}

void ll_netgame_view_metrics(const ll_netgame *g, int player, cJSON *object)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    double seconds = ll_to_s(in->measured);
    smoothness(object, in);
    buffer(object, in, ll_netgame_client(g, player));
    dejitter(object, ll_netgame_dejitter(g, player));
    cJSON *o = cJSON_AddObjectToObject(object, "inconsistency");
    episodes(o, "server", &in->server, in->entities, seconds);
    episodes(o, "clients", &in->clients, in->entities, seconds);
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

const ll_record ll_netgame_buffer_record = {
    .id = 6,
    .name = "buffers",
    .channel = LL_CHANNEL_GAUGES,
    .help = "The interpolation buffer and the de-jitter buffer of each player's view.",
    .form = LL_FORM_BY_INDEX,
    LL_ROWS_OF(buffer_row, buffer_fields)};

static double dejitter_ms(const ll_netgame *g, int player)
{
    bool on = g->config.players[player].dejitter != LL_DEJITTER_NONE;
    return on ? ll_to_ms(ll_dejitter_delay(ll_netgame_dejitter(g, player))) : 0;
}

/* Without interpolation the newest snapshot is drawn. */
static ll_time drawn_time(const ll_client *c)
{
    return c->view_state != LL_VIEW_NEWEST ? c->render : c->latest_time;
}

static buffer_row buffer_of(const ll_netgame *g, int player)
{
    const ll_client *c = ll_netgame_client(g, player);
    const ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    bool by_time = c->view_state != LL_VIEW_NEWEST;
    return (buffer_row){.player = (uint8_t)player,
                        .state = c->view_state,
                        .delay_ms = by_time ? (float)ll_to_ms(c->delay) : 0,
                        .behind_ms = by_time ? (float)ll_to_ms(g->now + c->offset - c->render) : 0,
                        .time_scale = by_time ? (float)c->time_scale : 1,
                        .dejitter_ms = (float)dejitter_ms(g, player),
                        .underruns = (uint32_t)in->underruns,
                        .overruns = (uint32_t)in->overruns,
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
    for (int64_t i = c->newest - 1 - c->depth; c->newest > 0 && i < c->newest && n < BUFFERED_MAX; i++) {
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
