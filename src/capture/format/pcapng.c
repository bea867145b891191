#include "capture/format/pcapng.h"

#include <string.h>

#include "base/assert.h"

enum { SECTION = 0x0A0D0D0A, INTERFACE = 1, ENHANCED_PACKET = 6 };
enum { BYTE_ORDER_MAGIC = 0x1A2B3C4D, VERSION_MAJOR = 1, VERSION_MINOR = 0 };
enum { LINKTYPE_RAW = 101 }; /* packets begin with an IP header */
enum { OPTION_END = 0, OPTION_COMMENT = 1, SECTION_APPLICATION = 4, INTERFACE_NAME = 2 };
enum { INTERFACE_RESOLUTION = 9, NANOSECONDS = 9, PACKET_FLAGS = 2, FLAG_INBOUND = 1, FLAG_OUTBOUND = 2 };
enum { FRAME = 12 }; /* type and length before a block's body, its length again after it */
enum { BODY_MAX = 20 + 3 * (4 + LL_PCAPNG_COMMENT_MAX) + 12 };

/* A block without the bytes of its packet. */
typedef struct block {
    char bytes[BODY_MAX];
    size_t size;
} block;

static void put(block *b, uint64_t value, size_t size)
{
    LL_ASSERT(b->size + size <= sizeof b->bytes);
    for (size_t i = 0; i < size; i++)
        b->bytes[b->size++] = (char)(value >> (8 * i));
}

static size_t padding(size_t length)
{
    return (4 - (length & 3)) & 3;
}

/* The longest beginning of at most `most` bytes that does not cut a character of UTF-8. */
static size_t cut(const char *text, size_t most)
{
    size_t length = strlen(text);
    if (length <= most)
        return length;
    while (most > 0 && ((unsigned char)text[most] & 0xC0) == 0x80)
        most--;
    return most;
}

static void put_text(block *b, uint16_t option, const char *text)
{
    size_t length = text ? cut(text, LL_PCAPNG_COMMENT_MAX) : 0;
    if (length == 0)
        return;
    put(b, option, 2);
    put(b, length, 2);
    memcpy(b->bytes + b->size, text, length);
    b->size += length;
    put(b, 0, padding(length));
}

static void put_end(block *b)
{
    put(b, OPTION_END, 2);
    put(b, 0, 2);
}

static void write_number(const ll_pcapng *file, uint32_t value)
{
    block b = {.size = 0};
    put(&b, value, 4);
    file->write(file->context, b.bytes, b.size);
}

/* A block: `head`, then the bytes of a packet, if any, then `tail`. */
static void write_block(const ll_pcapng *file, uint32_t type, const block *head,
                        const ll_pcapng_packet *packet, const block *tail)
{
    static const char zeros[3];
    size_t size = packet ? packet->size : 0;
    uint32_t total = (uint32_t)(FRAME + head->size + size + padding(size) + tail->size);
    write_number(file, type);
    write_number(file, total);
    file->write(file->context, head->bytes, head->size);
    if (packet)
        file->write(file->context, packet->bytes, size);
    file->write(file->context, zeros, padding(size));
    file->write(file->context, tail->bytes, tail->size);
    write_number(file, total);
}

void ll_pcapng_begin(const ll_pcapng *file, const char *application, const char *comment)
{
    block head = {.size = 0}, options = {.size = 0};
    put(&head, BYTE_ORDER_MAGIC, 4);
    put(&head, VERSION_MAJOR, 2);
    put(&head, VERSION_MINOR, 2);
    put(&head, UINT64_MAX, 8); /* the length of the section is not given */
    put_text(&options, OPTION_COMMENT, comment);
    put_text(&options, SECTION_APPLICATION, application);
    put_end(&options);
    write_block(file, SECTION, &head, NULL, &options);
}

void ll_pcapng_interface(const ll_pcapng *file, const char *name)
{
    block head = {.size = 0}, options = {.size = 0};
    put(&head, LINKTYPE_RAW, 2);
    put(&head, 0, 2);
    put(&head, 0, 4); /* packets are whole */
    put_text(&options, INTERFACE_NAME, name);
    put(&options, INTERFACE_RESOLUTION, 2);
    put(&options, 1, 2);
    put(&options, NANOSECONDS, 4); /* one byte and its padding */
    put_end(&options);
    write_block(file, INTERFACE, &head, NULL, &options);
}

void ll_pcapng_packet_write(const ll_pcapng *file, const ll_pcapng_packet *packet)
{
    block head = {.size = 0}, options = {.size = 0};
    put(&head, packet->interface, 4);
    put(&head, packet->time_ns >> 32, 4);
    put(&head, packet->time_ns & UINT32_MAX, 4);
    put(&head, packet->size, 4); /* captured, and as it was */
    put(&head, packet->size, 4);
    put_text(&options, OPTION_COMMENT, packet->comment);
    put(&options, PACKET_FLAGS, 2);
    put(&options, 4, 2);
    put(&options, packet->inbound ? FLAG_INBOUND : FLAG_OUTBOUND, 4);
    put_end(&options);
    write_block(file, ENHANCED_PACKET, &head, packet, &options);
}
