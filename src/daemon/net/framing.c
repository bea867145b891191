#include "daemon/net/framing.h"

#include <stdio.h>
#include <string.h>

#include <openssl/evp.h>

#include "base/assert.h"

enum { PROTOCOL_ERROR = 1002, NOT_UTF8 = 1007 };

static ll_framing_event fault(ll_framing *f, int code, const char *text)
{
    f->broken = true;
    f->code = code;
    f->fault = text;
    return LL_FRAMING_FAULT;
}

/* ---- incremental UTF-8 ---- */

/* For the first byte of a character: how many bytes follow, and the range of the next (Unicode 15, table
 * 3-7). */
static bool begin_character(ll_framing *f, unsigned char byte)
{
    f->utf8_low = 0x80;
    f->utf8_high = 0xbf;
    if (byte < 0x80)
        f->utf8_left = 0;
    else if (byte >= 0xc2 && byte <= 0xdf)
        f->utf8_left = 1;
    else if (byte >= 0xe0 && byte <= 0xef)
        f->utf8_left = 2;
    else if (byte >= 0xf0 && byte <= 0xf4)
        f->utf8_left = 3;
    else
        return false;
    if (byte == 0xe0)
        f->utf8_low = 0xa0;
    else if (byte == 0xed)
        f->utf8_high = 0x9f;
    else if (byte == 0xf0)
        f->utf8_low = 0x90;
    else if (byte == 0xf4)
        f->utf8_high = 0x8f;
    return true;
}

static bool take_text(ll_framing *f, const unsigned char *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        if (f->utf8_left == 0) {
            if (!begin_character(f, bytes[i]))
                return false;
            continue;
        }
        if (bytes[i] < f->utf8_low || bytes[i] > f->utf8_high)
            return false;
        f->utf8_left--;
        f->utf8_low = 0x80;
        f->utf8_high = 0xbf;
    }
    return true;
}

/* ---- heads ---- */

static bool is_control(ll_opcode opcode)
{
    return (opcode & 8) != 0;
}

static ll_opcode opcode_of(const ll_framing *f)
{
    return (ll_opcode)(f->head[0] & 15);
}

static bool is_final(const ll_framing *f)
{
    return (f->head[0] & 0x80) != 0;
}

/* The protocol error of the first two bytes; NULL: none. */
static const char *first_bytes_error(const ll_framing *f)
{
    ll_opcode opcode = opcode_of(f);
    unsigned length = f->head[1] & 0x7f;
    if ((f->head[0] & 0x70) != 0)
        return "reserved bit set; no extension was negotiated";
    if (opcode > LL_OPCODE_PONG || (opcode > LL_OPCODE_BINARY && opcode < LL_OPCODE_CLOSE))
        return "reserved opcode";
    if ((f->head[1] & 0x80) == 0)
        return "client frame not masked";
    if (is_control(opcode) && (!is_final(f) || length > LL_FRAMING_CONTROL_MAX))
        return "control frame fragmented or longer than 125 bytes";
    if (opcode == LL_OPCODE_CONTINUATION && f->message == 0)
        return "continuation frame without a message";
    if (!is_control(opcode) && opcode != LL_OPCODE_CONTINUATION && f->message != 0)
        return "new message before the end of the previous one";
    return NULL;
}

static int length_bytes(const ll_framing *f)
{
    unsigned length = f->head[1] & 0x7f;
    return length == 127 ? 8 : length == 126 ? 2 : 0;
}

static int head_bytes(const ll_framing *f)
{
    return 2 + length_bytes(f) + 4;
}

/* Called when the head is complete. */
static const char *open_payload(ll_framing *f)
{
    int bytes = length_bytes(f);
    uint64_t length = bytes > 0 ? 0 : f->head[1] & 0x7f;
    for (int i = 0; i < bytes; i++)
        length = length << 8 | f->head[2 + i];
    if ((bytes == 2 && length < 126) || (bytes == 8 && (length < 65536 || length >> 63 != 0)))
        return "frame length not in its shortest form";
    if (opcode_of(f) == LL_OPCODE_TEXT || opcode_of(f) == LL_OPCODE_BINARY) {
        f->message = opcode_of(f);
        f->fresh = true;
        f->utf8_left = 0;
    }
    f->left = length;
    f->masked = 0;
    f->control_size = 0;
    f->in_payload = true;
    return NULL;
}

/* ---- payloads ---- */

/* Whether a close frame may have this code. */
static bool is_close_code(int code)
{
    return (code >= 1000 && code <= 1003) || (code >= 1007 && code <= 1014) || (code >= 3000 && code <= 4999);
}

static ll_framing_event end_control(ll_framing *f)
{
    f->bytes = f->control;
    f->size = (size_t)f->control_size;
    if (opcode_of(f) == LL_OPCODE_PING)
        return LL_FRAMING_PING;
    if (opcode_of(f) == LL_OPCODE_PONG)
        return LL_FRAMING_PONG;
    f->code = f->size == 0 ? LL_FRAMING_NO_CODE : f->size == 1 ? 0 : f->control[0] << 8 | f->control[1];
    if (f->size > 0 && !is_close_code(f->code))
        return fault(f, PROTOCOL_ERROR, "invalid code in a close frame");
    f->utf8_left = 0;
    if (f->size > 2 && (!take_text(f, f->control + 2, f->size - 2) || f->utf8_left > 0))
        return fault(f, NOT_UTF8, "reason of a close frame must be UTF-8");
    f->broken = true; /* no frame may follow */
    return LL_FRAMING_CLOSE;
}

static ll_framing_event end_piece(ll_framing *f, const unsigned char *bytes, size_t size)
{
    f->bytes = bytes;
    f->size = size;
    f->first = f->fresh;
    f->fresh = false;
    f->binary = f->message == LL_OPCODE_BINARY;
    f->last = !f->in_payload && is_final(f);
    if (!f->binary && (!take_text(f, bytes, size) || (f->last && f->utf8_left > 0)))
        return fault(f, NOT_UTF8, "a text message must be UTF-8");
    if (f->last)
        f->message = 0;
    return LL_FRAMING_PIECE;
}

static ll_framing_event take_payload(ll_framing *f, unsigned char *bytes, size_t size, size_t *used)
{
    const unsigned char *mask = f->head + 2 + length_bytes(f);
    size_t taken = f->left < size ? (size_t)f->left : size;
    for (size_t i = 0; i < taken; i++)
        bytes[i] ^= mask[f->masked++ & 3];
    *used += taken;
    f->left -= taken;
    bool ended = f->left == 0, control = is_control(opcode_of(f));
    LL_ASSERT(!control || (size_t)f->control_size + taken <= sizeof f->control); /* the head was checked */
    if (control && taken > 0) {
        memcpy(f->control + f->control_size, bytes, taken);
        f->control_size += (int)taken;
    }
    if (ended) {
        f->in_payload = false;
        f->head_size = 0;
    }
    if (control)
        return ended ? end_control(f) : LL_FRAMING_NONE;
    return ended || taken > 0 ? end_piece(f, bytes, taken) : LL_FRAMING_NONE;
}

ll_framing_event ll_framing_read(ll_framing *f, unsigned char *bytes, size_t size, size_t *used)
{
    if (f->broken)
        *used = size;
    while (*used < size) {
        if (!f->in_payload) {
            const char *wrong = NULL;
            LL_ASSERT(f->head_size < (int)sizeof f->head);
            f->head[f->head_size++] = bytes[(*used)++];
            if (f->head_size == 2)
                wrong = first_bytes_error(f);
            if (!wrong && f->head_size >= 2 && f->head_size == head_bytes(f))
                wrong = open_payload(f);
            if (wrong)
                return fault(f, PROTOCOL_ERROR, wrong);
            if (!f->in_payload)
                continue;
        }
        ll_framing_event event = take_payload(f, bytes + *used, size - *used, used);
        if (event != LL_FRAMING_NONE)
            return event;
    }
    return LL_FRAMING_NONE;
}

/* ---- writing ---- */

size_t ll_framing_put_head(unsigned char *payload, size_t size, ll_opcode opcode)
{
    int bytes = size < 126 ? 0 : size < 65536 ? 2 : 8;
    unsigned char *head = payload - 2 - bytes;
    head[0] = (unsigned char)(0x80 | opcode);
    head[1] = (unsigned char)(bytes == 0 ? size : bytes == 2 ? 126 : 127);
    for (int i = 0; i < bytes; i++)
        head[2 + i] = (unsigned char)((uint64_t)size >> 8 * (bytes - 1 - i));
    return (size_t)(2 + bytes);
}

bool ll_framing_accept(const char *key, char accept[29])
{
    char text[80];
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned digest_size;
    int size = snprintf(text, sizeof text, "%s258EAFA5-E914-47DA-95CA-C5AB0DC85B11", key);
    return size > 0 && (size_t)size < sizeof text &&
           EVP_Digest(text, (size_t)size, digest, &digest_size, EVP_sha1(), NULL) == 1 && digest_size == 20 &&
           EVP_EncodeBlock((unsigned char *)accept, digest, 20) == 28;
}
