/* Commands to a running session, one per line: `p` and a merge patch, `c` and a control, `i` and an input (as
 * from a stream), `r` runs two ticks, `a` advances wall time by 40 ms. Each is either refused without effect,
 * or logged: at the end the log gives the same state.
 *
 * Most of the time of an input would be spent on what it does not change: so the scenario is parsed and its
 * first state made once, and a log that an earlier input has left is not restored again, except for one input
 * of sixteen. */
#include "check.h"

#include "base/hash.h"
#include "input/action_json.h"
#include "session/scenario.h"
#include "session/session.h"

#define COMMANDS 40
#define KNOWN_LOGS 4096

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

/* ---- restoring ---- */

static uint64_t hash_from_log(const char *text, size_t size, int64_t tick)
{
    ll_session *again;
    ll_status status = ll_session_restore(text, size, NULL, NULL, &again);
    FUZZ_CHECK(!fuzz_failed(&status));
    status = ll_session_run_to(again, tick);
    FUZZ_CHECK(!fuzz_failed(&status));
    uint64_t hash = ll_session_hash(again);
    ll_session_destroy(again);
    return hash;
}

/* A log that was restored: its whole text, and the hash that it gave at the tick. */
typedef struct known_log {
    char *text;
    size_t size;
    int64_t tick;
    uint64_t hash;
} known_log;

static void same_from_log(ll_session *s, lines *log, const state_hash *present, bool anew)
{
    static known_log known[KNOWN_LOGS];
    ll_session_info info = ll_session_get_info(s);
    if (info.status == LL_SESSION_FAILED)
        return;
    known_log *k = &known[ll_hash((uint64_t)info.tick, log->text, log->size) % KNOWN_LOGS];
    bool same = k->tick == info.tick && k->size == log->size && memcmp(k->text, log->text, log->size) == 0;
    uint64_t hash = same && !anew ? k->hash : hash_from_log(log->text, log->size, info.tick);
    FUZZ_CHECK(hash == (present->known ? present->value : ll_session_hash(s)));
    if (same)
        return;
    free(k->text);
    *k = (known_log){log->text, log->size, info.tick, hash};
    *log = (lines){0};
}

/* ---- the session ---- */

static struct {
    ll_scenario parsed;
    ll_sim_kind kind; /* the scenario's own, but for `init` */
    void *block;      /* what its `init` makes of the scenario */
} first;

/* `init` is a pure function. The restored session has the scenario's own, so that their hashes compare. */
static ll_status init(void *block, const void *config)
{
    const ll_sim_kind *own = first.parsed.kind;
    size_t size = ll_param_clone_size(own->table, config, NULL);
    if (size != ll_param_clone_size(own->table, first.parsed.config, NULL) ||
        memcmp(config, first.parsed.config, size) != 0)
        return own->init(block, config);
    memcpy(block, first.block, own->size(config));
    return ll_ok();
}

static void start(void)
{
    cJSON *json = cJSON_Parse(scenario);
    ll_status status = ll_scenario_parse(json, &first.parsed);
    FUZZ_CHECK(!fuzz_failed(&status));
    cJSON_Delete(json);
    const ll_sim_kind *own = first.parsed.kind;
    first.block = malloc(own->size(first.parsed.config));
    FUZZ_CHECK(first.block != NULL);
    status = own->init(first.block, first.parsed.config);
    FUZZ_CHECK(!fuzz_failed(&status));
    first.kind = *own;
    first.kind.init = init;
}

static ll_session *open_session(lines *log)
{
    ll_session *s;
    size_t size = first.kind.table->size;
    ll_scenario copy = {&first.kind, malloc(size)};
    FUZZ_CHECK(copy.config != NULL);
    memcpy(copy.config, first.parsed.config, size);
    ll_status status = ll_session_open(&copy, keep_line, log, &s);
    FUZZ_CHECK(!fuzz_failed(&status));
    return s;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lines log = {0};
    ll_time wall = LL_SECOND;
    state_hash hash = {0};
    if (first.block == NULL)
        start();
    ll_session *s = open_session(&log);
    const char *at = (const char *)data, *end = at + size;
    for (int i = 0; i < COMMANDS && at < end; i++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        size_t length = (size_t)((newline != NULL ? newline : end) - at);
        if (length > 0)
            command(s, &log, at[0], &wall, &hash, at + 1, length - 1);
        at += length + 1;
    }
    same_from_log(s, &log, &hash, ll_hash(0, data, size) % 16 == 0);
    ll_session_destroy(s);
    free(log.text);
    return 0;
}
