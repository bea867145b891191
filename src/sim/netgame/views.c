/* What is told of the players' views: M7 to M9, and sections 6 and 8 of session/frame.h. */
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
static void smoothness(cJSON *player, const ll_instruments *in)
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

void ll_netgame_gauge(cJSON *object, const char *name, const ll_gauge *g, double scale)
{
    cJSON *o = cJSON_AddObjectToObject(object, name);
    number(o, "mean", scale * ratio(g->sum, (double)g->count));
    number(o, "min", g->count > 0 ? scale * g->min : NAN);
    number(o, "max", g->count > 0 ? scale * g->max : NAN);
    number(o, "count", (double)g->count);
}

static void buffer(cJSON *player, const ll_instruments *in, const ll_client *client)
{
    cJSON *o = cJSON_AddObjectToObject(player, "buffer");
    number(o, "underruns", (double)in->underruns);
    number(o, "overruns", (double)in->overruns);
    number(o, "held_ratio", ratio((double)in->held_frames, (double)in->frames));
    number(o, "extrapolated_ratio", ratio((double)in->extrapolated_frames, (double)in->frames));
    number(o, "stale_states", (double)client->stale);
    ll_netgame_gauge(o, "depth_states", &in->depth, 1);
    ll_netgame_gauge(o, "delay_ms", &in->delay_ms, 1);
    ll_netgame_gauge(o, "time_scale", &in->time_scale, 1);
}

/* Counted from the start, as the link's own. */
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
static void excursions(cJSON *object, const char *name, const ll_inconsistency *total, double entities,
                       double seconds)
{
    cJSON *o = cJSON_AddObjectToObject(object, name);
    number(o, "sum_m_s_per_min", ratio(total->sum / entities, seconds / 60));
    number(o, "time_ratio", ratio(ll_to_s(total->time) / entities, seconds));
    number(o, "excursions", (double)total->excursions);
}

void ll_netgame_view_metrics(const ll_netgame *g, int player, cJSON *object)
{
    const ll_instruments *in = ll_netgame_instruments(g, player);
    double seconds = ll_to_s(in->measured);
    smoothness(object, in);
    buffer(object, in, ll_netgame_client(g, player));
    dejitter(object, ll_netgame_dejitter(g, player));
    cJSON *o = cJSON_AddObjectToObject(object, "inconsistency");
    excursions(o, "server", &in->server, in->entities, seconds);
    excursions(o, "clients", &in->clients, in->entities, seconds);
}

/* ---- frames ---- */

enum { SECTION_BUFFERS = 6, SECTION_BUFFERED = 8, BUFFERED_MAX = 16 };

typedef struct buffer_record {
    uint8_t player, state;
    uint16_t reserved;
    float delay_ms, behind_ms, time_scale, dejitter_ms;
    uint32_t underruns, overruns, late;
} buffer_record;

typedef struct buffered_record {
    uint8_t player, place;
    uint16_t reserved;
    uint32_t tick;
    float time_ms, sent_ms, arrived_ms, due_ms;
} buffered_record;

_Static_assert(sizeof(buffer_record) == 32 && sizeof(buffered_record) == 24, "the layout of session/frame.h");

static double dejitter_ms(const ll_netgame *g, int player)
{
    bool on = g->config.players[player].dejitter != LL_DEJITTER_NONE;
    return on ? ll_to_ms(ll_dejitter_delay(ll_netgame_dejitter(g, player))) : 0;
}

static buffer_record buffer_of(const ll_netgame *g, int player)
{
    const ll_client *c = ll_netgame_client(g, player);
    const ll_instruments *in = ll_netgame_instruments(g, player);
    bool by_time = c->view_state != LL_VIEW_NEWEST;
    return (buffer_record){.player = (uint8_t)player,
                           .state = c->view_state,
                           .delay_ms = by_time ? (float)ll_to_ms(c->delay) : 0,
                           .behind_ms = by_time ? (float)ll_to_ms(g->now + c->offset - c->render) : 0,
                           .time_scale = by_time ? (float)c->time_scale : 1,
                           .dejitter_ms = (float)dejitter_ms(g, player),
                           .underruns = (uint32_t)in->underruns,
                           .overruns = (uint32_t)in->overruns,
                           .late = (uint32_t)ll_dejitter_get_stats(ll_netgame_dejitter(g, player))->late};
}

/* The states from the one that is drawn, or just passed, to the newest. Returns how many were written. */
static int list_buffered(const ll_netgame *g, int player, buffered_record *records)
{
    ll_client *c = ll_netgame_client(g, player);
    int n = 0;
    for (int64_t i = c->newest - 1 - c->depth; c->newest > 0 && i < c->newest && n < BUFFERED_MAX; i++) {
        const ll_received *state = ll_client_state(c, i);
        ll_time drawn = c->view_state != LL_VIEW_NEWEST ? c->render : state->time;
        float arrived = (float)ll_to_ms(state->arrived - g->now);
        records[n++] = (buffered_record){.player = (uint8_t)player,
                                         .tick = (uint32_t)state->tick,
                                         .time_ms = (float)ll_to_ms(state->time - drawn),
                                         .sent_ms = (float)ll_to_ms(state->time - g->now),
                                         .arrived_ms = arrived,
                                         .due_ms = arrived};
    }
    return n;
}

/* Those that are still held back, in the order of playing. */
static int list_held(const ll_netgame *g, int player, buffered_record *records)
{
    const ll_client *c = ll_netgame_client(g, player);
    const ll_dejitter *buffer = ll_netgame_dejitter(g, player);
    const ll_dejitter_packet *packets = ll_dejitter_packets(buffer);
    ll_time drawn = c->view_state != LL_VIEW_NEWEST ? c->render : c->latest_time;
    int n = 0;
    for (; n < ll_dejitter_depth(buffer) && n < BUFFERED_MAX; n++)
        records[n] = (buffered_record){.player = (uint8_t)player,
                                       .place = 1,
                                       .tick = (uint32_t)packets[n].id,
                                       .time_ms = (float)ll_to_ms(packets[n].sent - drawn),
                                       .sent_ms = (float)ll_to_ms(packets[n].sent - g->now),
                                       .arrived_ms = (float)ll_to_ms(packets[n].arrived - g->now),
                                       .due_ms = (float)ll_to_ms(packets[n].due - g->now)};
    return n;
}

static int list_all_buffered(const ll_netgame *g, buffered_record *records)
{
    int n = 0;
    for (int i = 0; i < g->config.player_count; i++) {
        n += list_buffered(g, i, records + n);
        n += list_held(g, i, records + n);
    }
    return n;
}

void ll_netgame_view_sections(const ll_netgame *g,
                              void (*section)(void *context, int type, int count, const void *bytes,
                                              size_t size),
                              void *context)
{
    buffer_record buffers[LL_PLAYERS_MAX];
    buffered_record buffered[2 * LL_PLAYERS_MAX * BUFFERED_MAX];
    int players = g->config.player_count, n = list_all_buffered(g, buffered);
    for (int i = 0; i < players; i++)
        buffers[i] = buffer_of(g, i);
    section(context, SECTION_BUFFERS, players, buffers, (size_t)players * sizeof buffers[0]);
    section(context, SECTION_BUFFERED, n, buffered, (size_t)n * sizeof buffered[0]);
}

static cJSON *buffer_json(const buffer_record *b)
{
    cJSON *o = cJSON_CreateObject();
    number(o, "player", b->player);
    number(o, "state", b->state);
    number(o, "delay_ms", (double)b->delay_ms);
    number(o, "behind_ms", (double)b->behind_ms);
    number(o, "time_scale", (double)b->time_scale);
    number(o, "dejitter_ms", (double)b->dejitter_ms);
    number(o, "underruns", b->underruns);
    number(o, "overruns", b->overruns);
    number(o, "late", b->late);
    return o;
}

static cJSON *buffered_json(const buffered_record *b)
{
    cJSON *o = cJSON_CreateObject();
    number(o, "player", b->player);
    number(o, "place", b->place);
    number(o, "tick", b->tick);
    number(o, "time_ms", (double)b->time_ms);
    number(o, "sent_ms", (double)b->sent_ms);
    number(o, "arrived_ms", (double)b->arrived_ms);
    number(o, "due_ms", (double)b->due_ms);
    return o;
}

void ll_netgame_view_sections_json(const ll_netgame *g, cJSON *frame)
{
    cJSON *buffers = cJSON_AddArrayToObject(frame, "buffers"),
          *buffered = cJSON_AddArrayToObject(frame, "buffered");
    buffered_record records[2 * LL_PLAYERS_MAX * BUFFERED_MAX];
    int n = list_all_buffered(g, records);
    for (int i = 0; i < g->config.player_count; i++) {
        buffer_record b = buffer_of(g, i);
        cJSON_AddItemToArray(buffers, buffer_json(&b));
    }
    for (int i = 0; i < n; i++)
        cJSON_AddItemToArray(buffered, buffered_json(&records[i]));
}
