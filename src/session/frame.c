#include "session/frame.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

#include "session/internal.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "frames are written as they lie in memory");

enum { FRAME_TYPE = 1, SECTION_EVENTS = 2 };
enum { FLAG_KEY = 1, FLAG_PLAYING = 2, FLAG_ENDED = 4, FLAG_BEHIND = 8, FLAG_FAILED = 16 };

typedef struct header {
    uint16_t type, flags;
    uint32_t seq;
    double time_s, head_s, duration_s;
    int64_t tick;
    double speed;
    uint64_t wall_ns;
    uint32_t params_version, generation, viewers, sections;
    uint64_t reserved;
} header;

typedef struct wire_event {
    uint32_t id;
    uint8_t type, player, fate, outcome;
    double begin_s, end_s;
    uint32_t number;
    float value;
} wire_event;

typedef struct section_header {
    uint16_t type, count;
    uint32_t bytes;
} section_header;

_Static_assert(sizeof(header) == 80 && sizeof(wire_event) == 32, "the layout of frame.h");

static ll_status reserve(ll_buffer *b, size_t size)
{
    if (b->capacity >= size)
        return ll_ok();
    size_t capacity = size + size / 2;
    char *bytes = realloc(b->bytes, capacity);
    if (!bytes)
        return ll_error(LL_NO_MEMORY, "no memory for a frame");
    b->bytes = bytes;
    b->capacity = capacity;
    return ll_ok();
}

static ll_status append(ll_buffer *b, const void *bytes, size_t size)
{
    ll_status status = reserve(b, b->size + size);
    if (ll_failed(&status))
        return status;
    memcpy(b->bytes + b->size, bytes, size);
    b->size += size;
    return status;
}

/* ---- events ---- */

/* The first event of the window: of a key frame the last seconds, otherwise the last few ticks. */
static uint32_t first_event(const ll_session *s, bool key)
{
    uint32_t end = s->event_count,
             first = end - s->event_base > LL_EVENT_RING ? end - LL_EVENT_RING : s->event_base;
    ll_time now = ll_tick_time(s->tick, s->freq);
    double frame_s = s->speed > 1 ? s->speed / 60 : 1.0 / 60;
    ll_time window = key ? (ll_time)(LL_FRAME_WINDOW_S * 1e9) : (ll_time)(LL_FRAME_REPEAT * frame_s * 1e9);
    uint32_t i = end;
    while (i > first && s->events[(i - 1) % LL_EVENT_RING].begin >= now - window)
        i--;
    return i;
}

static wire_event wire(const ll_event *e)
{
    return (wire_event){e->id,           e->type,   e->player, e->fate, e->outcome, ll_to_s(e->begin),
                        ll_to_s(e->end), e->number, e->value};
}

static ll_status append_events(ll_session *s, bool key, ll_buffer *b)
{
    uint32_t first = first_event(s, key), count = s->event_count - first;
    section_header h = {SECTION_EVENTS, (uint16_t)count, count * (uint32_t)sizeof(wire_event)};
    ll_status status = append(b, &h, sizeof h);
    if (!ll_failed(&status))
        status = reserve(b, b->size + h.bytes);
    if (ll_failed(&status))
        return status;
    for (uint32_t i = first; i != s->event_count; i++) {
        wire_event e = wire(&s->events[i % LL_EVENT_RING]);
        memcpy(b->bytes + b->size, &e, sizeof e);
        b->size += sizeof e;
    }
    return status;
}

/* ---- binary ---- */

typedef struct sections {
    ll_buffer *buffer;
    ll_status status;
    uint32_t count;
} sections;

static void add_section(void *context, int type, int count, const void *bytes, size_t size)
{
    sections *all = context;
    section_header h = {(uint16_t)type, (uint16_t)count, (uint32_t)size};
    if (!ll_failed(&all->status))
        all->status = append(all->buffer, &h, sizeof h);
    if (!ll_failed(&all->status))
        all->status = append(all->buffer, bytes, size);
    all->count++;
}

static uint16_t flags(const ll_session *s, bool key)
{
    return (uint16_t)((key ? FLAG_KEY : 0) | (s->status == LL_SESSION_PLAYING ? FLAG_PLAYING : 0) |
                      (s->status == LL_SESSION_ENDED ? FLAG_ENDED : 0) |
                      (s->tick < s->head ? FLAG_BEHIND : 0) |
                      (s->status == LL_SESSION_FAILED ? FLAG_FAILED : 0));
}

static header header_of(const ll_session *s, bool key, uint32_t seq, uint64_t wall_ns, uint32_t viewers)
{
    return (header){
        .type = FRAME_TYPE,
        .flags = flags(s, key),
        .seq = seq,
        .time_s = ll_to_s(ll_tick_time(s->tick, s->freq)),
        .head_s = ll_to_s(ll_tick_time(s->head, s->freq)),
        .duration_s = ll_to_s(ll_tick_time(s->end, s->freq)),
        .tick = s->tick,
        .speed = s->speed,
        .wall_ns = wall_ns,
        .params_version = s->params_version,
        .generation = s->generation,
        .viewers = viewers,
    };
}

static ll_status encode_binary(ll_session *s, const header *h, bool key, ll_buffer *b)
{
    b->size = 0;
    sections all = {b, append(b, h, sizeof *h), 1};
    s->scenario.kind->sections(s->block, add_section, &all);
    if (ll_failed(&all.status))
        return all.status;
    ll_status status = append_events(s, key, b);
    if (!ll_failed(&status))
        memcpy(b->bytes + offsetof(header, sections), &all.count, sizeof all.count);
    return status;
}

/* ---- JSON ---- */

static ll_status encode_json(ll_session *s, const header *h, bool key, ll_buffer *b)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "type", "frame");
    cJSON_AddNumberToObject(o, "flags", h->flags);
    cJSON_AddNumberToObject(o, "seq", h->seq);
    cJSON_AddNumberToObject(o, "time_s", h->time_s);
    cJSON_AddNumberToObject(o, "head_s", h->head_s);
    cJSON_AddNumberToObject(o, "duration_s", h->duration_s);
    cJSON_AddNumberToObject(o, "tick", (double)h->tick);
    cJSON_AddNumberToObject(o, "speed", h->speed);
    cJSON_AddNumberToObject(o, "wall_ns", (double)h->wall_ns);
    cJSON_AddNumberToObject(o, "params_version", h->params_version);
    cJSON_AddNumberToObject(o, "generation", h->generation);
    cJSON_AddNumberToObject(o, "viewers", h->viewers);
    s->scenario.kind->sections_json(s->block, o);
    cJSON *events = cJSON_AddArrayToObject(o, "events");
    for (uint32_t i = first_event(s, key); i != s->event_count; i++) {
        wire_event e = wire(&s->events[i % LL_EVENT_RING]);
        cJSON *item = cJSON_CreateObject();
        cJSON_AddNumberToObject(item, "id", e.id);
        cJSON_AddNumberToObject(item, "type", e.type);
        cJSON_AddNumberToObject(item, "player", e.player);
        cJSON_AddNumberToObject(item, "fate", e.fate);
        cJSON_AddNumberToObject(item, "outcome", e.outcome);
        cJSON_AddNumberToObject(item, "begin_s", e.begin_s);
        cJSON_AddNumberToObject(item, "end_s", e.end_s);
        cJSON_AddNumberToObject(item, "number", e.number);
        cJSON_AddNumberToObject(item, "value", (double)e.value);
        cJSON_AddItemToArray(events, item);
    }
    char *text = cJSON_PrintUnformatted(o);
    cJSON_Delete(o);
    b->size = 0;
    ll_status status = text ? append(b, text, strlen(text)) : ll_error(LL_NO_MEMORY, "no memory for a frame");
    cJSON_free(text);
    return status;
}

ll_status ll_frame_encode(ll_session *s, ll_frame_format format, bool key, uint32_t seq, uint64_t wall_ns,
                          uint32_t viewers, ll_buffer *buffer)
{
    ll_status status = ll_session_wake(s);
    if (ll_failed(&status))
        return status;
    header h = header_of(s, key, seq, wall_ns, viewers);
    return format == LL_FRAME_BINARY ? encode_binary(s, &h, key, buffer) : encode_json(s, &h, key, buffer);
}

char *ll_frame_hello(ll_session *s, const char *session_id, ll_frame_format format)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "type", "hello");
    cJSON_AddStringToObject(o, "protocol", "laglab.v1");
    cJSON_AddStringToObject(o, "format", format == LL_FRAME_BINARY ? "bin" : "json");
    cJSON_AddStringToObject(o, "session", session_id);
    cJSON_AddNumberToObject(o, "window", LL_FRAME_WINDOW);
    cJSON_AddNumberToObject(o, "frame_hz", 60);
    cJSON_AddNumberToObject(o, "tick_hz", (double)s->freq / 1000);
    cJSON_AddNumberToObject(o, "duration_s", ll_to_s(ll_tick_time(s->end, s->freq)));
    cJSON_AddItemToObject(o, "params", ll_param_write(s->scenario.kind->table, s->config));
    cJSON_AddItemToObject(o, "layout", s->scenario.kind->layout(s->config));
    char *text = cJSON_PrintUnformatted(o);
    cJSON_Delete(o);
    return text;
}
