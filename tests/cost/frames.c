/* Plays a scenario and writes each of its frames for one viewer of the page's channels, as the daemon does
 * for a session with one viewer, without sockets and threads: what tests/cost counts of simulation and
 * encoding together. cost_frames SCENARIO FRAMES */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>

#include "library/library.h"
#include "netcode/metrics/client_metrics.h"
#include "session/frame.h"
#include "session/session.h"

typedef struct viewer {
    ll_frame_state published, has; /* the daemon's newest sections, and the viewer's */
    ll_row_set space;
    ll_buffer message;
    int64_t events; /* the first that the viewer does not have */
    uint32_t seq;
    size_t bytes;
} viewer;

/* What the page subscribes to: every frame has these, every n-th the others. */
static const struct {
    ll_channel channel;
    uint32_t every;
} page[] = {{LL_CHANNEL_SESSION, 1}, {LL_CHANNEL_CLOCK, 1},  {LL_CHANNEL_SCENE, 1}, {LL_CHANNEL_LANES, 1},
            {LL_CHANNEL_GAUGES, 6},  {LL_CHANNEL_SHOTS, 12}, {LL_CHANNEL_BODIES, 1}};

static uint16_t due(uint32_t seq)
{
    unsigned channels = 0;
    for (size_t i = 0; i < sizeof page / sizeof *page; i++)
        channels |= seq % page[i].every == 0 ? 1U << page[i].channel : 0;
    return (uint16_t)channels;
}

static void keep_sections(viewer *v, const ll_frame *frame)
{
    for (int i = 0; i < frame->count; i++) {
        if (frame->section[i] != NULL && frame->section[i] != v->has.section[i]) {
            ll_section_retain(frame->section[i]);
            ll_section_release(v->has.section[i]);
            v->has.section[i] = frame->section[i];
        }
    }
    if (frame->section[LL_RECORD_EVENTS] != NULL) {
        const ll_rows *events = frame->section[LL_RECORD_EVENTS]->rows;
        v->events = events->first + events->count;
    }
}

static ll_status send_frame(viewer *v, const ll_session *session)
{
    ll_frame *frame;
    uint16_t channels = due(++v->seq);
    ll_record_request request = {.channels = channels,
                                 .anew = v->seq == 1,
                                 .from_event = v->events,
                                 .viewers = 1,
                                 .wall_ns = (uint64_t)v->seq * 16666667};
    ll_status status = ll_frame_take(session, &request, v->seq, &v->published, &v->space, &frame);
    if (ll_failed(&status))
        return status;
    ll_frame_delivery to = {.state = &v->has, .channels = channels, .format = LL_FRAME_BINARY};
    v->message.size = 0;
    ll_frame_write(frame, &to, &v->message);
    v->bytes += v->message.size;
    keep_sections(v, frame);
    ll_frame_release(frame);
    return v->message.failed ? ll_error(LL_NO_MEMORY, "out of memory: frame") : ll_ok();
}

static ll_status play(ll_session *session, viewer *v, int64_t frames)
{
    ll_status status = ll_ok();
    for (int64_t tick = 1; tick <= frames && !ll_failed(&status); tick++) {
        status = ll_session_run_to(session, tick);
        if (!ll_failed(&status))
            status = send_frame(v, session);
    }
    return status;
}

int main(int argc, char **argv)
{
    cJSON *scenario = NULL;
    ll_session *session = NULL;
    viewer v = {0};
    if (argc != 3) {
        fprintf(stderr, "cost_frames SCENARIO FRAMES\n");
        return 2;
    }
    ll_status status = ll_scenario_load("scenarios", argv[1], &scenario);
    if (!ll_failed(&status))
        status = ll_session_create(scenario, -1, NULL, NULL, &session);
    if (!ll_failed(&status))
        status = play(session, &v, strtoll(argv[2], NULL, 10));
    if (ll_failed(&status))
        fprintf(stderr, "cost_frames: %s\n", status.text);
    else
        printf("%zu bytes in %u frames\n", v.bytes, (unsigned)v.seq);
    free(v.message.bytes);
    ll_frame_state_clear(&v.has);
    ll_frame_state_clear(&v.published);
    ll_row_set_free(&v.space);
    if (session != NULL)
        ll_session_destroy(session);
    cJSON_Delete(scenario);
    return ll_failed(&status) ? 1 : 0;
}
