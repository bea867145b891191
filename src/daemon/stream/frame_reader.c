#include "daemon/stream/frame_reader.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "record/integers.h"
#include "session/kinds.h"

enum {
    MESSAGE_KIND = 1,
    INFLATED_MOST = 16 << 20,
    INFLATE_STEP = 64 << 10,
    COST_MOST = 64 << 20, /* of a message; that of the largest scene has some megabytes */
};

#define EVENT_NUMBER_MAX (INT64_C(1) << 50)
#define TIME_MOST_S 1e9
#define TICK_HZ_LEAST 0.001
#define TICK_HZ_MOST 1e6

static ll_status bad(const char *what)
{
    return ll_error(LL_BAD_INPUT, "stream: %s", what);
}

/* ---- the records of a kind ---- */

static const ll_sim_kind *kind_named(const char *name)
{
    for (int i = 0; ll_sim_kinds[i]; i++)
        if (strcmp(ll_sim_kinds[i]->name, name) == 0)
            return ll_sim_kinds[i];
    return NULL;
}

static int field_named(const ll_record *record, const char *name)
{
    for (int k = 0; k < record->count; k++)
        if (strcmp(record->fields[k].name, name) == 0)
            return k;
    return -1;
}

static void add_record(ll_frame_reader *reader, const ll_record *record)
{
    LL_ASSERT(reader->count < LL_RECORDS_MAX);
    reader->record[reader->count++] = record;
    reader->of_kind |= (uint16_t)(1U << record->channel);
}

static void forget_rows(ll_frame_reader *reader)
{
    for (int i = 0; i < reader->count; i++) {
        ll_rows_free(reader->rows[i]);
        reader->rows[i] = NULL;
    }
}

void ll_frame_reader_end(ll_frame_reader *reader)
{
    forget_rows(reader);
    free(reader->inflated.bytes);
    *reader = (ll_frame_reader){0};
}

ll_status ll_frame_reader_begin(ll_frame_reader *reader, const char *kind_name, double tick_hz)
{
    const ll_sim_kind *kind = kind_named(kind_name);
    const ll_record *all[LL_ALL_RECORDS_MAX + 1];
    ll_frame_reader_end(reader);
    if (kind == NULL)
        return bad("unknown kind of session");
    if (!(tick_hz >= TICK_HZ_LEAST && tick_hz <= TICK_HZ_MOST))
        return bad("tick_hz out of range");
    ll_all_records(all); /* those of every session come first */
    for (int i = 0; i < LL_OWN_RECORDS; i++)
        add_record(reader, all[i]);
    for (const ll_record *const *record = kind->records; *record; record++)
        add_record(reader, *record);
    const ll_record *events = all[LL_RECORD_EVENTS];
    reader->freq = ll_freq_from_hz(tick_hz);
    reader->begin_field = field_named(events, "begin_s");
    LL_ASSERT(reader->begin_field >= 0);
    reader->begin_bits = events->fields[reader->begin_field].bits;
    return ll_ok();
}

/* ---- bytes ---- */

typedef struct cursor {
    const uint8_t *at, *end;
    bool failed;
} cursor;

static uint64_t varint(cursor *c)
{
    uint64_t value = 0;
    for (int i = 0; i < LL_VARINT_BYTES_MAX && c->at < c->end; i++) {
        uint8_t byte = *c->at++;
        value |= (uint64_t)(byte & 127) << 7 * i;
        if (byte < 128)
            return value;
    }
    c->failed = true;
    return 0;
}

static ll_status inflate_section(ll_buffer *out, const uint8_t *bytes, size_t size)
{
    z_stream z = {.next_in = (Bytef *)(uintptr_t)bytes, .avail_in = (uInt)size};
    int result = inflateInit2(&z, -MAX_WBITS);
    if (result != Z_OK)
        return ll_error(LL_NO_MEMORY, "out of memory: section");
    out->size = 0;
    out->failed = false;
    while (result == Z_OK && out->size < INFLATED_MOST) {
        char *to = ll_buffer_reserve(out, INFLATE_STEP);
        if (to == NULL)
            break;
        z.next_out = (Bytef *)to;
        z.avail_out = INFLATE_STEP;
        result = inflate(&z, Z_NO_FLUSH); /* Z_BUF_ERROR where the bytes end too early */
        out->size += INFLATE_STEP - z.avail_out;
    }
    inflateEnd(&z);
    if (out->failed)
        return ll_error(LL_NO_MEMORY, "out of memory: section");
    return result == Z_STREAM_END && z.avail_in == 0 ? ll_ok() : bad("a section cannot be inflated");
}

/* ---- events ---- */

static int64_t end_of(const ll_rows *log)
{
    return log->first + log->count;
}

/* Where `more` do not follow those that are there, some in between were lost: those before are of no use. */
static ll_status add_events(ll_rows **log, ll_rows *more) /* takes ownership of `more` */
{
    ll_rows *old = *log;
    if (old == NULL || more->first != end_of(old)) {
        ll_rows_free(old);
        *log = more;
        return ll_ok();
    }
    size_t width = (size_t)old->record->count * sizeof *old->values;
    if (old->count + more->count > old->capacity) { /* forgets the oldest */
        int kept = old->count < LL_EVENT_RING ? old->count : LL_EVENT_RING;
        ll_rows *grown = ll_rows_new(old->record, 2 * (kept + more->count));
        if (grown == NULL) {
            ll_rows_free(more);
            return ll_error(LL_NO_MEMORY, "out of memory: events");
        }
        memcpy(grown->values, ll_rows_at(old, old->count - kept), (size_t)kept * width);
        grown->count = kept;
        grown->first = end_of(old) - kept;
        ll_rows_free(old);
        *log = old = grown;
    }
    memcpy(ll_rows_at(old, old->count), more->values, (size_t)more->count * width);
    old->count += more->count;
    ll_rows_free(more);
    return ll_ok();
}

/* Viewers count on numbers that rise. */
static ll_status take_events(ll_rows **log, ll_rows *more, bool whole) /* takes ownership of `more` */
{
    if (end_of(more) > EVENT_NUMBER_MAX || (*log != NULL && end_of(more) < end_of(*log))) {
        ll_rows_free(more);
        return bad("numbers of events must rise");
    }
    if (whole) {
        ll_rows_free(*log);
        *log = NULL;
    }
    return add_events(log, more);
}

/* ---- messages ---- */

static ll_status take_rows(ll_frame_reader *reader, int i, const void *bytes, size_t size, bool whole)
{
    ll_rows *rows = NULL, **have = &reader->rows[i];
    if (!whole && *have == NULL)
        return bad("a section without its base");
    LL_TRY(ll_rows_decode(reader->record[i], whole ? NULL : *have, bytes, size, &rows));
    reader->cost += ll_rows_bytes(rows);
    if (reader->record[i]->form == LL_FORM_LOG)
        return take_events(have, rows, whole);
    ll_rows_free(*have);
    *have = rows;
    return ll_ok();
}

static int index_of(const ll_frame_reader *reader, uint64_t id)
{
    for (int i = 0; i < reader->count; i++)
        if ((uint64_t)reader->record[i]->id == id)
            return i;
    return -1;
}

static ll_status take_section(ll_frame_reader *reader, cursor *c)
{
    uint64_t id = varint(c), head = varint(c);
    if (c->failed || head / 4 > (uint64_t)(c->end - c->at))
        return bad("incomplete section");
    const uint8_t *bytes = c->at;
    size_t size = (size_t)(head / 4);
    int i = index_of(reader, id);
    c->at += size;
    if (i < 0) /* of a version with more records */
        return ll_ok();
    reader->present |= (uint16_t)(1U << reader->record[i]->channel);
    if (head & 1) {
        ll_status status = inflate_section(&reader->inflated, bytes, size);
        reader->cost += reader->inflated.size;
        if (ll_failed(&status))
            return status;
        bytes = (const uint8_t *)reader->inflated.bytes;
        size = reader->inflated.size;
    }
    return take_rows(reader, i, bytes, size, (head & 2) != 0);
}

ll_status ll_frame_reader_take(ll_frame_reader *reader, const void *bytes, size_t size)
{
    cursor c = {bytes, (const uint8_t *)bytes + size, false};
    if (size < 2 || c.at[0] != MESSAGE_KIND)
        return bad("unknown message");
    uint8_t flags = c.at[1];
    c.at += 2;
    uint64_t seq = varint(&c);
    int64_t tick = ll_unzigzag(varint(&c));
    double time_s = (double)tick * 1000 / (double)reader->freq;
    if (c.failed || seq > UINT32_MAX || time_s < -TIME_MOST_S || time_s > TIME_MOST_S)
        return bad("incomplete or invalid head of a frame");
    reader->jumped = !reader->begun || (flags & LL_FRAME_JUMP) != 0;
    reader->begun = true;
    reader->present = 0;
    reader->cost = 0;
    if (reader->jumped)
        forget_rows(reader);
    reader->seq = (uint32_t)seq;
    reader->flags = flags & (uint8_t)~LL_FRAME_JUMP;
    reader->tick = tick;
    while (c.at < c.end) {
        LL_TRY(take_section(reader, &c));
        if (reader->cost > COST_MOST) /* a few bytes can stand for a thousand times as many */
            return bad("a message has more than 64 MiB when it is unpacked");
    }
    return ll_ok();
}

/* ---- frames ---- */

uint16_t ll_frame_reader_channels(const ll_frame_reader *reader)
{
    unsigned lacks = 0;
    for (int i = 0; i < reader->count; i++)
        lacks |= (unsigned)(reader->rows[i] == NULL) << reader->record[i]->channel;
    return (uint16_t)~lacks;
}

bool ll_frame_reader_value(const ll_frame_reader *reader, int record, const char *field, int64_t *value)
{
    const ll_rows *rows = record < reader->count ? reader->rows[record] : NULL;
    int k = rows != NULL && rows->count == 1 ? field_named(rows->record, field) : -1;
    if (k < 0)
        return false;
    *value = ll_rows_at(rows, 0)[k];
    return true;
}

/* The same events as the session itself would choose (records.c), as a part of those that are there. */
static ll_rows wanted_events(const ll_frame_reader *reader, const ll_rows *log,
                             const ll_record_request *request, double time_s)
{
    int64_t end = end_of(log), oldest = log->count > LL_EVENT_RING ? end - LL_EVENT_RING : log->first,
            first = end, recent = end;
    double from = (time_s - LL_EVENTS_NEW_S) * ll_power_of_2(reader->begin_bits);
    if (request->from_event < end)
        first = request->from_event > oldest ? request->from_event : oldest;
    while (request->anew && recent > oldest &&
           (double)ll_rows_at(log, (int)(recent - 1 - log->first))[reader->begin_field] >= from)
        recent--;
    first = recent < first ? recent : first;
    ll_rows part = *log;
    part.values = ll_rows_at(log, (int)(first - log->first));
    part.count = part.capacity = (int)(end - first);
    part.first = first;
    return part;
}

ll_status ll_frame_reader_frame(const ll_frame_reader *reader, const ll_record_request *request, uint32_t seq,
                                uint32_t generation, ll_frame_state *last, ll_row_set *space,
                                ll_frame **frame)
{
    ll_frame_moment moment = {.generation = generation,
                              .flags = reader->flags,
                              .tick = reader->tick,
                              .time_s = ll_to_s(ll_tick_time(reader->tick, reader->freq))};
    ll_rows events;
    ll_row_set_clear(space);
    for (int i = 0; i < reader->count; i++) {
        int at = ll_row_set_add(space, reader->record[i], false);
        if (!(request->channels >> reader->record[i]->channel & 1))
            continue;
        space->rows[at] = reader->rows[i];
        if (reader->record[i]->form == LL_FORM_LOG && reader->rows[i] != NULL) {
            events = wanted_events(reader, reader->rows[i], request, moment.time_s);
            space->rows[at] = &events;
        }
    }
    return ll_frame_of_rows(&moment, request, seq, last, space, frame);
}
