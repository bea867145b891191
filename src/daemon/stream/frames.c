/* Selects the frames of each viewer: which channels, and when. Runs on the stream's thread. */
#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/stream/internal.h"

#include "base/assert.h"

/* An acknowledgement that takes this much longer than the fastest one means that frames queue somewhere (a
 * slow reader, a proxy's buffers): then fewer are kept in flight. About the time of a whole window at 60
 * Hz. */
#define QUEUEING_NS INT64_C(60000000)

/* A new viewer gets BEGIN_WINDOW frames, until it acknowledges, or answers the ping that follows the first of
 * them, or this time is over: RFC 6455 demands the answer also of who never acknowledges, and on a slow line
 * it takes as long as the frames before it. */
#define GRACE_NS INT64_C(5000000000)
#define BEGIN_WINDOW 3

/* A viewer that has been behind for so long loses the events of that time: all of them at once would keep its
 * line busy for as long again. A slow viewer loses them earlier, by the square of the largest divisor that it
 * had lately: the line of one that gets every second frame may be idle while its page is busy, that of one
 * that gets every eighth is not. */
#define BEHIND_NS INT64_C(4000000000)
#define BEHIND_LEAST_NS INT64_C(50000000)

/* A viewer that has not subscribed by then is subscribed to the channels that the page draws. */
#define SUBSCRIBE_NS INT64_C(1000000000)
enum { DEFAULT_HZ = 30, DEFAULT_JSON_HZ = 10 };
static const ll_channel drawn[] = {LL_CHANNEL_SESSION, LL_CHANNEL_SCENE, LL_CHANNEL_MOTION,
                                   LL_CHANNEL_BODIES,  LL_CHANNEL_FIELD, LL_CHANNEL_POINTS};

/* Limit of sections that viewers have as a base and that are not the newest. Beyond it the oldest is
 * released, and its viewers get the next section whole. */
#define KEPT_BYTES ((size_t)4 << 20)

/* ---- channels wanted in the next frame ---- */

static int64_t next_event(const ws_viewer *viewer)
{
    const ll_section *events = viewer->frames.state.section[LL_RECORD_EVENTS];
    return events->rows->first + events->rows->count;
}

static bool loses_events(const ws_viewer *viewer)
{
    int64_t slowdown = ll_ws_pace_worst_divisor(&viewer->flow.pace);
    int64_t part = BEHIND_NS / (slowdown * slowdown), limit = part > BEHIND_LEAST_NS ? part : BEHIND_LEAST_NS;
    return viewer->frames.overdue >> LL_CHANNEL_LANES & 1 &&
           viewer->thread->now_ns - viewer->frames.overdue_ns > limit;
}

/* Goes through all viewers: once for each frame, and when a viewer's part has changed in between, not for
 * every acknowledgement. */
static void publish_wants(ll_ws_stream *stream)
{
    unsigned long long every[LL_CHANNELS] = {0};
    unsigned missing = 0;
    bool anew = false;
    int64_t from_event = LL_NO_EVENT;
    for (const ws_viewer *v = stream->first; v != NULL; v = v->next) {
        if (!v->frames.ready || v->closing.code != 0)
            continue;
        for (int c = 0; c < LL_CHANNELS; c++)
            every[c] |= v->frames.wants >> c & 1 ? 1ULL << v->frames.subscription.every[c] : 0;
        missing |= (unsigned)(v->frames.wants & ~v->frames.has);
        if (!(v->frames.wants >> LL_CHANNEL_LANES & 1))
            continue;
        if (v->frames.state.section[LL_RECORD_EVENTS] == NULL)
            anew = true;
        else if (next_event(v) < from_event && !loses_events(v))
            from_event = next_event(v);
    }
    for (int c = 0; c < LL_CHANNELS; c++) /* a line that is written is gone from the publisher's cache */
        if (atomic_load_explicit(&stream->every[c], memory_order_relaxed) != every[c])
            atomic_store_explicit(&stream->every[c], every[c], memory_order_relaxed);
    if (atomic_load_explicit(&stream->missing, memory_order_relaxed) != missing)
        atomic_store_explicit(&stream->missing, missing, memory_order_relaxed);
    if (atomic_load_explicit(&stream->anew, memory_order_relaxed) != anew)
        atomic_store_explicit(&stream->anew, anew, memory_order_relaxed);
    if (atomic_load_explicit(&stream->from_event, memory_order_relaxed) != from_event)
        atomic_store_explicit(&stream->from_event, from_event, memory_order_relaxed);
    stream->wants_changed = false;
}

static bool lacks_channels(const ws_viewer *viewer)
{
    return viewer->frames.ready && viewer->closing.code == 0 &&
           (viewer->frames.wants & ~viewer->frames.has) != 0;
}

/* After publish_wants: the publisher may read the wants before the hook returns. When it has not read them
 * since the last call, its exchange in ll_ws_wants comes later and it sees the new ones. */
static void ask(ll_ws_stream *stream)
{
    const ll_ws_hooks *hooks = &stream->ws->hooks[stream->kind];
    if (!stream->closing && hooks->wanted != NULL &&
        !atomic_exchange_explicit(&stream->asked, true, memory_order_acq_rel))
        hooks->wanted(hooks->context, stream->session);
}

void ll_ws_viewer_subscribe(ws_viewer *viewer, const ll_ws_subscription *subscription)
{
    _Static_assert(LL_CHANNELS <= 16, "channels are bits of 16");
    viewer->frames.subscription = *subscription;
    viewer->frames.subscribed = true;
    viewer->frames.wants = 0;
    for (int c = 0; c < LL_CHANNELS; c++)
        viewer->frames.wants |= (uint16_t)((subscription->every[c] > 0) << c);
    viewer->frames.has &= viewer->frames.wants;
    viewer->frames.overdue &= viewer->frames.wants;
    viewer->stream->wants_changed = true;
    ll_ws_viewer_send_newest(viewer);
}

static void subscribe_default(ws_viewer *viewer)
{
    bool json = viewer->upgrade.format == LL_FRAME_JSON;
    ll_ws_subscription all = {{0}};
    for (size_t i = 0; i < sizeof drawn / sizeof drawn[0]; i++)
        all.every[drawn[i]] = (uint8_t)(LL_FRAME_HZ / (json ? DEFAULT_JSON_HZ : DEFAULT_HZ));
    ll_ws_viewer_subscribe(viewer, &all);
}

/* ---- sections that viewers have ---- */

static void drop(ll_ws_stream *stream, ll_section **place)
{
    ll_section *section = *place;
    LL_ASSERT(section == NULL || section->users > 0);
    if (section != NULL && --section->users == 0) {
        LL_ASSERT(stream->kept_bytes >= ll_rows_bytes(section->rows));
        stream->kept_bytes -= ll_rows_bytes(section->rows);
        ll_section_release(section);
    }
    *place = NULL;
}

static void have(ll_ws_stream *stream, ll_section **place, ll_section *section)
{
    if (*place == section)
        return;
    drop(stream, place);
    if (section->users++ == 0) { /* one reference for all of the stream's viewers */
        ll_section_retain(section);
        stream->kept_bytes += ll_rows_bytes(section->rows);
    }
    *place = section;
}

static bool is_newest(const ll_ws_stream *stream, int record, const ll_section *section)
{
    return stream->latest != NULL && stream->latest->section[record] == section;
}

/* The oldest section that is not of the newest frame; NULL: none. */
static const ll_section *oldest_kept(const ll_ws_stream *stream)
{
    const ll_section *oldest = NULL;
    for (const ws_viewer *v = stream->first; v != NULL; v = v->next) {
        for (int i = 0; i < LL_RECORDS_MAX; i++) {
            const ll_section *one = v->frames.state.section[i];
            if (one != NULL && !is_newest(stream, i, one) && (oldest == NULL || one->seq < oldest->seq))
                oldest = one;
        }
    }
    return oldest;
}

static void limit_kept_sections(ll_ws_stream *stream)
{
    const ll_section *oldest;
    while (stream->kept_bytes > KEPT_BYTES && (oldest = oldest_kept(stream)) != NULL) {
        for (ws_viewer *v = stream->first; v != NULL; v = v->next) {
            for (int i = 0; i < LL_RECORDS_MAX; i++)
                if (v->frames.state.section[i] == oldest)
                    drop(stream, &v->frames.state.section[i]);
        }
    }
}

static void release_all_sections(ws_viewer *viewer)
{
    for (int i = 0; i < LL_RECORDS_MAX; i++)
        drop(viewer->stream, &viewer->frames.state.section[i]);
    viewer->frames.has = 0;
}

void ll_ws_viewer_release_sections(ws_viewer *viewer)
{
    release_all_sections(viewer);
    viewer->frames.wants = 0;
    publish_wants(viewer->stream);
    if (viewer->stream->viewer_count ==
        1) { /* the last viewer leaves: no later frame would replace this one */
        ll_frame_release(viewer->stream->latest);
        viewer->stream->latest = NULL;
    }
}

/* ---- sending ---- */

/* Frames that may be sent now. A viewer that never acknowledges is limited only by its socket, but not before
 * it could have acknowledged: otherwise a slow reader's first frames would queue. */
static int credit(ws_viewer *viewer)
{
    bool limited =
        viewer->flow.acked_ns != 0 ||
        (!viewer->flow.answered && viewer->thread->now_ns - viewer->frames.first_sent_ns < GRACE_NS);
    bool mute =
        !viewer->frames.ready || viewer->dead || viewer->closing.code != 0 || viewer->messages.first != NULL;
    if (mute || ll_ws_socket_full(viewer))
        return 0;
    return limited && !viewer->frames.fresh ? viewer->flow.window - viewer->flow.outstanding_count
                                            : WS_PENDING;
}

/* Channels of this frame that are due for the viewer. */
static uint16_t due(const ws_viewer *viewer, const ll_frame *frame)
{
    bool last = (frame->flags & LL_FRAME_PLAYING) == 0 || frame->generation != viewer->frames.generation;
    uint16_t channels = (uint16_t)(viewer->frames.overdue | (viewer->frames.wants & ~viewer->frames.has));
    for (int c = 0; c < LL_CHANNELS; c++) {
        uint32_t every =
            viewer->frames.subscription.every[c] * (uint32_t)ll_ws_pace_divisor(&viewer->flow.pace);
        if (viewer->frames.wants >> c & 1 && (last || frame->seq % every == 0))
            channels |= (uint16_t)(1U << c);
    }
    channels &= viewer->frames.wants & frame->channels;
    if (viewer->frames.state.section[LL_RECORD_EVENTS] == NULL && !frame->anew) {
        channels &=
            (uint16_t) ~(1U << LL_CHANNEL_LANES); /* it has to start with the events of the last seconds */
    }
    return channels;
}

static void note_sent(ws_viewer *viewer, const ll_frame *frame, uint16_t channels)
{
    if (viewer->frames.fresh) {
        viewer->frames.first_sent_ns = viewer->thread->now_ns;
        viewer->flow.window = BEGIN_WINDOW;
        ll_ws_socket_measure(viewer);
    }
    viewer->stream->wants_changed = true;
    viewer->frames.fresh = false;
    viewer->frames.has |= channels;
    viewer->frames.overdue &= (uint16_t)~channels;
    viewer->frames.last_sent = frame->seq;
    viewer->frames.last_tick = frame->tick;
    viewer->frames.last_flags = frame->flags;
    viewer->frames.generation = frame->generation;
    for (int i = 0; i < frame->count; i++)
        if (frame->section[i] != NULL && channels >> frame->record[i]->channel & 1)
            have(viewer->stream, &viewer->frames.state.section[i], frame->section[i]);
    if (viewer->flow.outstanding_count == WS_OUTSTANDING) {
        memmove(viewer->flow.outstanding, viewer->flow.outstanding + 1,
                (WS_OUTSTANDING - 1) * sizeof *viewer->flow.outstanding);
        viewer->flow.outstanding_count--;
    }
    int i = viewer->flow.outstanding_count++;
    viewer->flow.outstanding[i].seq = frame->seq;
    viewer->flow.outstanding[i].sent_ns = viewer->thread->now_ns;
}

/* Whether the frame has anything for the viewer: a due channel with a change. */
static bool has_changes(const ws_viewer *viewer, const ll_frame *frame, uint16_t channels)
{
    return channels != 0 &&
           (viewer->frames.fresh || frame->tick != viewer->frames.last_tick ||
            frame->flags != viewer->frames.last_flags || frame->generation != viewer->frames.generation ||
            (channels & ~viewer->frames.has) != 0 || ll_frame_news(frame, &viewer->frames.state, channels));
}

/* Whether the bytes that were written last are those that the viewer gets, too. */
static bool is_repeated(const ws_repeated *last, const ll_frame *frame, const ll_frame_delivery *to)
{
    return last->frame == frame && last->channels == to->channels && last->jump == to->jump &&
           last->format == to->format && memcmp(&last->state, to->state, sizeof last->state) == 0;
}

/* Returns the number of bytes; 0: failed. */
static size_t write_frame(ws_viewer *viewer, const ll_frame *frame, const ll_frame_delivery *to)
{
    ll_buffer *message = &viewer->thread->message;
    ws_repeated *last = &viewer->thread->repeated;
    if (!to->shared || !is_repeated(last, frame, to)) {
        message->size = 0;
        message->failed = ll_buffer_grow(message, LWS_PRE) == NULL;
        ll_frame_write(frame, to, message);
        *last = (ws_repeated){.frame = message->failed ? NULL : frame,
                              .state = *to->state,
                              .channels = to->channels,
                              .jump = to->jump,
                              .format = to->format};
        if (message->failed)
            return 0;
    }
    size_t size = message->size - LWS_PRE;
    ll_ws_socket_write(viewer, (unsigned char *)message->bytes + LWS_PRE, size,
                       to->format == LL_FRAME_JSON ? LWS_WRITE_TEXT : LWS_WRITE_BINARY);
    return viewer->dead ? 0 : size;
}

static void send_frame(ws_viewer *viewer, ll_frame *frame)
{
    uint16_t channels = due(viewer, frame);
    if (!has_changes(viewer, frame, channels))
        return;
    bool jump = viewer->frames.fresh || frame->generation != viewer->frames.generation;
    if (jump)
        release_all_sections(viewer);
    ll_frame_delivery to = {.state = &viewer->frames.state,
                            .channels = channels,
                            .jump = jump,
                            .shared = viewer->stream->viewer_count > 1,
                            .format = viewer->upgrade.format};
    size_t size = write_frame(viewer, frame, &to);
    if (size > 0) {
        note_sent(viewer, frame, channels);
        ll_ws_count(&viewer->thread->counts.frames, 1);
        ll_ws_count(&viewer->thread->counts.bytes, size);
    }
}

static void try_latest(ws_viewer *viewer)
{
    ll_frame *latest = viewer->stream->latest;
    if (credit(viewer) > 0 && latest != NULL &&
        (latest->seq != viewer->frames.last_sent || viewer->frames.fresh ||
         viewer->frames.wants & ~viewer->frames.has))
        send_frame(viewer, latest);
}

void ll_ws_viewer_send_newest(ws_viewer *viewer)
{
    if (viewer->stream == NULL)
        return;
    try_latest(viewer);
    if (viewer->stream->wants_changed)
        publish_wants(viewer->stream);
    if (lacks_channels(viewer))
        ask(viewer->stream);
}

/* ---- slow viewers ---- */

static void say_rate(ws_viewer *viewer, const char *reason)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "type", "rate");
    cJSON_AddStringToObject(o, "reason", reason);
    cJSON_AddNumberToObject(o, "divisor", ll_ws_pace_divisor(&viewer->flow.pace));
    ll_ws_viewer_send_json(viewer, o);
}

static void count_due(ws_viewer *viewer, bool missed)
{
    int64_t now = viewer->thread->now_ns;
    int before = ll_ws_pace_divisor(&viewer->flow.pace);
    if (missed)
        ll_ws_count(&viewer->thread->counts.skipped, 1);
    if (ll_ws_pace_count(&viewer->flow.pace, missed, now)) {
        bool slower = ll_ws_pace_divisor(&viewer->flow.pace) > before;
        say_rate(viewer, slower ? "slow viewer" : "viewer keeps up again");
    }
}

/* ---- distribution ---- */

static void note_missed(ws_viewer *viewer, uint16_t channels)
{
    if (channels & ~viewer->frames.overdue & 1U << LL_CHANNEL_LANES)
        viewer->frames.overdue_ns = viewer->thread->now_ns;
    viewer->frames.overdue |= channels;
}

/* Of several frames a viewer with enough credit gets all, in order; others the newest ones. */
static void offer_frames(ws_viewer *viewer, ll_frame **frames, int count)
{
    int may = credit(viewer);
    for (int i = 0; i < count; i++) {
        uint16_t channels = due(viewer, frames[i]);
        bool misses = i < count - may || credit(viewer) <= 0;
        if (channels == 0 || !viewer->frames.ready)
            continue;
        if (misses)
            note_missed(viewer, channels);
        else
            send_frame(viewer, frames[i]);
        count_due(viewer, misses);
    }
}

/* Usually one; more when this thread was late. */
void ll_ws_stream_distribute(ll_ws_stream *stream, ll_frame **frames, int count)
{
    ll_frame_release(stream->latest);
    stream->latest = frames[count - 1];
    stream->thread->repeated.frame = NULL; /* its bytes may have gone, and its sections' addresses too */
    for (ws_viewer *viewer = stream->first; viewer != NULL; viewer = viewer->next)
        offer_frames(viewer, frames, count);
    stream->thread->repeated.frame = NULL;
    for (int i = 0; i < count - 1; i++)
        ll_frame_release(frames[i]);
    limit_kept_sections(stream);
    publish_wants(stream);
}

/* ---- acknowledgements ---- */

static void adapt_window(ws_viewer *viewer, int64_t delay)
{
    if (viewer->flow.delay_ns == 0 || delay < viewer->flow.delay_ns)
        viewer->flow.delay_ns = delay;
    else
        viewer->flow.delay_ns += (delay - viewer->flow.delay_ns) / 512;
    if (delay > viewer->flow.delay_ns + QUEUEING_NS)
        viewer->flow.window -= viewer->flow.window > 1 ? 1 : 0;
    else
        viewer->flow.window += viewer->flow.window < LL_FRAME_WINDOW ? 1 : 0;
}

void ll_ws_viewer_acknowledge(ws_viewer *viewer, uint32_t seq)
{
    if (viewer->frames.fresh || (int32_t)(seq - viewer->frames.last_sent) > 0)
        return; /* was never sent; ignore */
    int gone = 0;
    while (gone < viewer->flow.outstanding_count && (int32_t)(seq - viewer->flow.outstanding[gone].seq) >= 0)
        gone++;
    if (gone > 0 && viewer->flow.outstanding[gone - 1].seq == seq)
        adapt_window(viewer, viewer->thread->now_ns - viewer->flow.outstanding[gone - 1].sent_ns);
    /* The same one again is no progress; one that is older than those remembered may be. */
    if (viewer->flow.acked_ns == 0 || (int32_t)(seq - viewer->flow.acked_seq) > 0) {
        viewer->flow.acked_ns = viewer->thread->now_ns;
        viewer->flow.acked_seq = seq;
    }
    viewer->flow.outstanding_count -= gone;
    memmove(viewer->flow.outstanding, viewer->flow.outstanding + gone,
            (size_t)viewer->flow.outstanding_count * sizeof *viewer->flow.outstanding);
    ll_ws_viewer_send_newest(viewer);
}

void ll_ws_viewer_sweep_frames(ws_viewer *viewer)
{
    int64_t waited = viewer->thread->now_ns - viewer->frames.hello_ns;
    if (viewer->frames.ready && !viewer->frames.subscribed && waited > SUBSCRIBE_NS)
        subscribe_default(viewer);
    else
        ll_ws_viewer_send_newest(viewer); /* of a paused session, when the grace is over */
}
