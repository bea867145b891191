/* `laglab advise`: reads or makes an experiment and runs the search for advice. */
#include <cjson/cJSON.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/arguments.h"
#include "cli/input.h"
#include "cli/verbs.h"
#include "experiment/advise/advise.h"

/* Default axes and cost metric of each kind. For a path without values the parameter's own row gives them:
 * all choices, or off and on. Paths that the scenario does not have are left out. */
static const struct kind_defaults {
    const char *kind, *cost, *axes;
    int repeats;
} standards[] = {
    {"netgame", "players.0.bandwidth.down_bytes_per_s",
     "[{\"path\":\"server.update_hz\",\"values\":[5,10,15,20,30,45,60]},{\"path\":\"players.0.prediction\"},"
     "{\"path\":\"players.0.reconciliation\"},{\"path\":\"players.0.interpolation\"}]",
     4},
    {"motion", "methods.0.evaluations",
     "[{\"path\":\"methods.0.method\",\"values\":[\"explicit_euler\",\"semi_implicit_euler\",\"velocity_"
     "verlet\",\"rk4\"]},"
     "{\"path\":\"methods.0.dt_s\",\"from\":0.0002,\"to\":0.2,\"count\":24,\"scale\":\"log\"}]",
     1},
    {"rigid", "passes_per_s",
     "[{\"path\":\"solver.method\"},{\"path\":\"hz\",\"values\":[30,60,120]},"
     "{\"zip\":[{\"path\":\"solver.substeps\",\"values\":[1,2,4,8,16,32]},"
     "{\"path\":\"solver.iterations\",\"values\":[1,2,4,8,16,32]}]}]",
     1},
    {"fluid", "cell_visits",
     "[{\"path\":\"solver.method\"},{\"path\":\"solver.advection\"},{\"path\":\"solver.pressure\"},"
     "{\"path\":\"params.n\",\"values\":[16,24,32,48]},{\"path\":\"params.size\",\"values\":[10,14,20,28]},"
     "{\"path\":\"solver.cfl\",\"values\":[0.25,0.5,1]}]",
     1},
};

typedef struct advise {
    const char *metric, *max_error, *cost, *repeats, *scenarios, *most_runs, *workload;
    ll_option_list vary, set;
} advise;

/* As JSON if valid, else as a string. */
static cJSON *value_of(const char *text)
{
    cJSON *json = cJSON_ParseWithOpts(text, NULL, 1);
    return json ? json : cJSON_CreateString(text);
}

static ll_status split(const char *option, const char *text, char path[LL_EXPERIMENT_PATH_MAX + 1],
                       const char **value)
{
    const char *equals = strchr(text, '=');
    *value = "";
    if (!equals || equals == text || equals - text > LL_EXPERIMENT_PATH_MAX)
        return ll_error(LL_BAD_INPUT, "%s: must be path=value; got %.100s", option, text);
    snprintf(path, LL_EXPERIMENT_PATH_MAX + 1, "%.*s", (int)(equals - text), text);
    *value = equals + 1;
    return ll_ok();
}

/* 1:100:5:log */
static bool add_range(cJSON *axis, const char *value)
{
    double from, to;
    long count;
    char scale[8] = "linear";
    int used = 0, fields = sscanf(value, "%lf:%lf:%ld%n:%7[a-z]%n", &from, &to, &count, &used, scale, &used);
    if (fields < 3 || value[used] != '\0')
        return false;
    cJSON_AddItemToObject(axis, "from", ll_param_number(from));
    cJSON_AddItemToObject(axis, "to", ll_param_number(to));
    cJSON_AddNumberToObject(axis, "count", (double)count);
    cJSON_AddStringToObject(axis, "scale", scale);
    return true;
}

static void add_list(cJSON *axis, const char *value)
{
    cJSON *values = cJSON_AddArrayToObject(axis, "values");
    while (*value) {
        char one[128];
        size_t length = strcspn(value, ",");
        snprintf(one, sizeof one, "%.*s", (int)length, value);
        cJSON_AddItemToArray(values, value_of(one));
        value += length + (value[length] == ',');
    }
}

static ll_status add_axes(const advise *a, cJSON *experiment)
{
    cJSON *axes = cJSON_AddArrayToObject(experiment, "axes");
    for (int i = 0; i < a->vary.count; i++) {
        char path[LL_EXPERIMENT_PATH_MAX + 1];
        const char *value;
        LL_TRY(split("--vary", a->vary.items[i], path, &value));
        cJSON *axis = cJSON_CreateObject();
        cJSON_AddStringToObject(axis, "path", path);
        if (!add_range(axis, value))
            add_list(axis, value);
        cJSON_AddItemToArray(axes, axis);
    }
    return ll_ok();
}

static ll_status add_set(const advise *a, cJSON *experiment)
{
    cJSON *set = cJSON_AddObjectToObject(experiment, "set");
    for (int i = 0; i < a->set.count; i++) {
        char path[LL_EXPERIMENT_PATH_MAX + 1];
        const char *value;
        LL_TRY(split("--set", a->set.items[i], path, &value));
        cJSON_AddItemToObject(set, path, value_of(value));
    }
    return ll_ok();
}

static ll_status add_workload(const advise *a, cJSON *experiment)
{
    char *text;
    ll_status status = ll_argument_text(a->workload, &text);
    if (!ll_failed(&status))
        cJSON_AddStringToObject(experiment, "workload", text);
    free(text);
    return status;
}

/* Every kind has defaults. */
static const struct kind_defaults *defaults_of(const ll_sim_kind *kind)
{
    const struct kind_defaults *s = standards;
    while (strcmp(s->kind, kind->name) != 0)
        s++;
    return s;
}

/* False: the scenario has no such parameter. */
static bool fill(cJSON *axis, const ll_scenario *scenario)
{
    const char *path = cJSON_GetObjectItem(axis, "path")->valuestring;
    const ll_param *row = ll_param_find(scenario->kind->table, scenario->config, path, NULL);
    if (!row || cJSON_HasObjectItem(axis, "values") || cJSON_HasObjectItem(axis, "from"))
        return row != NULL;
    cJSON *values = cJSON_AddArrayToObject(axis, "values");
    for (int i = 0; row->type == LL_PARAM_CHOICE && row->choices[i]; i++)
        cJSON_AddItemToArray(values, cJSON_CreateString(row->choices[i]));
    for (int i = 0; row->type == LL_PARAM_BOOL && i < 2; i++)
        cJSON_AddItemToArray(values, cJSON_CreateBool(i));
    return true;
}

static void add_standard_axes(const char *text, const ll_scenario *scenario, cJSON *experiment)
{
    cJSON *axes = cJSON_Parse(text);
    for (int i = cJSON_GetArraySize(axes) - 1; i >= 0; i--) {
        cJSON *axis = cJSON_GetArrayItem(axes, i);
        if (!cJSON_HasObjectItem(axis, "zip") && !fill(axis, scenario))
            cJSON_DeleteItemFromArray(axes, i);
    }
    cJSON_AddItemToObject(experiment, "axes", axes);
}

static ll_status describe_experiment(const advise *a, ll_scenario *scenario, cJSON *e)
{
    const struct kind_defaults *kind_defaults = defaults_of(scenario->kind);
    int64_t repeats = kind_defaults->repeats;
    ll_status status = a->repeats ? ll_argument_whole("--repeats", a->repeats, 1, 1000, &repeats) : ll_ok();
    LL_THEN(status, add_set(a, e));
    LL_THEN(status, ll_param_merge(scenario->kind->table, cJSON_GetObjectItem(e, "set"), scenario->config));
    if (!ll_failed(&status) && a->vary.count > 0)
        status = add_axes(a, e);
    else if (!ll_failed(&status))
        add_standard_axes(kind_defaults->axes, scenario, e);
    cJSON_AddNumberToObject(e, "repeats", (double)repeats);
    if (!ll_failed(&status) && a->workload)
        status = add_workload(a, e);
    const char *metrics[] = {a->metric, a->cost ? a->cost : kind_defaults->cost};
    cJSON_AddItemToObject(e, "metrics", cJSON_CreateStringArray(metrics, 2));
    return status;
}

/* Owns `json`, a scenario. */
static ll_status make_experiment(const advise *a, cJSON *json, cJSON **experiment)
{
    ll_scenario scenario = {0};
    *experiment = cJSON_CreateObject();
    cJSON_AddItemToObject(*experiment, "scenario", json);
    if (!a->metric)
        return ll_error(LL_BAD_INPUT, "--metric: required; e.g. players.0.remote_error_m.mean");
    ll_status status = ll_scenario_parse(json, &scenario);
    LL_THEN(status, describe_experiment(a, &scenario, *experiment));
    ll_scenario_free(&scenario);
    return status;
}

static ll_status read_request(const advise *a, ll_advise_request *request)
{
    char *end;
    if (!a->max_error)
        return ll_error(LL_BAD_INPUT, "--max-error: required, a number above 0");
    request->max_error = strtod(a->max_error, &end);
    if (end == a->max_error || *end || !(request->max_error > 0) || !isfinite(request->max_error))
        return ll_error(LL_BAD_INPUT, "--max-error: must be a number above 0; got %.40s", a->max_error);
    return a->most_runs
               ? ll_argument_whole("--runs", a->most_runs, 1, LL_EXPERIMENT_RUNS_MAX, &request->most_runs)
               : ll_ok();
}

static ll_status load(const advise *a, const char *name, ll_experiment **experiment)
{
    cJSON *json = NULL, *made = NULL;
    ll_status status = ll_argument_json(name, a->scenarios, &json);
    if (ll_failed(&status))
        return status;
    if (cJSON_HasObjectItem(json, "kind"))
        status = make_experiment(a, json, &made);
    else if (a->metric || a->cost || a->repeats || a->workload || a->vary.count || a->set.count)
        status = ll_error(LL_BAD_INPUT, "an experiment has its own axes and metrics: give only --max-error");
    else
        made = json;
    LL_THEN(status, ll_experiment_from(made, a->scenarios, experiment));
    cJSON_Delete(made ? made : json);
    return status;
}

int ll_verb_advise(int argc, char **argv)
{
    advise a = {0};
    const ll_option options[] = {
        {"--metric", "M", "Error metric: a path in the metrics of a run.", .value = &a.metric},
        {"--max-error", "X", "Maximum error.", .value = &a.max_error},
        {"--cost", "M", "Cost metric; default: that of the kind of scenario.", .value = &a.cost},
        {"--vary", "PATH=VALUES",
         "Parameter to vary: A,B,C or FROM:TO:COUNT[:log]; default: those of the kind.", .list = &a.vary},
        {"--set", "PATH=VALUE", "A fixed value.", .list = &a.set},
        {"--repeats", "N", "Runs of each setting, with ascending seeds.", .value = &a.repeats},
        {"--runs", "N",
         "Maximum number of runs; default: one of each setting and 40; in netgames with repeats two fifths "
         "of "
         "all and 1024.",
         .value = &a.most_runs},
        {"--workload", "LOG", "Inputs that every run replays, for players whose control is person.",
         .value = &a.workload},
        {"--scenarios", "DIR", "Folder of the scenario library; default: next to the program.",
         .value = &a.scenarios},
        {0}};
    const char *positional[LL_POSITIONAL_MAX];
    int count;
    ll_experiment *experiment = NULL;
    ll_advise_request request = {0};
    cJSON *answer = NULL;
    ll_status status = ll_arguments("advise SCENARIO|EXPERIMENT --max-error X [OPTION]...: find the cheapest "
                                    "setting whose error is at most X",
                                    argc, argv, options, positional, &count);
    if (!ll_failed(&status) && count > 1)
        status = ll_error(LL_BAD_INPUT, "unexpected argument %.100s", positional[1]);
    LL_THEN(status, read_request(&a, &request));
    LL_THEN(status, load(&a, count ? positional[0] : NULL, &experiment));
    request.experiment = experiment;
    LL_THEN(status, ll_advise(&request, &answer));
    if (!ll_failed(&status)) {
        char *text = cJSON_Print(answer);
        puts(text ? text : "null");
        cJSON_free(text);
    }
    cJSON_Delete(answer);
    ll_experiment_free(experiment);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}
