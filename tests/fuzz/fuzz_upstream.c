/* What a relay reads of an owner: the first byte chooses the kind of session, the others are a server's
 * WebSocket frames. Each message that is read makes a frame for viewers, as bytes, which a second reader must
 * read as the same rows, and as text, which must be JSON. */
#include "check.h"

#include "daemon/net/framing.h"
#include "daemon/stream/frame_reader.h"

#define MESSAGE (1 << 20)

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const char *const kinds[] = {"netgame", "motion", "rigid", "fluid"};

typedef struct relay {
    ll_frame_reader reader, viewer;
    ll_frame_state last, has;
    ll_row_set space;
    uint32_t seq, generation;
    int64_t events;
    bool failed;
} relay;

static void begin(ll_frame_reader *reader, const char *kind)
{
    ll_status status = ll_frame_reader_begin(reader, kind, 60);
    FUZZ_CHECK(!fuzz_failed(&status));
}

static void read_as_viewer(relay *r, const ll_frame *frame, bool jump)
{
    ll_buffer message = {0}, text = {0};
    ll_frame_delivery to = {
        .state = &r->has, .channels = frame->channels, .jump = jump, .format = LL_FRAME_JSON};
    ll_frame_write(frame, &to, &text);
    ll_buffer_add(&text, "", 1);
    cJSON *json = cJSON_ParseWithOpts(text.bytes, NULL, true);
    FUZZ_CHECK(cJSON_IsObject(json));
    cJSON_Delete(json);
    to.format = LL_FRAME_BINARY;
    ll_frame_write(frame, &to, &message);
    FUZZ_CHECK(!message.failed && !text.failed);
    ll_status status = ll_frame_reader_take(&r->viewer, message.bytes, message.size);
    FUZZ_CHECK(!fuzz_failed(&status));
    for (int i = 0; i < frame->count; i++) {
        if (frame->section[i] == NULL)
            continue;
        const ll_rows *rows = frame->section[i]->rows, *seen = r->viewer.rows[i];
        FUZZ_CHECK(seen != NULL && seen->first + seen->count == rows->first + rows->count);
        FUZZ_CHECK(rows->record->form == LL_FORM_LOG || ll_rows_equal(rows, seen));
        ll_section_retain(frame->section[i]);
        ll_section_release(r->has.section[i]);
        r->has.section[i] = frame->section[i];
    }
    free(message.bytes);
    free(text.bytes);
}

static void take_message(relay *r, const void *bytes, size_t size)
{
    ll_frame *frame;
    ll_status status = ll_frame_reader_take(&r->reader, bytes, size);
    r->failed = ll_failed(&status);
    if (r->failed)
        return;
    bool jump = r->reader.jumped;
    if (jump) {
        r->generation++;
        ll_frame_state_clear(&r->last);
        ll_frame_state_clear(&r->has);
    }
    ll_record_request request = {.channels = ll_frame_reader_channels(&r->reader),
                                 .anew = jump || r->has.section[LL_RECORD_EVENTS] == NULL,
                                 .from_event = jump ? LL_NO_EVENT : r->events,
                                 .deltas = true};
    status =
        ll_frame_reader_frame(&r->reader, &request, ++r->seq, r->generation, &r->last, &r->space, &frame);
    FUZZ_CHECK(!fuzz_failed(&status));
    read_as_viewer(r, frame, jump);
    const ll_rows *log =
        frame->section[LL_RECORD_EVENTS] != NULL ? frame->section[LL_RECORD_EVENTS]->rows : NULL;
    r->events = log != NULL ? log->first + log->count : r->events;
    ll_frame_release(frame);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    relay r = {.events = LL_NO_EVENT};
    ll_framing framing = {.of_server = true};
    ll_buffer message = {0};
    size_t used = 0;
    if (size < 2)
        return 0;
    const char *kind = kinds[data[0] % (sizeof kinds / sizeof kinds[0])];
    unsigned char *bytes = malloc(size - 1);
    FUZZ_CHECK(bytes != NULL);
    memcpy(bytes, data + 1, size - 1);
    begin(&r.reader, kind);
    begin(&r.viewer, kind);
    while (used < size - 1 && !r.failed) {
        ll_framing_event event = ll_framing_read(&framing, bytes, size - 1, &used);
        if (event == LL_FRAMING_CLOSE || event == LL_FRAMING_FAULT)
            break;
        if (event != LL_FRAMING_PIECE || !framing.binary)
            continue;
        if (framing.first)
            message.size = 0;
        if (message.size + framing.size > MESSAGE)
            break;
        ll_buffer_add(&message, framing.bytes, framing.size);
        if (framing.last)
            take_message(&r, message.bytes != NULL ? message.bytes : "", message.size);
    }
    free(bytes);
    free(message.bytes);
    ll_frame_reader_end(&r.reader);
    ll_frame_reader_end(&r.viewer);
    ll_frame_state_clear(&r.last);
    ll_frame_state_clear(&r.has);
    ll_row_set_free(&r.space);
    return 0;
}
