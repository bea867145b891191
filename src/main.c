/* The table of verbs. Results go to stdout, errors to stderr; exit 2 for bad usage or input, 1 for a failed
 * run. */
#include <stdio.h>
#include <string.h>

#include "base/version.h"
#include "cli/verbs.h"

static int verb_help(int argc, char **argv);

static const struct {
    const char *name, *usage, *help;
    int (*run)(int argc, char **argv);
} verbs[] = {
    {"serve", "[--listen ADDRESS:PORT] [--data DIR] ...", "host sessions: page, API and streams on one port",
     ll_verb_serve},
    {"run",
     "SCENARIO [--set path=value]... [--seed N] [--duration S] [--trace FILE] [--trace-of RECORD=FILE]... "
     "[--log FILE] "
     "[--workload LOG] [--record-inputs FILE] [--link-trace PATH=FILE]... [--text]",
     "run a scenario as fast as it goes and print its metrics", ll_verb_run},
    {"sweep",
     "EXPERIMENT [--jobs N] [--out FILE] [--format csv|ndjson|json|sqlite] [--points] "
     "[--shard I/N|auto] [--report FILE.html] [--traces DIR] [--dry-run]",
     "run an experiment: a row for each run, or each point", ll_verb_sweep},
    {"advise",
     "SCENARIO|EXPERIMENT --metric M --max-error X [--cost C] [--vary PATH=A,B,...|FROM:TO:COUNT[:log]]... "
     "[--set path=value]... [--repeats N] [--workload LOG]",
     "find the cheapest setting whose error stays within a limit", ll_verb_advise},
    {"merge",
     "EXPERIMENT SHARD.csv... [--out FILE] [--format NAME] [--points] [--compare POINT] [--sensitivity] "
     "[--report FILE.html]",
     "put the rows of shards together; gives what sweep gives", ll_verb_merge},
    {"reproduce", "EXPERIMENT RESULTS [--rows N]",
     "make rows of a sweep's results again; exit 1 where one differs", ll_verb_reproduce},
    {"link-trace", "FILE", "print a measured link's trace, Mahimahi or CSV, as a profile of a scenario",
     ll_verb_link_trace},
    {"replay", "LOG", "run a log again; exit 1 at the first tick whose hash differs", ll_verb_replay},
    {"scenarios", "", "list the scenarios", ll_verb_scenarios},
    {"schema", "[KIND|experiment|all|stream|metrics|traces|results]",
     "print the JSON Schema of scenarios, of all kinds or one, of experiments, or of both; or the tables of "
     "the stream, of metrics, or of columns",
     ll_verb_schema},
    {"methods", "", "list the integrators", ll_verb_methods},
    {"problems", "", "list the problems of motion, with their parameters", ll_verb_problems},
    {"work-precision",
     "PROBLEM|SCENARIO [--methods A,B,...] [--set name=value]... [--duration S] [--seeds N] [--out FILE] "
     "[--format csv|ndjson|json|sqlite] [--report FILE.html]",
     "measure each method's error against its cost; of a scenario by cells, particles, sweeps, substeps or "
     "updates",
     ll_verb_work_precision},
    {"tradeoff",
     "[FAMILY...] [--methods A,B,...] [--seeds N] [--check-seeds N] [--duration S] [--out FILE] [--winners "
     "FILE] "
     "[--format csv|ndjson|json|sqlite] [--report FILE.html]",
     "speed against error of families of methods: fronts, and the cheapest at three levels of error, "
     "measured "
     "again",
     ll_verb_tradeoff},
    {"healthcheck", "[URL]", "exit 0 if the daemon there answers", ll_verb_healthcheck},
    {"help", "", "print this", verb_help},
};

static void print_verb(size_t i)
{
    printf("  laglab %s %s\n      %s\n", verbs[i].name, verbs[i].usage, verbs[i].help);
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
    for (size_t i = 0; i < sizeof verbs / sizeof verbs[0]; i++)
        if (strcmp(name, verbs[i].name) == 0)
            return verbs[i].run(argc - 2, argv + 2);
    fprintf(stderr, "laglab: %s%s; `laglab help` lists the verbs\n", argc > 1 ? "unknown verb " : "no verb",
            name);
    return 2;
}
