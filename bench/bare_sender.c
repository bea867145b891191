/* The least that a server of frames does: the peer of bench/frames.mjs.
 *
 *   bare_sender SESSIONS VIEWERS BYTES HZ
 *
 * One thread with epoll. Each session's frame is stamped and framed once per period and sent to each of its
 * viewers by one `send`; acknowledgements are read, unmasked and noted. Nothing is simulated, encoded,
 * limited or timed out, and no two messages of one viewer wait for each other. It serves stream_client's
 * plain mode: the same header and key, so the answer to the key is a constant. Prints
 * {"port":N,"paths":[...]} as the other peers do. */
#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

enum {
    HEAD = 26,  /* of a frame, as in bench/peers/frame.mjs */
    CLOCK = 60, /* ids of records; no table has the second */
    FILLER = 127,
    WEBSOCKET_HEAD = 4,
    INPUT = 1024, /* of one viewer: a request's head, or messages */
};

typedef struct viewer {
    int fd, filled;
    bool open;
    uint32_t acked;
    struct viewer *next; /* of its session */
    unsigned char input[INPUT];
} viewer;

static viewer **sessions;
static int session_count, poller;
static unsigned char *frame;
static size_t frame_size;

static void die(const char *what)
{
    fprintf(stderr, "bare_sender: %s: %s\n", what, strerror(errno));
    exit(1);
}

static void put(unsigned char *at, uint64_t value, int length)
{
    for (int i = 0; i < length; i++)
        at[i] = (unsigned char)((value >> 7 * i & 127) | (i < length - 1 ? 128 : 0));
}

/* Returns the payload's offset in `frame`. */
static size_t make_frame(size_t bytes)
{
    size_t size = bytes < HEAD ? HEAD : bytes, head = size < 126 ? 2 : WEBSOCKET_HEAD;
    frame_size = head + size;
    frame = malloc(frame_size);
    if (!frame || size > 65535)
        die("frame");
    memset(frame, 7, frame_size);
    frame[0] = 0x82;
    frame[1] = (unsigned char)(head == 2 ? size : 126);
    if (head == WEBSOCKET_HEAD) {
        frame[2] = (unsigned char)(size >> 8);
        frame[3] = (unsigned char)size;
    }
    unsigned char *body = frame + head;
    memcpy(body, (unsigned char[]){1, 2}, 2);
    put(body + 7, 0, 1);                                                   /* tick */
    memcpy(body + 8, (unsigned char[]){CLOCK, 4 * 12 + 2, 1, 1, 0, 1}, 6); /* whole: a row, its one field */
    body[22] = FILLER;
    put(body + 23, 4 * (size - HEAD), 3);
    return head;
}

static void send_frames(size_t body, uint32_t seq)
{
    for (int s = 0; s < session_count; s++) {
        struct timespec t;
        if (!sessions[s])
            continue;
        clock_gettime(CLOCK_MONOTONIC, &t);
        put(frame + body + 2, seq, 5);
        put(frame + body + 14, ((uint64_t)t.tv_sec * 1000000 + (uint64_t)t.tv_nsec / 1000) * 2, 8);
        for (viewer *v = sessions[s]; v; v = v->next)
            if (send(v->fd, frame, frame_size, MSG_NOSIGNAL | MSG_DONTWAIT) != (ssize_t)frame_size &&
                errno != EPIPE && errno != ECONNRESET)
                die("a viewer does not read"); /* as a peer it must not lose a frame */
    }
}

static void accept_viewer(int listener)
{
    int on = 1, fd = accept4(listener, NULL, NULL, SOCK_NONBLOCK);
    viewer *v = calloc(1, sizeof *v);
    struct epoll_event event = {.events = EPOLLIN, .data.ptr = v};
    if (fd < 0 || !v)
        die("accept");
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    v->fd = fd;
    epoll_ctl(poller, EPOLL_CTL_ADD, fd, &event);
}

static int open_viewer(viewer *v)
{
    static const char answer[] =
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n\r\n";
    unsigned char *end = memmem(v->input, (size_t)v->filled, "\r\n\r\n", 4);
    int session = -1;
    if (!end)
        return 0;
    if (!memmem(v->input, (size_t)v->filled, "dGhlIHNhbXBsZSBub25jZQ==", 24) ||
        sscanf((char *)v->input, "GET /%d ", &session) != 1 || session < 0 || session >= session_count ||
        send(v->fd, answer, sizeof answer - 1, MSG_NOSIGNAL) != sizeof answer - 1)
        die("not stream_client");
    v->open = true;
    v->next = sessions[session];
    sessions[session] = v;
    return (int)(end + 4 - v->input);
}

/* Returns how many bytes the message at `at` takes; 0: it is not whole. */
static int take_message(viewer *v, unsigned char *at, int filled)
{
    static const char ack[] = "{\"ack\":";
    int size = filled < 2 ? 0 : at[1] & 127;
    if (filled < 2 || filled < 6 + size)
        return 0;
    for (int i = 0; i < size; i++)
        at[6 + i] ^= at[2 + i % 4];
    if ((at[0] & 15) == 1 && size > (int)sizeof ack && memcmp(at + 6, ack, sizeof ack - 1) == 0)
        v->acked = (uint32_t)strtoul((char *)at + 6 + sizeof ack - 1, NULL, 10); /* ends at the brace */
    return 6 + size;
}

static void read_viewer(viewer *v)
{
    ssize_t n = recv(v->fd, v->input + v->filled, (size_t)(INPUT - 1 - v->filled), 0);
    if (n <= 0) {
        epoll_ctl(poller, EPOLL_CTL_DEL, v->fd, NULL); /* the measurement is over */
        return;
    }
    v->filled += (int)n;
    v->input[v->filled] = '\0';
    int used = v->open ? 0 : open_viewer(v), size = 0;
    while (v->open && (size = take_message(v, v->input + used, v->filled - used)) > 0)
        used += size;
    v->filled -= used;
    if (v->filled > 0)
        memmove(v->input, v->input + used, (size_t)v->filled);
}

static int start_listening(void)
{
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t size = sizeof address;
    struct epoll_event event = {.events = EPOLLIN, .data.ptr = NULL};
    int listener = socket(AF_INET, SOCK_STREAM, 0);
    if (listener < 0 || bind(listener, (struct sockaddr *)&address, size) != 0 ||
        listen(listener, 1024) != 0 || getsockname(listener, (struct sockaddr *)&address, &size) != 0)
        die("listen");
    epoll_ctl(poller, EPOLL_CTL_ADD, listener, &event);
    printf("{\"port\":%d,\"paths\":[", ntohs(address.sin_port));
    return listener;
}

int main(int argc, char **argv)
{
    if (argc != 5)
        die("SESSIONS VIEWERS BYTES HZ");
    int viewers = atoi(argv[2]), hz = atoi(argv[4]), timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK);
    struct rlimit files = {32768, 32768};
    struct itimerspec period = {.it_interval.tv_nsec = 1000000000 / hz, .it_value.tv_nsec = 1000000000 / hz};
    struct epoll_event tick = {.events = EPOLLIN, .data.ptr = &timer}, events[256];
    setrlimit(RLIMIT_NOFILE, &files);
    session_count = atoi(argv[1]);
    sessions = calloc((size_t)session_count, sizeof *sessions);
    poller = epoll_create1(0);
    size_t body = make_frame((size_t)atoi(argv[3]));
    int listener = start_listening();
    for (int i = 0; i < session_count * viewers; i++)
        printf("%s\"/%d\"", i > 0 ? "," : "", i / viewers);
    printf("]}\n");
    fflush(stdout);
    epoll_ctl(poller, EPOLL_CTL_ADD, timer, &tick);
    timerfd_settime(timer, 0, &period, NULL);
    for (uint32_t seq = 0;;) {
        int n = epoll_wait(poller, events, 256, -1);
        for (int i = 0; i < n; i++) {
            uint64_t periods;
            if (events[i].data.ptr == &timer && read(timer, &periods, sizeof periods) == sizeof periods)
                send_frames(body, ++seq);
            else if (events[i].data.ptr == NULL)
                accept_viewer(listener);
            else if (events[i].data.ptr != &timer)
                read_viewer(events[i].data.ptr);
        }
    }
}
