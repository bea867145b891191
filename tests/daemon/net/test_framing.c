/* RFC 6455 on the server side: random messages compared with a naive writer, in pieces of any
 * size; all refusals with their codes; UTF-8 compared with a naive decoder. No sockets. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "base/rng.h"
#include "daemon/net/framing.h"

static uint64_t drawn;

static uint32_t draw(uint32_t below)
{
    return (uint32_t)(ll_rng_u64(71, 3, drawn++) % below);
}

/* A masked frame, as a client writes it; returns its size. */
static size_t put_frame(unsigned char *to, int first_byte, const void *payload, size_t size)
{
    size_t at = 0;
    to[at++] = (unsigned char)first_byte;
    if (size < 126) {
        to[at++] = (unsigned char)(0x80 | size);
    } else if (size < 65536) {
        to[at++] = 0x80 | 126;
        to[at++] = (unsigned char)(size >> 8);
        to[at++] = (unsigned char)size;
    } else {
        to[at++] = 0x80 | 127;
        for (int i = 7; i >= 0; i--)
            to[at++] = (unsigned char)((uint64_t)size >> 8 * i);
    }
    unsigned char mask[4];
    for (int i = 0; i < 4; i++)
        to[at++] = mask[i] = (unsigned char)draw(256);
    for (size_t i = 0; i < size; i++)
        to[at++] = ((const unsigned char *)payload)[i] ^ mask[i % 4];
    return at;
}

/* What was read, as one text: "t" or "b" and the message, "i" and "o" and the payload of a ping or pong. */
typedef struct heard {
    char text[400000];
    size_t size;
} heard;
static heard expected, told;

static void note(heard *h, char kind, const void *bytes, size_t size)
{
    if (kind != 0)
        h->text[h->size++] = kind;
    memcpy(h->text + h->size, bytes, size);
    h->size += size;
}

/* Copies the bytes to an allocation of their exact size, so that the sanitizer detects an over-read. */
static ll_framing_event feed(ll_framing *f, const unsigned char *bytes, size_t size)
{
    unsigned char *copy = malloc(size > 0 ? size : 1);
    memcpy(copy, bytes, size);
    size_t used = 0;
    ll_framing_event event = LL_FRAMING_NONE, last = LL_FRAMING_NONE;
    while (used < size && last != LL_FRAMING_FAULT && last != LL_FRAMING_CLOSE) {
        event = ll_framing_read(f, copy, size, &used);
        if (event == LL_FRAMING_PIECE)
            note(&told, f->first ? (f->binary ? 'b' : 't') : 0, f->bytes, f->size);
        else if (event == LL_FRAMING_PING || event == LL_FRAMING_PONG)
            note(&told, event == LL_FRAMING_PING ? 'i' : 'o', f->bytes, f->size);
        last = event != LL_FRAMING_NONE ? event : last;
    }
    free(copy);
    return last;
}

static void test_random_messages(void **state)
{
    (void)state;
    static unsigned char stream[600000];
    for (int trial = 0; trial < 300; trial++) {
        ll_framing f = {0};
        size_t size = 0;
        expected.size = told.size = 0;
        for (int message = 0; message < 5; message++) {
            static const uint32_t sizes[] = {2, 126, 127, 300, 70000};
            size_t left = draw(sizes[draw(5)]);
            bool binary = draw(2) == 1, begun = false, end = false;
            while (!end) {
                char payload[70000];
                size_t part = draw(3) == 0 ? draw((uint32_t)left + 1) : left;
                left -= part;
                end = left == 0 && draw(4) != 0;
                memset(payload, 'a' + (int)draw(26), part);
                size += put_frame(stream + size,
                                  (begun    ? 0
                                   : binary ? 2
                                            : 1) |
                                      (end ? 0x80 : 0),
                                  payload, part);
                note(&expected, begun ? 0 : binary ? 'b' : 't', payload, part);
                begun = true;
                if (end &&
                    draw(2) == 0) { /* control frames may come between fragments; here they would mix */
                    size_t control = draw(126);
                    bool ping = draw(2) == 0;
                    size +=
                        put_frame(stream + size, ping ? 0x89 : 0x8a, payload, control < part ? control : 0);
                    note(&expected, ping ? 'i' : 'o', payload, control < part ? control : 0);
                }
            }
        }
        for (size_t at = 0; at < size;) {
            size_t step = 1 + draw(draw(2) == 0 ? 3 : 20000);
            step = step < size - at ? step : size - at;
            assert_int_not_equal(feed(&f, stream + at, step), LL_FRAMING_FAULT);
            at += step;
        }
        assert_int_equal(told.size, expected.size);
        assert_memory_equal(told.text, expected.text, told.size);
    }
}

static void test_control_between_pieces(void **state)
{
    (void)state;
    unsigned char bytes[400];
    size_t size = put_frame(bytes, 0x01, "gr\xc3", 3);
    size += put_frame(bytes + size, 0x89, "are you there", 13);
    size += put_frame(bytes + size, 0x00, "", 0);
    size += put_frame(bytes + size, 0x80, "\xbc\xc3\x9f", 3);
    for (size_t step = 1; step <= size; step++) {
        ll_framing f = {0};
        told.size = 0;
        for (size_t at = 0; at < size; at += step)
            assert_int_not_equal(feed(&f, bytes + at, step < size - at ? step : size - at), LL_FRAMING_FAULT);
        told.text[told.size] = '\0';
        assert_string_equal(told.text, "tgr\xc3"
                                       "iare you there"
                                       "\xbc\xc3\x9f");
        assert_true(f.last);
    }
}

static void test_faults(void **state)
{
    (void)state;
#define B(text) text, sizeof(text) - 1
    static const struct {
        const char *what, *bytes;
        size_t size;
        int code;
    } cases[] = {
        {"unmasked text", B("\x81\x02hi"), 1002},
        {"unmasked ping", B("\x89"), 0},
        {"unmasked, detected after two bytes", B("\x81\x7e"), 1002},
        {"unmasked close", B("\x88\x00"), 1002},
        {"RSV1 without an extension", B("\xc1\x80"), 1002},
        {"RSV3", B("\x91\x80"), 1002},
        {"opcode 3", B("\x83\x80"), 1002},
        {"opcode 11", B("\x8b\x80"), 1002},
        {"a ping of 126 bytes", B("\x89\xfe"), 1002},
        {"a ping in pieces", B("\x09\x80"), 1002},
        {"goes on with nothing", B("\x80\x80"), 1002},
        {"text in a text", B("\x01\x80\0\0\0\0\x81\x80"), 1002},
        {"126 for 125 bytes", B("\x81\xfe\x00\x7d\0\0\0\0"), 1002},
        {"127 for 65535 bytes", B("\x82\xff\0\0\0\0\0\0\xff\xff\0\0\0\0"), 1002},
        {"more than 2^63 bytes", B("\x82\xff\x80\0\0\0\0\0\0\0\0\0\0\0"), 1002},
        {"a close of one byte", B("\x88\x81\0\0\0\0\x03"), 1002},
        {"close 1005", B("\x88\x82\0\0\0\0\x03\xed"), 1002},
        {"close 999", B("\x88\x82\0\0\0\0\x03\xe7"), 1002},
        {"close 5000", B("\x88\x82\0\0\0\0\x13\x88"), 1002},
        {"a reason that is no UTF-8", B("\x88\x83\0\0\0\0\x03\xe8\xff"), 1007},
        {"a reason cut in a character", B("\x88\x83\0\0\0\0\x03\xe8\xc3"), 1007},
        {"text that is no UTF-8", B("\x81\x81\0\0\0\0\xc0"), 1007},
        {"text cut in a character", B("\x81\x82\0\0\0\0\xe2\x82"), 1007},
        {"a surrogate", B("\x81\x83\0\0\0\0\xed\xa0\x80"), 1007},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int whole = 0; whole < 2; whole++) {
            ll_framing f = {0};
            ll_framing_event event = LL_FRAMING_NONE;
            size_t step = whole ? cases[i].size : 1;
            for (size_t at = 0; at < cases[i].size && event != LL_FRAMING_FAULT; at += step)
                event = feed(&f, (const unsigned char *)cases[i].bytes + at, step);
            if (cases[i].code == 0) {
                assert_int_equal(event, LL_FRAMING_NONE);
                continue;
            }
            if (event != LL_FRAMING_FAULT)
                print_message("%s was taken\n", cases[i].what);
            assert_int_equal(event, LL_FRAMING_FAULT);
            assert_int_equal(f.code, cases[i].code);
            assert_true(strlen(f.fault) > 10);
            /* Nothing after it is read. */
            assert_int_equal(feed(&f, (const unsigned char *)"\x81\x80\0\0\0\0", 6), LL_FRAMING_NONE);
        }
    }
}

static void test_closes(void **state)
{
    (void)state;
    for (int code = 0; code < 65536; code++) {
        /* RFC 6455 7.4 and IANA's registry. */
        bool may = code == 1000 || code == 1001 || code == 1002 || code == 1003 ||
                   (code >= 1007 && code <= 1014) || (code >= 3000 && code < 5000);
        unsigned char bytes[20], payload[2] = {(unsigned char)(code >> 8), (unsigned char)code};
        size_t size = put_frame(bytes, 0x88, payload, 2);
        ll_framing f = {0};
        assert_int_equal(feed(&f, bytes, size), may ? LL_FRAMING_CLOSE : LL_FRAMING_FAULT);
        assert_int_equal(f.code, may ? code : 1002);
    }
    unsigned char bytes[20];
    ll_framing f = {0};
    assert_int_equal(feed(&f, bytes, put_frame(bytes, 0x88, "", 0)), LL_FRAMING_CLOSE);
    assert_int_equal(f.code, LL_FRAMING_NO_CODE);
}

/* Next code point of a text, by the definition; -1: invalid. */
static int decode(const unsigned char **at, const unsigned char *end)
{
    static const int least[] = {0, 0, 0x80, 0x800, 0x10000};
    int lead = *(*at)++;
    int length = lead < 0x80 ? 1 : lead >> 5 == 6 ? 2 : lead >> 4 == 14 ? 3 : lead >> 3 == 30 ? 4 : 0;
    int point = length == 1 ? lead : lead & (0x7f >> length);
    if (length == 0 || end - *at < length - 1)
        return -1;
    for (int i = 1; i < length; i++, (*at)++) {
        if (**at >> 6 != 2)
            return -1;
        point = point << 6 | (**at & 0x3f);
    }
    return point < least[length] || point > 0x10ffff || (point >= 0xd800 && point < 0xe000) ? -1 : point;
}

static void test_utf8(void **state)
{
    (void)state;
    int good = 0;
    for (int trial = 0; trial < 400000; trial++) {
        static const unsigned char likely[] = {0x80, 0x8f, 0x90, 0x9f, 0xa0, 0xbf, 0xc1, 0xc2, 0xdf, 0xe0,
                                               0xe1, 0xed, 0xef, 0xf0, 0xf1, 0xf4, 0xf5, 'a',  0xff};
        unsigned char text[6], bytes[20];
        size_t size = draw(6);
        for (size_t i = 0; i < size; i++)
            text[i] = draw(3) == 0 ? (unsigned char)draw(256) : likely[draw(sizeof likely)];
        bool right = true;
        for (const unsigned char *at = text; right && at < text + size;)
            right = decode(&at, text + size) >= 0;
        ll_framing f = {0};
        ll_framing_event event = feed(&f, bytes, put_frame(bytes, 0x81, text, size));
        assert_int_equal(event, right ? LL_FRAMING_PIECE : LL_FRAMING_FAULT);
        good += right && size > 1;
        told.size = 0;
    }
    assert_true(good > 1000);
}

static void test_heads(void **state)
{
    (void)state;
    static unsigned char bytes[LL_FRAMING_HEAD_SPACE + 10];
    unsigned char *payload = bytes + LL_FRAMING_HEAD_SPACE;
    assert_int_equal(ll_framing_put_head(payload, 125, LL_OPCODE_TEXT), 2);
    assert_memory_equal(payload - 2, "\x81\x7d", 2);
    assert_int_equal(ll_framing_put_head(payload, 126, LL_OPCODE_BINARY), 4);
    assert_memory_equal(payload - 4, "\x82\x7e\x00\x7e", 4);
    assert_int_equal(ll_framing_put_head(payload, 65535, LL_OPCODE_PONG), 4);
    assert_memory_equal(payload - 4, "\x8a\x7e\xff\xff", 4);
    assert_int_equal(ll_framing_put_head(payload, 0x12345678, LL_OPCODE_BINARY), 10);
    assert_memory_equal(payload - 10, "\x82\x7f\0\0\0\0\x12\x34\x56\x78", 10);
    char accept[29]; /* the example of RFC 6455 1.3 */
    assert_true(ll_framing_accept("dGhlIHNhbXBsZSBub25jZQ==", accept));
    assert_string_equal(accept, "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_messages),
        cmocka_unit_test(test_control_between_pieces),
        cmocka_unit_test(test_faults),
        cmocka_unit_test(test_closes),
        cmocka_unit_test(test_utf8),
        cmocka_unit_test(test_heads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
