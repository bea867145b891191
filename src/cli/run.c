/* The verb `run`. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/assert.h"
#include "cli/arguments.h"
#include "cli/input.h"
#include "cli/link_trace.h"
#include "cli/paper.h"
#include "cli/trace.h"
#include "cli/verbs.h"
#include "experiment/spec/metric_path.h"
#include "session/scenario.h"
#include "session/session.h"
#include "session/workload.h"
#include "threads/clock.h"
#include "threads/team.h"

enum { ASKED_MAX = 64 }; /* paths of --metrics */

typedef struct run_options {
    const char *scenario;
    ll_option_list sets, traces, traced; /* traced: orders of --trace-of */
    bool text;
    const char *metrics; /* paths, separated by commas; NULL: all */
    const char *seed, *duration, *trace, *packets, *packets_at, *log, *workload, *record, *scenarios,
        *threads;
} run_options;

static void write_text(void *context, const char *text, size_t length)
{
    fwrite(text, 1, length, context);
}

static void write_line(void *context, const char *text, size_t length)
{
    fwrite(text, 1, length, context);
    fputc('\n', context);
}

static ll_status to_file(const char *path, FILE **f)
{
    *f = fopen(path, "wb");
    return *f ? ll_ok() : ll_error(LL_IO, "cannot write %.200s", path);
}

static ll_status close_file(FILE *f, const char *path)
{
    bool bad = ferror(f) != 0;
    bad |= fclose(f) != 0;
    return bad ? ll_error(LL_IO, "cannot write %.200s", path) : ll_ok();
}

/* path=value of an option such as --seed. The caller frees it. NULL: no memory. */
static char *set_of(const char *path, const char *value)
{
    size_t size = strlen(path) + strlen(value) + 2;
    char *set = malloc(size);
    if (set)
        snprintf(set, size, "%s=%s", path, value);
    return set;
}

/* Applies --set, then --seed and --duration, to the scenario's JSON. */
static ll_status override(const run_options *a, cJSON **json)
{
    char *seed = a->seed ? set_of("seed", a->seed) : NULL;
    char *duration = a->duration ? set_of("duration_s", a->duration) : NULL;
    const char *const later[] = {seed ? seed : duration, seed ? duration : NULL, NULL};
    ll_status status = ll_ok();
    if ((a->seed && !seed) || (a->duration && !duration))
        status = ll_error(LL_NO_MEMORY, "out of memory: scenario");
    LL_THEN(status, ll_scenario_override(json, a->sets.items, a->sets.count, later));
    free(seed);
    free(duration);
    return status;
}

/* Runs tick by tick and writes each hash, so that a replay can find the first difference. */
static ll_status run_logged(ll_session *s, int64_t end, FILE *log)
{
    ll_status status = ll_ok();
    ll_session_log(s, write_line, log);
    for (int64_t tick = 1; tick <= end && !ll_failed(&status); tick++) {
        status = ll_session_run_to(s, tick);
        fprintf(log, "{\"op\":\"hash\",\"tick\":%" PRId64 ",\"hash\":\"%016" PRIx64 "\"}\n", tick,
                ll_session_hash(s));
    }
    return status;
}

/* Something of all ticks, computed on a copy. */
typedef ll_status write_ticks(ll_session *s, const run_options *a, FILE *f);

static ll_status write_trace(ll_session *s, const run_options *a, FILE *f)
{
    (void)a;
    return ll_session_trace(s, 0, ll_session_get_info(s).tick, write_text, f);
}

static ll_status write_packets(ll_session *s, const run_options *a, FILE *f)
{
    ll_capture_range range = {.to = ll_session_get_info(s).tick};
    LL_TRY(ll_session_interface(s, a->packets_at, &range.interface));
    return ll_session_capture(s, &range, write_text, f);
}

static ll_status write_file(ll_session *s, const run_options *a, const char *path, write_ticks *what)
{
    FILE *f;
    if (!path)
        return ll_ok();
    LL_TRY(to_file(path, &f));
    ll_status status = what(s, a, f);
    ll_status closed = close_file(f, path);
    return ll_failed(&status) ? status : closed;
}

/* The paths of --metrics. */
typedef struct asked_metrics {
    char *text; /* owned; the paths point into it */
    const char *path[ASKED_MAX];
    int count;
} asked_metrics;

/* Splits the list, and checks each path with the metrics before the first tick. */
static ll_status read_asked(const char *list, ll_session *s, asked_metrics *asked)
{
    if (!list)
        return ll_ok();
    asked->text = strdup(list);
    cJSON *report = asked->text ? ll_session_metrics(s) : NULL;
    ll_status status = report ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: metrics");
    char *rest = asked->text, *path;
    while (!ll_failed(&status) && (path = strsep(&rest, ","))) {
        if (asked->count == ASKED_MAX)
            status = ll_error(LL_BAD_INPUT, "--metrics: must be at most %d paths", ASKED_MAX);
        else
            status = ll_metric_check(cJSON_GetObjectItem(report, "metrics"), "--metrics", path);
        for (int i = 0; i < asked->count && !ll_failed(&status); i++)
            if (strcmp(asked->path[i], path) == 0)
                status = ll_error(LL_BAD_INPUT, "--metrics: duplicate %s", path);
        if (!ll_failed(&status))
            asked->path[asked->count++] = path;
    }
    cJSON_Delete(report);
    return status;
}

/* All metrics, or those that were asked for by their paths. Caller deletes. */
static cJSON *metrics_of(ll_session *s, cJSON *report, const asked_metrics *asked)
{
    cJSON *all = cJSON_DetachItemFromObject(report, "metrics");
    if (!asked->text) {
        ll_session_time_parts(s, all, ll_process_cpu_ns);
        return all;
    }
    cJSON *some = cJSON_CreateObject();
    for (int i = 0; i < asked->count; i++)
        cJSON_AddItemToObject(some, asked->path[i], cJSON_Duplicate(ll_metric_at(all, asked->path[i]), true));
    cJSON_Delete(all);
    return some;
}

static void print_result(const run_options *a, ll_session *s, const asked_metrics *asked, double wall_s)
{
    ll_session_info info = ll_session_get_info(s);
    cJSON *report = ll_session_metrics(s), *out = cJSON_CreateObject();
    cJSON_AddStringToObject(out, "scenario", a->scenario);
    cJSON_AddItemToObject(
        out, "seed", ll_param_number((double)info.seed)); /* all digits, so that the run can be repeated */
    cJSON_AddNumberToObject(out, "duration_s", ll_to_s(info.duration));
    cJSON_AddNumberToObject(out, "ticks", (double)info.tick);
    cJSON_AddItemToObject(out, "hash", cJSON_DetachItemFromObject(report, "hash"));
    cJSON_AddNumberToObject(out, "wall_s", wall_s);
    cJSON_AddItemToObject(out, "metrics", metrics_of(s, report, asked));
    cJSON_AddItemToObject(out, "cost", ll_session_cost(s));
    char *text = cJSON_Print(out);
    puts(text);
    cJSON_free(text);
    cJSON_Delete(out);
    cJSON_Delete(report);
}

/* Loads the inputs of a log, for players with control `person`. */
static ll_status load_workload(const char *path, ll_session *s)
{
    char *text;
    ll_workload *workload = NULL;
    ll_status status = ll_argument_text(path, &text);
    cJSON *log = cJSON_CreateString(text ? text : "");
    free(text);
    LL_THEN(status, ll_workload_parse(log, &workload));
    LL_THEN(status, ll_session_load(s, workload));
    ll_workload_free(workload);
    cJSON_Delete(log);
    return status;
}

/* Before the run, which may take long. */
static ll_status check_packets(const run_options *a, const ll_session *s)
{
    int interface;
    if (a->packets_at && !a->packets)
        return ll_error(LL_BAD_INPUT, "--pcap-at: needs --pcap");
    if (a->packets && ll_session_players(s) == 0)
        return ll_error(LL_CONFLICT, "packets: the kind must be netgame; got %s",
                        ll_session_get_info(s).kind);
    return ll_session_interface(s, a->packets_at, &interface);
}

static ll_status run_session(const run_options *a, ll_session *s, double *wall_s)
{
    int64_t end = ll_session_get_info(s).end_tick;
    int64_t wall = ll_now_ns(), cpu = ll_process_cpu_ns();
    ll_status status;
    ll_session_step_profiler(s, ll_process_cpu_ns);
    if (a->log && a->record)
        return ll_error(LL_BAD_INPUT, "--log, --record-inputs: must not be given together");
    LL_TRY(check_packets(a, s));
    for (int i = 0; i < a->traced.count; i++)
        LL_TRY(ll_trace_check(s, a->traced.items[i]));
    const char *path = a->log ? a->log : a->record;
    if (path) {
        FILE *log;
        status = to_file(path, &log);
        if (ll_failed(&status))
            return status;
        status = a->log ? run_logged(s, end, log) : ll_session_record(s, write_line, log);
        ll_status closed = close_file(log, path);
        status = ll_failed(&status) ? status : closed;
    } else {
        status = ll_session_run_to(s, end);
    }
    *wall_s = (double)(ll_now_ns() - wall) * 1e-9;
    ll_session_account(s, ll_process_cpu_ns() - cpu, ll_session_get_info(s).tick);
    if (a->trace && !ll_trace_is_csv(a->trace))
        LL_THEN(status, ll_trace_write_columns(s, a->trace));
    else
        LL_THEN(status, write_file(s, a, a->trace, write_trace));
    for (int i = 0; i < a->traced.count; i++)
        LL_THEN(status, ll_trace_write(s, a->traced.items[i]));
    LL_THEN(status, write_file(s, a, a->packets, write_packets));
    return status;
}

/* Prints what the paper prints for the scenario. */
static ll_status print_text(const cJSON *json)
{
    ll_scenario scenario = {0};
    ll_status status = ll_scenario_parse(json, &scenario);
    if (ll_failed(&status))
        return status;
    if (scenario.kind->text)
        status = scenario.kind->text(scenario.config, write_text, stdout);
    else if (scenario.kind->player_name)
        status = ll_paper_netgame(&scenario, stdout);
    else
        status =
            ll_error(LL_BAD_INPUT, "--text: kind must be motion or netgame; got %s", scenario.kind->name);
    ll_scenario_free(&scenario);
    return status;
}

enum { OPTIONS = 20 };

/* The files that a run writes. Returns how many options. */
static int output_options(run_options *a, ll_option *options)
{
    const ll_option outputs[] = {
        {.name = "--trace",
         .takes = "FILE",
         .help = "Writes a table with a row per tick; csv, ndjson, json or sqlite by its ending.",
         .value = &a->trace},
        {.name = "--trace-of",
         .takes = "RECORD=FILE",
         .help =
             "Writes the rows of a record of the stream at every tick, such as entities, as each player's "
             "screen draws them, or of events as they happen: packets, corrections, events. Formats as of "
             "--trace.",
         .list = &a->traced},
        {.name = "--pcap",
         .takes = "FILE.pcapng",
         .help = "Writes the packets of a netgame for Wireshark, as sent and as received.",
         .value = &a->packets},
        {.name = "--pcap-at",
         .takes = "NAME",
         .help = "Only the packets that `server` or this player sends and receives; default: of all.",
         .value = &a->packets_at},
        {.name = "--log",
         .takes = "FILE",
         .help = "Writes the log with the hash of every tick, for `laglab replay`.",
         .value = &a->log}};
    memcpy(options, outputs, sizeof outputs);
    return (int)(sizeof outputs / sizeof outputs[0]);
}

/* What is run, and how. */
static int input_options(run_options *a, ll_option *options)
{
    const ll_option inputs[] = {
        {.name = "--set",
         .takes = "path=value",
         .help = "A parameter value, such as players.0.lag_ms=200.",
         .list = &a->sets},
        {.name = "--metrics",
         .takes = "PATH,PATH...",
         .help =
             "Prints only these metrics, such as players.0.remote_error_m.mean, and measures no more than "
             "they need, which is faster.",
         .value = &a->metrics},
        {.name = "--link-trace",
         .takes = "PATH=FILE",
         .help =
             "A trace of Mahimahi, or CSV with the header t_ms,delay_ms,lost, for one direction of a link, "
             "such as players.0.link.down; it becomes a profile of the scenario.",
         .list = &a->traces},
        {.name = "--seed", .takes = "N", .help = "Random seed.", .value = &a->seed},
        {.name = "--duration", .takes = "S", .help = "Duration in virtual seconds.", .value = &a->duration},
        {.name = "--workload",
         .takes = "LOG",
         .help = "Inputs of people, as in a log, for players whose control is person.",
         .value = &a->workload},
        {.name = "--record-inputs",
         .takes = "FILE",
         .help = "Writes the players' inputs as a workload.",
         .value = &a->record},
        {.name = "--threads",
         .takes = "N",
         .help =
             "Threads of a step of kinds rigid and fluid, 1 to 16, with the same results; default 1. More "
             "than one helps worlds of some thousand bodies, cells or particles.",
         .value = &a->threads},
        {.name = "--text",
         .help =
             "Prints what the paper prints for the scenario, in place of metrics; kinds motion and netgame.",
         .flag = &a->text},
        {.name = "--scenarios",
         .takes = "DIR",
         .help = "Folder in which ids of scenarios are looked up; default: next to the program.",
         .value = &a->scenarios}};
    memcpy(options, inputs, sizeof inputs);
    return (int)(sizeof inputs / sizeof inputs[0]);
}

static ll_status parse(int argc, char **argv, run_options *a)
{
    ll_option options[OPTIONS] = {{0}};
    int count = input_options(a, options);
    count += output_options(a, options + count);
    LL_ASSERT(count < OPTIONS); /* the last one ends the list */
    return ll_arguments_one("run SCENARIO [OPTION]...: run a scenario at full speed and print its metrics; "
                            "SCENARIO is an id, a file, or - for standard input",
                            argc, argv, options, &a->scenario);
}

/* Nothing seeks back in it: files of all ticks are computed on copies. */
static ll_status open_session(const cJSON *json, ll_session **session)
{
    ll_scenario scenario = {0};
    LL_TRY(ll_scenario_parse(json, &scenario));
    return ll_session_open_forward(&scenario, NULL, session);
}

/* NULL for one thread. */
static ll_status make_team(const char *threads, ll_team **team)
{
    int64_t count = 1;
    if (threads)
        LL_TRY(ll_argument_whole("--threads", threads, 1, LL_TEAM_PARTS_MAX, &count));
    return count > 1 ? ll_team_make((int)count, team) : ll_ok();
}

int ll_verb_run(int argc, char **argv)
{
    run_options a = {0};
    cJSON *json = NULL;
    ll_session *session = NULL;
    ll_team *team = NULL;
    asked_metrics asked = {0};
    double wall_s = 0;
    ll_status status = parse(argc, argv, &a);
    LL_THEN(status, ll_scenario_argument(a.scenario, a.scenarios, &json));
    LL_THEN(status, ll_link_traces_add(&a.traces, json));
    LL_THEN(status, override(&a, &json));
    if (a.text && !ll_failed(&status)) {
        status = print_text(json);
        cJSON_Delete(json);
        return ll_failed(&status) ? ll_argument_fail(&status) : 0;
    }
    LL_THEN(status, open_session(json, &session));
    LL_THEN(status, read_asked(a.metrics, session, &asked));
    if (!ll_failed(&status) && a.metrics)
        ll_session_observe_only(session, asked.path, asked.count);
    if (!ll_failed(&status) && a.workload)
        status = load_workload(a.workload, session);
    LL_THEN(status, make_team(a.threads, &team));
    if (!ll_failed(&status)) {
        ll_session_set_team(session, team);
        status = run_session(&a, session, &wall_s);
    }
    if (!ll_failed(&status))
        print_result(&a, session, &asked, wall_s);
    free(asked.text);
    ll_session_destroy(session);
    ll_team_free(team);
    cJSON_Delete(json);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}
