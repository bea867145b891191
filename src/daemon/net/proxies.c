#include "daemon/net/proxies.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const uint8_t mapped[12] = {[10] = 0xff, [11] = 0xff};

static bool read_address(const char *text, uint8_t address[16])
{
    if (inet_pton(AF_INET6, text, address) == 1)
        return true;
    memcpy(address, mapped, sizeof mapped);
    return inet_pton(AF_INET, text, address + 12) == 1;
}

static bool is_ipv4(const uint8_t address[16])
{
    return memcmp(address, mapped, sizeof mapped) == 0;
}

static void address_of(const struct sockaddr *from, uint8_t address[16])
{
    memset(address, 0, 16);
    if (from && from->sa_family == AF_INET) {
        memcpy(address, mapped, sizeof mapped);
        memcpy(address + 12, &((const struct sockaddr_in *)(const void *)from)->sin_addr, 4);
    } else if (from && from->sa_family == AF_INET6) {
        memcpy(address, &((const struct sockaddr_in6 *)(const void *)from)->sin6_addr, 16);
    }
}

/* ---- the list ---- */

/* Next item of a comma separated list, without spaces around it; false at the end. */
static bool next_piece(const char **at, char *piece, size_t size)
{
    *at += strspn(*at, ", \t");
    size_t length = strcspn(*at, ", \t");
    snprintf(piece, size, "%.*s", (int)(length < size ? length : size - 1), *at);
    *at += length;
    return length > 0;
}

static ll_status read_network(char *text, ll_network *network)
{
    char *slash = strchr(text, '/'), *end = "";
    ll_status bad = ll_field_error(
        LL_BAD_INPUT, "trusted_proxy",
        "trusted_proxy: must be addresses or networks such as 10.0.0.0/8 or ::1; got `%.60s`.", text);
    if (slash)
        *slash = '\0';
    if (!read_address(text, network->address))
        return bad;
    int most = is_ipv4(network->address) ? 32 : 128;
    long bits = slash ? strtol(slash + 1, &end, 10) : most;
    if (*end || (slash && (slash[1] < '0' || slash[1] > '9')) || bits < 0 || bits > most)
        return bad;
    network->bits = (int)bits + 128 - most;
    return ll_ok();
}

ll_status ll_proxies_parse(const char *text, ll_proxies *proxies)
{
    char piece[64];
    proxies->count = 0;
    ll_status status = ll_ok();
    while (!ll_failed(&status) && next_piece(&text, piece, sizeof piece)) {
        if (proxies->count == LL_PROXIES_MAX)
            return ll_field_error(LL_BAD_INPUT, "trusted_proxy",
                                  "trusted_proxy: must have at most %d networks", LL_PROXIES_MAX);
        status = read_network(piece, &proxies->network[proxies->count++]);
    }
    return status;
}

static bool is_in(const ll_network *network, const uint8_t address[16])
{
    int whole = network->bits / 8, rest = network->bits % 8;
    if (memcmp(network->address, address, (size_t)whole) != 0)
        return false;
    unsigned mask = 0xff00u >> rest & 0xff;
    return rest == 0 || ((network->address[whole] ^ address[whole]) & mask) == 0;
}

static bool is_trusted(const ll_proxies *proxies, const uint8_t address[16])
{
    for (int i = 0; i < proxies->count; i++)
        if (is_in(&proxies->network[i], address))
            return true;
    return false;
}

/* ---- the client behind a proxy ---- */

/* IPv6 clients are counted by their /64, as in the connection limiter. */
static void write_client(const uint8_t address[16], char peer[LL_PEER_TEXT])
{
    static const uint8_t loopback[16] = {[15] = 1};
    uint8_t cut[16] = {0};
    if (is_ipv4(address)) {
        inet_ntop(AF_INET, address + 12, peer, LL_PEER_TEXT);
        return;
    }
    memcpy(cut, address, memcmp(address, loopback, sizeof loopback) == 0 ? 16 : 8);
    inet_ntop(AF_INET6, cut, peer, LL_PEER_TEXT);
}

/* An entry may be `1.2.3.4`, `1.2.3.4:80`, `::1` or `[::1]:80`. */
static bool read_entry(const char *entry, uint8_t address[16])
{
    char text[64];
    bool brackets = entry[0] == '[';
    const char *colon = strchr(entry, ':');
    size_t length = brackets                                ? strcspn(entry + 1, "]")
                    : colon && strrchr(entry, ':') == colon ? (size_t)(colon - entry)
                                                            : strlen(entry);
    snprintf(text, sizeof text, "%.*s", (int)length, entry + brackets);
    return read_address(text, address);
}

void ll_proxies_client(const ll_proxies *proxies, const char *forwarded, char peer[LL_PEER_TEXT])
{
    size_t end = strlen(forwarded);
    while (end > 0) {
        size_t begin = end;
        while (begin > 0 && forwarded[begin - 1] != ',')
            begin--;
        char piece[64], whole[128];
        uint8_t address[16];
        snprintf(whole, sizeof whole, "%.*s", (int)(end - begin < 127 ? end - begin : 127),
                 forwarded + begin);
        const char *at = whole;
        if (!next_piece(&at, piece, sizeof piece) || !read_entry(piece, address))
            return; /* unknown client, or a name: count as the proxy */
        if (!is_trusted(proxies, address)) {
            write_client(address, peer);
            return;
        }
        end = begin > 0 ? begin - 1 : 0;
    }
}

void ll_proxies_peer(const struct sockaddr *from, char peer[LL_PEER_TEXT])
{
    uint8_t address[16];
    address_of(from, address);
    if (from && (from->sa_family == AF_INET || from->sa_family == AF_INET6))
        write_client(address, peer);
    else
        snprintf(peer, LL_PEER_TEXT, "?");
}

ll_connection_limiter_pass ll_proxies_pass(const ll_proxies *proxies, const struct sockaddr *from)
{
    uint8_t address[16];
    ll_connection_limiter_pass pass = ll_connection_limiter_pass_of(from);
    address_of(from, address);
    pass.many = is_trusted(proxies, address);
    return pass;
}
