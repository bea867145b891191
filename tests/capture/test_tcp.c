/* Headers of TCP: fields at the places of RFC 9293, RFC 7323 and RFC 2018, and a receiver's check of the sum.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "capture/checksum.h"
#include "capture/format/tcp.h"

enum { HEADERS_MAX = 20 + 60, PAYLOAD_MAX = 1500 };

static const ll_ip_end from = {0xC0A80001, 50003}, to = {0xC0A800C7, 7777};

static void assert_sums(const uint8_t *packet, size_t tcp_size)
{
    uint8_t pseudo[12 + HEADERS_MAX + PAYLOAD_MAX] = {0};
    assert_int_equal(folded(packet, 20), 0xFFFF);
    assert_int_equal(packet[2] << 8 | packet[3], 20 + tcp_size);
    memcpy(pseudo, packet + 12, 8);
    pseudo[9] = 6;
    pseudo[10] = (uint8_t)(tcp_size >> 8);
    pseudo[11] = (uint8_t)tcp_size;
    memcpy(pseudo + 12, packet + 20, tcp_size);
    assert_int_equal(folded(pseudo, 12 + tcp_size), 0xFFFF);
}

static void test_fields(void **state)
{
    (void)state;
    uint8_t packet[HEADERS_MAX + 2] = {0};
    const ll_tcp_segment s = {.sequence = 0x01020304,
                              .acknowledgement = 0xA0B0C0D0,
                              .push = true,
                              .time_ms = 0x11223344,
                              .echo_ms = 0x55667788,
                              .blocks = 1,
                              .block = {{0xA0B0C0E0, 0xA0B0C100}}};
    static const uint8_t tcp[] = {
        0xC3,    0x53, 0x1E, 0x61, 1, 2, 3, 4, 0xA0, 0xB0, 0xC0, 0xD0, /* ports and numbers */
        11 << 4, 0x18, 0xFF, 0xFF,                                     /* 44 bytes; PSH and ACK; window */
    };
    static const uint8_t options[] = {1, 1, 8, 10, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88,
                                      1, 1, 5, 10, 0xA0, 0xB0, 0xC0, 0xE0, 0xA0, 0xB0, 0xC1, 0x00};
    assert_int_equal(ll_tcp_headers_size(&s), 64);
    packet[64] = 'x';
    packet[65] = 'y';
    ll_tcp_headers_write(packet, &from, &to, 7, &s, 2);
    assert_int_equal(packet[9], 6);
    assert_memory_equal(packet + 20, tcp, sizeof tcp);
    assert_memory_equal(packet + 40, options, sizeof options);
    assert_memory_equal(packet + 64, "xy", 2);
    assert_int_equal(ll_tcp_time_ms(packet), 0x11223344);
    assert_sums(packet, 46);
}

static void test_sizes(void **state)
{
    (void)state;
    uint8_t packet[HEADERS_MAX + PAYLOAD_MAX];
    for (int blocks = 0; blocks <= LL_TCP_BLOCKS_MAX; blocks++)
        for (size_t size = 0; size <= PAYLOAD_MAX; size += 1 + size / 3) {
            ll_tcp_segment s = {.sequence = UINT32_MAX, .reset = size & 1, .blocks = blocks};
            size_t headers = ll_tcp_headers_size(&s);
            assert_int_equal(headers, 52 + (blocks > 0 ? 4 + 8 * blocks : 0));
            for (size_t i = 0; i < size; i++)
                packet[headers + i] = (uint8_t)(i * 37 + size);
            ll_tcp_headers_write(packet, &from, &to, 1, &s, size);
            assert_int_equal(packet[33], size & 1 ? 0x14 : 0x10);
            assert_sums(packet, headers - 20 + size);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_fields), cmocka_unit_test(test_sizes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
