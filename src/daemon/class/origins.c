#include "daemon/class/origins.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* ---- texts ---- */

/* Characters of a host with port; anything else would not be an address. */
static bool is_host(const char *text)
{
    size_t length = text ? strlen(text) : 0;
    return length > 0 && length < 256 &&
           strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-:[]") == length;
}

static bool begins(const char *text, const char *prefix)
{
    return strncasecmp(text, prefix, strlen(prefix)) == 0;
}

static bool is_loopback(const char *host)
{
    return begins(host, "localhost") || begins(host, "127.") || begins(host, "[::1]") ||
           begins(host, "[::ffff:127.");
}

static bool is_wildcard(const char *bound)
{
    return begins(bound, "0.0.0.0:") || begins(bound, "[::]:") || begins(bound, "*:");
}

static void add(ll_origins *origins, const char *scheme, const char *host)
{
    char text[LL_ORIGIN_TEXT];
    snprintf(text, sizeof text, "%s://%s", scheme, host);
    for (int i = 0; i < origins->count; i++)
        if (strcasecmp(origins->text[i], text) == 0)
            return;
    if (origins->count < LL_ORIGINS_MAX)
        memcpy(origins->text[origins->count++], text, sizeof text);
}

/* ---- the choice ---- */

/* Networks within the machine: of containers and virtual machines. */
static bool is_inner(const ll_interface *interface)
{
    static const char *const prefixes[] = {"docker", "br-", "veth", "virbr", "cni", "lxc", "podman"};
    for (size_t i = 0; i < sizeof prefixes / sizeof prefixes[0]; i++)
        if (begins(interface->name, prefixes[i]))
            return true;
    return false;
}

/* IPv4 before IPv6, whose addresses are too long to type; networks of the room before those within the
 * machine. */
static void add_interfaces(const ll_origins_request *request, ll_origins *origins)
{
    bool only4 = begins(request->bound, "0.0.0.0:");
    for (int pass = 0; pass < 4; pass++) {
        for (int i = 0; i < request->interface_count; i++) {
            const ll_interface *interface = &request->interfaces[i];
            bool six = strchr(interface->address, ':') != NULL;
            char host[80];
            if (is_inner(interface) != (pass >= 2) || six != (pass % 2 == 1) || (six && only4))
                continue;
            snprintf(host, sizeof host, six ? "[%s]:%u" : "%s:%u", interface->address,
                     (unsigned)request->port);
            add(origins, "http", host);
        }
    }
}

void ll_origins_choose(const ll_origins_request *request, ll_origins *origins)
{
    const char *host = is_host(request->host) ? request->host : NULL;
    memset(origins, 0, sizeof *origins);
    if (request->proxied) {
        if (host)
            add(origins, request->tls ? "https" : "http", host);
        origins->local = !host || is_loopback(host);
        return;
    }
    if (host && !is_loopback(host))
        add(origins, "http", host);
    if (is_wildcard(request->bound))
        add_interfaces(request, origins);
    else if (!is_loopback(request->bound))
        add(origins, "http", request->bound);
    origins->local = origins->count == 0;
    if (origins->local)
        add(origins, "http", is_wildcard(request->bound) && host ? host : request->bound);
}

/* ---- the interfaces ---- */

static bool take(const struct ifaddrs *from, ll_interface *interface)
{
    const unsigned up = IFF_UP | IFF_RUNNING;
    if (!from->ifa_addr || (from->ifa_flags & up) != up || (from->ifa_flags & IFF_LOOPBACK) != 0)
        return false;
    int family = from->ifa_addr->sa_family;
    const void *address = NULL;
    if (family == AF_INET) {
        address = &((const struct sockaddr_in *)(const void *)from->ifa_addr)->sin_addr;
    } else if (family == AF_INET6) {
        const struct in6_addr *six = &((const struct sockaddr_in6 *)(const void *)from->ifa_addr)->sin6_addr;
        if (IN6_IS_ADDR_LINKLOCAL(six) || IN6_IS_ADDR_LOOPBACK(six))
            return false;
        address = six;
    }
    if (!address || !inet_ntop(family, address, interface->address, sizeof interface->address))
        return false;
    snprintf(interface->name, sizeof interface->name, "%s", from->ifa_name);
    return !begins(interface->address, "169.254.");
}

int ll_interfaces_list(ll_interface interfaces[LL_INTERFACES_MAX])
{
    struct ifaddrs *list = NULL;
    int count = 0;
    if (getifaddrs(&list) != 0)
        return 0;
    for (const struct ifaddrs *from = list; from && count < LL_INTERFACES_MAX; from = from->ifa_next)
        if (take(from, &interfaces[count]))
            count++;
    freeifaddrs(list);
    return count;
}
