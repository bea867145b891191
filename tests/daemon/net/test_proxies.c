/* The address by which a client is counted. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <cmocka.h>

#include "daemon/net/proxies.h"

static const char *peer_of(const char *address)
{
    static char peer[LL_PEER_TEXT];
    struct sockaddr_in in = {.sin_family = AF_INET};
    struct sockaddr_in6 in6 = {.sin6_family = AF_INET6};
    if (inet_pton(AF_INET, address, &in.sin_addr) == 1)
        ll_proxies_peer((const struct sockaddr *)&in, peer);
    else if (inet_pton(AF_INET6, address, &in6.sin6_addr) == 1)
        ll_proxies_peer((const struct sockaddr *)&in6, peer);
    else
        ll_proxies_peer(NULL, peer);
    return peer;
}

static const char *client_of(const char *forwarded)
{
    static char peer[LL_PEER_TEXT];
    ll_proxies proxies;
    assert_int_equal(ll_proxies_parse("10.0.0.0/8, ::1", &proxies).code, LL_OK);
    strcpy(peer, "10.0.0.1");
    ll_proxies_client(&proxies, forwarded, peer);
    return peer;
}

static void a_client_is_an_address_or_a_network_of_ipv6(void **state)
{
    (void)state;
    assert_string_equal(peer_of("192.168.1.20"), "192.168.1.20");
    assert_string_equal(peer_of("::ffff:192.168.1.20"), "192.168.1.20");
    assert_string_equal(peer_of("2001:db8:7:9:1:2:3:4"), "2001:db8:7:9::");
    assert_string_equal(peer_of("2001:db8:7:9:ffff::1"), "2001:db8:7:9::");
    assert_string_equal(peer_of("::1"), "::1");
    assert_string_equal(peer_of("a unix socket"), "?");
}

static void behind_a_proxy_it_is_the_same(void **state)
{
    (void)state;
    assert_string_equal(client_of("192.168.1.20"), "192.168.1.20");
    assert_string_equal(client_of("203.0.113.9, 192.168.1.20:8080, 10.7.7.7"), "192.168.1.20");
    assert_string_equal(client_of("2001:db8:7:9:1:2:3:4"), "2001:db8:7:9::");
    assert_string_equal(client_of("[2001:db8:7:9::1]:443, ::1"), "2001:db8:7:9::");
    assert_string_equal(client_of("192.168.1.20, unknown"), "10.0.0.1");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_client_is_an_address_or_a_network_of_ipv6),
        cmocka_unit_test(behind_a_proxy_it_is_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
