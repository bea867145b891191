/* A frame: the records of a session at one tick, taken once and shared by all who look.
 *
 * Binary (`laglab.v2.bin`), numbers as varints (record/buffer.h):
 *
 *   frame     u8 1 | u8 flags (ll_frame_flag) | varint seq | zigzag varint tick | sections
 *   section   varint id of the record | varint 4 * bytes + 2 * whole + deflated | bytes (record/rows.h)
 *
 * A section is a delta against the one of that record that was sent last, or whole; one that has not changed
 * is left out. A deflated one (RFC 1951) is so where that pays, for all alike.
 *
 * JSON (`laglab.v2.json`): {"type":"frame","seq","tick","time_s","flags":["playing",...], and by the name of
 * each record that is due an array of its rows, whole; of events those since the last frame}. */
#pragma once

#include <stdatomic.h>

#include "session/records.h"

#define LL_FRAME_HZ 60
#define LL_FRAME_WINDOW 4 /* frames in flight to a viewer that acknowledges */

typedef enum ll_frame_format { LL_FRAME_BINARY, LL_FRAME_JSON } ll_frame_format;

typedef enum ll_frame_flag {
    LL_FRAME_PLAYING = 2,
    LL_FRAME_ENDED = 4,
    LL_FRAME_BEHIND = 8, /* replaying: the log goes further */
    LL_FRAME_FAILED = 16,
    LL_FRAME_JUMP = 32, /* time has jumped since the viewer's last frame: all is sent whole */
} ll_frame_flag;

typedef struct ll_encoding ll_encoding;

/* The rows of a record, from the first frame that has them on. */
typedef struct ll_section {
    atomic_int references;
    uint32_t seq; /* of that frame: with the record it names the section */
    int users;    /* viewers that have it; used by the thread that sends, as the next */
    ll_rows *rows;
    ll_encoding *encodings; /* that were made of it */
} ll_section;

void ll_section_retain(ll_section *section);
void ll_section_release(ll_section *section); /* NULL: nothing */

typedef struct ll_frame {
    atomic_int references;
    uint32_t seq, generation;
    uint16_t channels; /* that were asked for: bits of ll_channel */
    bool anew;         /* events: of the last seconds */
    uint8_t flags;
    int64_t tick;
    double time_s;
    int count;
    const ll_record *record[LL_RECORDS_MAX];
    ll_section *section[LL_RECORDS_MAX]; /* NULL: of a channel that was not asked for */
} ll_frame;

/* The section of each record that came last, by its place in the session's frames; NULL: none. */
typedef struct ll_frame_state {
    ll_section *section[LL_RECORDS_MAX];
} ll_frame_state;

void ll_frame_state_clear(ll_frame_state *state);

/* Takes the present tick; one reference. `last` is what was taken before, and is renewed: rows that are as
 * they were are shared with it; clear it when time has jumped. The session must be awake, and stays as it is.
 * LL_NO_MEMORY. */
ll_status ll_frame_take(const ll_session *session, const ll_record_request *request, uint32_t seq,
                        ll_frame_state *last, ll_frame **frame);
void ll_frame_retain(ll_frame *frame);
void ll_frame_release(ll_frame *frame);

/* Appends the message of a frame for a viewer that has `state`, of the records whose channels are set. Each
 * encoding is made once for all that have the same. Sets buffer->failed without memory. */
void ll_frame_write(const ll_frame *frame, const ll_frame_state *state, uint16_t channels, bool jump,
                    ll_frame_format format, ll_buffer *buffer);

/* Whether there is something in these channels that a viewer with `state` has not got. */
bool ll_frame_news(const ll_frame *frame, const ll_frame_state *state, uint16_t channels);

/* The first message of a stream: protocol, schema's hash, channels, layout, window, the scenario's present
 * params. Caller frees. */
char *ll_frame_hello(ll_session *session, const char *session_id, ll_frame_format format);
