/* States that are kept outside of a session: another process begins from one, and goes on with the same
 * hashes, events included; what does not fit is refused. */
#include "harness.h"

#include <unistd.h>

#include "library/library.h"
#include "session/internal.h"

enum { BLOCK_MAX = 2 << 20 };

static const char *program;

typedef struct bytes {
    char *at;
    size_t size;
} bytes;

static void add_line(void *context, const char *line, size_t length)
{
    bytes *b = context;
    b->at = realloc(b->at, b->size + length + 1);
    assert_non_null(b->at);
    memcpy(b->at + b->size, line, length);
    b->size += length;
    b->at[b->size++] = '\n';
}

static ll_session *open_library(const char *id, bytes *log)
{
    cJSON *json;
    ll_session *s;
    must(ll_scenario_load("scenarios", id, &json));
    must(ll_session_create(json, 5, log ? add_line : NULL, log, &s));
    cJSON_Delete(json);
    return s;
}

/* ---- another process ---- */

static void write_file(const char *name, const void *at, size_t size)
{
    FILE *f = fopen(name, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(at, 1, size, f), size);
    fclose(f);
}

static bytes read_file(const char *name)
{
    FILE *f = fopen(name, "rb");
    bytes b = {0};
    if (!f)
        return b;
    fseek(f, 0, SEEK_END);
    b.size = (size_t)ftell(f);
    rewind(f);
    b.at = malloc(b.size + 1);
    if (b.at && fread(b.at, 1, b.size, f) != b.size)
        b.size = 0;
    fclose(f);
    return b;
}

/* Prints where it began and the hashes at two ticks. */
static int resume_elsewhere(char *const *arguments)
{
    bytes log = read_file(arguments[0]), state = read_file(arguments[1]);
    ll_session *s;
    ll_status status = ll_session_restore(log.at, log.size, NULL, NULL, &s);
    LL_THEN(status, ll_session_use_state(s, state.at, state.size));
    LL_THEN(status, ll_session_begin_wake(s));
    if (ll_failed(&status)) {
        printf("%s\n", status.text);
        return 1;
    }
    printf("%lld", (long long)ll_session_get_info(s).at_tick);
    for (int i = 2; i < 4; i++) {
        status = ll_session_run_to(s, strtoll(arguments[i], NULL, 10));
        printf(" %016llx", ll_failed(&status) ? 0ull : (unsigned long long)ll_session_hash(s));
    }
    printf("\n");
    ll_session_destroy(s);
    free(log.at);
    free(state.at);
    return 0;
}

/* ---- tests ---- */

/* False: too short, or it fails. */
static bool resumes(const char *id, const char *folder)
{
    bytes log = {0}, none = {0};
    char log_name[64], state_name[64], command[512], expected[96], got[96] = "";
    void *state = NULL;
    size_t size;
    ll_session *s = open_library(id, &log);
    ll_session_info info = ll_session_get_info(s);
    int64_t at = info.end_tick / 3 < 150 ? info.end_tick / 3 : 150, more = at / 3;
    if (ll_session_awake_bytes(s) > BLOCK_MAX || strncmp(id, "fluid", 5) == 0) {
        at = at < 9 ? at : 9;
        more = at / 3;
    }
    snprintf(log_name, sizeof log_name, "%s/log", folder);
    snprintf(state_name, sizeof state_name, "%s/state", folder);
    ll_status status = at > 0 ? ll_session_run_to(s, at) : ll_error(LL_CONFLICT, "too short");
    LL_THEN(status, ll_session_save_state(s, &state, &size));
    LL_THEN(status, ll_session_run_to(s, at + more));
    bool saved = !ll_failed(&status);
    if (saved) {
        uint64_t first = ll_session_hash(s);
        ll_session_log(s, add_line, &none);
        write_file(log_name, none.at, none.size);
        must(ll_session_run_to(s, at + 2 * more));
        write_file(state_name, state, size);
        snprintf(expected, sizeof expected, "%lld %016llx %016llx\n", (long long)at,
                 (unsigned long long)first, (unsigned long long)ll_session_hash(s));
        snprintf(command, sizeof command, "%s --resume %s %s %lld %lld", program, log_name, state_name,
                 (long long)(at + more), (long long)(at + 2 * more));
        FILE *pipe = popen(command, "r");
        assert_non_null(pipe);
        assert_non_null(fgets(got, sizeof got, pipe));
        pclose(pipe);
        if (strcmp(got, expected) != 0)
            fail_msg("%s: expected %s, got %s", id, expected, got);
    }
    free(state);
    free(log.at);
    free(none.at);
    ll_session_destroy(s);
    return saved;
}

static void another_process_goes_on(void **state)
{
    (void)state;
    char folder[] = "/tmp/laglab-saved-XXXXXX", name[64];
    cJSON *list, *each;
    int count = 0;
    assert_non_null(mkdtemp(folder));
    must(ll_scenario_list("scenarios", &list));
    cJSON_ArrayForEach(each, list)
    {
        count += resumes(cJSON_GetObjectItemCaseSensitive(each, "id")->valuestring, folder);
    }
    cJSON_Delete(list);
    assert_true(count > 100);
    snprintf(name, sizeof name, "%s/log", folder);
    unlink(name);
    snprintf(name, sizeof name, "%s/state", folder);
    unlink(name);
    rmdir(folder);
}

static void change(ll_session *s, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    must(ll_session_patch(s, 0, json));
    cJSON_Delete(json);
}

static ll_session *restored(const bytes *log)
{
    ll_session *s;
    must(ll_session_restore(log->at, log->size, NULL, NULL, &s));
    return s;
}

/* Commands before, at and after the tick of the state, and steps of a timeline. */
static void commands_are_applied_once(void **state)
{
    (void)state;
    static const char *const ids[] = {"race", "outage", "behind_cover", "rollback"};
    for (size_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        bytes log = {0};
        void *saved;
        size_t size;
        ll_session *s = open_library(ids[i], &log);
        must(ll_session_run_to(s, 100));
        change(s, "{\"players.0.lag_ms\":90}");
        must(ll_session_run_to(s, 240));
        change(s, "{\"players.0.lag_ms\":10}");
        must(ll_session_save_state(s, &saved, &size));
        change(s, "{\"players.1.link.up.loss_pct\":20}");
        must(ll_session_run_to(s, 260));
        change(s, "{\"players.0.lag_ms\":90}");
        must(ll_session_run_to(s, 290));
        ll_session *again = restored(&log);
        ll_session_set_position(again, 0, &(ll_session_position){.tick = 290, .head = 290});
        must(ll_session_use_state(again, saved, size));
        free(saved); /* it was copied */
        must(ll_session_begin_wake(again));
        assert_int_equal(ll_session_get_info(again).at_tick, 240);
        assert_true(ll_session_hash(again) == ll_session_hash(s));
        assert_true(memcmp(again->config, s->config, ll_session_config_used(s)) == 0);
        assert_true(ll_session_bytes(again) <= ll_session_awake_bytes(again)); /* the copy is freed */
        must(ll_session_run_to(again, 400));
        must(ll_session_run_to(again, 50)); /* seeking back before it */
        must(ll_session_run_to(again, 290));
        assert_true(ll_session_hash(again) == ll_session_hash(s));
        ll_session_destroy(again);
        ll_session_destroy(s);
        free(log.at);
    }
}

/* Viewers get the same events of the last seconds as if the log had been replayed. */
static void events_are_kept(void **state)
{
    (void)state;
    bytes log = {0};
    void *saved;
    size_t size;
    ll_session *s = open_library("race", &log), *again[2];
    must(ll_session_run_to(s, 1000));
    must(ll_session_save_state(s, &saved, &size));
    for (int i = 0; i < 2; i++) {
        again[i] = restored(&log);
        ll_session_set_position(again[i], 0, &(ll_session_position){.tick = 1030, .head = 1030});
        if (i == 1)
            must(ll_session_use_state(again[i], saved, size));
        must(ll_session_wake(again[i]));
    }
    const ll_session_events *whole = &again[0]->events, *part = &again[1]->events;
    uint32_t count = whole->count - whole->base; /* the other one has some that are older */
    assert_true(count > 100 && count <= part->count - part->base);
    for (uint32_t k = 1; k <= count; k++) {
        ll_event a = whole->ring[(whole->count - k) % LL_EVENT_RING];
        ll_event b = part->ring[(part->count - k) % LL_EVENT_RING];
        a.id = b.id = 0;
        assert_true(a.type == b.type && a.begin == b.begin && a.end == b.end && a.player == b.player &&
                    a.number == b.number && a.value == b.value);
    }
    ll_session_destroy(again[0]);
    ll_session_destroy(again[1]);
    ll_session_destroy(s);
    free(saved);
    free(log.at);
}

static void what_does_not_fit_is_refused(void **state)
{
    (void)state;
    bytes log = {0}, longer = {0};
    unsigned char *saved;
    void *got;
    size_t size;
    ll_session *s = open_library("race", &log);
    assert_int_equal(ll_session_save_state(s, &got, &size).code, LL_CONFLICT); /* at tick 0 */
    must(ll_session_run_to(s, 300));
    must(ll_session_save_state(s, &got, &size));
    saved = got;
    ll_session *again = restored(&log); /* its head is 0 */
    assert_int_equal(ll_session_save_state(again, &got, &size).code, LL_CONFLICT);
    assert_int_equal(ll_session_use_state(again, saved, 300).code, LL_CONFLICT);
    must(ll_session_save_state(s, &got, &size));
    free(got);
    ll_session_set_position(again, 0, &(ll_session_position){.tick = 400, .head = 400});
    must(ll_session_use_state(again, saved, size));
    for (size_t i = 0; i < size; i += 1 + i / 3) {
        saved[i] ^= 1;
        assert_int_equal(ll_session_use_state(again, saved, size).code, LL_CONFLICT);
        saved[i] ^= 1;
    }
    assert_int_equal(ll_session_use_state(again, saved, size - 1).code, LL_CONFLICT);
    assert_int_equal(ll_session_use_state(again, saved, 0).code, LL_CONFLICT);
    must(ll_session_wake(again)); /* a refused one is not used */
    assert_int_equal(ll_session_get_info(again).tick, 400);
    ll_session_destroy(again);

    ll_session *other = open_library("race", &longer); /* whose commands were made before that tick */
    must(ll_session_run_to(other, 200));
    change(other, "{\"players.0.lag_ms\":10}");
    must(ll_session_run_to(other, 350));
    again = restored(&longer);
    ll_session_set_position(again, 0, &(ll_session_position){.tick = 350, .head = 350});
    assert_int_equal(ll_session_use_state(again, saved, size).code, LL_CONFLICT);
    ll_session_destroy(again);
    ll_session_destroy(other);
    ll_session_destroy(s);
    free(saved);
    free(log.at);
    free(longer.at);
}

int main(int count, char **arguments)
{
    program = arguments[0];
    if (count == 6 && strcmp(arguments[1], "--resume") == 0)
        return resume_elsewhere(arguments + 2);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(another_process_goes_on),
        cmocka_unit_test(commands_are_applied_once),
        cmocka_unit_test(events_are_kept),
        cmocka_unit_test(what_does_not_fit_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
