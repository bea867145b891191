/* Frames: what a viewer decodes equals the session's rows for any subscription; taking a frame changes
 * nothing; sizes. */
#include "session/harness.h"

#include <math.h>
#include <zlib.h>

#include "base/rng.h"
#include "library/library.h"
#include "session/frame.h"
#include "support/decode.h"
#include "support/table_valid.h"

/* ---- a viewer: the sender's state of it, and the rows that it decodes ---- */

typedef struct watcher {
    ll_frame_state state;
    ll_rows *seen[64]; /* by record id */
    size_t bytes;      /* of the last message */
} watcher;

typedef struct bytes {
    const uint8_t *at, *end;
} bytes;

static uint64_t varint(bytes *b)
{
    uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
        assert_true(b->at < b->end);
        value |= (uint64_t)(*b->at & 127) << shift;
        if (*b->at++ < 128)
            return value;
    }
}

static const ll_record *record_of(uint64_t id)
{
    const ll_record *all[LL_ALL_RECORDS_MAX + 1];
    ll_all_records(all);
    for (int i = 0; all[i]; i++)
        if ((uint64_t)all[i]->id == id)
            return all[i];
    fail_msg("unknown record id %d", (int)id);
    return NULL;
}

static void read_section(watcher *w, bytes *b)
{
    static uint8_t room[16 << 20];
    const ll_record *record = record_of(varint(b));
    uint64_t size = varint(b);
    bool deflated = size & 1, whole = size & 2;
    size /= 4;
    assert_true(size <= (uint64_t)(b->end - b->at));
    const uint8_t *body = b->at;
    b->at += size;
    if (deflated) {
        z_stream z = {.next_in = (Bytef *)(uintptr_t)body,
                      .avail_in = (uInt)size,
                      .next_out = room,
                      .avail_out = sizeof room};
        assert_int_equal(inflateInit2(&z, -MAX_WBITS), Z_OK);
        assert_int_equal(inflate(&z, Z_FINISH), Z_STREAM_END);
        inflateEnd(&z);
        body = room;
        size = sizeof room - z.avail_out;
    }
    ll_rows *rows;
    assert_true(whole || w->seen[record->id] != NULL);
    must(ll_rows_decode(record, whole ? NULL : w->seen[record->id], body, size, &rows));
    ll_rows_free(w->seen[record->id]);
    w->seen[record->id] = rows;
}

/* Encodes the frame for a viewer of these channels and decodes it. */
static void watch(watcher *w, const ll_frame *frame, uint16_t channels, bool jump)
{
    ll_buffer message = {0}, shared = {0};
    ll_frame_delivery to = {
        .state = &w->state, .channels = channels, .jump = jump, .format = LL_FRAME_BINARY};
    ll_frame_write(frame, &to, &message);
    assert_false(message.failed);
    to.shared = true;
    for (int viewer = 0; viewer < 2; viewer++) { /* the first one makes the encodings */
        shared.size = 0;
        ll_frame_write(frame, &to, &shared);
        assert_int_equal(shared.size, message.size);
        assert_memory_equal(shared.bytes, message.bytes, message.size);
    }
    free(shared.bytes);
    bytes b = {(const uint8_t *)message.bytes, (const uint8_t *)message.bytes + message.size};
    assert_int_equal(*b.at, 1);
    b.at += 2;
    assert_int_equal(varint(&b), frame->seq);
    assert_int_equal(unzigzag(varint(&b)), frame->tick);
    while (b.at < b.end)
        read_section(w, &b);
    for (int i = 0; i < frame->count; i++) {
        if (frame->section[i] == NULL || !(channels >> frame->record[i]->channel & 1))
            continue;
        ll_section_retain(frame->section[i]);
        ll_section_release(w->state.section[i]);
        w->state.section[i] = frame->section[i];
    }
    w->bytes = message.size;
    free(message.bytes);
}

static void assert_has(const watcher *w, const ll_frame *frame, uint16_t channels)
{
    for (int i = 0; i < frame->count; i++) {
        if (frame->section[i] == NULL || !(channels >> frame->record[i]->channel & 1))
            continue;
        const ll_rows *rows = frame->section[i]->rows, *seen = w->seen[rows->record->id];
        assert_non_null(seen);
        if (rows->record->form == LL_FORM_LOG)
            assert_int_equal(rows->first + rows->count, seen->first + seen->count);
        else
            assert_true(ll_rows_equal(rows, seen));
    }
}

static void forget(watcher *w)
{
    ll_frame_state_clear(&w->state);
    for (int i = 0; i < 64; i++)
        ll_rows_free(w->seen[i]);
    *w = (watcher){0};
}

/* ---- sessions ---- */

enum { EVERYTHING = (1 << LL_CHANNELS) - 1 };

typedef struct show {
    ll_session *session;
    ll_frame_state last;
    ll_row_set space;
    uint32_t seq;
    int64_t events;
    bool anew;
    ll_time wall;
} show;

/* `params` replaces the scenario's; NULL: unchanged. */
static show open_show(const char *id, const char *params)
{
    show s = {.anew = true};
    cJSON *json;
    must(ll_scenario_load("scenarios", id, &json));
    if (params != NULL) {
        cJSON_ReplaceItemInObjectCaseSensitive(json, "params", cJSON_Parse(params));
        cJSON_ReplaceItemInObjectCaseSensitive(json, "duration_s", cJSON_CreateNumber(60));
        cJSON_DeleteItemFromObjectCaseSensitive(json, "expect");
    }
    must(ll_session_create(json, -1, NULL, NULL, &s.session));
    cJSON_Delete(json);
    return s;
}

static ll_frame *take(show *s, uint16_t channels)
{
    ll_frame *frame;
    ll_record_request request = {.channels = channels,
                                 .anew = s->anew,
                                 .from_event = s->events,
                                 .viewers = 1,
                                 .wall_ns = (uint64_t)s->seq * 16666667};
    must(ll_frame_take(s->session, &request, ++s->seq, &s->last, &s->space, &frame));
    if (frame->section[LL_RECORD_EVENTS] != NULL) {
        const ll_rows *events = frame->section[LL_RECORD_EVENTS]->rows;
        s->events = events->first + events->count;
        s->anew = false;
    }
    return frame;
}

/* 1/60 s. */
static void step(show *s)
{
    ll_session_info info = ll_session_get_info(s->session);
    int64_t tick = ll_tick_at(info.time + LL_SECOND / 60 + 1000, info.tick_freq);
    must(ll_session_run_to(s->session, tick > info.tick ? tick : info.tick + 1));
}

static void close_show(show *s)
{
    ll_frame_state_clear(&s->last);
    ll_row_set_free(&s->space);
    ll_session_destroy(s->session);
}

static const char *const kinds[] = {"race",
                                    "rifle",
                                    "rollback",
                                    "desync_float",
                                    "crates",
                                    "motion/spring",
                                    "rigid/tumbler",
                                    "rigid/bridge",
                                    "rigid/domino",
                                    "fluid/cylinder",
                                    "fluid/dam_break",
                                    "fluid/sea",
                                    NULL};

static void viewers_decode_the_sessions_rows(void **state)
{
    (void)state;
    for (int k = 0; kinds[k]; k++) {
        show s = open_show(kinds[k], NULL);
        watcher all = {0}, slow = {0};
        for (int i = 0; i < 60; i++) {
            uint64_t before = ll_session_hash(s.session);
            ll_frame *frame = take(&s, EVERYTHING);
            watch(&all, frame, EVERYTHING, false);
            assert_has(&all, frame, EVERYTHING);
            if (i % 12 == 0) {
                uint16_t some = (uint16_t)(EVERYTHING & ~(1 << LL_CHANNEL_LANES));
                watch(&slow, frame, some, i == 36);
                assert_has(&slow, frame, some);
            }
            ll_frame_release(frame);
            assert_true(ll_session_hash(s.session) == before);
            step(&s);
        }
        forget(&all);
        forget(&slow);
        close_show(&s);
    }
}

/* Unchanged sections are not sent, and an encoding is made only once. */
static void a_session_at_rest_costs_a_head(void **state)
{
    (void)state;
    show s = open_show("race", NULL);
    watcher w = {0};
    must(ll_session_run_to(s.session, 300));
    ll_frame *first = take(&s, EVERYTHING & ~(1 << LL_CHANNEL_CLOCK));
    watch(&w, first, EVERYTHING, false);
    size_t whole = w.bytes;
    ll_frame *second = take(&s, EVERYTHING & ~(1 << LL_CHANNEL_CLOCK));
    watch(&w, second, EVERYTHING, false);
    assert_true(whole > 1000);
    assert_true(w.bytes < 10);
    assert_false(ll_frame_news(second, &w.state, EVERYTHING));
    ll_frame_release(first);
    ll_frame_release(second);
    forget(&w);
    close_show(&s);
}

static void records_are_sound(void **state)
{
    (void)state;
    const ll_record *all[LL_ALL_RECORDS_MAX + 1];
    ll_all_records(all);
    for (int i = 0; all[i]; i++) {
        must(record_valid(all[i]));
        for (int k = 0; k < i; k++) {
            assert_int_not_equal(all[i]->id, all[k]->id);
            assert_string_not_equal(all[i]->name, all[k]->name);
        }
    }
}

/* ---- sizes ---- */

typedef struct budget {
    const char *id, *params;
    double from_s;
    int frames;
    uint16_t channels;
    double mean, p99;
} budget;

#define CHANNEL(name) (1 << LL_CHANNEL_##name)
enum {
    STANDARD = CHANNEL(SESSION) | CHANNEL(SCENE) | CHANNEL(LANES) | CHANNEL(GAUGES) | CHANNEL(SHOTS),
    NETGAME = STANDARD | CHANNEL(INPUT_HISTORY) | CHANNEL(BUFFERED)
};

static const budget budgets[] = {
    {"race", NULL, 5, 540, STANDARD, 240, 310},
    {"race", NULL, 5, 540, NETGAME, 300, 380},
    {"eight", NULL, 5, 540, NETGAME, 1300, 1600},
    {"rifle", NULL, 5, 540, NETGAME, 400, 700},
    {"motion/orbit", NULL, 1, 540, CHANNEL(SESSION) | CHANNEL(MOTION), 200, 240},
    {"rigid/tumbler", NULL, 1, 150, CHANNEL(SESSION) | CHANNEL(BODIES) | CHANNEL(CONTACTS) | CHANNEL(JOINTS),
     6500, 12500},
    {"rigid/pyramid", "{\"size\":40}", 8, 120,
     CHANNEL(SESSION) | CHANNEL(BODIES) | CHANNEL(CONTACTS) | CHANNEL(JOINTS), 500, 1000},
    {"fluid/cylinder", "{\"n\":256}", 5, 60, CHANNEL(SESSION) | CHANNEL(FIELD), 6144, 10000},
};

static int by_size(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

static void frames_are_within_their_budgets(void **state)
{
    (void)state;
    for (size_t b = 0; b < sizeof budgets / sizeof budgets[0]; b++) {
        static int sizes[600];
        show s = open_show(budgets[b].id, budgets[b].params);
        watcher w = {0};
        double sum = 0;
        must(ll_session_run_to(s.session, ll_tick_at((ll_time)(budgets[b].from_s * 1e9),
                                                     ll_session_get_info(s.session).tick_freq)));
        for (int i = -1; i < budgets[b].frames; i++) {
            ll_frame *frame = take(&s, budgets[b].channels);
            watch(&w, frame, budgets[b].channels, false);
            if (i >= 0) {
                sizes[i] = (int)w.bytes;
                sum += (double)w.bytes;
            } else {
                printf("%s: whole %zu, ", budgets[b].id, w.bytes);
            }
            ll_frame_release(frame);
            step(&s);
        }
        qsort(sizes, (size_t)budgets[b].frames, sizeof sizes[0], by_size);
        double mean = sum / budgets[b].frames;
        int p99 = sizes[budgets[b].frames * 99 / 100];
        printf("mean %.0f, p99 %d\n", mean, p99);
        if (!getenv("SIZES")) {
            assert_true(mean <= budgets[b].mean);
            assert_true(p99 <= budgets[b].p99);
        }
        forget(&w);
        close_show(&s);
    }
}

/* ---- conversions that the compiler makes of a table ---- */

static const double odd[] = {0, -0.0, INFINITY, -INFINITY, NAN, 1e300, -1e300, 0.5, -0.5, 1e-300};

static double some_real(uint64_t *n)
{
    uint64_t draw = ll_rng_u64(7, 3, (*n)++);
    return draw % 4 == 0 ? odd[draw / 4 % (sizeof odd / sizeof odd[0])]
                         : ((double)(draw >> 11) - 0x1p52) * 0x1p-40;
}

/* A valid value of any size of the field's type. */
static void fill_field(const ll_record_field *f, char *at, uint64_t *n)
{
    uint64_t draw = ll_rng_u64(7, 4, (*n)++);
    static const size_t sizes[] = {[LL_TYPE_U8] = 1,  [LL_TYPE_U16] = 2, [LL_TYPE_U32] = 4,
                                   [LL_TYPE_I32] = 4, [LL_TYPE_I64] = 8, [LL_TYPE_BOOL] = 1};
    if (f->type == LL_TYPE_F32)
        *(float *)(void *)at = (float)(some_real(n) * 0x1p-8);
    else if (f->type == LL_TYPE_F64)
        *(double *)(void *)at = some_real(n);
    else if (f->type == LL_TYPE_BOOL)
        *(bool *)at = draw & 1;
    else
        memcpy(at, &draw, sizes[f->type]);
}

static void integers_follow_the_table(void **state)
{
    (void)state;
    const ll_record *all[LL_ALL_RECORDS_MAX + 1];
    enum { ROWS = 200 };
    uint64_t n = 0;
    int own = 0;
    ll_all_records(all);
    for (int i = 0; all[i]; i++) {
        const ll_record *r = all[i];
        char *structs = calloc(ROWS, r->size);
        int64_t *to = malloc(ROWS * (size_t)r->count * sizeof *to);
        for (int row = 0; row < ROWS; row++)
            for (int k = 0; k < r->count; k++)
                fill_field(&r->fields[k], structs + (size_t)row * r->size + r->fields[k].offset, &n);
        if (r->integers != NULL) {
            own++;
            r->integers(structs, ROWS, to);
        }
        for (int row = 0; row < ROWS && r->integers != NULL; row++)
            for (int k = 0; k < r->count; k++)
                assert_int_equal(to[row * r->count + k],
                                 ll_field_integer(&r->fields[k], structs + (size_t)row * r->size));
        free(to);
        free(structs);
    }
    assert_true(own > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(integers_follow_the_table),        cmocka_unit_test(records_are_sound),
        cmocka_unit_test(viewers_decode_the_sessions_rows), cmocka_unit_test(a_session_at_rest_costs_a_head),
        cmocka_unit_test(frames_are_within_their_budgets),
    };
    return cmocka_run_group_tests_name("frame", tests, NULL, NULL);
}
