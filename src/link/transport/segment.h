/* What a packet of a transport contains, for captures: reads what sending.c wrote. Pure. */
#pragma once

#include "link/transport/transport.h"

enum { LL_SEGMENT_BLOCKS_MAX = 3 };

typedef struct ll_segment {
    uint16_t generation; /* of the connection */
    bool acknowledges, reset;
    bool echo, reduced; /* tcp: ECE and CWR */
    int32_t chunks;
    uint32_t number; /* tcp: of the first chunk, or of the next where there is none; others: of the packet */
    uint32_t next;   /* tcp: chunks before it have arrived */
    int32_t blocks;  /* tcp: selective acknowledgements: first chunk, and past the last */
    uint32_t block[LL_SEGMENT_BLOCKS_MAX][2];
    const char *payload; /* the chunks and what stands before each; in the packet */
    int32_t payload_size;
} ll_segment;

typedef struct ll_segment_chunk {
    uint32_t number;
    int32_t type;        /* of its message */
    bool first;          /* of its message */
    const char *bytes;   /* of the message */
    int32_t size, whole; /* bytes; with what stands before them */
} ll_segment_chunk;

/* `kind`: not udp, which has no packets of its own. `bytes` are those of a packet that is not damaged. */
ll_segment ll_segment_read(int kind, const void *bytes, int size);

/* The chunk that begins at byte `*at` of the payload, of which `index` were before it; moves `*at` past it.
 */
ll_segment_chunk ll_segment_chunk_at(int kind, const ll_segment *segment, int index, int *at);
