#include "session/frame.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session/internal.h"
#include "session/section.h"

/* ---- taking a frame ---- */

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

/* Makes a section of the rows, or shares the last section if it equals them. NULL without memory. */
static ll_section *take_rows(const ll_rows *rows, uint32_t seq, ll_section **last)
{
    if (!is_unchanged(*last, rows)) {
        ll_section_release(*last);
        *last = ll_section_new(rows, seq);
    }
    if (*last != NULL)
        ll_section_retain(*last);
    return *last;
}

void ll_frame_state_clear(ll_frame_state *state)
{
    for (int i = 0; i < LL_RECORDS_MAX; i++)
        ll_section_release(state->section[i]);
    *state = (ll_frame_state){0};
}

ll_status ll_frame_take(const ll_session *s, const ll_record_request *request, uint32_t seq,
                        ll_frame_state *last, ll_row_set *space, ll_frame **result)
{
    ll_frame *frame = calloc(1, sizeof *frame);
    if (frame == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: frame");
    *frame = (ll_frame){.seq = seq,
                        .generation = s->generation,
                        .channels = request->channels,
                        .anew = request->anew,
                        .flags = flags_of(s),
                        .tick = s->tick,
                        .time_s = ll_to_s(ll_tick_time(s->tick, s->freq))};
    atomic_init(&frame->references, 1);
    ll_row_set_clear(space);
    ll_session_fill(s, request, space);
    bool failed = space->failed;
    frame->count = space->count;
    for (int i = 0; i < space->count; i++) {
        frame->record[i] = space->record[i];
        if (space->rows[i] == NULL || failed)
            continue;
        frame->section[i] = take_rows(space->rows[i], seq, &last->section[i]);
        failed = frame->section[i] == NULL;
    }
    if (failed) {
        ll_frame_release(frame);
        return ll_error(LL_NO_MEMORY, "out of memory: frame");
    }
    *result = frame;
    return ll_ok();
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
        ll_section_release(frame->section[i]);
    free(frame);
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
    cJSON_AddItemToObject(o, "layout", s->scenario.kind->layout(s->config));
    char *text = cJSON_PrintUnformatted(o);
    cJSON_Delete(o);
    return text;
}
