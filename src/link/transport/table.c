/* The tables of this room: protocols, delivery classes, congestion controls. */
#include "link/transport/core.h"

#define NAMED(ID, NAME) #NAME,
const char *const ll_transport_names[LL_TRANSPORT_KINDS + 1] = {LL_TRANSPORTS(NAMED) NULL};
const char *const ll_delivery_names[LL_DELIVERY_CLASSES + 1] = {LL_DELIVERIES(NAMED) NULL};
const char *const ll_congestion_names[LL_CONGESTION_KINDS + 1] = {LL_CONGESTIONS(NAMED) NULL};

#define PROTOCOL(ID, NAME) &ll_protocol_##NAME,
static const ll_protocol *const protocols[LL_TRANSPORT_KINDS] = {LL_TRANSPORTS(PROTOCOL)};

/* Has no state and no packets of its own. */
const ll_protocol ll_protocol_udp = {.deliveries = 1 << LL_DELIVERY_USUAL | 1 << LL_DELIVERY_UNRELIABLE,
                                     .usual = LL_DELIVERY_UNRELIABLE};

const ll_protocol *ll_protocol_of(int kind)
{
    return protocols[kind];
}

bool ll_transport_plain(int kind)
{
    return !protocols[kind]->write_ack;
}

bool ll_transport_delivers(int kind, int delivery)
{
    return protocols[kind]->deliveries >> delivery & 1;
}

uint32_t ll_transport_ecn(int kind)
{
    return protocols[kind]->ecn ? 1 + (uint32_t)offsetof(ll_packet_head, flags) : 0;
}

/* `usual` is replaced by one of the others before. */
const ll_delivery_class *ll_delivery_of(const ll_transport *t)
{
    static const ll_delivery_class classes[LL_DELIVERY_CLASSES] = {
        [LL_DELIVERY_SEQUENCED] = {.sequenced = true},
        [LL_DELIVERY_UNORDERED] = {.reliable = true},
        [LL_DELIVERY_BY_TYPE] = {.reliable = true, .by_type = true},
        [LL_DELIVERY_ORDERED] = {.reliable = true, .ordered = true}};
    return &classes[t->delivery];
}
