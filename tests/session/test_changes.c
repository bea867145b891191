/* Changes at random of all live parameters, in scenarios of every kind: each is refused, and then nothing is
 * lost, or taken, and then the session goes on and its log gives the same states again. */
#include "harness.h"

#include "base/rng.h"
#include "library/library.h"
#include "session/kinds.h"

enum { CHANGES = 60, SEEDS = 2, PATHS = 600 };

typedef struct row {
    char path[96];
    const ll_param *row;
} row;

typedef struct rows {
    row of[PATHS];
    int count;
} rows;

/* The live rows below `table`, with their paths: of arrays the first two elements. */
static void gather(const ll_param_table *table, const char *prefix, const char *object, rows *r)
{
    for (int i = 0; table && i < table->count; i++) {
        const ll_param *p = &table->rows[i];
        char path[96];
        snprintf(path, sizeof path, "%s%s%s", prefix, prefix[0] ? "." : "", p->name);
        const char *at = object + p->offset;
        if (p->type == LL_PARAM_OBJECT) {
            gather(p->child, path, at, r);
        } else if (p->type == LL_PARAM_VARIANT) {
            int32_t choice;
            memcpy(&choice, object + p->count_offset, sizeof choice);
            gather(p->variants[choice], path, at, r);
        } else if (p->type == LL_PARAM_ARRAY) {
            int32_t count;
            memcpy(&count, object + p->count_offset, sizeof count);
            for (int k = 0; k < count && k < 2; k++) {
                char element[112];
                snprintf(element, sizeof element, "%s.%d", path, k);
                gather(p->child, element, at + (size_t)k * p->child->size, r);
            }
        } else if (p->live) {
            assert_true(r->count < PATHS);
            r->of[r->count].row = p;
            snprintf(r->of[r->count++].path, sizeof path, "%s", path);
        }
    }
}

typedef struct draws {
    uint64_t seed, count;
} draws;

static double draw(draws *d)
{
    return ll_rng_unit(d->seed, 0, d->count++);
}

/* A value of a row: mostly within its range, often at an end of it. */
static cJSON *value_of(const ll_param *p, draws *d)
{
    double x = draw(d) < 0.3 ? p->default_value : p->min + (p->max - p->min) * draw(d);
    if (draw(d) < 0.1)
        x = p->min;
    else if (draw(d) < 0.05)
        x = p->max * 2 + 1; /* beyond its range */
    int n = 0;
    switch (p->type) {
    case LL_PARAM_REAL:
        return cJSON_CreateNumber(x);
    case LL_PARAM_INT:
        return cJSON_CreateNumber((double)(int64_t)x);
    case LL_PARAM_BOOL:
        return cJSON_CreateBool(draw(d) < 0.5);
    case LL_PARAM_CHOICE:
        while (p->choices[n])
            n++;
        return cJSON_CreateString(p->choices[(int)(draw(d) * n)]);
    case LL_PARAM_TEXT:
        return cJSON_CreateString(draw(d) < 0.5 ? "" : "x");
    case LL_PARAM_VECTOR:
        return cJSON_CreateDoubleArray((double[]){x, p->default_value}, 2);
    default:
        return cJSON_CreateArray();
    }
}

typedef struct growing {
    char *text;
    size_t size, room;
} growing;

static void add_line(void *context, const char *line, size_t length)
{
    growing *g = context;
    if (g->size + length + 1 > g->room)
        g->text = realloc(g->text, g->room = 2 * (g->size + length + 1));
    assert_non_null(g->text);
    memcpy(g->text + g->size, line, length);
    g->size += length;
    g->text[g->size++] = '\n';
}

static int64_t tick_of(const ll_session *s)
{
    return ll_session_get_info(s).tick;
}

/* How many of the changes were taken. */
static int change_at_random(const char *id, uint64_t seed)
{
    cJSON *json;
    growing log = {0};
    ll_scenario scenario;
    ll_session *s, *again;
    rows *r = calloc(1, sizeof *r);
    draws d = {seed, 0};
    int taken = 0;
    must(ll_scenario_load("scenarios", id, &json));
    must(ll_scenario_parse(json, &scenario));
    gather(scenario.kind->table, "", scenario.config, r);
    must(ll_session_create(json, 7, add_line, &log, &s));
    for (int i = 0; i < CHANGES; i++) {
        cJSON *patch = cJSON_CreateObject();
        for (int k = draw(&d) < 0.3 ? 2 : 1; k > 0; k--) {
            const row *one = &r->of[(int)(draw(&d) * r->count)];
            cJSON_DeleteItemFromObject(patch, one->path);
            cJSON_AddItemToObject(patch, one->path, value_of(one->row, &d));
        }
        uint64_t hash = ll_session_hash(s);
        size_t size = log.size;
        cJSON *before = ll_session_params(s);
        ll_status status = ll_session_patch(s, 0, patch);
        if (ll_failed(&status)) {
            cJSON *after = ll_session_params(s);
            assert_true(status.code == LL_BAD_INPUT || status.code == LL_CONFLICT);
            assert_true(ll_session_hash(s) == hash && log.size == size);
            assert_true(cJSON_Compare(before, after, true));
            cJSON_Delete(after);
        }
        taken += !ll_failed(&status);
        cJSON_Delete(before);
        cJSON_Delete(patch);
        status = ll_session_run_to(s, tick_of(s) + (int)(draw(&d) * 4));
        if (ll_failed(&status)) { /* such values can make a method diverge: that is said, and it ends there */
            assert_int_equal(status.code, LL_DIVERGED);
            break;
        }
    }
    ll_status status = ll_session_restore(log.text, log.size, NULL, NULL, &again);
    if (ll_failed(&status))
        fail_msg("%s, seed %d: %s", id, (int)seed, status.text);
    if (ll_session_get_info(s).status !=
        LL_SESSION_FAILED) /* the log has its failure, and else no tick after the last change */
        must(ll_session_run_to(again, tick_of(s)));
    if (ll_session_hash(again) != ll_session_hash(s) || tick_of(again) != tick_of(s))
        fail_msg("%s, seed %d: the log gives another state at tick %d", id, (int)seed, (int)tick_of(s));
    ll_session_destroy(again);
    ll_session_destroy(s);
    ll_scenario_free(&scenario);
    cJSON_Delete(json);
    free(log.text);
    free(r);
    return taken;
}

static void changes_at_random(void **state)
{
    (void)state;
    static const char *const of[] = {
        "race",          "cannon",         "eight",           "behind_cover",
        "crates",        "crates_delta",   "rollback",        "lockstep_pipelined",
        "bucket",        "mesh",           "swarm_interest",  "aim_bot",
        "deterministic", "dead_reckoning", "adaptive_delay",  "position_reports",
        "stack_watched", "transport_quic", "transport_tcp",   "link_shared",
        "motion/spring", "rigid/pyramid",  "fluid/dam_break",
    };
    for (size_t i = 0; i < sizeof of / sizeof of[0]; i++) {
        int taken = 0;
        for (uint64_t seed = 1; seed <= SEEDS; seed++)
            taken += change_at_random(of[i], seed * 1000 + i);
        if (taken < 5)
            fail_msg("%s took %d changes only", of[i], taken);
    }
}

/* What only a layout of its own has room for is refused by name, in a patch, and as a step of the timeline.
 */
static void another_layout_is_refused(void **state)
{
    (void)state;
    static const char *const sets[][3] = {
        {"race", "{\"server.snapshot_encoding\":\"partial_delta\"}", "server.snapshot_encoding"},
        {"swarm_interest", "{\"server\":{\"snapshot_encoding\":\"delta\"}}", "server.snapshot_encoding"},
    };
    for (size_t i = 0; i < sizeof sets / sizeof sets[0]; i++) {
        cJSON *json, *patch = cJSON_Parse(sets[i][1]);
        ll_session *s;
        must(ll_scenario_load("scenarios", sets[i][0], &json));
        must(ll_session_create(json, 7, NULL, NULL, &s));
        must(ll_session_run_to(s, 11));
        uint64_t hash = ll_session_hash(s);
        ll_status status = ll_session_patch(s, 0, patch);
        if (status.code != LL_CONFLICT || strcmp(status.field, sets[i][2]) != 0)
            fail_msg("%s %s: %s", sets[i][0], sets[i][1], ll_failed(&status) ? status.text : "taken");
        assert_true(ll_session_hash(s) == hash);
        must(ll_session_run_to(s, 17));
        ll_session_destroy(s);
        cJSON_Delete(patch);
        cJSON_Delete(json);
    }
}

static void patch_text(ll_session *s, const char *text)
{
    cJSON *patch = cJSON_Parse(text);
    must(ll_session_patch(s, 0, patch));
    cJSON_Delete(patch);
}

static void control_text(ll_session *s, const char *text)
{
    cJSON *control = cJSON_Parse(text);
    must(ll_session_control(s, 0, control));
    cJSON_Delete(control);
}

static ll_session *open_library(const char *id, growing *log)
{
    cJSON *json;
    ll_session *s;
    must(ll_scenario_load("scenarios", id, &json));
    must(ll_session_create(json, 7, add_line, log, &s));
    cJSON_Delete(json);
    return s;
}

static void assert_log_gives(const growing *log, ll_session *s)
{
    ll_session *again;
    must(ll_session_restore(log->text, log->size, NULL, NULL, &again));
    must(ll_session_run_to(again, tick_of(s)));
    assert_true(ll_session_hash(again) == ll_session_hash(s));
    ll_session_destroy(again);
}

static double block_bytes(ll_session *s)
{
    cJSON *cost = ll_session_cost(s);
    double bytes = cJSON_GetObjectItem(cost, "block_bytes")->valuedouble;
    cJSON_Delete(cost);
    return bytes;
}

/* The block of another sync mode is larger: a restart was written beyond the old one. */
static void a_restart_has_the_layout_of_its_parameters(void **state)
{
    (void)state;
    static const char *const syncs[] = {"rollback", "free", "deterministic", "lockstep", "rollback"};
    growing log = {0};
    ll_session *s = open_library("race", &log);
    must(ll_session_run_to(s, 600)); /* has a checkpoint */
    const double size = block_bytes(s);
    for (size_t i = 0; i < sizeof syncs / sizeof syncs[0]; i++) {
        char text[64];
        snprintf(text, sizeof text, "{\"server.sync\":\"%s\"}", syncs[i]);
        patch_text(s, text);
        must(ll_session_run_to(s, tick_of(s) + 100));
        control_text(s, "{\"op\":\"restart\"}");
        must(ll_session_run_to(s, 700));
        control_text(s, "{\"op\":\"seek\",\"tick\":650}");
        assert_log_gives(&log, s);
    }
    assert_true(block_bytes(s) > size);
    control_text(s, "{\"op\":\"restart\",\"reset\":true}");
    assert_true(block_bytes(s) == size);
    must(ll_session_run_to(s, 300));
    assert_log_gives(&log, s);
    ll_session_destroy(s);
    free(log.text);
}

/* A device that is read once in an age: the wait was more ns than an integer has. */
static void a_device_may_be_read_hardly_ever(void **state)
{
    (void)state;
    growing log = {0};
    ll_session *s = open_library("rifle", &log);
    patch_text(s, "{\"players.0.input_hz\":1e-300,\"players.1.input_hz\":1e-9}");
    must(ll_session_run_to(s, 200));
    assert_log_gives(&log, s);
    ll_session_destroy(s);
    free(log.text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(changes_at_random),
        cmocka_unit_test(another_layout_is_refused),
        cmocka_unit_test(a_restart_has_the_layout_of_its_parameters),
        cmocka_unit_test(a_device_may_be_read_hardly_ever),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
