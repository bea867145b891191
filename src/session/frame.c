#include "session/frame.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/prefetch.h"
#include "session/internal.h"
#include "session/section.h"

static uint8_t flags_of(const ll_session *s)
{
    return (uint8_t)((s->status == LL_SESSION_PLAYING ? LL_FRAME_PLAYING : 0) |
                     (s->status == LL_SESSION_ENDED ? LL_FRAME_ENDED : 0) |
                     (s->tick < s->head ? LL_FRAME_BEHIND : 0) |
                     (s->status == LL_SESSION_FAILED ? LL_FRAME_FAILED : 0));
}

/* Whether the section equals the rows, or has all of their events. */
static bool is_unchanged(const ll_section *section, const ll_rows *rows)
{
    if (section == NULL)
        return false;
    const ll_rows *old = section->rows;
    if (rows->record->form == LL_FORM_LOG)
        return old->first + old->count == rows->first + rows->count && old->first <= rows->first;
    return ll_rows_equal(old, rows);
}

/* ---- references ---- */

static void free_frame(ll_frame *frame)
{
    for (int i = 0; i < frame->count; i++)
        if (frame->own >> i & 1)
            ll_section_drop_encodings(frame->section[i]);
    free(frame);
}

/* The frame itself counts as one that keeps its memory, in addition to `kept_for`. */
static void keep_less(ll_frame *frame)
{
    if (atomic_fetch_sub_explicit(&frame->kept_for, 1, memory_order_acq_rel) == 0)
        free_frame(frame);
}

void ll_section_retain(ll_section *section)
{
    atomic_int *count = section->home != NULL ? &section->home->kept_for : &section->references;
    atomic_fetch_add_explicit(count, 1, memory_order_relaxed);
}

void ll_section_release(ll_section *section)
{
    if (section == NULL)
        return;
    if (section->home != NULL) {
        keep_less(section->home);
    } else if (atomic_fetch_sub_explicit(&section->references, 1, memory_order_acq_rel) == 1) {
        ll_section_drop_encodings(section);
        free(section);
    }
}

void ll_frame_retain(ll_frame *frame)
{
    atomic_fetch_add_explicit(&frame->references, 1, memory_order_relaxed);
}

void ll_frame_release(ll_frame *frame)
{
    if (frame == NULL || atomic_fetch_sub_explicit(&frame->references, 1, memory_order_acq_rel) != 1)
        return;
    for (int i = 0; i < frame->count; i++)
        if (!(frame->own >> i & 1))
            ll_section_release(frame->section[i]);
    keep_less(frame);
}

void ll_frame_state_clear(ll_frame_state *state)
{
    for (int i = 0; i < LL_RECORDS_MAX; i++)
        ll_section_release(state->section[i]);
    *state = (ll_frame_state){0};
}

/* ---- taking ---- */

/* A section that is large lies by itself: in a frame it would keep the others' memory, or they its. */
enum { SMALL_BYTES = 4096 };

typedef enum place { NOWHERE, SHARED, IN_FRAME, BY_ITSELF } place;

/* Where the sections of a frame that is taken will be, and what those have in it. */
typedef struct layout {
    place place[LL_RECORDS_MAX];
    size_t at[LL_RECORDS_MAX], delta[LL_RECORDS_MAX],
        delta_size[LL_RECORDS_MAX]; /* delta: in `space->bytes` */
    size_t size;
} layout;

static size_t aligned(size_t size)
{
    return (size + 15) / 16 * 16;
}

static place place_of(const ll_rows *rows, const ll_section *last)
{
    return rows == NULL                              ? NOWHERE
           : is_unchanged(last, rows)                ? SHARED
           : ll_rows_copy_bytes(rows) <= SMALL_BYTES ? IN_FRAME
                                                     : BY_ITSELF;
}

/* Differences of planes are large, and deflated: only who needs them makes them. */
static void encode_delta(layout *l, int i, const ll_rows *rows, const ll_section *last, ll_row_set *space)
{
    l->delta[i] = space->bytes.size;
    if (last != NULL && rows->record->form != LL_FORM_GRID)
        ll_section_encode(rows, last->rows, &space->bytes);
    l->delta_size[i] = space->bytes.size - l->delta[i];
}

static void lay_out(layout *l, const ll_record_request *request, const ll_frame_state *last,
                    ll_row_set *space)
{
    space->bytes.size = 0;
    l->size = aligned(sizeof(ll_frame));
    for (int i = 0; i < space->count; i++) {
        l->place[i] = place_of(space->rows[i], last->section[i]);
        l->delta_size[i] = 0;
        if (l->place[i] != IN_FRAME)
            continue;
        if (request->deltas)
            encode_delta(l, i, space->rows[i], last->section[i], space);
        l->at[i] = l->size;
        l->size += aligned(ll_section_bytes(space->rows[i]) + l->delta_size[i]);
    }
    space->failed = space->failed || space->bytes.failed;
    space->bytes.failed = false;
}

static void put_own(ll_frame *frame, int i, const layout *l, const ll_row_set *space, const ll_section *last)
{
    char *at = (char *)frame + l->at[i];
    ll_section *section = ll_section_put(at, frame, space->rows[i], frame->seq);
    frame->section[i] = section;
    frame->own |= 1U << i;
    if (l->delta_size[i] == 0)
        return;
    char *delta = at + ll_section_bytes(space->rows[i]);
    memcpy(delta, space->bytes.bytes + l->delta[i], l->delta_size[i]);
    section->delta = delta;
    section->delta_size = (uint32_t)l->delta_size[i];
    section->base = last->seq;
}

/* False without memory. */
static bool put_section(ll_frame *frame, int i, const layout *l, const ll_row_set *space, ll_section **last)
{
    if (l->place[i] == NOWHERE)
        return true;
    if (l->place[i] == SHARED)
        frame->section[i] = *last;
    else if (l->place[i] == BY_ITSELF)
        frame->section[i] = ll_section_new(space->rows[i], frame->seq);
    else
        put_own(frame, i, l, space, *last);
    if (frame->section[i] == NULL)
        return false;
    if (l->place[i] != BY_ITSELF) /* a new one has a reference, the frame's */
        ll_section_retain(frame->section[i]);
    return true;
}

static void keep_as_last(const ll_frame *frame, const layout *l, ll_frame_state *last)
{
    for (int i = 0; i < frame->count; i++) {
        if (l->place[i] != IN_FRAME && l->place[i] != BY_ITSELF)
            continue;
        ll_section_release(last->section[i]);
        last->section[i] = frame->section[i];
        if (l->place[i] == BY_ITSELF)
            ll_section_retain(last->section[i]);
    }
}

ll_status ll_frame_take(const ll_session *s, const ll_record_request *request, uint32_t seq,
                        ll_frame_state *last, ll_row_set *space, ll_frame **result)
{
    layout l;
    ll_row_set_clear(space);
    ll_session_fill(s, request, space);
    lay_out(&l, request, last, space);
    ll_frame *frame = space->failed ? NULL : malloc(l.size);
    if (frame == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: frame");
    *frame = (ll_frame){.seq = seq,
                        .generation = s->generation,
                        .channels = request->channels,
                        .anew = request->anew,
                        .flags = flags_of(s),
                        .tick = s->tick,
                        .time_s = ll_to_s(ll_tick_time(s->tick, s->freq)),
                        .count = space->count,
                        .size = (uint32_t)l.size};
    atomic_init(&frame->references, 1);
    bool whole = true;
    for (int i = 0; i < space->count; i++) {
        frame->record[i] = space->record[i];
        whole = put_section(frame, i, &l, space, &last->section[i]) && whole;
    }
    if (!whole) {
        for (int i = 0; i < frame->count; i++)
            if (frame->own >> i & 1)
                ll_section_release(frame->section[i]); /* that was for `last` */
        ll_frame_release(frame);
        return ll_error(LL_NO_MEMORY, "out of memory: frame");
    }
    keep_as_last(frame, &l, last);
    *result = frame;
    return ll_ok();
}

/* ---- writing ---- */

static bool is_due(const ll_frame *frame, int i, uint16_t channels)
{
    return frame->section[i] != NULL && channels >> frame->record[i]->channel & 1;
}

bool ll_frame_news(const ll_frame *frame, const ll_frame_state *state, uint16_t channels)
{
    for (int i = 0; i < frame->count; i++)
        if (is_due(frame, i, channels) && frame->section[i] != state->section[i])
            return true;
    return false;
}

static void put_json_head(const ll_frame *frame, uint8_t flags, ll_buffer *buffer)
{
    static const char *const names[] = {"", "playing", "ended", "behind", "failed", "jump"};
    char text[160], time[32];
    const char *between = "";
    ll_number_text(frame->time_s, time);
    snprintf(text, sizeof text,
             "{\"type\":\"frame\",\"seq\":%" PRIu32 ",\"tick\":%" PRId64 ",\"time_s\":%s,\"flags\":[",
             frame->seq, frame->tick, time);
    ll_buffer_text(buffer, text);
    for (int bit = 1; bit < 6; bit++) {
        if (!(flags >> bit & 1))
            continue;
        snprintf(text, sizeof text, "%s\"%s\"", between, names[bit]);
        ll_buffer_text(buffer, text);
        between = ",";
    }
    ll_buffer_text(buffer, "]");
}

static void put_head(const ll_frame *frame, uint8_t flags, ll_frame_format format, ll_buffer *buffer)
{
    const char start[] = {1, (char)flags};
    if (format == LL_FRAME_JSON) {
        put_json_head(frame, flags, buffer);
        return;
    }
    ll_buffer_add(buffer, start, sizeof start);
    ll_buffer_varint(buffer, frame->seq);
    ll_buffer_varint(buffer, ll_zigzag(frame->tick));
}

void ll_frame_write(const ll_frame *frame, const ll_frame_delivery *to, ll_buffer *buffer)
{
    put_head(frame, (uint8_t)(frame->flags | (to->jump ? LL_FRAME_JUMP : 0)), to->format, buffer);
    for (int i = 0; i < frame->count; i++) {
        const ll_section *base = to->jump ? NULL : to->state->section[i];
        if (is_due(frame, i, to->channels) && (to->format == LL_FRAME_JSON || base != frame->section[i]))
            ll_section_write(frame->section[i], base, to->format, to->shared, buffer);
    }
    if (to->format == LL_FRAME_JSON)
        ll_buffer_text(buffer, "}");
}

ll_status ll_frame_write_whole(const ll_session *s, const ll_record_request *request, ll_buffer *buffer)
{
    ll_row_set set = {0};
    ll_session_fill(s, request, &set);
    put_head(&(ll_frame){.tick = s->tick}, flags_of(s), LL_FRAME_BINARY, buffer);
    for (int i = 0; i < set.count; i++)
        if (set.rows[i] != NULL)
            ll_section_encode(set.rows[i], NULL, buffer);
    bool failed = set.failed || buffer->failed;
    ll_row_set_free(&set);
    return failed ? ll_error(LL_NO_MEMORY, "out of memory: frame") : ll_ok();
}

/* ---- hello message ---- */

static void add_channels(cJSON *hello, const ll_sim_kind *kind)
{
    cJSON *list = cJSON_AddArrayToObject(hello, "channels");
    const ll_record *all[LL_ALL_RECORDS_MAX + 1];
    uint32_t own = 0;
    ll_all_records(all);
    for (int i = 0; i < LL_OWN_RECORDS; i++)
        own |= 1U << all[i]->channel;
    for (const ll_record *const *record = kind->records; *record; record++)
        own |= 1U << (*record)->channel;
    for (int c = 0; c < LL_CHANNELS; c++) {
        if (!(own >> c & 1))
            continue;
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "name", ll_channels[c].name);
        cJSON_AddNumberToObject(o, "max_hz", LL_FRAME_HZ);
        cJSON_AddItemToArray(list, o);
    }
}

char *ll_frame_hello(ll_session *s, const char *session_id, ll_frame_format format)
{
    char hash[17];
    cJSON *o = cJSON_CreateObject();
    snprintf(hash, sizeof hash, "%016" PRIx64, ll_stream_schema_hash());
    cJSON_AddStringToObject(o, "type", "hello");
    cJSON_AddStringToObject(o, "protocol", "laglab.v2");
    cJSON_AddStringToObject(o, "format", format == LL_FRAME_BINARY ? "bin" : "json");
    cJSON_AddStringToObject(o, "schema", hash);
    cJSON_AddStringToObject(o, "session", session_id);
    cJSON_AddNumberToObject(o, "window", LL_FRAME_WINDOW);
    cJSON_AddNumberToObject(o, "frame_hz", LL_FRAME_HZ);
    cJSON_AddNumberToObject(o, "tick_hz", (double)s->freq / 1000);
    cJSON_AddNumberToObject(o, "duration_s", ll_to_s(ll_tick_time(s->end, s->freq)));
    add_channels(o, s->scenario.kind);
    cJSON_AddItemToObject(o, "params", ll_param_write(s->scenario.kind->table, s->config));
    cJSON_AddNumberToObject(o, "params_version", s->params_version);
    cJSON_AddItemToObject(o, "layout", s->scenario.kind->layout(s->config));
    char *text = cJSON_PrintUnformatted(o);
    cJSON_Delete(o);
    return text;
}

/* ---- what comes next ---- */

enum { AHEAD_BYTES = 8192 }; /* of the newest frame, which holds the rows of the last */

void ll_ahead_note(ll_ahead *ahead, const ll_session *s, const ll_frame *newest)
{
    ahead->session = (const char *)s;
    ahead->block = s->block;
    ahead->frame = (const char *)newest;
    ahead->frame_bytes = newest->size < AHEAD_BYTES ? newest->size : AHEAD_BYTES;
    ahead->count = s->scenario.kind->touches ? s->scenario.kind->touches(s->block, ahead->range) : 0;
}

void ll_ahead_fetch(const ll_ahead *ahead)
{
    if (ahead->session == NULL)
        return;
    ll_prefetch(ahead->session, sizeof(ll_session));
    ll_prefetch(ahead->frame, ahead->frame_bytes);
    for (int i = 0; i < ahead->count; i++)
        ll_prefetch(ahead->block + (size_t)ahead->range[i].line * LL_LINE,
                    (size_t)ahead->range[i].count * LL_LINE);
}
