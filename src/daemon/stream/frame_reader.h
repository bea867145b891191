/* Reads the binary messages of a stream as a viewer does, and makes frames of what it has read, for viewers
 * of one's own: a relay.
 *
 * All bytes are checked. After an error the stream must be opened again, from ll_frame_reader_begin. */
#pragma once

#include "session/frame.h"

/* Initially all zero. */
typedef struct ll_frame_reader {
    const ll_record *record[LL_RECORDS_MAX]; /* in the order of the frames of the session's kind */
    int count;
    uint16_t of_kind; /* channels of these records */
    ll_freq freq;
    ll_rows *rows[LL_RECORDS_MAX]; /* the newest; NULL: none since the last jump. Of events the last ones */
    int begin_field;               /* of events: when they began; its step is 2^-begin_bits s */
    int begin_bits;
    bool begun;       /* a message was read */
    bool jumped;      /* the last message was the first, or the first after a jump of time */
    uint16_t present; /* channels of the records that it had */
    uint32_t seq;
    uint8_t flags; /* without LL_FRAME_JUMP */
    int64_t tick;
    ll_buffer inflated;
    size_t cost; /* of the last message, also of a refused one: bytes that were inflated, and of rows made */
} ll_frame_reader;

/* For a stream of a session of this kind, before its first message. LL_BAD_INPUT: no such kind or rate. */
ll_status ll_frame_reader_begin(ll_frame_reader *reader, const char *kind, double tick_hz);
void ll_frame_reader_end(ll_frame_reader *reader); /* frees its memory; it is all zero then */

/* Reads the next message. LL_BAD_INPUT, also where a few bytes become far too many; LL_NO_MEMORY. */
ll_status ll_frame_reader_take(ll_frame_reader *reader, const void *bytes, size_t size);

/* Channels of which it has all records; those without a record of the kind among them. */
uint16_t ll_frame_reader_channels(const ll_frame_reader *reader);

/* The integer of a field of a record with one row; false: it has none. */
bool ll_frame_reader_value(const ll_frame_reader *reader, int record, const char *field, int64_t *value);

/* The frame of the last message. `request->channels` must be among those that it has; the other arguments as
 * of ll_frame_take. */
ll_status ll_frame_reader_frame(const ll_frame_reader *reader, const ll_record_request *request, uint32_t seq,
                                uint32_t generation, ll_frame_state *last, ll_row_set *space,
                                ll_frame **frame);
