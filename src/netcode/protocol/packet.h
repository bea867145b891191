/* A packet between a player and the server, as a capture shows it: the row that ll_recorder's `packet` gets,
 * when the packet is sent. */
#pragma once

#include <stdbool.h>

#include "link/stages/parameters.h"
#include "netcode/protocol/wire.h"

typedef struct ll_packet {
    ll_time sent;
    int32_t player;
    bool up;                       /* to the server */
    const char *name;              /* type of the message, as metrics name it; "packet": of a transport */
    const ll_link_packet *on_link; /* what became of it, and the message or packet that the link got */
    const void *bytes;             /* those of it that this packet contains */
    int32_t size;
} ll_packet;
