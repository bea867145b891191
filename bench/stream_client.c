/* Viewers of a stream server, many of them in one thread, measured from outside.
 *
 *   stream_client --port N --mode laglab|ws|colyseus [--pid SERVER] [--warmup S] [--seconds S] [--no-ack]
 * [--each]
 *
 * Reads one viewer a line from standard input, `[slow|slowframes] PATH`, opens all of them, acknowledges
 * every frame, and prints one JSON object: intervals between frames, frames missing from the sequence, age of
 * the frames, what the server spent meanwhile. `slow` reads a fifth of the bytes that a fast viewer gets;
 * `slowframes` reads a fifth of the frames.
 *
 * The WebSocket client is as small as it can be, so that what is measured is the server. All modes carry the
 * same frame: laglab's header (session/frame.h), of which `seq` and `wall_ns` are read. Server and client
 * share one monotonic clock. */
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
#include <time.h>
#include <unistd.h>

#include "session/frame.h"

enum {
    VIEWERS_MAX = 20000,
    BUFFER = 1 << 18, /* of one viewer; the largest message must fit */
    SLOW_FACTOR = 5,  /* a slow viewer reads this many times less */
    FRAME_HZ = 60,
    LATE_MS = 350, /* no viewer should see older frames */
    OPENING_AT_ONCE = 64,
    OPENING_S = 60,
    COLYSEUS_JOIN = 10, /* first byte of its messages */
    COLYSEUS_BYTES = 17,
    COLYSEUS_HEAD = 2, /* that byte and the message's type */
};

typedef enum mode { LAGLAB, PLAIN_WS, COLYSEUS } mode;
typedef enum pace { FAST, SLOW_BYTES, SLOW_FRAMES } pace;
typedef enum state { WAITING, HANDSHAKE, OPEN, CLOSED } state;

typedef struct viewer {
    char *path;
    pace pace;
    state state;
    int fd;
    unsigned char *buffer;
    size_t filled;
    double budget; /* of a slow one: bytes or frames that it may still read */
    uint32_t seq;
    double last_s;           /* when the last frame was read */
    double opened_s, late_s; /* ..., and when the last one that was older than LATE_MS */
    bool begun;              /* a frame has been counted: the next one ends an interval */
    long frames, lost, keys;
    int64_t wall_us; /* of the daemon's clock */
    double bytes;
    float *interval, *age; /* ms, one entry per frame */
    long intervals, ages, capacity;
} viewer;

static mode server_mode;
static bool acknowledge = true;
static int rate_hz = 60; /* of a viewer's frames */
static uint16_t port;
static viewer *viewers;
static int viewer_count;
static int poller;
static bool measuring;

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void die(const char *what)
{
    fprintf(stderr, "stream_client: %s: %s\n", what, strerror(errno));
    exit(1);
}

/* ---- sending ---- */

static void close_viewer(viewer *v, const char *why)
{
    fprintf(stderr, "stream_client: %s was closed: %s\n", v->path, why);
    close(v->fd);
    v->state = CLOSED;
}

/* A short masked message. The mask is what the protocol asks of clients; a constant one does. */
static void send_message(viewer *v, int opcode, const void *bytes, size_t size)
{
    static const unsigned char mask[4] = {0x12, 0x34, 0x56, 0x78};
    unsigned char out[6 + 125] = {(unsigned char)(0x80 | opcode), (unsigned char)(0x80 | size)};
    memcpy(out + 2, mask, sizeof mask);
    for (size_t i = 0; i < size; i++)
        out[6 + i] = ((const unsigned char *)bytes)[i] ^ mask[i % 4];
    if (send(v->fd, out, 6 + size, MSG_NOSIGNAL | MSG_DONTWAIT) != (ssize_t)(6 + size))
        close_viewer(v, "it does not take acknowledgements");
}

static void send_ack(viewer *v, uint32_t seq)
{
    if (server_mode == COLYSEUS) {
        unsigned char out[COLYSEUS_HEAD + sizeof seq] = {COLYSEUS_BYTES, 1};
        memcpy(out + COLYSEUS_HEAD, &seq, sizeof seq);
        send_message(v, 2, out, sizeof out);
    } else {
        char out[32];
        int size = snprintf(out, sizeof out, "{\"ack\":%u}", seq);
        send_message(v, 1, out, (size_t)size);
    }
}

/* What the page subscribes to, and the clock. */
static void subscribe(viewer *v)
{
    char wish[128];
    int size = snprintf(wish, sizeof wish,
                        "{\"subscribe\":{\"session\":%d,\"scene\":%d,\"lanes\":%d,\"gauges\":%d,\"shots\":%d,"
                        "\"clock\":%d,\"bodies\":%d}}",
                        rate_hz, rate_hz, rate_hz, rate_hz < 10 ? rate_hz : 10, rate_hz < 5 ? rate_hz : 5,
                        rate_hz, rate_hz);
    if (server_mode != COLYSEUS)
        send_message(v, 1, wish, (size_t)size);
}

/* ---- receiving ---- */

static uint64_t varint(const unsigned char **at, const unsigned char *end)
{
    uint64_t value = 0;
    for (int shift = 0; *at < end; shift += 7) {
        value |= (uint64_t)(**at & 127) << shift;
        if (*(*at)++ < 128)
            break;
    }
    return value;
}

static int64_t unzigzag(uint64_t value)
{
    return (int64_t)(value >> 1) ^ -(int64_t)(value & 1);
}

/* The daemon's clock, the one row and field of its record: whole, or what it has gone on since. */
static void take_clock(viewer *v, const unsigned char *at, const unsigned char *end, bool whole)
{
    varint(&at, end); /* rows */
    if (varint(&at, end) == 0)
        return;
    varint(&at, end); /* skipped */
    varint(&at, end); /* mask */
    v->wall_us = (whole ? 0 : v->wall_us) + unzigzag(varint(&at, end));
}

static void count_frame(viewer *v, const unsigned char *frame, size_t size)
{
    const unsigned char *at = frame + 2, *end = frame + size;
    uint8_t flags = frame[1];
    uint32_t seq = (uint32_t)varint(&at, end);
    varint(&at, end); /* tick */
    static uint64_t clock_id;
    if (clock_id == 0) {
        const ll_record *all[LL_ALL_RECORDS_MAX + 1];
        ll_all_records(all);
        for (int i = 0; clock_id == 0; i++)
            clock_id = strcmp(all[i]->name, "clock") == 0 ? (uint64_t)all[i]->id : 0;
    }
    while (at < end) {
        uint64_t id = varint(&at, end), head = varint(&at, end);
        if (head / 4 > (uint64_t)(end - at))
            break;
        if (id == clock_id)
            take_clock(v, at, at + head / 4, head & 2);
        at += head / 4;
    }
    /* laglab numbers all frames of a session, of which a viewer may ask for fewer. */
    long step = server_mode == LAGLAB && rate_hz < FRAME_HZ ? FRAME_HZ / rate_hz : 1;
    double now = now_s(), age_ms = (now - (double)v->wall_us * 1e-6) * 1e3;
    if (age_ms > LATE_MS)
        v->late_s = now - v->opened_s;
    if (measuring) {
        if (v->ages == v->capacity) {
            v->capacity = v->capacity ? 2 * v->capacity : 2048;
            v->interval = realloc(v->interval, (size_t)v->capacity * sizeof *v->interval);
            v->age = realloc(v->age, (size_t)v->capacity * sizeof *v->age);
            if (!v->interval || !v->age)
                die("memory");
        }
        if (v->begun) {
            v->interval[v->intervals++] = (float)((now - v->last_s) * 1e3);
            v->lost += ((long)(seq - v->seq) + step / 2) / step - 1;
        }
        v->begun = true;
        v->age[v->ages++] = (float)age_ms;
        v->frames++;
        v->bytes += (double)size;
        v->keys += (flags & LL_FRAME_JUMP) != 0;
    } else if (!v->begun) {
        v->frames++; /* of the warm-up: how fast a slow viewer may read */
        v->bytes += (double)size;
    }
    v->seq = seq;
    v->last_s = now;
    if (acknowledge && v->state == OPEN)
        send_ack(v, seq);
}

static void take_message(viewer *v, int opcode, const unsigned char *bytes, size_t size)
{
    static const unsigned char join = COLYSEUS_JOIN;
    size_t head = server_mode == COLYSEUS ? COLYSEUS_HEAD : 0;
    if (opcode == 8) {
        close_viewer(v, size > 2 ? (const char *)bytes + 2 : "no reason given");
    } else if (opcode == 9) {
        send_message(v, 10, bytes, size < 125 ? size : 125);
    } else if (server_mode == COLYSEUS && opcode == 2 && size > 0 && bytes[0] == COLYSEUS_JOIN) {
        send_message(v, 2, &join, sizeof join);
    } else if (opcode == 2 && size > head + 3) {
        count_frame(v, bytes + head, size - head);
    }
}

/* Whole size of the message at the front of the buffer; 0: not known yet. */
static size_t message_size(const viewer *v, size_t *head)
{
    const unsigned char *b = v->buffer;
    if (v->filled < 2)
        return 0;
    size_t size = b[1] & 0x7f;
    *head = 2;
    if (size == 126) {
        if (v->filled < 4)
            return 0;
        size = (size_t)b[2] << 8 | b[3];
        *head = 4;
    } else if (size == 127) {
        if (v->filled < 10)
            return 0;
        size = (size_t)b[6] << 24 | (size_t)b[7] << 16 | (size_t)b[8] << 8 | b[9];
        *head = 10;
    }
    return *head + size;
}

/* Returns how many frames (binary messages) there were. */
static int take_messages(viewer *v)
{
    int taken = 0;
    size_t head, size, used = 0;
    unsigned char *start = v->buffer;
    while (v->state == OPEN && (size = message_size(v, &head)) > 0 && size <= v->filled) {
        int opcode = v->buffer[0] & 15;
        take_message(v, opcode, v->buffer + head, size - head);
        taken += opcode == 2;
        v->buffer += size;
        v->filled -= size;
        used += size;
    }
    v->buffer = start;
    memmove(v->buffer, v->buffer + used, v->filled);
    return taken;
}

static void finish_handshake(viewer *v)
{
    unsigned char *end = memmem(v->buffer, v->filled, "\r\n\r\n", 4);
    if (!end)
        return;
    if (memcmp(v->buffer, "HTTP/1.1 101", 12) != 0) {
        *end = '\0';
        close_viewer(v, (const char *)v->buffer);
        return;
    }
    size_t used = (size_t)(end + 4 - v->buffer);
    v->filled -= used;
    memmove(v->buffer, end + 4, v->filled);
    v->state = OPEN;
    v->opened_s = now_s();
    subscribe(v);
    if (v->pace != FAST)
        epoll_ctl(poller, EPOLL_CTL_DEL, v->fd, NULL); /* read by the clock */
}

/* Reads at most `limit` bytes. Returns how many. */
static size_t receive(viewer *v, size_t limit)
{
    size_t room = BUFFER - v->filled;
    ssize_t n = recv(v->fd, v->buffer + v->filled, limit < room ? limit : room, MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno != EAGAIN))
        close_viewer(v, n == 0 ? "end of stream" : strerror(errno));
    if (n <= 0)
        return 0;
    v->filled += (size_t)n;
    return (size_t)n;
}

static void read_fast(viewer *v)
{
    if (receive(v, BUFFER) == 0)
        return;
    if (v->state == HANDSHAKE)
        finish_handshake(v);
    take_messages(v);
}

static void read_slow(viewer *v)
{
    if (v->pace == SLOW_BYTES) {
        size_t n = v->budget >= 1 ? receive(v, (size_t)v->budget) : 0;
        v->budget -= (double)n;
        take_messages(v);
        return;
    }
    while (v->state == OPEN && v->budget >= 1) { /* not a byte more than this one message */
        size_t head = 2, size = message_size(v, &head);
        size_t wanted = size ? size : v->filled < 2 ? 2 : (v->buffer[1] & 0x7f) == 127 ? 10 : 4;
        if (v->filled < wanted && receive(v, wanted - v->filled) == 0)
            return;
        v->budget -= take_messages(v);
    }
}

/* ---- opening ---- */

static void open_viewer(viewer *v)
{
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons(port)};
    struct epoll_event event = {.events = EPOLLIN, .data.ptr = v};
    char request[1024];
    int on = 1;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    v->fd = socket(AF_INET, SOCK_STREAM, 0);
    v->buffer = malloc(BUFFER);
    if (v->fd < 0 || !v->buffer || connect(v->fd, (struct sockaddr *)&address, sizeof address) != 0)
        die("connect");
    setsockopt(v->fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    int size = snprintf(
        request, sizeof request,
        "GET %s HTTP/1.1\r\nHost: 127.0.0.1:%u\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n%s\r\n",
        v->path, (unsigned)port, server_mode == COLYSEUS ? "" : "Sec-WebSocket-Protocol: laglab.v2.bin\r\n");
    if (send(v->fd, request, (size_t)size, MSG_NOSIGNAL) != size)
        die("send");
    epoll_ctl(poller, EPOLL_CTL_ADD, v->fd, &event);
    v->state = HANDSHAKE;
}

static int count_state(state s)
{
    int n = 0;
    for (int i = 0; i < viewer_count; i++)
        n += viewers[i].state == s;
    return n;
}

static void read_ready(int timeout_ms)
{
    struct epoll_event events[256];
    int n = epoll_wait(poller, events, 256, timeout_ms);
    for (int i = 0; i < n; i++)
        read_fast(events[i].data.ptr);
}

static void open_all(void)
{
    double deadline = now_s() + OPENING_S;
    int opened = 0;
    while (count_state(OPEN) + count_state(CLOSED) < viewer_count && now_s() < deadline) {
        while (opened < viewer_count && count_state(HANDSHAKE) < OPENING_AT_ONCE)
            open_viewer(&viewers[opened++]);
        read_ready(10);
    }
}

/* ---- running ---- */

static double fast_bytes_per_frame(void)
{
    double bytes = 0, frames = 0;
    for (int i = 0; i < viewer_count; i++)
        if (viewers[i].pace == FAST && viewers[i].frames > 0) {
            bytes += viewers[i].bytes;
            frames += (double)viewers[i].frames;
        }
    return frames > 0 ? bytes / frames + 4 : 0; /* with the WebSocket header */
}

static void run_until(double end)
{
    double last = now_s(), slow_s = 0.002;
    bool any_slow = false;
    for (int i = 0; i < viewer_count; i++)
        any_slow |= viewers[i].pace != FAST;
    for (double now = last; now < end; now = now_s()) {
        read_ready(any_slow ? 2 : 20);
        if (!any_slow || now_s() - last < slow_s)
            continue;
        double passed = now_s() - last, frames = passed * FRAME_HZ / SLOW_FACTOR,
               size = fast_bytes_per_frame();
        last += passed;
        for (int i = 0; i < viewer_count; i++) {
            viewer *v = &viewers[i];
            if (v->state != OPEN || v->pace == FAST)
                continue;
            /* No saving up: who did not read for lack of data does not read faster later. */
            double most = v->pace == SLOW_FRAMES ? 1.5 : size / 2;
            v->budget += v->pace == SLOW_FRAMES ? frames : frames * size;
            v->budget = v->budget > most ? most : v->budget;
            read_slow(v);
        }
    }
}

typedef struct cpu {
    double server, client, machine; /* seconds; machine: all that was not idle */
} cpu;

static double server_rss_mb(long pid)
{
    char path[64], line[256];
    long kb = 0;
    snprintf(path, sizeof path, "/proc/%ld/status", pid);
    FILE *f = fopen(path, "r");
    while (f && fgets(line, sizeof line, f))
        sscanf(line, "VmRSS: %ld", &kb);
    if (f)
        fclose(f);
    return (double)kb / 1024;
}

static cpu read_cpu(long pid)
{
    cpu c = {0};
    char path[64], text[1024];
    double hz = (double)sysconf(_SC_CLK_TCK);
    unsigned long long user = 0, nice = 0, system = 0, idle, wait, irq = 0, softirq = 0, own_user = 0,
                       own_system = 0;
    snprintf(path, sizeof path, "/proc/%ld/stat", pid);
    FILE *f = pid ? fopen(path, "r") : NULL;
    if (f && fgets(text, sizeof text, f)) {
        const char *after = strrchr(text, ')');
        if (after)
            sscanf(after + 2, "%*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %llu %llu", &own_user,
                   &own_system);
    }
    if (f)
        fclose(f);
    f = fopen("/proc/stat", "r");
    if (f && fscanf(f, "cpu %llu %llu %llu %llu %llu %llu %llu", &user, &nice, &system, &idle, &wait, &irq,
                    &softirq) != 7)
        user = 0;
    if (f)
        fclose(f);
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    c.server = (double)(own_user + own_system) / hz;
    c.machine = (double)(user + nice + system + irq + softirq) / hz;
    c.client = (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
               (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) * 1e-6;
    return c;
}

/* ---- the report ---- */

static int ascending(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static double quantile(const float *sorted, long count, double q)
{
    long i = (long)(q * (double)(count - 1) + 0.5);
    return count > 0 ? (double)sorted[i] : 0;
}

static void print_distribution(const char *name, float *values, long count)
{
    qsort(values, (size_t)count, sizeof *values, ascending);
    printf("\"%s\":{\"p1\":%.3f,\"p50\":%.3f,\"p95\":%.3f,\"p99\":%.3f,\"p999\":%.3f,\"max\":%.3f,\"count\":%"
           "ld}",
           name, quantile(values, count, 0.01), quantile(values, count, 0.5), quantile(values, count, 0.95),
           quantile(values, count, 0.99), quantile(values, count, 0.999), quantile(values, count, 1), count);
}

/* All viewers of one pace: their samples pooled, and the p99 of the worst of them. */
static void print_group(const char *name, pace wanted)
{
    long intervals = 0, ages = 0, frames = 0, lost = 0, keys = 0, losers = 0, stalls = 0;
    double bytes = 0, worst = 0, late = 0;
    int count = 0;
    for (int i = 0; i < viewer_count; i++)
        if (viewers[i].pace == wanted) {
            intervals += viewers[i].intervals;
            ages += viewers[i].ages;
        }
    if (!ages)
        return;
    float *interval = malloc(((size_t)intervals + 1) * sizeof *interval),
          *age = malloc(((size_t)ages + 1) * sizeof *age);
    if (!interval || !age)
        die("memory");
    intervals = ages = 0;
    for (int i = 0; i < viewer_count; i++) {
        viewer *v = &viewers[i];
        if (v->pace != wanted)
            continue;
        count++;
        frames += v->frames;
        lost += v->lost;
        losers += v->lost > 0;
        keys += v->keys;
        bytes += v->bytes;
        late = v->late_s > late ? v->late_s : late;
        if (v->intervals)
            memcpy(interval + intervals, v->interval, (size_t)v->intervals * sizeof *interval);
        if (v->ages)
            memcpy(age + ages, v->age, (size_t)v->ages * sizeof *age);
        intervals += v->intervals;
        ages += v->ages;
        if (v->intervals)
            qsort(v->interval, (size_t)v->intervals, sizeof *v->interval, ascending);
        double p99 = quantile(v->interval, v->intervals, 0.99);
        worst = p99 > worst ? p99 : worst;
        for (long k = 0; k < v->intervals; k++)
            stalls += (double)v->interval[k] > 25; /* a frame and a half */
    }
    printf(",\"%s\":{\"viewers\":%d,\"frames\":%ld,\"lost\":%ld,\"viewers_with_loss\":%ld,\"keys\":%ld,"
           "\"bytes_per_frame\":%.1f,"
           "\"stalls\":%ld,\"worst_viewer_p99_ms\":%.3f,\"late_until_s\":%.3f,",
           name, count, frames, lost, losers, keys, frames ? bytes / (double)frames : 0, stalls, worst, late);
    print_distribution("interval_ms", interval, intervals);
    printf(",");
    print_distribution("age_ms", age, ages);
    printf("}");
    free(interval);
    free(age);
}

static void read_targets(void)
{
    char line[1024];
    viewers = calloc(VIEWERS_MAX, sizeof *viewers);
    while (viewers && viewer_count < VIEWERS_MAX && fgets(line, sizeof line, stdin)) {
        viewer *v = &viewers[viewer_count++];
        char *path = strchr(line, '/');
        line[strcspn(line, "\r\n")] = '\0';
        if (!path)
            die("a line of standard input has no path");
        v->pace = strncmp(line, "slowframes ", 11) == 0 ? SLOW_FRAMES
                  : strncmp(line, "slow ", 5) == 0      ? SLOW_BYTES
                                                        : FAST;
        v->path = strdup(path);
    }
}

int main(int argc, char **argv)
{
    double warmup = 3, seconds = 20;
    long pid = 0;
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--no-ack") == 0) {
            acknowledge = false;
            continue;
        }
        if (strcmp(argv[i], "--port") == 0)
            port = (uint16_t)atoi(value);
        else if (strcmp(argv[i], "--mode") == 0)
            server_mode = strcmp(value, "colyseus") == 0 ? COLYSEUS
                          : strcmp(value, "ws") == 0     ? PLAIN_WS
                                                         : LAGLAB;
        else if (strcmp(argv[i], "--pid") == 0)
            pid = atol(value);
        else if (strcmp(argv[i], "--hz") == 0)
            rate_hz = atoi(value);
        else if (strcmp(argv[i], "--warmup") == 0)
            warmup = atof(value);
        else if (strcmp(argv[i], "--seconds") == 0)
            seconds = atof(value);
        else {
            fprintf(stderr, "stream_client: unknown option %s\n", argv[i]);
            return 2;
        }
        i++;
    }
    struct rlimit files = {VIEWERS_MAX + 64, VIEWERS_MAX + 64};
    setrlimit(RLIMIT_NOFILE, &files); /* the default is enough for a thousand */
    poller = epoll_create1(0);
    read_targets();
    open_all();
    run_until(now_s() + warmup);
    for (int i = 0; i < viewer_count; i++) {
        viewers[i].frames = 0;
        viewers[i].bytes = 0;
    }
    measuring = true;
    double begin = now_s();
    cpu before = read_cpu(pid);
    run_until(begin + seconds);
    double wall = now_s() - begin;
    cpu after = read_cpu(pid);
    double server = after.server - before.server, client = after.client - before.client, frames = 0;
    for (int i = 0; i < viewer_count; i++)
        frames += (double)viewers[i].frames;
    printf("{\"viewers\":%d,\"open\":%d,\"seconds\":%.3f,\"frames_per_s\":%.1f,\"server_cpu_pct\":%.2f,"
           "\"server_us_per_frame\":%.3f,"
           "\"client_cpu_pct\":%.2f,\"others_cpu_pct\":%.2f,\"server_rss_mb\":%.1f",
           viewer_count, count_state(OPEN), wall, frames / wall, 100 * server / wall,
           frames > 0 ? 1e6 * server / frames : 0, 100 * client / wall,
           100 * (after.machine - before.machine - server - client) / wall, server_rss_mb(pid));
    print_group("fast", FAST);
    print_group("slow_bytes", SLOW_BYTES);
    print_group("slow_frames", SLOW_FRAMES);
    printf("}\n");
    return count_state(OPEN) == viewer_count ? 0 : 1;
}
