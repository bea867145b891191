/* Whether the process behind the URL of another daemon is gone. */
#include <errno.h>
#include <netdb.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "daemon/hosting/session_entry.h"
#include "daemon/support/log.h"

enum { CONNECT_MS = 500 };

/* HOST and PORT of http://HOST:PORT[/...] or http://[ADDRESS6]:PORT. */
static bool split(const char *url, char host[256], char port[8])
{
    static const char scheme[] = "http://";
    if (strncmp(url, scheme, sizeof scheme - 1) != 0)
        return false;
    const char *begin = url + sizeof scheme - 1;
    size_t size = strcspn(begin, "/?#");
    const char *colon = memrchr(begin, ':', size);
    if (!colon || colon == begin || colon + 1 == begin + size || begin + size - colon - 1 > 5)
        return false;
    bool six = begin[0] == '[' && colon[-1] == ']';
    int length = (int)(colon - begin) - (six ? 2 : 0);
    if (length < 1 || length > 255)
        return false;
    snprintf(host, 256, "%.*s", length, begin + six);
    snprintf(port, 8, "%.*s", (int)(begin + size - colon - 1), colon + 1);
    return true;
}

static bool refuses(const struct addrinfo *to)
{
    int fd = socket(to->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), error = 0;
    socklen_t size = sizeof error;
    if (fd < 0)
        return false;
    if (connect(fd, to->ai_addr, to->ai_addrlen) != 0)
        error = errno;
    struct pollfd on = {.fd = fd, .events = POLLOUT};
    if (error == EINPROGRESS &&
        (poll(&on, 1, CONNECT_MS) != 1 || getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0))
        error = ETIMEDOUT;
    close(fd);
    return error == ECONNREFUSED;
}

bool ll_neighbour_is_url(const char *url)
{
    char host[256], port[8];
    return split(url, host, port) && strspn(port, "0123456789") == strlen(port);
}

bool ll_neighbour_refuses(const char *url)
{
    char host[256], port[8];
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_NUMERICSERV}, *found = NULL;
    if (!split(url, host, port) || getaddrinfo(host, port, &hints, &found) != 0)
        return false;
    bool all = found != NULL;
    for (const struct addrinfo *to = found; to && all; to = to->ai_next)
        all = refuses(to);
    freeaddrinfo(found);
    return all;
}

ll_status ll_neighbour_judge(ll_store *store, int64_t daemon, const char *url, bool over, bool *gone)
{
    bool marked;
    *gone = over || ll_neighbour_refuses(url);
    if (!*gone)
        return ll_ok();
    LL_TRY(ll_store_mark_dead(store, daemon, !over, &marked));
    if (marked)
        ll_log_write("warn", "daemon marked as dead", "Number %lld, %.200s: %s.", (long long)daemon, url,
                     over ? "its lease is over" : "its port refuses connections");
    return ll_ok();
}
