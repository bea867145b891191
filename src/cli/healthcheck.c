#include <netdb.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "cli/arguments.h"
#include "cli/verbs.h"

typedef struct target {
    char host[200], port[8];
} target;

/* http://HOST[:PORT][/...], HOST may be [ADDRESS6] */
static int read_url(const char *url, target *t)
{
    if (strncmp(url, "http://", 7) != 0)
        return -1;
    url += 7;
    const char *begin = url[0] == '[' ? url + 1 : url;
    size_t length = url[0] == '[' ? strcspn(begin, "]") : strcspn(begin, ":/");
    if (length == 0 || length >= sizeof t->host)
        return -1;
    memcpy(t->host, begin, length);
    t->host[length] = '\0';
    const char *rest = begin + length + (url[0] == '[' && begin[length] == ']');
    snprintf(t->port, sizeof t->port, "80");
    if (*rest == ':') {
        size_t digits = strspn(rest + 1, "0123456789");
        if (digits == 0 || digits >= sizeof t->port)
            return -1;
        memcpy(t->port, rest + 1, digits);
        t->port[digits] = '\0';
    }
    return 0;
}

static int connect_to(const target *t)
{
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM}, *list = NULL;
    struct timeval timeout = {.tv_sec = 3};
    int fd = -1;
    if (getaddrinfo(t->host, t->port, &hints, &list) != 0)
        return -1;
    for (struct addrinfo *a = list; a && fd < 0; a = a->ai_next) {
        fd = socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol);
        if (fd < 0)
            continue;
        setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &timeout, sizeof timeout);
        setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
        if (connect(fd, a->ai_addr, a->ai_addrlen) != 0) {
            close(fd);
            fd = -1;
        }
    }
    freeaddrinfo(list);
    return fd;
}

int ll_verb_healthcheck(int argc, char **argv)
{
    const ll_option none[] = {{0}};
    const char *given;
    ll_status status =
        ll_arguments_one("healthcheck [URL]: exit 0 if the daemon there answers", argc, argv, none, &given);
    if (ll_failed(&status))
        return ll_argument_fail(&status);
    const char *url = given ? given : "http://127.0.0.1:8080/";
    target t;
    if (read_url(url, &t) != 0) {
        fprintf(stderr, "laglab: healthcheck: URL: must be like http://127.0.0.1:8080/\n");
        return 2;
    }
    int fd = connect_to(&t);
    if (fd < 0) {
        fprintf(stderr, "laglab: no answer from %s\n", url);
        return 1;
    }
    char text[512];
    int length =
        snprintf(text, sizeof text, "GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    ssize_t got = send(fd, text, (size_t)length, MSG_NOSIGNAL) == length
                      ? recv(fd, text, sizeof text - 1, MSG_WAITALL)
                      : -1;
    close(fd);
    text[got > 0 ? got : 0] = '\0';
    if (strncmp(text, "HTTP/1.1 200 ", 13) == 0)
        return 0;
    fprintf(stderr, "laglab: %s is not ready: %.*s\n", url, (int)strcspn(text, "\r\n"), text);
    return 1;
}
