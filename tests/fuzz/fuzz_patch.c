/* Commands to a running session, one per line: `p` and a merge patch, `c` and a control, `i` and an input (as
 * from a stream), `r` runs two ticks, `a` advances wall time by 40 ms. Each is either refused without effect,
 * or logged: at the end the log gives the same state. */
#include "check.h"

#include "input/action_json.h"
#include "session/scenario.h"
#include "session/session.h"

#define COMMANDS 40

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const char scenario[] =
    "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":1,\"tick_hz\":60,\"warmup_s\":0,\"players\":["
    "{\"lag_ms\":30,\"prediction\":true,\"reconciliation\":true,\"interpolation\":true},"
    "{\"lag_ms\":5,\"control\":\"person\"}]}";

typedef struct lines {
    char *text;
    size_t size;
} lines;

static void keep_line(void *context, const char *line, size_t length)
{
    lines *l = context;
    l->text = realloc(l->text, l->size + length + 1);
    FUZZ_CHECK(l->text != NULL);
    memcpy(l->text + l->size, line, length);
    l->size += length;
    l->text[l->size++] = '\n';
}

static ll_status give(ll_session *s, char kind, ll_time wall, const cJSON *json)
{
    int player;
    ll_action action;
    if (kind == 'p')
        return ll_session_patch(s, wall, json);
    if (kind == 'c')
        return ll_session_control(s, wall, json);
    ll_status status = ll_action_parse(json, "input", &player, &action);
    return ll_failed(&status) ? status : ll_session_input(s, wall, player, &action);
}

/* The hash of the present state. Most commands are refused, and change nothing: then the next one has it. */
typedef struct state_hash {
    bool known;
    uint64_t value;
} state_hash;

static void command(ll_session *s, const lines *log, char kind, ll_time *wall, state_hash *hash,
                    const char *text, size_t length)
{
    cJSON *json;
    if (kind == 'r' || kind == 'a')
        hash->known = false;
    if (kind == 'r') {
        int64_t to = ll_session_get_info(s).tick + 2, end = ll_session_get_info(s).end_tick;
        ll_session_run_to(s, to < end ? to : end);
        return;
    }
    if (kind == 'a') {
        ll_session_advance(s, *wall += 40 * LL_MS, 100);
        return;
    }
    ll_status status = ll_json_parse(text, length, &json);
    if (fuzz_failed(&status) || (kind != 'p' && kind != 'c' && kind != 'i')) {
        cJSON_Delete(json);
        return;
    }
    if (!hash->known)
        *hash = (state_hash){true, ll_session_hash(s)};
    size_t size = log->size;
    ll_session_info before = ll_session_get_info(s);
    status = give(s, kind, *wall, json);
    if (fuzz_failed(&status) && status.code != LL_DIVERGED) {
        FUZZ_CHECK(ll_session_hash(s) == hash->value && log->size == size);
        FUZZ_CHECK(ll_session_get_info(s).tick == before.tick &&
                   ll_session_get_info(s).status == before.status);
    } else {
        hash->known = false;
    }
    cJSON_Delete(json);
}

static void same_from_log(ll_session *s, const lines *log)
{
    ll_session *again;
    if (ll_session_get_info(s).status == LL_SESSION_FAILED)
        return;
    ll_status status = ll_session_restore(log->text, log->size, NULL, NULL, &again);
    FUZZ_CHECK(!fuzz_failed(&status));
    status = ll_session_run_to(again, ll_session_get_info(s).tick);
    FUZZ_CHECK(!fuzz_failed(&status));
    FUZZ_CHECK(ll_session_hash(again) == ll_session_hash(s));
    ll_session_destroy(again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    cJSON *json = cJSON_Parse(scenario);
    ll_session *s;
    lines log = {0};
    ll_time wall = LL_SECOND;
    state_hash hash = {0};
    ll_status status = ll_session_create(json, -1, keep_line, &log, &s);
    FUZZ_CHECK(!fuzz_failed(&status));
    cJSON_Delete(json);
    const char *at = (const char *)data, *end = at + size;
    for (int i = 0; i < COMMANDS && at < end; i++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        size_t length = (size_t)((newline != NULL ? newline : end) - at);
        if (length > 0)
            command(s, &log, at[0], &wall, &hash, at + 1, length - 1);
        at += length + 1;
    }
    same_from_log(s, &log);
    ll_session_destroy(s);
    free(log.text);
    return 0;
}
