/* Blocks of a capture file, read back as draft-ietf-opsawg-pcapng describes them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "capture/format/pcapng.h"

typedef struct memory {
    char bytes[4096];
    size_t size;
} memory;

static void keep(void *context, const char *bytes, size_t length)
{
    memory *m = context;
    assert_true(m->size + length <= sizeof m->bytes);
    memcpy(m->bytes + m->size, bytes, length);
    m->size += length;
}

static uint32_t number(const memory *m, size_t at)
{
    const uint8_t *b = (const uint8_t *)m->bytes + at;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static uint32_t number16(const memory *m, size_t at)
{
    return number(m, at) & 0xFFFF;
}

/* The value of an option among those from `at` to `end`; its length, -1: there is none. */
static int option(const memory *m, size_t at, size_t end, uint32_t code, const char **value)
{
    while (at + 4 <= end && number16(m, at) != 0) {
        uint32_t length = number16(m, at + 2);
        assert_true(at + 4 + length <= end);
        *value = m->bytes + at + 4;
        if (number16(m, at) == code)
            return (int)length;
        at += 4 + (length + 3) / 4 * 4;
    }
    assert_int_equal(at + 4, end); /* the end of options is the last */
    return -1;
}

static void assert_text(const memory *m, size_t at, size_t end, uint32_t code, const char *expected)
{
    const char *value = NULL;
    int length = option(m, at, end, code, &value);
    assert_int_equal(length, (int)strlen(expected));
    assert_memory_equal(value, expected, strlen(expected));
}

/* The end of the block at `at`, whose two lengths must agree. */
static size_t block_end(const memory *m, size_t at, uint32_t type)
{
    uint32_t length = number(m, at + 4);
    assert_int_equal(number(m, at), type);
    assert_int_equal(length % 4, 0);
    assert_int_equal(number(m, at + length - 4), length);
    return at + length;
}

static void test_blocks(void **state)
{
    (void)state;
    memory m = {.size = 0};
    const ll_pcapng file = {keep, &m};
    const char *value = NULL;
    ll_pcapng_begin(&file, "a program", "a comment");
    ll_pcapng_interface(&file, "one");
    ll_pcapng_packet_write(&file, &(ll_pcapng_packet){.interface = 3,
                                                      .inbound = true,
                                                      .time_ns = UINT64_C(0x0102030405060708),
                                                      .bytes = "E____",
                                                      .size = 5,
                                                      .comment = NULL});
    size_t section = 0, interface = block_end(&m, section, 0x0A0D0D0A);
    assert_int_equal(number(&m, 8), 0x1A2B3C4D);
    assert_int_equal(number16(&m, 12), 1);
    assert_text(&m, 24, interface - 4, 1, "a comment");
    assert_text(&m, 24, interface - 4, 4, "a program");
    size_t packet = block_end(&m, interface, 1);
    assert_int_equal(number16(&m, interface + 8), 101);
    assert_text(&m, interface + 16, packet - 4, 2, "one");
    assert_int_equal(option(&m, interface + 16, packet - 4, 9, &value), 1);
    assert_int_equal(*value, 9);
    size_t end = block_end(&m, packet, 6);
    assert_int_equal(end, m.size);
    assert_int_equal(number(&m, packet + 8), 3);
    assert_int_equal(number(&m, packet + 12), 0x01020304);
    assert_int_equal(number(&m, packet + 16), 0x05060708);
    assert_int_equal(number(&m, packet + 20), 5);
    assert_int_equal(number(&m, packet + 24), 5);
    assert_memory_equal(m.bytes + packet + 28, "E____\0\0\0", 8);
    assert_int_equal(option(&m, packet + 36, end - 4, 1, &value), -1);
    assert_int_equal(option(&m, packet + 36, end - 4, 2, &value), 4);
    assert_int_equal(*value, 1);
}

/* A long comment ends at a whole character. */
static void test_long_comment(void **state)
{
    (void)state;
    memory m = {.size = 0};
    char comment[LL_PCAPNG_COMMENT_MAX + 4];
    const char *value = NULL;
    memset(comment, 'x', sizeof comment);
    memcpy(comment + LL_PCAPNG_COMMENT_MAX - 1, "\xC3\xA4", 3);
    ll_pcapng_packet_write(&(ll_pcapng){keep, &m},
                           &(ll_pcapng_packet){.bytes = "E", .size = 1, .comment = comment});
    assert_int_equal(option(&m, 32, m.size - 4, 1, &value), LL_PCAPNG_COMMENT_MAX - 1);
    assert_int_equal(block_end(&m, 0, 6), m.size);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_blocks), cmocka_unit_test(test_long_comment)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
