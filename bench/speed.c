/* How fast the engine runs a scenario, and what a session of it holds: speed SECONDS RUNS [unobserved]
 * <scenario.json
 *
 * With `unobserved` no metric is asked for, so that no view is compared with the truth; the hash is the same.
 * Prints one JSON object: CPU time of this thread for SECONDS simulated seconds (after a first run that warms
 * caches), and the bytes of a session with 30 s of history, as `cost` reports them, live and parked. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "session/scenario.h"
#include "session/session.h"

enum { HISTORY_S = 30, WARMUP_S = 60 };

static double cpu_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void check(ll_status status)
{
    if (ll_failed(&status)) {
        fprintf(stderr, "speed: %s\n", status.text);
        exit(1);
    }
}

static void set_duration(cJSON *scenario, double seconds)
{
    cJSON_DeleteItemFromObject(scenario, "duration_s");
    cJSON_AddNumberToObject(scenario, "duration_s", seconds);
}

static cJSON *read_scenario(double seconds)
{
    static char text[1 << 20];
    cJSON *json;
    check(ll_json_parse(text, fread(text, 1, sizeof text, stdin), &json));
    set_duration(json, seconds);
    return json;
}

static ll_session *create(const cJSON *scenario)
{
    ll_session *session;
    check(ll_session_create(scenario, -1, NULL, NULL, &session));
    return session;
}

/* As `laglab run` does: without checkpoints, and without events for viewers. */
static ll_session *open_forward(const cJSON *json)
{
    ll_scenario scenario;
    ll_session *session;
    check(ll_scenario_parse(json, &scenario));
    check(ll_session_open_forward(&scenario, NULL, &session));
    return session;
}

static int64_t tick_at(ll_session *session, double seconds)
{
    ll_session_info info = ll_session_get_info(session);
    int64_t tick = ll_tick_at(info.tick_freq, (ll_time)(seconds * 1e9));
    return tick < info.end_tick ? tick : info.end_tick;
}

static double run(const cJSON *scenario, double seconds, bool observes, uint64_t *hash, int64_t *ticks)
{
    ll_session *session = open_forward(scenario);
    if (!observes)
        ll_session_observe_only(session, NULL, 0);
    double begin = cpu_now();
    check(ll_session_run_to(session, tick_at(session, seconds)));
    double spent = cpu_now() - begin;
    *hash = ll_session_hash(session);
    *ticks = ll_session_get_info(session).tick;
    ll_session_destroy(session);
    return spent;
}

/* Of a session that ends after HISTORY_S: it then has all the snapshots that a session ever keeps. */
static void add_bytes(cJSON *out, cJSON *scenario)
{
    set_duration(scenario, HISTORY_S);
    ll_session *session = create(scenario);
    check(ll_session_run_to(session, tick_at(session, HISTORY_S)));
    cJSON_AddItemToObject(out, "live", ll_session_cost(session));
    ll_session_park(session);
    cJSON_AddItemToObject(out, "parked", ll_session_cost(session));
    ll_session_destroy(session);
}

int main(int argc, char **argv)
{
    double seconds = argc > 1 ? atof(argv[1]) : 3600, spent = 0;
    int runs = argc > 2 ? atoi(argv[2]) : 1;
    bool observes = argc <= 3;
    if (seconds < WARMUP_S)
        seconds = WARMUP_S;
    cJSON *scenario = read_scenario(seconds), *out = cJSON_CreateObject();
    uint64_t hash;
    int64_t ticks;
    run(scenario, WARMUP_S, observes, &hash, &ticks);
    for (int i = 0; i < runs; i++)
        spent += run(scenario, seconds, observes, &hash, &ticks);
    cJSON_AddNumberToObject(out, "cpu_s", spent);
    cJSON_AddNumberToObject(out, "sim_s", seconds * runs);
    cJSON_AddNumberToObject(out, "ticks", (double)ticks);
    char text[17];
    snprintf(text, sizeof text, "%016" PRIx64, hash);
    cJSON_AddStringToObject(out, "hash", text);

    add_bytes(out, scenario);

    char *line = cJSON_PrintUnformatted(out);
    puts(line);
    cJSON_free(line);
    cJSON_Delete(out);
    cJSON_Delete(scenario);
    return 0;
}
