/* The verbs of the command line. Results go to stdout, errors to stderr; exit 2 for bad usage or input, 1 for
 * a failed run. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "library/program.h"
#include "base/version.h"
#include "daemon/serve/serve.h"
#include "cli/arguments.h"
#include "experiment/spec/experiment.h"
#include "cli/verbs.h"
#include "ode/core/method.h"
#include "ode/core/problem.h"
#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"
#include "session/workload.h"

#define SETS_MAX 256
#define INPUT_MAX (64u << 20)

/* ---- arguments ---- */

typedef struct arguments {
    const char *positional;
    const char *sets[SETS_MAX];
    int set_count;
    bool text;
    const char *seed, *duration, *trace, *log, *workload, *record, *scenarios;
} arguments;

static int fail(const ll_status *status)
{
    fprintf(stderr, "laglab: %s\n", status->text);
    return status->code == LL_DIVERGED || status->code == LL_IO || status->code == LL_NO_MEMORY ? 1 : 2;
}

static ll_status parse_arguments(int argc, char **argv, arguments *a)
{
    const struct {
        const char *name, **value;
    } options[] = {{"--seed", &a->seed},          {"--duration", &a->duration},
                   {"--trace", &a->trace},        {"--log", &a->log},
                   {"--workload", &a->workload},  {"--record-inputs", &a->record},
                   {"--scenarios", &a->scenarios}};
    for (int i = 0; i < argc; i++) {
        const char **value = NULL;
        for (size_t k = 0; k < sizeof options / sizeof options[0]; k++)
            if (strcmp(argv[i], options[k].name) == 0)
                value = options[k].value;
        bool set = strcmp(argv[i], "--set") == 0;
        if (strcmp(argv[i], "--text") == 0) {
            a->text = true;
        } else if (set || value) {
            if (i + 1 == argc)
                return ll_error(LL_BAD_INPUT, "%s needs a value", argv[i]);
            if (set && a->set_count == SETS_MAX)
                return ll_error(LL_BAD_INPUT, "--set is given more than %d times", SETS_MAX);
            *(set ? &a->sets[a->set_count++] : value) = argv[i + 1];
            i++;
        } else if (argv[i][0] == '-' && argv[i][1] != '\0') {
            return ll_error(LL_BAD_INPUT, "unknown option %s", argv[i]);
        } else if (a->positional) {
            return ll_error(LL_BAD_INPUT, "unexpected argument %s", argv[i]);
        } else {
            a->positional = argv[i];
        }
    }
    return ll_ok();
}

static ll_status read_whole(FILE *f, const char *name, char **text, size_t *length)
{
    size_t capacity = 1 << 16;
    *length = 0;
    *text = malloc(capacity);
    while (*text) {
        *length += fread(*text + *length, 1, capacity - *length, f);
        if (*length < capacity)
            break;
        if (capacity >= INPUT_MAX) {
            free(*text);
            return ll_error(LL_BAD_INPUT, "%s is longer than %u bytes", name, INPUT_MAX);
        }
        capacity *= 2;
        char *bigger = realloc(*text, capacity);
        if (!bigger)
            free(*text);
        *text = bigger;
    }
    return *text ? ll_ok() : ll_error(LL_NO_MEMORY, "no memory for %s", name);
}

/* Where the scenarios are: beside the binary, unless told. */
static const char *scenario_directory(const arguments *a, char path[PATH_MAX])
{
    if (a->scenarios)
        return a->scenarios;
    ll_beside_program("scenarios", path, PATH_MAX);
    return path;
}

static ll_status load_scenario(const arguments *a, cJSON **json)
{
    char path[PATH_MAX];
    *json = NULL;
    if (!a->positional)
        return ll_error(LL_BAD_INPUT,
                        "which scenario? An id (see `laglab scenarios`), a file, or - for standard input");
    if (strcmp(a->positional, "-") == 0) {
        char *text = NULL;
        size_t length = 0;
        ll_status status = read_whole(stdin, "standard input", &text, &length);
        if (!ll_failed(&status)) {
            status = ll_json_parse(text, length, json);
            free(text);
        }
        return status;
    }
    ll_status status = ll_scenario_load(scenario_directory(a, path), a->positional, json);
    if (status.code == LL_NOT_FOUND && access(a->positional, R_OK) == 0)
        return ll_scenario_read(a->positional, json);
    return status;
}

/* An option that stands for a value, after those of --set; NULL, when it is not given, sets nothing. */
static ll_status put_option(const ll_param_table *table, void *config, const char *path, const char *value)
{
    if (!value)
        return ll_ok();
    size_t size = strlen(path) + strlen(value) + 2;
    char *set = malloc(size);
    if (!set)
        return ll_error(LL_NO_MEMORY, "no memory for a scenario");
    snprintf(set, size, "%s=%s", path, value);
    ll_status status = ll_param_put(table, config, (const char *const[]){set}, 1);
    free(set);
    return status;
}

/* Applies --set, --seed and --duration to the scenario's JSON by way of its tables, so that all are checked
 * alike: when all are set, so that their order does not matter. */
static ll_status override(const arguments *a, cJSON **json)
{
    ll_scenario scenario = {0};
    ll_status status = ll_scenario_parse(*json, &scenario);
    if (ll_failed(&status))
        return status;
    const ll_param_table *table = scenario.kind->table;
    void *before = malloc(table->size);
    if (!before) {
        ll_scenario_free(&scenario);
        return ll_error(LL_NO_MEMORY, "no memory for a scenario");
    }
    memcpy(before, scenario.config, table->size);
    status = ll_param_put(table, scenario.config, a->sets, a->set_count);
    if (!ll_failed(&status))
        status = put_option(table, scenario.config, "seed", a->seed);
    if (!ll_failed(&status))
        status = put_option(table, scenario.config, "duration_s", a->duration);
    if (!ll_failed(&status))
        status = ll_param_check(table, scenario.config);
    if (!ll_failed(&status)) {
        scenario.kind->settle(scenario.config, before);
        cJSON_Delete(*json);
        *json = ll_param_write(table, scenario.config);
    }
    free(before);
    ll_scenario_free(&scenario);
    return status;
}

/* ---- run ---- */

static void write_text(void *context, const char *text, size_t length)
{
    fwrite(text, 1, length, context);
}

static void write_line(void *context, const char *text, size_t length)
{
    fwrite(text, 1, length, context);
    fputc('\n', context);
}

static double seconds_now(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* Runs tick by tick and writes the hash after each, so that a replay can tell the first that differs. */
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

static ll_status write_trace(ll_session *s, const char *path)
{
    FILE *f;
    ll_status status = to_file(path, &f);
    if (ll_failed(&status))
        return status;
    status = ll_session_trace(s, 0, ll_session_get_info(s).tick, write_text, f);
    ll_status closed = close_file(f, path);
    return ll_failed(&status) ? status : closed;
}

static int64_t cpu_now_ns(void)
{
    return (int64_t)(seconds_now(CLOCK_PROCESS_CPUTIME_ID) * 1e9);
}

static void print_result(const arguments *a, ll_session *s, double wall_s)
{
    ll_session_info info = ll_session_get_info(s);
    cJSON *report = ll_session_metrics(s), *out = cJSON_CreateObject();
    cJSON_AddStringToObject(out, "scenario", a->positional);
    cJSON_AddItemToObject(out, "seed",
                          ll_param_number((double)info.seed)); /* to the last digit: it may be run again */
    cJSON_AddNumberToObject(out, "duration_s", ll_to_s(info.duration));
    cJSON_AddNumberToObject(out, "ticks", (double)info.tick);
    cJSON_AddItemToObject(out, "hash", cJSON_DetachItemFromObject(report, "hash"));
    cJSON_AddNumberToObject(out, "wall_s", wall_s);
    ll_session_time_parts(s, cJSON_GetObjectItem(report, "metrics"), cpu_now_ns);
    cJSON_AddItemToObject(out, "metrics", cJSON_DetachItemFromObject(report, "metrics"));
    cJSON_AddItemToObject(out, "cost", ll_session_cost(s));
    char *text = cJSON_Print(out);
    puts(text);
    cJSON_free(text);
    cJSON_Delete(out);
    cJSON_Delete(report);
}

/* The inputs of a log, for the players that a person drives. */
static ll_status load_workload(const char *path, ll_session *s)
{
    char *text;
    ll_workload *workload = NULL;
    ll_status status = ll_argument_text(path, &text);
    cJSON *log = cJSON_CreateString(text ? text : "");
    free(text);
    if (!ll_failed(&status))
        status = ll_workload_parse(log, &workload);
    if (!ll_failed(&status))
        status = ll_session_load(s, workload);
    ll_workload_free(workload);
    cJSON_Delete(log);
    return status;
}

static ll_status run_session(const arguments *a, ll_session *s, double *wall_s)
{
    int64_t end = ll_session_get_info(s).end_tick;
    double wall = seconds_now(CLOCK_MONOTONIC), cpu = seconds_now(CLOCK_PROCESS_CPUTIME_ID);
    ll_status status;
    ll_session_meter(s, cpu_now_ns);
    if (a->log && a->record)
        return ll_error(LL_BAD_INPUT, "--log and --record-inputs are for two runs: give one of them");
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
    *wall_s = seconds_now(CLOCK_MONOTONIC) - wall;
    ll_session_account(s, (int64_t)((seconds_now(CLOCK_PROCESS_CPUTIME_ID) - cpu) * 1e9),
                       ll_session_get_info(s).tick);
    if (a->trace && !ll_failed(&status))
        status = write_trace(s, a->trace);
    return status;
}

/* The lines that the paper prints of it, in place of a run. */
static ll_status print_text(const cJSON *json)
{
    ll_scenario scenario = {0};
    ll_status status = ll_scenario_parse(json, &scenario);
    if (ll_failed(&status))
        return status;
    if (scenario.kind->text)
        status = scenario.kind->text(scenario.config, write_text, stdout);
    else
        status = ll_error(LL_BAD_INPUT, "--text is for scenarios of kind motion; this one is of kind %s",
                          scenario.kind->name);
    ll_scenario_free(&scenario);
    return status;
}

static int verb_run(int argc, char **argv)
{
    arguments a = {0};
    cJSON *json = NULL;
    ll_session *session = NULL;
    double wall_s = 0;
    ll_status status = parse_arguments(argc, argv, &a);
    if (!ll_failed(&status))
        status = load_scenario(&a, &json);
    if (!ll_failed(&status))
        status = override(&a, &json);
    if (a.text && !ll_failed(&status)) {
        status = print_text(json);
        cJSON_Delete(json);
        return ll_failed(&status) ? fail(&status) : 0;
    }
    if (!ll_failed(&status))
        status = ll_session_create(json, -1, NULL, NULL, &session);
    if (!ll_failed(&status) && a.workload)
        status = load_workload(a.workload, session);
    if (!ll_failed(&status))
        status = run_session(&a, session, &wall_s);
    if (!ll_failed(&status))
        print_result(&a, session, wall_s);
    ll_session_destroy(session);
    cJSON_Delete(json);
    return ll_failed(&status) ? fail(&status) : 0;
}

/* ---- replay ---- */

static bool read_hash(const char *line, size_t length, int64_t *tick, char hash[17])
{
    cJSON *o = cJSON_ParseWithLength(line, length);
    const cJSON *op = cJSON_GetObjectItemCaseSensitive(o, "op"),
                *t = cJSON_GetObjectItemCaseSensitive(o, "tick");
    const cJSON *h = cJSON_GetObjectItemCaseSensitive(o, "hash");
    bool ok = cJSON_IsString(op) && strcmp(op->valuestring, "hash") == 0 && cJSON_IsNumber(t) &&
              cJSON_IsString(h) && strlen(h->valuestring) == 16;
    if (ok) {
        *tick = (int64_t)t->valuedouble;
        memcpy(hash, h->valuestring, 17);
    }
    cJSON_Delete(o);
    return ok;
}

/* Compares with every hash line of the log; returns how many there were, or -1 after telling the first that
 * differs. */
static int64_t compare_hashes(ll_session *s, const char *text, size_t length)
{
    int64_t compared = 0;
    for (const char *p = text, *end = text + length; p < end;) {
        const char *newline = memchr(p, '\n', (size_t)(end - p));
        size_t size = newline ? (size_t)(newline - p) : (size_t)(end - p);
        char wanted[17], got[17];
        int64_t tick;
        if (read_hash(p, size, &tick, wanted)) {
            ll_status status = ll_session_run_to(s, tick);
            if (ll_failed(&status)) {
                fprintf(stderr, "laglab: tick %" PRId64 ": %s\n", tick, status.text);
                return -1;
            }
            snprintf(got, sizeof got, "%016" PRIx64, ll_session_hash(s));
            if (strcmp(got, wanted) != 0) {
                fprintf(stderr, "laglab: tick %" PRId64 " differs: the log says %s, the replay gives %s\n",
                        tick, wanted, got);
                return -1;
            }
            compared++;
        }
        p += size + 1;
    }
    return compared;
}

/* Behind the log's last tick, where the session that made it failed. */
static bool fails_alike(ll_session *s, int64_t tick)
{
    char wanted[17], got[17];
    ll_status status = ll_session_run_to(s, tick);
    snprintf(wanted, sizeof wanted, "%016" PRIx64, ll_session_failed_hash(s));
    if (!ll_failed(&status))
        status = ll_session_run_to(s, tick + 1);
    snprintf(got, sizeof got, "%016" PRIx64, ll_session_hash(s));
    if (!ll_failed(&status))
        fprintf(stderr,
                "laglab: the log says that the session failed behind tick %" PRId64 "; the replay goes on\n",
                tick);
    else if (strcmp(wanted, got) != 0)
        fprintf(stderr, "laglab: it failed behind tick %" PRId64 ": the log says %s, the replay gives %s\n",
                tick, wanted, got);
    else
        fprintf(stderr, "laglab: it failed behind tick %" PRId64 ", as the log says: %s\n", tick,
                status.text);
    return ll_failed(&status) && strcmp(wanted, got) == 0;
}

/* A session that failed is told as one: exit 1, also when the replay fails alike. */
static int replay(ll_session *session, const char *text, size_t length)
{
    int64_t head = ll_session_get_info(session).head_tick, failed_at = ll_session_failed_at(session);
    int64_t compared = compare_hashes(session, text, length);
    if (compared < 0)
        return 1;
    if (failed_at >= 0)
        compared += fails_alike(session, failed_at);
    else if (ll_session_run_to(session, head).code != LL_OK)
        failed_at = ll_session_failed_at(session);
    printf("{\"ticks\":%" PRId64 ",\"compared\":%" PRId64 ",\"hash\":\"%016" PRIx64 "\"}\n", head, compared,
           ll_session_hash(session));
    return failed_at >= 0;
}

static int verb_replay(int argc, char **argv)
{
    arguments a = {0};
    char *text = NULL;
    size_t length = 0;
    ll_session *session = NULL;
    FILE *f = NULL;
    int result = 2;
    ll_status status = parse_arguments(argc, argv, &a);
    if (!ll_failed(&status) && !a.positional)
        status = ll_error(LL_BAD_INPUT,
                          "which log? A file as `laglab run --log` writes it, or - for standard input");
    if (!ll_failed(&status)) {
        f = strcmp(a.positional, "-") == 0 ? stdin : fopen(a.positional, "rb");
        status = f ? read_whole(f, a.positional, &text, &length)
                   : ll_error(LL_NOT_FOUND, "cannot read %.200s", a.positional);
    }
    if (!ll_failed(&status))
        status = ll_session_restore(text, length, NULL, NULL, &session);
    if (ll_failed(&status))
        result = fail(&status);
    else
        result = replay(session, text, length);
    ll_session_destroy(session);
    free(text);
    if (f && f != stdin)
        fclose(f);
    return result;
}

/* ---- lists ---- */

static int print_json(cJSON *json)
{
    char *text = cJSON_Print(json);
    puts(text ? text : "null");
    cJSON_free(text);
    cJSON_Delete(json);
    return 0;
}

static int verb_scenarios(int argc, char **argv)
{
    arguments a = {0};
    char path[PATH_MAX];
    cJSON *list = NULL;
    ll_status status = parse_arguments(argc, argv, &a);
    if (!ll_failed(&status))
        status = ll_scenario_list(scenario_directory(&a, path), &list);
    if (ll_failed(&status))
        return fail(&status);
    const cJSON *item;
    cJSON_ArrayForEach(item, list)
    {
        printf("%-24s %-12s %s\n", cJSON_GetObjectItem(item, "id")->valuestring,
               cJSON_GetObjectItem(item, "paper")->valuestring,
               cJSON_GetObjectItem(item, "title")->valuestring);
    }
    cJSON_Delete(list);
    return 0;
}

static int verb_methods(int argc, char **argv)
{
    arguments a = {0};
    ll_status status = parse_arguments(argc, argv, &a);
    if (ll_failed(&status))
        return fail(&status);
    printf("%-27s order  of v  steps     kept             %s\n", "name", "what it is");
    for (int i = 0; ll_ode_methods[i]; i++) {
        const ll_ode_method *m = ll_ode_methods[i];
        char kept[32];
        snprintf(kept, sizeof kept, "%s%s%s", m->symplectic ? "symplectic " : "",
                 m->a_stable ? "A-stable " : "", m->reversible && !m->symplectic ? "reversible" : "");
        printf("%-27s %5d  %4d  %-8s  %-15s  %s\n", m->name, m->order,
               m->order_velocity ? m->order_velocity : m->order, m->adaptive ? "adaptive" : "fixed", kept,
               m->help);
    }
    puts("of v: the order where forces depend on velocities (drag, damping, a magnetic field).");
    return 0;
}

static int verb_problems(int argc, char **argv)
{
    arguments a = {0};
    ll_status status = parse_arguments(argc, argv, &a);
    if (ll_failed(&status))
        return fail(&status);
    for (int i = 0; ll_ode_problems[i]; i++) {
        const ll_ode_problem *p = ll_ode_problems[i];
        char given[160] = "";
        size_t used = 0;
        for (int k = 0; k < p->params->count && used < sizeof given; k++)
            used += (size_t)snprintf(given + used, sizeof given - used, "%s%s=%g", k ? " " : "",
                                     p->params->rows[k].name, p->params->rows[k].standard);
        printf("%-18s %9g s  %-6s %s (%s)\n", p->name, p->duration, p->stiff ? "stiff" : "", p->help, given);
    }
    return 0;
}

static int verb_schema(int argc, char **argv)
{
    arguments a = {0};
    ll_status status = parse_arguments(argc, argv, &a);
    if (ll_failed(&status))
        return fail(&status);
    cJSON *schema = NULL;
    if (a.positional && strcmp(a.positional, "experiment") == 0)
        schema = ll_experiment_schema();
    else
        status = ll_scenario_schema(a.positional, &schema);
    return ll_failed(&status) ? fail(&status) : print_json(schema);
}

static int verb_help(int argc, char **argv);

static const struct {
    const char *name, *usage, *help;
    int (*run)(int argc, char **argv);
    bool tells; /* its options by itself, for --help */
} verbs[] = {
    {"serve", "[--listen ADDRESS:PORT] [--data DIR] ...", "host sessions: page, API and streams on one port",
     ll_serve, true},
    {"run",
     "SCENARIO [--set path=value]... [--seed N] [--duration S] [--trace FILE.csv] [--log FILE] "
     "[--workload LOG] [--record-inputs FILE] [--text]",
     "run a scenario as fast as it goes and print its metrics", verb_run, false},
    {"sweep",
     "EXPERIMENT [--jobs N] [--out FILE] [--format csv|ndjson|json|parquet|sqlite] [--points] [--store URL] "
     "[--shard I/N|auto] [--report FILE.html] [--traces DIR] [--dry-run]",
     "run an experiment: a row for each run, or each point", ll_verb_sweep, true},
    {"advise",
     "SCENARIO|EXPERIMENT --metric M --max-error X [--cost C] [--vary PATH=A,B,...|FROM:TO:COUNT[:log]]... "
     "[--set path=value]... [--repeats N] [--workload LOG]",
     "find the cheapest setting whose error stays within a limit", ll_verb_advise, true},
    {"worker", "--store URL [--experiment ID] [--drain] [--jobs N] [--lease-s N]",
     "work on the experiments of a store, beside workers on other machines", ll_verb_worker, true},
    {"submit", "EXPERIMENT --engine slurm --store URL [-n N] [--jobs N] [--print]",
     "start workers on a cluster", ll_verb_submit, true},
    {"store", "list|show ID|delete ID... [--store URL] [--force]",
     "look at the experiments of a store, and delete them with their results", ll_verb_store, true},
    {"merge", "EXPERIMENT SHARD.csv... [--out FILE]", "put the rows of shards together", ll_verb_merge, true},
    {"replay", "LOG", "run a log again; exit 1 at the first tick whose hash differs", verb_replay, false},
    {"scenarios", "", "list the scenarios", verb_scenarios, false},
    {"schema", "[KIND|experiment]",
     "print the JSON Schema of scenarios, of all kinds or one, or of experiments", verb_schema, false},
    {"methods", "", "list the integrators", verb_methods, false},
    {"problems", "", "list the problems of motion, with their parameters", verb_problems, false},
    {"work-precision",
     "PROBLEM|SCENARIO [--methods A,B,...] [--set name=value]... [--duration S] [--seeds N] [--out FILE] "
     "[--format csv|ndjson|json|parquet|sqlite] [--report FILE.html]",
     "measure each method's error against its cost; of a scenario by cells, particles, sweeps, substeps or "
     "updates",
     ll_verb_work_precision, true},
    {"healthcheck", "[URL]", "exit 0 if the daemon there answers", ll_healthcheck, false},
    {"help", "", "print this", verb_help, false},
};

static void print_verb(size_t i)
{
    printf("  laglab %s %s\n      %s\n", verbs[i].name, verbs[i].usage, verbs[i].help);
}

static bool asks_for_help(int argc, char **argv)
{
    for (int i = 0; i < argc; i++)
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
            return true;
    return false;
}

static int verb_help(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    puts("laglab: a laboratory for game physics under lag\n");
    for (size_t i = 0; i < sizeof verbs / sizeof verbs[0]; i++)
        print_verb(i);
    return 0;
}

int main(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0)
        return verb_help(0, NULL);
    if (strcmp(name, "--version") == 0)
        return printf("laglab %s\n", ll_version) < 0;
    for (size_t i = 0; i < sizeof verbs / sizeof verbs[0]; i++) {
        if (strcmp(name, verbs[i].name) != 0)
            continue;
        if (verbs[i].tells || !asks_for_help(argc - 2, argv + 2))
            return verbs[i].run(argc - 2, argv + 2);
        print_verb(i);
        return 0;
    }
    fprintf(stderr, "laglab: %s%s; `laglab help` lists the verbs\n", argc > 1 ? "unknown verb " : "no verb",
            name);
    return 2;
}
