#include "daemon/relay/upstream.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

#include <curl/curl.h>
#include <openssl/evp.h>

#include "base/assert.h"
#include "daemon/net/framing.h"
#include "record/buffer.h"

enum {
    INPUT = 64 << 10,
    HEAD_MOST = 16 << 10,    /* of the answer to an upgrade */
    MESSAGE_MOST = 32 << 20, /* a frame of the largest scene has some hundred kilobytes */
    UNSENT_MOST = 256 << 10, /* of an owner that does not read */
    CONNECT_MS = 5000,       /* then the owner counts as away */
    HEAD_MS = 10000,         /* for the answer */
    EVENTS = 64,
};

#define CHECK_NS INT64_C(500000000)   /* between two looks for silent ones */
#define PING_NS INT64_C(2000000000)   /* without a byte of the owner */
#define ANSWER_NS INT64_C(5000000000) /* for the answer to a ping */

struct ll_upstream {
    ll_upstreams *all;
    ll_upstream *next; /* of `first`, or of the finished attempts */
    ll_upstream_hooks hooks;
    void *context;
    char path[700], protocol[32];

    /* of the attempt, then of the serving thread */
    CURL *curl;
    int fd;
    int status; /* of the attempt: 101, another HTTP status, or 0 */
    char error[200];
    ll_buffer early; /* bytes after the head */

    ll_framing framing;
    ll_buffer message;
    ll_buffer unsent;
    int64_t heard_ns, pinged_ns; /* when bytes came; when a ping was sent since: 0, none */
    bool connecting, writes, dead;
};

struct ll_upstreams {
    ll_owner *owner;
    int epoll, event_fd;
    ll_upstream *first;
    bool any_dead;
    int64_t checked_ns;
    unsigned char *input;

    pthread_mutex_t lock;
    pthread_cond_t attempt_done;
    int attempts;
    ll_upstream *finished; /* attempts */
};

int64_t ll_relay_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* ---- the owner ---- */

static bool take_part(CURLU *url, CURLUPart part, char *to, size_t size)
{
    char *text = NULL;
    bool fits = curl_url_get(url, part, &text, 0) == CURLUE_OK && strlen(text) < size;
    snprintf(to, size, "%s", fits ? text : "");
    curl_free(text);
    return fits;
}

ll_status ll_owner_parse(const char *text, const char *ca_file, ll_owner *owner)
{
    char scheme[16], host[256], port[8];
    CURLU *url = curl_url();
    bool valid = url != NULL && curl_url_set(url, CURLUPART_URL, text, 0) == CURLUE_OK &&
                 take_part(url, CURLUPART_SCHEME, scheme, sizeof scheme) &&
                 (strcmp(scheme, "http") == 0 || strcmp(scheme, "https") == 0) &&
                 take_part(url, CURLUPART_HOST, host, sizeof host) &&
                 take_part(url, CURLUPART_PATH, owner->path, sizeof owner->path) && strlen(text) < 500 &&
                 strpbrk(text, "?#@ \t\r\n") == NULL;
    if (valid) {
        bool has_port = take_part(url, CURLUPART_PORT, port, sizeof port);
        snprintf(owner->host, sizeof owner->host, "%s%s%s", host, has_port ? ":" : "", port);
        snprintf(owner->url, sizeof owner->url, "%s", text);
        for (size_t n = strlen(owner->url); n > 0 && owner->url[n - 1] == '/'; n--)
            owner->url[n - 1] = '\0';
        for (size_t n = strlen(owner->path); n > 0 && owner->path[n - 1] == '/'; n--)
            owner->path[n - 1] = '\0';
        owner->ca_file = ca_file;
        atomic_init(&owner->stopping, false);
    }
    curl_url_cleanup(url);
    return valid
               ? ll_ok()
               : ll_field_error(LL_BAD_INPUT, "of", "of: must be like http://HOST:PORT; got `%.100s`", text);
}

/* Each second or so: ends an attempt when the relay stops. */
static int on_progress(void *context, curl_off_t a, curl_off_t b, curl_off_t c, curl_off_t d)
{
    (void)a, (void)b, (void)c, (void)d;
    const ll_owner *owner = context;
    return atomic_load(&owner->stopping);
}

void *ll_owner_request(ll_owner *owner)
{
    CURL *curl = curl_easy_init();
    if (curl == NULL)
        return NULL;
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_HTTP_VERSION, (long)CURL_HTTP_VERSION_1_1);
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT_MS, (long)CONNECT_MS);
#if LIBCURL_VERSION_NUM >= 0x075500
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
#endif
    curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);
    curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, on_progress);
    curl_easy_setopt(curl, CURLOPT_XFERINFODATA, owner);
    if (owner->ca_file != NULL && owner->ca_file[0] != '\0')
        curl_easy_setopt(curl, CURLOPT_CAINFO, owner->ca_file);
    return curl;
}

/* ---- an attempt, on a thread of its own ---- */

static int64_t now_ms(void)
{
    return ll_relay_now() / 1000000;
}

/* Waits until the socket is ready. False: too late, or the relay stops. */
static bool wait_for(const ll_upstream *u, short events, int64_t until_ms)
{
    struct pollfd p = {.fd = u->fd, .events = events};
    while (now_ms() < until_ms && !atomic_load(&u->all->owner->stopping))
        if (poll(&p, 1, 100) > 0)
            return true;
    return false;
}

static bool send_all(ll_upstream *u, const char *bytes, size_t size, int64_t until_ms)
{
    while (size > 0) {
        size_t sent = 0;
        CURLcode code = curl_easy_send(u->curl, bytes, size, &sent);
        if (code != CURLE_OK && !(code == CURLE_AGAIN && wait_for(u, POLLOUT, until_ms)))
            return false;
        bytes += sent;
        size -= sent;
    }
    return true;
}

/* Size of the head that `bytes` begin with; 0: incomplete. */
static size_t head_size(const ll_buffer *bytes)
{
    const char *end = bytes->size > 0 ? memmem(bytes->bytes, bytes->size, "\r\n\r\n", 4) : NULL;
    return end != NULL ? (size_t)(end + 4 - bytes->bytes) : 0;
}

static bool read_head(ll_upstream *u, int64_t until_ms)
{
    while (head_size(&u->early) == 0) {
        size_t got = 0;
        char *to = u->early.size < HEAD_MOST ? ll_buffer_reserve(&u->early, HEAD_MOST) : NULL;
        if (to == NULL)
            return false;
        CURLcode code = curl_easy_recv(u->curl, to, HEAD_MOST, &got);
        if (code == CURLE_AGAIN ? !wait_for(u, POLLIN, until_ms) : code != CURLE_OK || got == 0)
            return false;
        u->early.size += got;
    }
    return true;
}

/* Whether the head has this line, with the value after any space. */
static bool has_line(const char *head, size_t size, const char *name, const char *value)
{
    size_t length = strlen(name), wanted = strlen(value);
    for (const char *line = head, *end = head + size; line < end;) {
        const char *stop = memchr(line, '\n', (size_t)(end - line));
        const char *at = line + length;
        stop = stop != NULL ? stop : end;
        if (at < stop && strncasecmp(line, name, length) == 0 && *at == ':') {
            at++;
            while (at < stop && (*at == ' ' || *at == '\t'))
                at++;
            if ((size_t)(stop - at) >= wanted && memcmp(at, value, wanted) == 0 &&
                (at + wanted == stop || at[wanted] == '\r' || at[wanted] == ' '))
                return true;
        }
        line = stop + 1;
    }
    return false;
}

/* Asks for the stream and reads the answer: 101, the status of a refusal, or 0. */
static int upgrade(ll_upstream *u)
{
    unsigned char random[16];
    char key[25], accept[29], request[2000];
    const ll_owner *owner = u->all->owner;
    int64_t until_ms = now_ms() + HEAD_MS;
    int version, minor, status = 0;
    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return 0;
    EVP_EncodeBlock((unsigned char *)key, random, sizeof random);
    int size = snprintf(request, sizeof request,
                        "GET %s%s HTTP/1.1\r\nHost: %s\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                        "Sec-WebSocket-Key: %s\r\nSec-WebSocket-Version: 13\r\n"
                        "Sec-WebSocket-Protocol: %s\r\nUser-Agent: laglab-relay\r\n\r\n",
                        owner->path, u->path, owner->host, key, u->protocol);
    if (size <= 0 || (size_t)size >= sizeof request || !send_all(u, request, (size_t)size, until_ms) ||
        !read_head(u, until_ms))
        return 0;
    size_t head = head_size(&u->early);
    u->early.bytes[head - 1] = '\0';
    if (sscanf(u->early.bytes, "HTTP/%d.%d %d", &version, &minor, &status) != 3 || status < 100)
        return 0;
    u->early.bytes[head - 1] = '\n';
    if (status == 101 &&
        (!ll_framing_accept(key, accept) || !has_line(u->early.bytes, head, "Sec-WebSocket-Accept", accept) ||
         !has_line(u->early.bytes, head, "Sec-WebSocket-Protocol", u->protocol)))
        return 0;
    u->early.size -= head;
    memmove(u->early.bytes, u->early.bytes + head, u->early.size);
    return status;
}

static bool connect_curl(ll_upstream *u)
{
    curl_socket_t fd = CURL_SOCKET_BAD;
    u->curl = ll_owner_request(u->all->owner);
    if (u->curl == NULL)
        return false;
    char error[CURL_ERROR_SIZE] = "";
    curl_easy_setopt(u->curl, CURLOPT_URL, u->all->owner->url);
    curl_easy_setopt(u->curl, CURLOPT_CONNECT_ONLY, 1L);
    curl_easy_setopt(u->curl, CURLOPT_HTTPPROXYTUNNEL, 1L); /* a proxy between must not read it */
    curl_easy_setopt(u->curl, CURLOPT_ERRORBUFFER, error);
    CURLcode code = curl_easy_perform(u->curl);
    curl_easy_setopt(u->curl, CURLOPT_ERRORBUFFER, NULL);
    if (code != CURLE_OK) {
        snprintf(u->error, sizeof u->error, "%.190s", error[0] != '\0' ? error : curl_easy_strerror(code));
        return false;
    }
    bool has = curl_easy_getinfo(u->curl, CURLINFO_ACTIVESOCKET, &fd) == CURLE_OK && fd != CURL_SOCKET_BAD;
    u->fd = (int)fd;
    return has;
}

static void *attempt(void *argument)
{
    ll_upstream *u = argument;
    ll_upstreams *all = u->all;
    pthread_setname_np(pthread_self(), "connect");
    snprintf(u->error, sizeof u->error, "the owner does not answer");
    u->status = connect_curl(u) ? upgrade(u) : 0;
    pthread_mutex_lock(&all->lock);
    u->next = all->finished;
    all->finished = u;
    eventfd_write(all->event_fd, 1); /* under the lock: afterwards all may be freed */
    all->attempts--;
    pthread_cond_signal(&all->attempt_done);
    pthread_mutex_unlock(&all->lock);
    return NULL;
}

/* ---- opening and closing ---- */

static void free_upstream(ll_upstream *u)
{
    curl_easy_cleanup(u->curl); /* closes the socket */
    free(u->early.bytes);
    free(u->message.bytes);
    free(u->unsent.bytes);
    free(u);
}

ll_upstream *ll_upstream_open(ll_upstreams *all, const char *path, const char *protocol,
                              const ll_upstream_hooks *hooks, void *context)
{
    pthread_t thread;
    ll_upstream *u = calloc(1, sizeof *u);
    if (u == NULL)
        return NULL;
    u->all = all;
    u->hooks = *hooks;
    u->context = context;
    u->fd = -1;
    u->connecting = true;
    u->framing.of_server = true;
    snprintf(u->path, sizeof u->path, "%s", path);
    snprintf(u->protocol, sizeof u->protocol, "%s", protocol);
    pthread_mutex_lock(&all->lock);
    all->attempts++;
    pthread_mutex_unlock(&all->lock);
    if (pthread_create(&thread, NULL, attempt, u) != 0) {
        pthread_mutex_lock(&all->lock);
        all->attempts--;
        pthread_mutex_unlock(&all->lock);
        free(u);
        return NULL;
    }
    pthread_detach(thread);
    return u;
}

void ll_upstream_close(ll_upstream *u)
{
    if (u == NULL || u->dead)
        return;
    u->dead = true;
    u->all->any_dead = true; /* of one that is connecting when its attempt has ended */
    if (u->fd >= 0 && !u->connecting)
        epoll_ctl(u->all->epoll, EPOLL_CTL_DEL, u->fd, NULL);
}

static void end(ll_upstream *u, int code, const char *reason)
{
    if (!u->dead) {
        ll_upstream_close(u);
        u->hooks.closed(u->context, code, reason);
    }
}

/* ---- output ---- */

static void watch(ll_upstream *u, bool writes)
{
    struct epoll_event interest = {.events = writes ? EPOLLIN | EPOLLOUT : EPOLLIN, .data.ptr = u};
    if (u->writes != writes && !u->dead)
        epoll_ctl(u->all->epoll, EPOLL_CTL_MOD, u->fd, &interest);
    u->writes = writes;
}

static void flush(ll_upstream *u)
{
    size_t at = 0;
    CURLcode code = CURLE_OK;
    while (at < u->unsent.size && code == CURLE_OK) {
        size_t sent = 0;
        code = curl_easy_send(u->curl, u->unsent.bytes + at, u->unsent.size - at, &sent);
        at += sent;
    }
    u->unsent.size -= at;
    if (u->unsent.size > 0 && at > 0)
        memmove(u->unsent.bytes, u->unsent.bytes + at, u->unsent.size);
    if ((code != CURLE_OK && code != CURLE_AGAIN) || u->unsent.size > UNSENT_MOST)
        end(u, LL_UPSTREAM_CUT, "the owner does not read");
    else
        watch(u, u->unsent.size > 0);
}

static void send_frame(ll_upstream *u, const void *payload, size_t size, ll_opcode opcode)
{
    unsigned char mask[4];
    if (u->dead || u->connecting || getrandom(mask, sizeof mask, 0) != (ssize_t)sizeof mask)
        return;
    size_t before = u->unsent.size;
    char *to = ll_buffer_reserve(&u->unsent, LL_FRAMING_HEAD_SPACE + size);
    if (to == NULL) {
        end(u, LL_UPSTREAM_CUT, "out of memory");
        return;
    }
    unsigned char *copy = (unsigned char *)to + LL_FRAMING_HEAD_SPACE;
    if (size > 0)
        memcpy(copy, payload, size);
    size_t head = ll_framing_put_masked(copy, size, opcode, mask);
    memmove(to, copy - head, head + size);
    u->unsent.size = before + head + size;
    if (before == 0)
        flush(u);
    else if (u->unsent.size > UNSENT_MOST) /* the socket is full, and may stay so */
        end(u, LL_UPSTREAM_CUT, "the owner does not read");
}

void ll_upstream_send(ll_upstream *u, const char *text, size_t size)
{
    send_frame(u, text, size, LL_OPCODE_TEXT);
}

/* ---- input ---- */

static void take_piece(ll_upstream *u)
{
    const ll_framing *piece = &u->framing;
    if (piece->first)
        u->message.size = 0;
    if (u->message.size + piece->size > MESSAGE_MOST) {
        end(u, LL_UPSTREAM_CUT, "the owner sent a message of more than 32 MiB");
        return;
    }
    ll_buffer_add(&u->message, piece->bytes, piece->size);
    char *terminator = ll_buffer_reserve(&u->message, 1);
    if (u->message.failed || terminator == NULL) {
        end(u, LL_UPSTREAM_CUT, "out of memory");
        return;
    }
    *terminator = '\0';
    if (!piece->last)
        return;
    if (piece->binary)
        u->hooks.binary(u->context, u->message.bytes, u->message.size);
    else
        u->hooks.text(u->context, u->message.bytes, u->message.size);
}

static void take_event(ll_upstream *u, ll_framing_event event)
{
    char reason[LL_FRAMING_CONTROL_MAX + 1] = "";
    const ll_framing *f = &u->framing;
    switch (event) {
    case LL_FRAMING_PIECE:
        take_piece(u);
        break;
    case LL_FRAMING_PING:
        send_frame(u, f->bytes, f->size, LL_OPCODE_PONG);
        break;
    case LL_FRAMING_CLOSE:
        if (f->size > 2)
            memcpy(reason, f->bytes + 2, f->size - 2);
        end(u, f->code, reason);
        break;
    case LL_FRAMING_FAULT:
        end(u, LL_UPSTREAM_CUT, f->fault);
        break;
    case LL_FRAMING_PONG:
    case LL_FRAMING_NONE:
        break;
    }
}

static void take_bytes(ll_upstream *u, unsigned char *bytes, size_t size)
{
    size_t used = 0;
    while (used < size && !u->dead)
        take_event(u, ll_framing_read(&u->framing, bytes, size, &used));
}

static void read_socket(ll_upstream *u)
{
    while (!u->dead) {
        size_t got = 0;
        CURLcode code = curl_easy_recv(u->curl, u->all->input, INPUT, &got);
        if (code == CURLE_AGAIN)
            return;
        if (code != CURLE_OK || got == 0) {
            end(u, LL_UPSTREAM_CUT, "the connection to the owner was cut");
            return;
        }
        u->heard_ns = ll_relay_now();
        u->pinged_ns = 0;
        take_bytes(u, u->all->input, got);
    }
}

/* A connection that is cut without a word, as by a machine that has lost its power or a firewall that has
 * forgotten it, looks like one of an owner that has nothing to say. */
static void check_alive(ll_upstream *u, int64_t now)
{
    if (u->pinged_ns != 0 && now - u->pinged_ns > ANSWER_NS) {
        /* The answer may wait in the socket: one turn reads few of them, and this program may have been
         * stopped. */
        read_socket(u);
        if (u->pinged_ns != 0)
            end(u, LL_UPSTREAM_CUT, "the owner is silent");
    } else if (u->pinged_ns == 0 && now - u->heard_ns > PING_NS) {
        u->pinged_ns = now;
        send_frame(u, NULL, 0, LL_OPCODE_PING);
    }
}

/* ---- serving ---- */

static void take_attempt(ll_upstreams *all, ll_upstream *u)
{
    struct epoll_event interest = {.events = EPOLLIN, .data.ptr = u};
    char text[64];
    u->next = all->first;
    all->first = u;
    u->connecting = false;
    if (u->dead) { /* it was closed meanwhile */
        all->any_dead = true;
    } else if (u->status == 0) {
        end(u, LL_UPSTREAM_CUT, u->error);
    } else if (u->status != 101) {
        snprintf(text, sizeof text, "the owner answered %d", u->status);
        end(u, u->status, text);
    } else if (epoll_ctl(all->epoll, EPOLL_CTL_ADD, u->fd, &interest) != 0) {
        end(u, LL_UPSTREAM_CUT, "out of memory");
    } else {
        u->heard_ns = ll_relay_now();
        u->hooks.opened(u->context);
        if (u->early.size > 0)
            take_bytes(u, (unsigned char *)u->early.bytes, u->early.size);
        read_socket(u); /* TLS may have read more than the head */
    }
}

static void take_attempts(ll_upstreams *all)
{
    pthread_mutex_lock(&all->lock);
    ll_upstream *finished = all->finished;
    all->finished = NULL;
    pthread_mutex_unlock(&all->lock);
    while (finished != NULL) {
        ll_upstream *u = finished;
        finished = u->next;
        take_attempt(all, u);
    }
}

static void check_all(ll_upstreams *all)
{
    int64_t now = ll_relay_now();
    if (now - all->checked_ns < CHECK_NS)
        return;
    all->checked_ns = now;
    for (ll_upstream *u = all->first; u != NULL; u = u->next) /* those that a hook opens are not in it yet */
        if (!u->dead)
            check_alive(u, now);
}

static void free_dead(ll_upstreams *all)
{
    all->any_dead = false;
    for (ll_upstream **link = &all->first; *link != NULL;) {
        ll_upstream *u = *link;
        if (!u->dead) {
            link = &u->next;
            continue;
        }
        *link = u->next;
        free_upstream(u);
    }
}

void ll_upstreams_serve(ll_upstreams *all, int wait_ms)
{
    struct epoll_event events[EVENTS];
    eventfd_t value;
    int count = epoll_wait(all->epoll, events, EVENTS, wait_ms);
    for (int i = 0; i < count; i++) {
        ll_upstream *u = events[i].data.ptr;
        if (u == NULL) {
            eventfd_read(all->event_fd, &value);
            continue;
        }
        if (!u->dead && (events[i].events & EPOLLOUT) != 0)
            flush(u);
        if (!u->dead && (events[i].events & ~(uint32_t)EPOLLOUT) != 0)
            read_socket(u);
    }
    take_attempts(all);
    check_all(all);
    if (all->any_dead)
        free_dead(all);
}

void ll_upstreams_wake(ll_upstreams *all)
{
    eventfd_write(all->event_fd, 1);
}

ll_status ll_upstreams_new(ll_owner *owner, ll_upstreams **result)
{
    struct epoll_event interest = {.events = EPOLLIN, .data.ptr = NULL};
    ll_upstreams *all = calloc(1, sizeof *all);
    if (all == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: streams of the owner");
    all->owner = owner;
    pthread_mutex_init(&all->lock, NULL);
    pthread_cond_init(&all->attempt_done, NULL);
    all->epoll = epoll_create1(EPOLL_CLOEXEC);
    all->event_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    all->input = malloc(INPUT);
    if (all->epoll < 0 || all->event_fd < 0 || all->input == NULL ||
        epoll_ctl(all->epoll, EPOLL_CTL_ADD, all->event_fd, &interest) != 0) {
        ll_status error = ll_error(LL_IO, "cannot read streams: %s", strerror(errno));
        ll_upstreams_free(all);
        return error;
    }
    *result = all;
    return ll_ok();
}

static void free_list(ll_upstream *u)
{
    while (u != NULL) {
        ll_upstream *next = u->next;
        free_upstream(u);
        u = next;
    }
}

void ll_upstreams_free(ll_upstreams *all)
{
    if (all == NULL)
        return;
    pthread_mutex_lock(&all->lock);
    while (all->attempts > 0)
        pthread_cond_wait(&all->attempt_done, &all->lock);
    pthread_mutex_unlock(&all->lock);
    free_list(all->first);
    free_list(all->finished);
    if (all->epoll >= 0)
        close(all->epoll);
    if (all->event_fd >= 0)
        close(all->event_fd);
    free(all->input);
    pthread_mutex_destroy(&all->lock);
    pthread_cond_destroy(&all->attempt_done);
    free(all);
}
