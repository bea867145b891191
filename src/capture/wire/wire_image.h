/* What a packet of a netgame is on a wire: its headers and bytes, and a comment on what it contains. */
#pragma once

#include "base/status.h"
#include "capture/format/pcapng.h"
#include "netcode/protocol/packet.h"

typedef struct ll_wire ll_wire; /* what the headers depend on: numbers of packets, places in streams */

typedef struct ll_wire_image {
    uint8_t *bytes; /* from the IPv4 header on; the caller frees them */
    uint32_t size;
    char comment[LL_PCAPNG_COMMENT_MAX];
} ll_wire_image;

ll_wire *ll_wire_new(void); /* NULL without memory */
void ll_wire_free(ll_wire *wire);

/* Takes all packets of a session from its start, in the order of sending. LL_NO_MEMORY; LL_CONFLICT: a TCP
 * segment that the link splits. */
ll_status ll_wire_image_of(ll_wire *wire, const ll_packet *packet, ll_wire_image *image);

/* A packet arrives undamaged; before all packets that are sent later. */
void ll_wire_arrived(ll_wire *wire, int32_t transport, int player, bool up, const uint8_t *bytes);
