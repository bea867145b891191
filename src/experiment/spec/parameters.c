/* Members with a table, and the JSON Schema of a whole specification. */
#include <cjson/cJSON.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/assert.h"
#include "experiment/spec/internal.h"
#include "session/scenario.h"

static const char *const intervals[] = {"auto", "t", NULL};
static const char *const samplings[] = {"none", "random", "sobol", "lhs", "saltelli", NULL};

#define SAMPLE(member) offsetof(ll_experiment_head, sample.member) - offsetof(ll_experiment_head, sample)
#define STOP(member) offsetof(ll_experiment_head, stop.member) - offsetof(ll_experiment_head, stop)

static const ll_param sample_rows[] = {
    {.name = "method",
     .type = LL_PARAM_CHOICE,
     .offset = SAMPLE(method),
     .choices = samplings,
     .help = "Sampling method of the axes, instead of their product: random, sobol (a Sobol' sequence, which "
             "fills evenly), lhs (Latin hypercube) or saltelli (for sensitivity indices)."},
    {.name = "count",
     .type = LL_PARAM_INT,
     .offset = SAMPLE(count),
     .min = 1,
     .max = LL_EXPERIMENT_RUNS_MAX,
     .default_value = 64,
     .help = "Number of points; for saltelli number of base samples, each with (dimensions + 2) points. "
             "Powers of two are best for sobol and saltelli."},
    {.name = "seed",
     .type = LL_PARAM_INT,
     .offset = SAMPLE(seed),
     .max = 9007199254740991,
     .default_value = 1,
     .help = "Random seed of the samples; of a Sobol' sequence's shift."},
};

static const ll_param_table sample_table = {.name = "sample",
                                            .help = "Sampling of points.",
                                            LL_PARAM_ROWS(sample_rows, ((ll_experiment_head *)0)->sample)};

static const ll_param stop_rows[] = {
    {.name = "metric",
     .type = LL_PARAM_TEXT,
     .offset = STOP(metric),
     .max = LL_EXPERIMENT_PATH_MAX,
     .help = "Metric that ends a run early; empty: none."},
    {.name = "above",
     .type = LL_PARAM_REAL,
     .offset = STOP(above),
     .min = -1e15,
     .max = 1e15,
     .help = "A run ends when the metric exceeds this."},
    {.name = "every_s",
     .type = LL_PARAM_REAL,
     .offset = STOP(every_s),
     .min = 0.01,
     .max = 3600,
     .default_value = 1,
     .unit = "s",
     .help = "Interval of these checks, in virtual time."},
};

static const ll_param_table stop_table = {
    .name = "stop", .help = "Early end of a run.", LL_PARAM_ROWS(stop_rows, ((ll_experiment_head *)0)->stop)};

#define UNTIL(member) offsetof(ll_experiment_head, until.member) - offsetof(ll_experiment_head, until)

static const ll_param until_rows[] = {
    {.name = "metric",
     .type = LL_PARAM_TEXT,
     .offset = UNTIL(metric),
     .max = LL_EXPERIMENT_PATH_MAX,
     .help = "One of the metrics; empty: the error metric."},
    {.name = "half_width",
     .type = LL_PARAM_REAL,
     .offset = UNTIL(half_width),
     .max = 1e15,
     .help = "Half width of the interval at which a point has enough runs; 0: no such rule."},
    {.name = "relative",
     .type = LL_PARAM_REAL,
     .offset = UNTIL(relative),
     .max = 1,
     .help = "The same relative to the mean's magnitude; 0: no such rule."},
    {.name = "least",
     .type = LL_PARAM_INT,
     .offset = UNTIL(least),
     .min = LL_INTERVAL_MIN,
     .max = 100000,
     .default_value = 10,
     .help = "Runs before the first check; further checks come after each doubling."},
};

static const ll_param_table until_table = {.name = "until",
                                           .help = "When a point has enough runs, below `repeats`.",
                                           LL_PARAM_ROWS(until_rows, ((ll_experiment_head *)0)->until)};

#define ROW(member) .name = #member, .offset = offsetof(ll_experiment_head, member)

static const ll_param head_rows[] = {
    {ROW(title), .type = LL_PARAM_TEXT, .max = LL_TITLE_MAX, .help = "Title."},
    {ROW(text), .type = LL_PARAM_TEXT, .max = LL_TEXT_MAX,
     .help = "Description: the question of the experiment."},
    {ROW(scenario_id), .type = LL_PARAM_TEXT, .max = LL_EXPERIMENT_PATH_MAX,
     .help = "File that the scenario was read from."},
    {ROW(error), .type = LL_PARAM_TEXT, .max = LL_EXPERIMENT_PATH_MAX,
     .help = "Error metric; empty: the first."},
    {ROW(cost), .type = LL_PARAM_TEXT, .max = LL_EXPERIMENT_PATH_MAX,
     .help = "Cost metric; empty: the second, if there is one."},
    {ROW(repeats), .type = LL_PARAM_INT, .min = 1, .max = 100000, .default_value = 1,
     .help = "Runs of each point, with ascending seeds from the scenario's."},
    {ROW(interval), .type = LL_PARAM_CHOICE, .choices = intervals,
     .help = "Method of the means' intervals: auto (chosen by the values) or t (Student's for all but "
             "shares, for values known to be nearly normal)."},
    {ROW(traces), .type = LL_PARAM_BOOL,
     .help = "Write each run's trace next to the rows; at most 1000 runs."},
    {ROW(sample), .type = LL_PARAM_OBJECT, .child = &sample_table, .help = "Sampling of points."},
    {ROW(stop), .type = LL_PARAM_OBJECT, .child = &stop_table, .help = "Early end of a run."},
    {ROW(until), .type = LL_PARAM_OBJECT, .child = &until_table,
     .help = "When a point has enough runs, below `repeats`."},
    {ROW(windows), .type = LL_PARAM_ARRAY, .max = LL_WINDOWS_MAX, .child = &ll_window_table,
     .count_offset = offsetof(ll_experiment_head, window_count),
     .help = "Parts of a run; a metric `PATH@NAME` is taken over the window NAME."},
};

static const ll_param_table head_table = {
    .name = "experiment",
    .help = "A scenario, its varied parameters, and the metrics that are kept.",
    LL_PARAM_ROWS(head_rows, ll_experiment_head)};

/* Keys with values of several types, which are not in the table. */
static const char *const other_keys[] = {"scenario", "set", "axes", "metrics", "workload", "front"};

/* ---- schema ---- */

static void add_other(cJSON *properties, const char *name, const char *schema)
{
    cJSON_AddItemToObject(properties, name, cJSON_Parse(schema));
}

static void add_workload(cJSON *properties)
{
    add_other(
        properties, "workload",
        "{\"description\":\"Inputs that every run replays, at their times, for the players whose control is "
        "person: the lines of a session's log as one text, or an object; in a file of an experiment also the "
        "path of a log next to it.\",\"type\":[\"string\",\"object\"],\"properties\":{"
        "\"tick_hz\":{\"description\":\"Rate of the inputs' ticks.\",\"type\":\"number\","
        "\"minimum\":1,\"maximum\":1000,\"default\":60,\"x-unit\":\"Hz\"},"
        "\"inputs\":{\"description\":\"In the order of ticks; an input counts until the next of its "
        "player.\",\"type\":\"array\",\"minItems\":1,\"maxItems\":1000000,\"items\":{\"type\":\"object\","
        "\"properties\":{\"op\":{\"const\":\"input\"},"
        "\"tick\":{\"type\":\"integer\",\"minimum\":0,\"maximum\":1000000000},"
        "\"player\":{\"type\":\"integer\",\"minimum\":0,\"maximum\":15},"
        "\"axes\":{\"type\":\"array\",\"minItems\":2,\"maxItems\":2,\"items\":{\"type\":\"number\","
        "\"minimum\":-1,\"maximum\":1}},"
        "\"buttons\":{\"type\":\"integer\",\"minimum\":0,\"maximum\":4294967295,\"default\":0}},"
        "\"required\":[\"tick\",\"player\",\"axes\"],\"additionalProperties\":false}}},"
        "\"required\":[\"inputs\"],\"additionalProperties\":false}");
}

cJSON *ll_experiment_schema(void)
{
    cJSON *schema = ll_param_schema(&head_table), *axis = ll_axis_schema();
    cJSON *properties = cJSON_GetObjectItem(schema, "properties"),
          *defs = cJSON_GetObjectItem(schema, "$defs");
    add_other(
        properties, "scenario",
        "{\"description\":\"An id of the library, or a whole scenario.\",\"type\":[\"string\",\"object\"]}");
    add_other(properties, "set",
              "{\"description\":\"Fixed values by path, before the axes.\",\"type\":\"object\"}");
    add_other(
        properties, "axes",
        "{\"description\":\"Varied parameters: the product of all axes, the last one fastest. Axes in a "
        "`zip` vary "
        "together.\",\"type\":\"array\",\"items\":{\"anyOf\":[{\"$ref\":\"#/$defs/"
        "axis\"},{\"type\":\"object\",\"properties\":{\"zip\":{\"type\":\"array\",\"minItems\":1,\"items\":{"
        "\"$ref\":\"#/$defs/axis\"}}},\"required\":[\"zip\"],\"additionalProperties\":false}]}}");
    add_other(properties, "metrics",
              "{\"description\":\"Paths of numbers in the metrics of a run, and cost.ns_per_sim_s, which is "
              "measured: processor time in nanoseconds per second of simulated time, the minimum of several "
              "runs. PATH@NAME: in a "
              "window.\",\"type\":\"array\",\"minItems\":1,\"maxItems\":32,\"items\":{\"type\":\"string\"}}");
    add_other(properties, "front",
              "{\"description\":\"Metrics of the Pareto front that the report marks: points that no other "
              "point beats, by magnitude; default: cost and "
              "error.\",\"type\":\"array\",\"minItems\":2,\"maxItems\":32,\"items\":{\"type\":\"string\"}}");
    add_workload(properties);
    cJSON_AddItemToObject(cJSON_GetObjectItem(axis, "properties"), "values",
                          cJSON_Parse("{\"description\":\"List of values, instead of a "
                                      "range.\",\"type\":\"array\",\"minItems\":1,\"items\":{\"type\":["
                                      "\"number\",\"string\",\"boolean\"]}}"));
    cJSON_DeleteItemFromObject(axis, "$schema");
    cJSON_DeleteItemFromObject(axis, "$defs");
    cJSON_AddItemToObject(defs, "axis", axis);
    cJSON_AddItemToObject(schema, "required", cJSON_Parse("[\"scenario\",\"metrics\"]"));
    return schema;
}

cJSON *ll_schemas(void)
{
    cJSON *schemas = cJSON_CreateObject(), *scenario = NULL, *experiment = ll_experiment_schema();
    ll_status status = ll_scenario_schema(NULL, &scenario);
    LL_ASSERT(!ll_failed(&status)); /* of all kinds */
    cJSON_AddItemToObject(schemas, "$schema", cJSON_DetachItemFromObject(scenario, "$schema"));
    cJSON *defs = cJSON_AddObjectToObject(schemas, "$defs");
    cJSON_AddItemToObject(defs, "scenario", scenario);
    cJSON_AddItemToObject(defs, "experiment", experiment);
    ll_param_schema_part(scenario, defs);
    ll_param_schema_part(experiment, defs);
    return schemas;
}

/* ---- reading ---- */

static ll_status check_keys(const cJSON *json, ll_experiment_head *head)
{
    char known[260] = "";
    const cJSON *item;
    for (size_t i = 0; i < sizeof other_keys / sizeof other_keys[0]; i++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s, ", other_keys[i]);
    for (int i = 0; i < head_table.count; i++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", head_rows[i].name,
                 i + 1 < head_table.count ? ", " : "");
    cJSON_ArrayForEach(item, json)
    {
        bool found = ll_param_find(&head_table, head, item->string, NULL) != NULL;
        for (size_t i = 0; i < sizeof other_keys / sizeof other_keys[0]; i++)
            found |= strcmp(item->string, other_keys[i]) == 0;
        if (!found)
            return ll_field_error(LL_BAD_INPUT, item->string, "%.40s is unknown; an experiment has %s",
                                  item->string, known);
    }
    return ll_ok();
}

ll_status ll_experiment_read_head(const cJSON *json, ll_experiment_head *head)
{
    ll_param_defaults(&head_table, head);
    LL_TRY(check_keys(json, head));
    cJSON *rest = cJSON_Duplicate(json, true);
    for (size_t i = 0; i < sizeof other_keys / sizeof other_keys[0]; i++)
        cJSON_DeleteItemFromObjectCaseSensitive(rest, other_keys[i]);
    ll_status status = ll_param_parse(&head_table, rest, head);
    cJSON_Delete(rest);
    return status;
}
