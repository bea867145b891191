/* The stream of one session: read once from the owner, published to all of its viewers.
 *
 * A frame that is published has the rows of its own tick and no older ones, as the owner's have. Which
 * channels those are is known from what a message has, and from the subscription: a record that has not
 * changed is left out of a message, so that its absence alone says nothing. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <inttypes.h>

#include "daemon/relay/internal.h"
#include "daemon/support/log.h"

#define RETRY_NS INT64_C(100000000)       /* the first wait for another attempt, then doubled */
#define RETRY_MOST_NS INT64_C(2000000000) /* and the longest */
#define STABLE_NS INT64_C(5000000000)     /* a connection that lasted so long was a good one */
#define PING_NS INT64_C(2000000000)
#define MUTE_NS INT64_C(7000000000) /* until a second connection without a hello is given up */
/* An owner that has just started answers 404 until its sessions are loaded. */
#define MISSING_NS INT64_C(5000000000)
#define LOWER_NS INT64_C(2000000000) /* until a subscription is lowered: viewers come and go */
#define AWAY_NS INT64_C(500000000)   /* until viewers get a message */
#define GREET_NS INT64_C(100000000)  /* between two fetched hellos */
#define REPEAT_NS INT64_C(10000000)  /* between two frames for viewers that have come */
/* What the messages of a session may cost to read, each byte that was sent apart from that FAIR times: deltas
 * and compression make that of any honest frame. The largest scene costs half as much. */
#define COST_PER_S (64.0 * (1 << 20))
#define COST_BURST (2 * COST_PER_S)
enum { FAIR = 8 };
enum { SOON = 3 /* the next frame comes within 3 of 60 a second */ };
#define DRIFT 1e-4 /* of two machines' clocks, at most */

static void leave_open(relay_source *s)
{
    if (s->up)
        atomic_fetch_sub(&s->streams->counts.connected, 1);
    s->upstream = NULL;
    s->open = s->up = false;
}

static void end_with(relay_source *s, int code, const char *reason)
{
    s->end_code = code;
    snprintf(s->end_reason, sizeof s->end_reason, "%s", reason);
}

/* ---- subscription ---- */

/* Whether some frames that `wish` has are not among those of `have`. */
static bool needs_more(const ll_ws_subscription *have, const ll_ws_subscription *wish)
{
    for (int c = 0; c < LL_CHANNELS; c++)
        if (wish->every[c] != 0 && (have->every[c] == 0 || wish->every[c] % have->every[c] != 0))
            return true;
    return false;
}

static void send_subscription(relay_source *s, const ll_ws_subscription *wish)
{
    char text[700];
    int size = snprintf(text, sizeof text, "{\"subscribe\":{");
    const char *between = "";
    for (int c = 0; c < LL_CHANNELS; c++) {
        if (wish->every[c] == 0)
            continue;
        size += snprintf(text + size, sizeof text - (size_t)size, "%s\"%s\":%d", between, ll_channels[c].name,
                         LL_FRAME_HZ / wish->every[c]);
        between = ",";
    }
    size += snprintf(text + size, sizeof text - (size_t)size, "}}");
    s->asked = *wish;
    s->asks++;
    s->granting = 0;
    s->lower_ns = 0;
    ll_upstream_send(s->upstream, text, (size_t)size);
}

/* Never gives a channel up, but keeps it at a frame a second: the rows that are there stay known. */
static void update_subscription(relay_source *s, int64_t now)
{
    ll_ws_subscription wish = ll_ws_rates(s->stream);
    if (wish.every[LL_CHANNEL_SESSION] == 0) /* says when parameters change */
        wish.every[LL_CHANNEL_SESSION] = LL_FRAME_HZ;
    for (int c = 0; c < LL_CHANNELS; c++)
        if (wish.every[c] == 0 && s->asked.every[c] != 0)
            wish.every[c] = LL_FRAME_HZ;
    if (memcmp(&wish, &s->asked, sizeof wish) == 0)
        s->lower_ns = 0;
    else if (needs_more(&s->asked, &wish) || (s->lower_ns != 0 && now - s->lower_ns > LOWER_NS))
        send_subscription(s, &wish);
    else if (s->lower_ns == 0)
        s->lower_ns = now;
}

/* ---- hello ---- */

static char *with_format(const char *hello, const char *format)
{
    static const char own[] = "\"format\":\"bin\"";
    const char *at = strstr(hello, own);
    size_t size = strlen(hello) + 32;
    char *text = at != NULL ? malloc(size) : NULL;
    if (text != NULL)
        snprintf(text, size, "%.*s\"format\":\"%s\"%s", (int)(at - hello), hello, format,
                 at + sizeof own - 1);
    return text;
}

static void keep_hello(relay_source *s, const char *text)
{
    char *bin = with_format(text, "bin"), *json = with_format(text, "json");
    if (bin == NULL || json == NULL) {
        free(bin);
        free(json);
        return;
    }
    free(s->hello[LL_FRAME_BINARY]);
    free(s->hello[LL_FRAME_JSON]);
    s->hello[LL_FRAME_BINARY] = bin;
    s->hello[LL_FRAME_JSON] = json;
}

static const char *text_of(const cJSON *json, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, name);
    return cJSON_IsString(item) ? item->valuestring : "";
}

static double number_of(const cJSON *json, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, name);
    return cJSON_IsNumber(item) ? item->valuedouble : 0;
}

/* Why the stream cannot be read; NULL: it can. */
static const char *hello_fault(relay_source *s, const cJSON *hello)
{
    char schema[17];
    const char *kind = text_of(cJSON_GetObjectItemCaseSensitive(hello, "params"), "kind");
    double tick_hz = number_of(hello, "tick_hz");
    snprintf(schema, sizeof schema, "%016" PRIx64, ll_stream_schema_hash());
    if (strcmp(text_of(hello, "protocol"), "laglab.v2") != 0 ||
        strcmp(text_of(hello, "format"), "bin") != 0 || strcmp(text_of(hello, "schema"), schema) != 0)
        return "the owner's version of laglab has another stream than the relay's";
    if (s->hello[0] != NULL && (strcmp(kind, s->session_kind) != 0 || tick_hz != s->tick_hz))
        return "the session has become another one";
    ll_status status = ll_frame_reader_begin(&s->reader, kind, tick_hz);
    if (ll_failed(&status))
        return "the owner's hello cannot be read";
    snprintf(s->session_kind, sizeof s->session_kind, "%s", kind);
    s->tick_hz = tick_hz;
    return NULL;
}

static void take_hello(relay_source *s, const cJSON *hello, const char *text)
{
    const char *fault = s->up ? NULL : hello_fault(s, hello);
    if (fault == NULL)
        keep_hello(s, text);
    if (fault != NULL || s->hello[0] == NULL) {
        end_with(s, LL_WS_TRY_LATER, fault != NULL ? fault : "the owner's hello cannot be read");
        return;
    }
    if (!s->up) {
        atomic_fetch_add(&s->streams->counts.connected, 1);
        s->up = true;
        s->owner_away = false;
        s->up_ns = ll_relay_now();
        s->missing_ns = 0;
        s->version_known = false;
    }
    s->stale = false;
}

static void say_to(relay_source *s, ll_ws_viewer viewer)
{
    const char *text =
        s->away ? "{\"type\":\"owner\",\"connected\":false}" : "{\"type\":\"owner\",\"connected\":true}";
    ll_ws_send(s->streams->ws, viewer, text, strlen(text));
}

static void give_hellos(relay_source *s)
{
    relay_streams *streams = s->streams;
    pthread_mutex_lock(&streams->lock);
    for (relay_viewer *v = s->watching; v != NULL && s->waiting > 0; v = v->next) {
        const char *hello = s->hello[v->format];
        if (v->greeted)
            continue;
        v->greeted = true;
        s->waiting--;
        ll_ws_hello(streams->ws, v->viewer, hello, strlen(hello));
        if (s->away)
            say_to(s, v->viewer);
    }
    pthread_mutex_unlock(&streams->lock);
}

/* Says to viewers when the owner is away for more than a moment: what they see stands still, and no key
 * helps.
 */
static void note_away(relay_source *s, int64_t now)
{
    bool away = !s->up || s->owner_away;
    s->away_ns = !away ? 0 : s->away_ns != 0 ? s->away_ns : now;
    bool tell = away && now - s->away_ns > AWAY_NS;
    if (tell == s->away || s->hello[0] == NULL)
        return;
    s->away = tell;
    pthread_mutex_lock(&s->streams->lock);
    for (const relay_viewer *v = s->watching; v != NULL; v = v->next)
        if (v->greeted)
            say_to(s, v->viewer);
    pthread_mutex_unlock(&s->streams->lock);
}

/* ---- a second connection, for a hello with the present parameters ---- */

static void on_greeting(void *context, const char *text, size_t size)
{
    relay_source *s = context;
    cJSON *json = cJSON_ParseWithLength(text, size);
    if (strcmp(text_of(json, "type"), "hello") == 0) {
        keep_hello(s, text);
        ll_upstream_close(s->greeting);
        s->greeting = NULL;
        s->streams->swept_ns = 0;
    }
    cJSON_Delete(json);
}

static void on_greeting_closed(void *context, int code, const char *reason)
{
    (void)code, (void)reason;
    relay_source *s = context;
    s->greeting = NULL; /* the hello that is there has to do */
}

static void ignore_opened(void *context)
{
    (void)context;
}

static void ignore_binary(void *context, const void *bytes, size_t size)
{
    (void)context, (void)bytes, (void)size;
}

static const ll_upstream_hooks greeting_hooks = {
    .opened = ignore_opened, .text = on_greeting, .binary = ignore_binary, .closed = on_greeting_closed};

static void path_of(const relay_source *s, char path[120])
{
    snprintf(path, 120, "/api/v1/sessions/%s/stream", s->id);
}

/* Gives hellos to those who wait, once there is one with the present parameters. */
static void greet(relay_source *s, int64_t now)
{
    char path[120];
    if (s->greeting != NULL && now - s->greeted_ns > MUTE_NS) { /* the hello that is there has to do */
        ll_upstream_close(s->greeting);
        s->greeting = NULL;
    }
    if (s->up && s->stale && s->greeting == NULL && now - s->greeted_ns > GREET_NS) {
        path_of(s, path);
        s->greeted_ns = now;
        s->stale = false; /* a change from now on makes it stale again */
        s->greeting = ll_upstream_open(s->streams->upstreams, path, "laglab.v2.bin", &greeting_hooks, s);
    }
    if (s->greeting == NULL && s->hello[0] != NULL)
        give_hellos(s);
}

/* ---- frames ---- */

/* Channels whose rows are of the last message's tick. While a subscription is on its way, only what the old
 * one and the new one have in common is sure. */
static uint16_t fresh_channels(const relay_source *s)
{
    const ll_frame_reader *reader = &s->reader;
    unsigned fresh = reader->present | (unsigned)~reader->of_kind;
    if (reader->jumped || !(reader->flags & LL_FRAME_PLAYING))
        return ll_frame_reader_channels(reader);
    for (int c = 0; c < LL_CHANNELS; c++) {
        uint32_t asked = s->asked.every[c] * s->divisor, granted = s->granted.every[c] * s->divisor;
        if (asked != 0 && granted != 0 && reader->seq % asked == 0 && reader->seq % granted == 0)
            fresh |= 1U << c;
    }
    return (uint16_t)(fresh & ll_frame_reader_channels(reader));
}

/* The number under which the last message is published: the owner's, as long as that rises. A frame that
 * comes instead of an earlier one, which the owner left out, has that one's number when more viewers wait for
 * it: their rates are multiples of frames. */
static uint32_t next_seq(relay_source *s)
{
    uint32_t newest = s->reader.seq + s->offset;
    int32_t behind = (int32_t)(s->seq - newest);
    if (!s->published)
        return newest;
    if (behind >= 0) {
        s->offset += ((uint32_t)behind / LL_FRAME_HZ + 1) * LL_FRAME_HZ;
        newest = s->reader.seq + s->offset;
    }
    uint32_t best = newest, left_out = newest - s->seq - 1;
    int most = -1;
    for (uint32_t n = 0; left_out > 0 && n <= left_out && n < LL_FRAME_HZ; n++) {
        ll_record_request request = {0};
        ll_ws_wants(s->stream, newest - n, s->generation, false, &request);
        int due = __builtin_popcount(request.channels);
        if (due > most) {
            most = due;
            best = newest - n;
        }
    }
    return best;
}

static void publish(relay_source *s, uint32_t seq, uint16_t channels)
{
    relay_streams *streams = s->streams;
    ll_record_request request = {0};
    ll_frame *frame;
    ll_ws_wants(s->stream, seq, s->generation, !(s->reader.flags & LL_FRAME_PLAYING), &request);
    request.channels &= channels;
    s->seq = seq;
    s->published = true;
    if (request.channels == 0)
        return;
    if (s->last_generation != s->generation)
        ll_frame_state_clear(&s->last);
    s->last_generation = s->generation;
    ll_status status =
        ll_frame_reader_frame(&s->reader, &request, seq, s->generation, &s->last, &streams->space, &frame);
    if (ll_failed(&status))
        return; /* no memory: the next one may have it */
    ll_ws_publish(s->stream, frame);
    ll_frame_release(frame);
    streams->published = true;
}

static void note_version(relay_source *s)
{
    int64_t version;
    if (!ll_frame_reader_value(&s->reader, LL_RECORD_SESSION, "params_version", &version))
        return;
    if (s->version_known && version != s->version) {
        s->stale = true;
        atomic_fetch_add(&s->streams->epoch, 1);
    }
    s->version_known = true;
    s->version = version;
}

static void acknowledge(relay_source *s)
{
    char text[32];
    int size = snprintf(text, sizeof text, "{\"ack\":%" PRIu32 "}", s->reader.seq);
    ll_upstream_send(s->upstream, text, (size_t)size);
}

/* Whether the last message may have cost what it did. Not reset with the connection: an owner that is cut off
 * comes again at once. */
static bool charge(relay_source *s, size_t size)
{
    int64_t now = ll_relay_now();
    double cost = (double)s->reader.cost - (double)FAIR * (double)size;
    double paid = (double)(now - s->charged_ns) * 1e-9 * COST_PER_S;
    s->charged_ns = now;
    s->debt = (s->debt > paid ? s->debt - paid : 0) + (cost > 0 ? cost : 0);
    return s->debt <= COST_BURST;
}

static void lost(relay_source *s, int code, const char *reason);

static void on_binary(void *context, const void *bytes, size_t size)
{
    relay_source *s = context;
    relay_counts *counts = &s->streams->counts;
    if (!s->up || s->end_code != 0)
        return;
    atomic_fetch_add_explicit(&counts->frames, 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&counts->bytes, size, memory_order_relaxed);
    ll_status status = ll_frame_reader_take(&s->reader, bytes, size);
    if (!charge(s, size))
        status =
            ll_error(LL_BAD_INPUT, "the owner's messages, when unpacked, have more than 64 MiB a second");
    if (ll_failed(&status)) {
        atomic_fetch_add(&counts->faults, 1);
        ll_upstream_close(s->upstream);
        lost(s, LL_UPSTREAM_CUT, status.text);
        return;
    }
    s->generation += s->reader.jumped;
    if (s->granting > 0 && --s->granting == 0)
        s->granted = s->asked;
    s->fresh = fresh_channels(s);
    note_version(s);
    publish(s, next_seq(s), s->fresh);
    acknowledge(s); /* may find that the connection has ended */
}

/* Shows the last frame to viewers that have come since. Where the next one comes soon, they wait for it. */
static void repeat(relay_source *s, int64_t now)
{
    bool playing = (s->reader.flags & LL_FRAME_PLAYING) != 0, soon = false;
    pthread_mutex_lock(&s->streams->lock);
    bool wanted = s->wanted && now - s->repeated_ns > REPEAT_NS && s->reader.begun;
    s->wanted = s->wanted && !wanted;
    pthread_mutex_unlock(&s->streams->lock);
    for (int c = 0; c < LL_CHANNELS; c++)
        soon = soon || (s->asked.every[c] != 0 && s->asked.every[c] * s->divisor <= SOON);
    if (!wanted || (s->up && playing && soon))
        return;
    s->repeated_ns = now;
    publish(s, s->seq + 1, s->up ? s->fresh : ll_frame_reader_channels(&s->reader));
}

/* ---- messages of the owner ---- */

static void take_pong(relay_source *s, const cJSON *pong)
{
    relay_streams *streams = s->streams;
    int64_t now = ll_relay_now(), sent = s->pinged_ns, error = (now - sent) / 2;
    double wall = number_of(pong, "wall_ns");
    if (number_of(pong, "ping") != (double)(sent / 1000) || !(wall > -9e15 && wall < 9e18))
        return;
    double grown = (double)streams->clock_error_ns + DRIFT * (double)(now - streams->clock_known_ns);
    if (streams->clock_known_ns == 0 || (double)error <= grown) {
        streams->clock_known_ns = now;
        streams->clock_error_ns = error;
        atomic_store(&streams->clock_ns, (int64_t)wall - (sent + error));
    }
}

static void on_text(void *context, const char *text, size_t size)
{
    relay_source *s = context;
    cJSON *json = cJSON_ParseWithLength(text, size);
    const char *type = text_of(json, "type");
    if (s->end_code != 0) {
        /* nothing counts any more */
    } else if (strcmp(type, "hello") == 0) {
        take_hello(s, json, text);
        s->streams->swept_ns = 0;
    } else if (strcmp(type, "reply") == 0) {
        s->asks--;
        s->granting = s->asks == 0 ? 2 : 0; /* a frame may have been taken just before */
    } else if (strcmp(type, "rate") == 0) {
        double divisor = number_of(json, "divisor");
        s->divisor = divisor >= 1 && divisor <= LL_FRAME_HZ ? (unsigned)divisor : 1;
    } else if (strcmp(type, "pong") == 0) {
        take_pong(s, json);
    } else if (strcmp(type, "owner") == 0) {
        s->owner_away = cJSON_IsFalse(cJSON_GetObjectItemCaseSensitive(json, "connected"));
    }
    cJSON_Delete(json);
}

/* ---- the connection ---- */

static void lost(relay_source *s, int code, const char *reason)
{
    int64_t now = ll_relay_now(), wait = RETRY_NS << (s->attempt < 5 ? s->attempt : 5);
    bool had = s->up, missing = code == 404 || code == LL_WS_NO_SESSION;
    leave_open(s);
    atomic_fetch_add(&s->streams->counts.lost, 1);
    s->streams->clock_known_ns = 0; /* it may come back on another machine */
    s->missing_ns = !missing ? 0 : s->missing_ns != 0 ? s->missing_ns : now;
    if (missing && (code == LL_WS_NO_SESSION || s->hello[0] == NULL || now - s->missing_ns > MISSING_NS)) {
        end_with(s, LL_WS_NO_SESSION, "the owner does not have it");
        return;
    }
    if (had)
        ll_log_write("warn", "stream of the owner lost", "%s", reason);
    wait = wait < RETRY_MOST_NS ? wait : RETRY_MOST_NS;
    s->retry_ns = now + wait / 2 + now % (wait / 2); /* not all of them at once */
    s->attempt++;
}

static void on_opened(void *context)
{
    relay_source *s = context;
    s->open = true;
    s->pinged_ns = 0;
    s->asked = s->granted = (ll_ws_subscription){{0}};
    s->asks = s->granting = 0;
    s->divisor = 1;
    update_subscription(s, ll_relay_now());
}

static void on_closed(void *context, int code, const char *reason)
{
    lost(context, code, reason);
}

static const ll_upstream_hooks source_hooks = {
    .opened = on_opened, .text = on_text, .binary = on_binary, .closed = on_closed};

static void open_connection(relay_source *s, int64_t now)
{
    char path[120];
    path_of(s, path);
    s->upstream = ll_upstream_open(s->streams->upstreams, path, "laglab.v2.bin", &source_hooks, s);
    if (s->upstream == NULL)
        s->retry_ns = now + RETRY_MOST_NS;
}

/* Measures the owner's clock. Whether the owner is silent is noticed by upstream.c. */
static void ping_owner(relay_source *s, int64_t now)
{
    char text[48];
    if (s->up && now - s->up_ns > STABLE_NS)
        s->attempt = 0;
    if (now - s->pinged_ns > PING_NS) {
        s->pinged_ns = now;
        int size = snprintf(text, sizeof text, "{\"ping\":%" PRId64 "}", now / 1000);
        ll_upstream_send(s->upstream, text, (size_t)size);
    }
}

void ll_relay_source_step(relay_source *s, int64_t now)
{
    if (s->kind != LL_STREAM_SESSION || s->end_code != 0)
        return;
    if (s->upstream == NULL && now >= s->retry_ns)
        open_connection(s, now);
    if (s->open)
        update_subscription(s, now);
    if (s->open) /* each of these may find that it has ended */
        ping_owner(s, now);
    if (s->end_code == 0) {
        note_away(s, now);
        greet(s, now);
        repeat(s, now);
    }
}

void ll_relay_source_disconnect(relay_source *s)
{
    ll_upstream_close(s->upstream);
    ll_upstream_close(s->greeting);
    s->greeting = NULL;
    leave_open(s);
    ll_relay_tunnels_free(s);
}

void ll_relay_source_free(relay_source *s)
{
    while (s->watching != NULL) {
        relay_viewer *next = s->watching->next;
        free(s->watching);
        s->watching = next;
    }
    ll_frame_reader_end(&s->reader);
    ll_frame_state_clear(&s->last);
    free(s->hello[0]);
    free(s->hello[1]);
    free(s);
}
