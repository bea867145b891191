/* A viewer's bytes after its handshake, to a stream of the daemon, which libwebsockets reads: frames,
 * fragments, control frames and invalid data. Messages must equal those of a second reader of RFC 6455, up to
 * the point where that one finds a fault or stops; output must be whole, unmasked frames, the last a close
 * with a valid code. */
#include "check.h"

#include <errno.h>
#include <semaphore.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/hash.h"
#include "daemon/listener/web_server.h"
#include "daemon/net/connection_limiter.h"
#include "daemon/stream/ws.h"

#define LONG 4096
#define MESSAGE 512             /* --max-message-bytes */
#define MESSAGES (LONG / 6 + 1) /* the smallest frame has six bytes */
#define HELLO "{\"type\":\"hello\"}"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* ---- the daemon ---- */

static struct {
    ll_connection_limiter *connection_limiter;
    ll_ws *ws;
    ll_ws_stream *stream;
    sem_t gone;
    int count; /* of received messages */
    char *text[MESSAGES];
    size_t size[MESSAGES];
} side;

static void on_opened(void *context, void *session, ll_ws_viewer viewer, ll_frame_format format)
{
    (void)context, (void)session, (void)format;
    ll_ws_hello(side.ws, viewer, HELLO, strlen(HELLO));
}

static void on_message(void *context, void *session, ll_ws_viewer viewer, const char *text, size_t length)
{
    (void)context, (void)session, (void)viewer;
    FUZZ_CHECK(length <= MESSAGE && text[length] == '\0' && side.count < MESSAGES);
    char *copy = malloc(length + 1);
    FUZZ_CHECK(copy != NULL);
    memcpy(copy, text, length + 1);
    side.text[side.count] = copy;
    side.size[side.count++] = length;
}

static void on_closed(void *context, void *session, ll_ws_viewer viewer)
{
    (void)context, (void)session, (void)viewer;
    sem_post(&side.gone);
}

static void start(void)
{
    const ll_ws_hooks hooks = {.opened = on_opened, .message = on_message, .closed = on_closed};
    ll_web_server_config config;
    ll_param_defaults(&ll_web_server_table, &config);
    config.stream_threads = 1;
    config.max_messages_per_s = 1e9;
    config.max_message_bytes = MESSAGE;
    side.connection_limiter = ll_connection_limiter_new(1000, 1000);
    FUZZ_CHECK(side.connection_limiter != NULL && sem_init(&side.gone, 0, 0) == 0);
    ll_status status = ll_ws_start(&config, side.connection_limiter, &side.ws);
    FUZZ_CHECK(!fuzz_failed(&status));
    ll_ws_set_hooks(side.ws, LL_STREAM_SESSION, &hooks);
    status = ll_ws_stream_open(side.ws, LL_STREAM_SESSION, "s", &side, &side.stream);
    FUZZ_CHECK(!fuzz_failed(&status));
}

/* ---- the second reader ---- */

typedef struct frame {
    bool fin;
    int opcode;
    const uint8_t *mask;
    size_t at, size; /* of the payload */
} frame;

/* The next frame; false: incomplete or invalid. */
static bool next_frame(const uint8_t *data, size_t size, size_t *at, frame *f)
{
    size_t left = size - *at, head = 2;
    const uint8_t *b = data + *at;
    if (left < head || (b[0] & 0x70) != 0 || (b[1] & 0x80) == 0)
        return false;
    uint64_t length = b[1] & 0x7f;
    size_t more = length == 126 ? 2 : length == 127 ? 8 : 0;
    head += more;
    if (left < head + 4)
        return false;
    if (more > 0)
        length = 0;
    for (size_t i = 0; i < more; i++)
        length = length << 8 | b[2 + i];
    if (length > left - head - 4)
        return false;
    *f = (frame){(b[0] & 0x80) != 0, b[0] & 15, b + head, *at + head + 4, (size_t)length};
    *at = f->at + f->size;
    return true;
}

/* RSV bits, or no mask: the rest is not compared. */
static bool is_faulty(const uint8_t *data, size_t size, size_t at)
{
    return size - at >= 2 && ((data[at] & 0x70) != 0 || (data[at + 1] & 0x80) == 0);
}

static bool is_ack(const char *text)
{
    unsigned long long value;
    int end = -1, digits;
    return sscanf(text, " { \"ack\" : %n", &digits) == 0 && text[0] != '\0' &&
           sscanf(text, " { \"ack\" : %10llu } %n", &value, &end) == 1 && end > 0 && text[end] == '\0' &&
           value <= UINT32_MAX && strpbrk(text, "+-\v\f") == NULL;
}

/* Compares the messages with those of the second reader. */
static void compare(const uint8_t *data, size_t size)
{
    char text[LONG + 1];
    size_t at = 0, length = 0;
    int seen = 0;
    bool open = false, followed = true;
    frame f;
    while (followed && next_frame(data, size, &at, &f)) {
        bool control = f.opcode >= 8;
        followed = control ? f.fin && f.size <= 125 && (f.opcode == 9 || f.opcode == 10)
                           : f.opcode == (open ? 0 : 1);
        if (!followed || control)
            continue;
        length = open ? length : 0;
        for (size_t i = 0; i < f.size; i++)
            text[length + i] = (char)(data[f.at + i] ^ f.mask[i & 3]);
        length += f.size;
        text[length] = '\0';
        open = !f.fin;
        followed = length <= MESSAGE && (open || (strlen(text) == length && fuzz_is_text(text)));
        if (!followed || open || is_ack(text))
            continue;
        if (seen == side.count) /* the end may be detected before the last bytes are read */
            return;
        FUZZ_CHECK(side.size[seen] == length && memcmp(side.text[seen], text, length) == 0);
        seen++;
    }
    FUZZ_CHECK(!followed || is_faulty(data, size, at) || seen == side.count);
}

/* ---- output ---- */

static bool may_be_sent(int code)
{
    return (code >= 1000 && code <= 1003) || (code >= 1007 && code <= 1011) || code == 1013;
}

/* The library echoes a viewer's close frame unchanged, also an invalid one. */
static bool is_own_close(const uint8_t *sent, size_t sent_size, const uint8_t *payload, size_t length)
{
    size_t at = 0;
    frame f;
    while (next_frame(sent, sent_size, &at, &f)) {
        bool same = f.opcode == 8 && f.size >= length;
        for (size_t i = 0; same && i < length; i++)
            same = payload[i] == (sent[f.at + i] ^ f.mask[i & 3]);
        if (same)
            return true;
    }
    return is_faulty(sent, sent_size, at);
}

static void check_answer(const uint8_t *sent, size_t sent_size, const uint8_t *data, size_t size)
{
    size_t at = 0;
    const uint8_t *head = memmem(data, size, "\r\n\r\n", 4);
    FUZZ_CHECK(head != NULL && memcmp(data, "HTTP/1.1 101", 12) == 0);
    for (at = (size_t)(head - data) + 4; size - at >= 2;) {
        const uint8_t *b = data + at;
        size_t length = b[1], more = length == 126 ? 2 : length == 127 ? 8 : 0;
        int opcode = b[0] & 15;
        FUZZ_CHECK((b[0] & 0xf0) == 0x80 && b[1] < 128 && more < 8);
        if (size - at < 2 + more)
            return;
        length = more > 0 ? (size_t)(b[2] << 8 | b[3]) : length;
        FUZZ_CHECK(opcode == 1 || opcode == 8 || opcode == 10);
        if (size - at < 2 + more + length)
            return;
        if (opcode == 8)
            FUZZ_CHECK(length == 0 || (length >= 2 && may_be_sent(b[2] << 8 | b[3])) ||
                       is_own_close(sent, sent_size, b + 2, length));
        at += 2 + more + length;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t answer[1 << 20];
    const ll_connection_limiter_pass pass = {.valid = false};
    ll_upgrade upgrade = {
        .kind = LL_STREAM_SESSION, .id = "s", .key = "dGhlIHNhbXBsZSBub25jZQ==", .format = LL_FRAME_JSON};
    int ends[2];
    if (side.ws == NULL)
        start();
    if (size > LONG)
        return 0;
    FUZZ_CHECK(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
    side.count = 0;
    /* The first piece ends anywhere: within a head, a mask's turn, a character. */
    size_t early = ll_hash(0, data, size) % (size + 1), late = size - early;
    FUZZ_CHECK(early == 0 || write(ends[0], data, early) == (ssize_t)early);
    ll_ws_adopt(side.ws, &upgrade, ends[1], &pass);
    if (late > 0 && send(ends[0], data + early, late, MSG_NOSIGNAL) < 0)
        FUZZ_CHECK(errno == EPIPE); /* it was closed for the first */
    shutdown(ends[0], SHUT_WR);
    size_t got = 0;
    ssize_t n;
    while ((n = read(ends[0], answer + got, sizeof answer - got)) > 0 || (n < 0 && errno == EINTR))
        got += n > 0 ? (size_t)n : 0;
    while (sem_wait(&side.gone) != 0) /* libFuzzer's timer interrupts waits */
        FUZZ_CHECK(errno == EINTR);
    close(ends[0]);
    compare(data, size);
    if (n == 0) /* closing a socket with unread bytes resets it, and loses what was sent */
        check_answer(data, size, answer, got);
    for (int i = 0; i < side.count; i++)
        free(side.text[i]);
    return 0;
}
