/* Writes capture files of packets, for Wireshark and its like: the pcapng format
 * (draft-ietf-opsawg-pcapng), little-endian, one section, times in ns. No allocation. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LL_PCAPNG_COMMENT_MAX 200 /* longest comment, bytes; a longer one is cut */

/* Where the blocks go, in order. */
typedef struct ll_pcapng {
    void (*write)(void *context, const char *bytes, size_t length);
    void *context;
} ll_pcapng;

/* A packet that begins with its IPv4 header. */
typedef struct ll_pcapng_packet {
    uint32_t interface; /* in the order of ll_pcapng_interface, from 0 */
    bool inbound;       /* received at that interface; false: sent from it */
    uint64_t time_ns;   /* since 1970 */
    const void *bytes;
    uint32_t size;
    const char *comment; /* NULL: none */
} ll_pcapng_packet;

/* First the section, then its interfaces, then the packets. Texts are UTF-8. */
void ll_pcapng_begin(const ll_pcapng *file, const char *application, const char *comment);
void ll_pcapng_interface(const ll_pcapng *file, const char *name);
void ll_pcapng_packet_write(const ll_pcapng *file, const ll_pcapng_packet *packet);
