/* The other side of a stream: what a reader makes of a session's messages equals the session's frames, also
 * through two of them; bytes that are none are refused. */
#include "session/harness.h"

#include "base/rng.h"
#include "daemon/stream/frame_reader.h"
#include "library/library.h"

enum { EVERYTHING = (1 << LL_CHANNELS) - 1, SOME = EVERYTHING & ~(1 << LL_CHANNEL_SCENE) };

/* One end of a hop: what its viewer has, and the reader at the other end, which makes frames again. */
typedef struct hop {
    ll_frame_state has;
    ll_frame_reader reader;
    ll_frame_state last;
    ll_row_set space;
} hop;

static const char *const scenarios[] = {
    "race",         "rifle",          "rollback",        "motion/spring", "rigid/tumbler",
    "rigid/bridge", "fluid/cylinder", "fluid/dam_break", "fluid/sea",     NULL};

static ll_session *open_session(const char *id)
{
    ll_session *session;
    cJSON *json;
    must(ll_scenario_load("scenarios", id, &json));
    must(ll_session_create(json, -1, NULL, NULL, &session));
    cJSON_Delete(json);
    return session;
}

static void begin(hop *h, const char *id)
{
    char *text;
    ll_session *session = open_session(id);
    *h = (hop){0};
    text = ll_frame_hello(session, "session", LL_FRAME_BINARY);
    cJSON *hello = cJSON_Parse(text);
    const cJSON *kind = cJSON_GetObjectItem(cJSON_GetObjectItem(hello, "params"), "kind");
    must(ll_frame_reader_begin(&h->reader, kind->valuestring,
                               cJSON_GetObjectItem(hello, "tick_hz")->valuedouble));
    cJSON_Delete(hello);
    free(text);
    ll_session_destroy(session);
}

static void end(hop *h)
{
    ll_frame_reader_end(&h->reader);
    ll_frame_state_clear(&h->has);
    ll_frame_state_clear(&h->last);
    ll_row_set_free(&h->space);
}

static ll_buffer message_for(hop *h, const ll_frame *frame, uint16_t channels, bool jump)
{
    ll_buffer message = {0};
    ll_frame_delivery to = {.state = &h->has, .channels = channels, .jump = jump, .format = LL_FRAME_BINARY};
    if (jump)
        ll_frame_state_clear(&h->has);
    ll_frame_write(frame, &to, &message);
    assert_false(message.failed);
    for (int i = 0; i < frame->count; i++)
        if (frame->section[i] != NULL && channels >> frame->record[i]->channel & 1) {
            ll_section_retain(frame->section[i]);
            ll_section_release(h->has.section[i]);
            h->has.section[i] = frame->section[i];
        }
    return message;
}

/* Sends the frame over the hop and makes one of what is read, as for a viewer that has events up to
 * `events`. */
static ll_frame *pass(hop *h, const ll_frame *frame, uint16_t channels, bool jump, int64_t events)
{
    ll_frame *made;
    ll_buffer message = message_for(h, frame, channels, jump);
    must(ll_frame_reader_take(&h->reader, message.bytes, message.size));
    free(message.bytes);
    assert_int_equal(h->reader.seq, frame->seq);
    assert_int_equal(h->reader.jumped, jump);
    ll_record_request request = {.channels = (uint16_t)(channels & ll_frame_reader_channels(&h->reader)),
                                 .anew = frame->anew,
                                 .from_event = events,
                                 .deltas = true};
    must(ll_frame_reader_frame(&h->reader, &request, frame->seq, frame->generation, &h->last, &h->space,
                               &made));
    return made;
}

static void assert_same(const ll_frame *frame, const ll_frame *other, uint16_t channels)
{
    assert_int_equal(other->tick, frame->tick);
    assert_int_equal(other->flags, frame->flags);
    assert_true(other->time_s == frame->time_s);
    assert_int_equal(other->count, frame->count);
    for (int i = 0; i < frame->count; i++) {
        assert_ptr_equal(other->record[i], frame->record[i]);
        if (frame->section[i] == NULL || !(channels >> frame->record[i]->channel & 1))
            continue;
        assert_non_null(other->section[i]);
        assert_true(ll_rows_equal(other->section[i]->rows, frame->section[i]->rows));
    }
}

static void frames_pass_unchanged(void **state)
{
    (void)state;
    for (int k = 0; scenarios[k]; k++) {
        hop near, far;
        ll_frame_state last = {0};
        ll_row_set space = {0};
        ll_session *session = open_session(scenarios[k]);
        int64_t events = LL_NO_EVENT;
        begin(&near, scenarios[k]);
        begin(&far, scenarios[k]);
        for (uint32_t i = 1; i <= 60; i++) {
            ll_frame *frame;
            bool jump = i == 1 || i == 40;
            uint16_t channels = i % 3 == 1 || jump ? EVERYTHING : SOME;
            ll_record_request request = {
                .channels = EVERYTHING, .anew = jump, .from_event = jump ? LL_NO_EVENT : events};
            must(ll_frame_take(session, &request, i, &last, &space, &frame));
            ll_frame *once = pass(&near, frame, channels, jump, request.from_event),
                     *twice = pass(&far, once, channels, jump, request.from_event);
            assert_same(frame, once, channels);
            assert_same(frame, twice, channels);
            const ll_rows *log = frame->section[LL_RECORD_EVENTS]->rows;
            events = log->first + log->count;
            ll_frame_release(frame);
            ll_frame_release(once);
            ll_frame_release(twice);
            ll_session_info info = ll_session_get_info(session);
            int64_t tick = ll_tick_at(info.time + LL_SECOND / 60 + 1000, info.tick_freq);
            must(ll_session_run_to(session, tick > info.tick ? tick : info.tick + 1));
        }
        end(&near);
        end(&far);
        ll_frame_state_clear(&last);
        ll_row_set_free(&space);
        ll_session_destroy(session);
    }
}

/* Any bytes are read or refused; a truncated message never counts as a whole one's rows. */
static void faults_are_refused(void **state)
{
    (void)state;
    uint64_t drawn = 0;
    hop h;
    ll_frame *frame;
    ll_frame_state last = {0};
    ll_row_set space = {0};
    ll_session *session = open_session("race");
    begin(&h, "race");
    must(ll_session_run_to(session, 200));
    ll_record_request request = {.channels = EVERYTHING, .anew = true, .from_event = LL_NO_EVENT};
    must(ll_frame_take(session, &request, 1, &last, &space, &frame));
    ll_buffer message = message_for(&h, frame, EVERYTHING, true);
    int refused = 0;
    for (int i = 0; i < 4000; i++) {
        size_t at = ll_rng_u64(5, 1, drawn++) % message.size;
        char was = message.bytes[at];
        message.bytes[at] = (char)ll_rng_u64(5, 2, drawn++);
        ll_status status = ll_frame_reader_take(&h.reader, message.bytes, message.size);
        refused += ll_failed(&status);
        message.bytes[at] = was;
    }
    assert_true(refused > 100);
    ll_status status = ll_frame_reader_take(&h.reader, message.bytes, message.size - 1);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_int_equal(ll_frame_reader_take(&h.reader, "\1", 1).code, LL_BAD_INPUT);
    assert_int_equal(ll_frame_reader_take(&h.reader, "\2\0\1\0", 4).code, LL_BAD_INPUT);
    must(ll_frame_reader_take(&h.reader, message.bytes, message.size));
    assert_int_equal(ll_frame_reader_begin(&h.reader, "nothing", 60).code, LL_BAD_INPUT);
    assert_int_equal(ll_frame_reader_begin(&h.reader, "netgame", 0).code, LL_BAD_INPUT);
    free(message.bytes);
    ll_frame_release(frame);
    end(&h);
    ll_frame_state_clear(&last);
    ll_row_set_free(&space);
    ll_session_destroy(session);
}

static void put_varint(ll_buffer *to, uint64_t value)
{
    for (; value >= 128; value >>= 7)
        ll_buffer_add(to, &(uint8_t){(uint8_t)(value | 128)}, 1);
    ll_buffer_add(to, &(uint8_t){(uint8_t)value}, 1);
}

/* A section of a few bytes, with `count` rows of zeros. */
static void put_zeros(ll_buffer *to, const ll_record *record, uint64_t count)
{
    ll_buffer body = {0};
    put_varint(&body, count);
    put_varint(&body, 0); /* none of them changed */
    put_varint(to, (uint64_t)record->id);
    put_varint(to, body.size << 2 | 2);
    ll_buffer_add(to, body.bytes, body.size);
    free(body.bytes);
}

static void few_bytes_do_not_become_any_number(void **state)
{
    (void)state;
    hop h;
    int i = 0;
    begin(&h, "race");
    while (h.reader.record[i]->form != LL_FORM_BY_INDEX)
        i++;
    const ll_record *record = h.reader.record[i];
    uint64_t count = (16 << 20) / (8 * (uint64_t)record->count);
    ll_buffer message = {0};
    ll_buffer_add(&message, "\1\0\1\0", 4);
    put_zeros(&message, record, count);
    must(ll_frame_reader_take(&h.reader, message.bytes, message.size));
    assert_int_equal(h.reader.rows[i]->count, count);
    assert_true(h.reader.cost >= count * 8 && h.reader.cost < 17 << 20);
    for (int k = 0; k < 200; k++)
        put_zeros(&message, record, count);
    ll_status status = ll_frame_reader_take(&h.reader, message.bytes, message.size);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_non_null(strstr(status.text, "64 MiB"));
    assert_true(h.reader.cost < 96 << 20);
    free(message.bytes);
    end(&h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_pass_unchanged),
        cmocka_unit_test(faults_are_refused),
        cmocka_unit_test(few_bytes_do_not_become_any_number),
    };
    return cmocka_run_group_tests_name("frame_reader", tests, NULL, NULL);
}
