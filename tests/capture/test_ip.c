/* Headers of IPv4 and UDP, against headers and sums that others have published. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "capture/checksum.h"
#include "capture/format/ip.h"

/* A receiver's check of both headers, as RFC 791 and RFC 768 describe it. */
static void assert_valid(const uint8_t *packet, size_t payload)
{
    uint8_t pseudo[12 + 8 + 70000] = {0};
    size_t datagram = LL_UDP_HEADER + payload;
    assert_int_equal(folded(packet, LL_IP_HEADER), 0xFFFF);
    assert_int_equal(packet[2] << 8 | packet[3], LL_IP_HEADER + datagram);
    memcpy(pseudo, packet + 12, 8);
    pseudo[9] = 17;
    pseudo[10] = (uint8_t)(datagram >> 8);
    pseudo[11] = (uint8_t)datagram;
    memcpy(pseudo + 12, packet + LL_IP_HEADER, datagram);
    assert_int_equal(folded(pseudo, 12 + datagram), 0xFFFF);
    assert_true(packet[26] != 0 || packet[27] != 0); /* 0 means that there is no checksum */
}

static void test_fields(void **state)
{
    (void)state;
    uint8_t packet[LL_UDP_HEADERS + 3] = {[LL_UDP_HEADERS] = 'a', 'b', 'c'};
    const ll_ip_end from = {0xC0A80001, 5353}, to = {0xC0A800C7, 7777};
    static const uint8_t expected[] = {0x45, 0, 0, 31, 0x12, 0x34, 0x40, 0, 64, 17};
    static const uint8_t ends[] = {192, 168, 0, 1, 192, 168, 0, 199, 0x14, 0xE9, 0x1E, 0x61, 0, 11};
    ll_udp_headers_write(packet, &from, &to, 0x1234, 3);
    assert_memory_equal(packet, expected, sizeof expected);
    assert_memory_equal(packet + 12, ends, sizeof ends);
    assert_memory_equal(packet + LL_UDP_HEADERS, "abc", 3);
    assert_valid(packet, 3);
}

/* Every length up to the largest datagram, odd ones too, and payloads with carries. */
static void test_checksums(void **state)
{
    (void)state;
    static uint8_t packet[UINT16_MAX];
    const ll_ip_end from = {0xFFFFFFFE, 65535}, to = {0xC6336401, 50000};
    for (size_t size = 0; size <= UINT16_MAX - LL_UDP_HEADERS; size += size < 300 ? 1 : 1301) {
        for (size_t i = 0; i < size; i++)
            packet[LL_UDP_HEADERS + i] = (uint8_t)(255 - i * size % 7);
        ll_udp_headers_write(packet, &from, &to, (uint16_t)size, size);
        assert_valid(packet, size);
    }
}

/* A sum that comes out as 0 is sent as 0xFFFF. */
static void test_zero_sum(void **state)
{
    (void)state;
    const ll_ip_end from = {0, 0}, to = {0, 0};
    uint8_t packet[LL_UDP_HEADERS + 2];
    int zeros = 0;
    for (uint32_t word = 0; word <= UINT16_MAX; word++) {
        packet[LL_UDP_HEADERS] = (uint8_t)(word >> 8);
        packet[LL_UDP_HEADERS + 1] = (uint8_t)word;
        ll_udp_headers_write(packet, &from, &to, 0, 2);
        zeros += packet[26] == 0xFF && packet[27] == 0xFF;
        assert_true(packet[26] != 0 || packet[27] != 0);
    }
    assert_int_equal(zeros, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_fields), cmocka_unit_test(test_checksums),
                                       cmocka_unit_test(test_zero_sum)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
