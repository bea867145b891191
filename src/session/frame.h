/* A frame: the records of a session at one tick, taken once and shared by all viewers.
 *
 * Binary (`laglab.v2.bin`), numbers as varints (record/buffer.h):
 *
 *   frame     u8 1 | u8 flags (ll_frame_flag) | varint seq | zigzag varint tick | sections
 *   section   varint id of the record | varint 4 * bytes + 2 * whole + deflated | bytes (record/rows.h)
 *
 * A section is whole, or a delta against the section of that record that was sent last. An unchanged section
 * is left out. Sections are deflated (RFC 1951) where that saves enough; all viewers get the same bytes.
 *
 * JSON (`laglab.v2.json`): {"type":"frame","seq","tick","time_s","flags":["playing",...], and for each record
 * that is due, under its name, an array of all its rows; of events those since the last frame}. */
#pragma once

#include <stdatomic.h>

#include "session/records.h"

#define LL_FRAME_HZ 60
#define LL_FRAME_WINDOW 4 /* frames in flight to a viewer that acknowledges */

typedef enum ll_frame_format { LL_FRAME_BINARY, LL_FRAME_JSON } ll_frame_format;

typedef enum ll_frame_flag {
    LL_FRAME_PLAYING = 2,
    LL_FRAME_ENDED = 4,
    LL_FRAME_BEHIND = 8, /* replaying: the log extends beyond this tick */
    LL_FRAME_FAILED = 16,
    LL_FRAME_JUMP = 32, /* time has jumped since the viewer's last frame: all sections are whole */
} ll_frame_flag;

typedef struct ll_encoding ll_encoding;
typedef struct ll_frame ll_frame;

/* The rows of a record, from the first frame that has them. */
typedef struct ll_section {
    ll_frame *home;        /* a small one lies in its first frame, which stays as long; NULL: by itself */
    atomic_int references; /* by itself */
    uint32_t seq;          /* of that frame: record and seq identify the section */
    int users; /* viewers that have it; this and `encodings` are used by the sending thread only */
    uint32_t base, delta_size;
    const char *delta; /* its part of a binary message to who has the section of seq `base`; NULL: not made */
    ll_rows *rows;
    ll_encoding *encodings; /* made since, for viewers that share them */
} ll_section;

void ll_section_retain(ll_section *section);
void ll_section_release(ll_section *section); /* NULL: no effect */

struct ll_frame {
    atomic_int references;
    atomic_int kept_for; /* references to the sections that lie in it */
    uint32_t own;        /* which sections do: bits of their index */
    uint32_t seq, generation;
    uint16_t channels; /* that were requested: bits of ll_channel */
    bool anew;         /* events: those of the last seconds */
    uint8_t flags;
    int64_t tick;
    double time_s;
    int count;
    uint32_t size; /* bytes of it, with its sections */
    const ll_record *record[LL_RECORDS_MAX];
    ll_section *section[LL_RECORDS_MAX]; /* NULL: its channel was not requested */
};

/* The newest section of each record, by the record's index in the session's frames; NULL: none. */
typedef struct ll_frame_state {
    ll_section *section[LL_RECORDS_MAX];
} ll_frame_state;

void ll_frame_state_clear(ll_frame_state *state);

/* Takes the frame of the present tick, with one reference. `last` is what was taken before, and is updated:
 * sections with equal rows are shared. Clear it when time has jumped. Where `request->deltas` is set, a small
 * section is encoded here, next to the rows that it is compared with: another thread would read both from
 * memory. `space` is memory for this call, which the frames of any sessions may use in turn. The session must
 * be awake, and does not change. LL_NO_MEMORY. */
ll_status ll_frame_take(const ll_session *session, const ll_record_request *request, uint32_t seq,
                        ll_frame_state *last, ll_row_set *space, ll_frame **frame);
void ll_frame_retain(ll_frame *frame);
void ll_frame_release(ll_frame *frame);

/* What a viewer gets of a frame. */
typedef struct ll_frame_delivery {
    const ll_frame_state *state; /* what it has */
    uint16_t channels;
    bool jump;   /* time has jumped since its last frame: sends whole sections */
    bool shared; /* keeps the encodings of sections, for other viewers with the same state */
    ll_frame_format format;
} ll_frame_delivery;

/* Appends the message of a frame. Sets buffer->failed without memory. */
void ll_frame_write(const ll_frame *frame, const ll_frame_delivery *to, ll_buffer *buffer);

/* Whether the frame has something in these channels that a viewer with `state` does not have. */
bool ll_frame_news(const ll_frame *frame, const ll_frame_state *state, uint16_t channels);

/* Appends the binary message of the present tick, whole, for who has no stream; its seq is 0. The session
 * must be awake, and does not change. LL_NO_MEMORY. */
ll_status ll_frame_write_whole(const ll_session *session, const ll_record_request *request,
                               ll_buffer *buffer);

/* Hello message of a stream: protocol, hash of the schema, channels, layout, window, present parameters of
 * the scenario. Caller frees. */
char *ll_frame_hello(ll_session *session, const char *session_id, ll_frame_format format);

/* What the next tick and frame of a session will touch, noted at the end of the last, while it is at hand.
 * The sessions of a worker do not fit into its cache: each of some hundred lines comes from memory, one after
 * the other. While one session runs, those of the next are fetched all at once.
 *
 * Addresses are hints: they are never read, and may be stale. */
typedef struct ll_ahead {
    const char *session, *block, *frame;
    uint32_t frame_bytes;
    int count;
    ll_block_range range[LL_BLOCK_RANGES_MAX];
} ll_ahead;

void ll_ahead_note(ll_ahead *ahead, const ll_session *session, const ll_frame *newest);
void ll_ahead_fetch(const ll_ahead *ahead);
