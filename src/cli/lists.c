/* Verbs that list: `scenarios`, `methods`, `problems` and `schema`. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

#include "cli/arguments.h"
#include "cli/input.h"
#include "cli/output.h"
#include "cli/verbs.h"
#include "experiment/format/table.h"
#include "library/library.h"
#include "ode/core/method.h"
#include "ode/core/problem.h"
#include "session/records.h"
#include "session/scenario.h"

int ll_verb_scenarios(int argc, char **argv)
{
    const char *scenarios = NULL;
    const ll_option options[] = {{.name = "--scenarios",
                                  .takes = "DIR",
                                  .help = "Folder of the scenarios; default: next to the program.",
                                  .value = &scenarios},
                                 {0}};
    char path[PATH_MAX];
    cJSON *list = NULL;
    ll_status status =
        ll_arguments_one("scenarios [OPTION]...: list the scenarios", argc, argv, options, NULL);
    LL_THEN(status, ll_scenario_list(ll_scenario_folder(scenarios, path), &list));
    if (ll_failed(&status))
        return ll_argument_fail(&status);
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

int ll_verb_methods(int argc, char **argv)
{
    const ll_option none[] = {{0}};
    ll_status status = ll_arguments_one("methods: list the integrators", argc, argv, none, NULL);
    if (ll_failed(&status))
        return ll_argument_fail(&status);
    printf("%-27s order  of v  steps     kept             %s\n", "name", "description");
    for (int i = 0; ll_ode_methods[i]; i++) {
        const ll_ode_method *m = ll_ode_methods[i];
        char kept[32];
        snprintf(kept, sizeof kept, "%s%s%s", m->symplectic ? "symplectic " : "",
                 m->a_stable ? "A-stable " : "", m->reversible && !m->symplectic ? "reversible" : "");
        printf("%-27s %5d  %4d  %-8s  %-15s  %s\n", m->name, m->order,
               m->order_velocity ? m->order_velocity : m->order, m->adaptive ? "adaptive" : "fixed", kept,
               m->help);
    }
    puts("of v: the order when forces depend on velocities (drag, damping, a magnetic field).");
    return 0;
}

int ll_verb_problems(int argc, char **argv)
{
    const ll_option none[] = {{0}};
    ll_status status = ll_arguments_one("problems: list the problems of motion, with their parameters", argc,
                                        argv, none, NULL);
    if (ll_failed(&status))
        return ll_argument_fail(&status);
    for (int i = 0; ll_ode_problems[i]; i++) {
        const ll_ode_problem *p = ll_ode_problems[i];
        char given[160] = "";
        size_t used = 0;
        for (int k = 0; k < p->params->count && used < sizeof given; k++)
            used += (size_t)snprintf(given + used, sizeof given - used, "%s%s=%g", k ? " " : "",
                                     p->params->rows[k].name, p->params->rows[k].default_value);
        printf("%-18s %9g s  %-6s %s (%s)\n", p->name, p->duration, p->stiff ? "stiff" : "", p->help, given);
    }
    return 0;
}

int ll_verb_schema(int argc, char **argv)
{
    const ll_option none[] = {{0}};
    const char *kind;
    ll_status status = ll_arguments_one(
        "schema [KIND|experiment|all|stream|metrics|traces|results]: print the JSON "
        "Schema of scenarios (all kinds or one), of experiments or of both, or the tables of "
        "the stream, of the metrics, or of the columns of traces or results",
        argc, argv, none, &kind);
    if (ll_failed(&status))
        return ll_argument_fail(&status);
    cJSON *schema = NULL;
    if (kind && strcmp(kind, "experiment") == 0)
        schema = ll_experiment_schema();
    else if (kind && strcmp(kind, "all") == 0)
        schema = ll_schemas();
    else if (kind && strcmp(kind, "stream") == 0)
        schema = ll_stream_schema();
    else if (kind && strcmp(kind, "metrics") == 0)
        schema = ll_metrics_of_kinds();
    else if (kind && strcmp(kind, "traces") == 0)
        schema = ll_traces_of_kinds();
    else if (kind && strcmp(kind, "results") == 0)
        schema = ll_metrics_schema(ll_result_columns);
    else
        status = ll_scenario_schema(kind, &schema);
    return ll_failed(&status) ? ll_argument_fail(&status) : ll_print_json(schema);
}
