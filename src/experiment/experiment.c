#include "experiment/experiment.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/rng.h"
#include "base/utf8.h"
#include "experiment/sobol.h"
#include "session/session.h"

/* ---- the table ---- */

static const char *const samplings[] = {"none", "random", "sobol", NULL};

#define SAMPLE(member) offsetof(ll_experiment_head, sample.member) - offsetof(ll_experiment_head, sample)
#define STOP(member) offsetof(ll_experiment_head, stop.member) - offsetof(ll_experiment_head, stop)

static const ll_param sample_rows[] = {
    {.name = "method",
     .type = LL_PARAM_CHOICE,
     .offset = SAMPLE(method),
     .choices = samplings,
     .help =
         "Points drawn from the axes in place of their product: at random, or a Sobol' sequence, which fills "
         "evenly."},
    {.name = "count",
     .type = LL_PARAM_INT,
     .offset = SAMPLE(count),
     .min = 1,
     .max = LL_EXPERIMENT_RUNS_MAX,
     .standard = 64,
     .help = "How many points; powers of two suit a Sobol' sequence."},
    {.name = "seed",
     .type = LL_PARAM_INT,
     .offset = SAMPLE(seed),
     .max = 9007199254740991,
     .standard = 1,
     .help = "Of the draws; of a Sobol' sequence's shift."},
};

static const ll_param_table sample_table = {.name = "sample",
                                            .help = "How points are drawn.",
                                            .rows = sample_rows,
                                            .count = sizeof sample_rows / sizeof sample_rows[0],
                                            .size = sizeof((ll_experiment_head *)0)->sample};

static const ll_param stop_rows[] = {
    {.name = "metric",
     .type = LL_PARAM_TEXT,
     .offset = STOP(metric),
     .max = LL_EXPERIMENT_PATH_MAX,
     .help = "A metric that ends a run early; empty: none does."},
    {.name = "above",
     .type = LL_PARAM_REAL,
     .offset = STOP(above),
     .min = -1e15,
     .max = 1e15,
     .help = "A run ends when the metric is above."},
    {.name = "every_s",
     .type = LL_PARAM_REAL,
     .offset = STOP(every_s),
     .min = 0.01,
     .max = 3600,
     .standard = 1,
     .unit = "s",
     .help = "How often that is looked at, in virtual time."},
};

static const ll_param_table stop_table = {.name = "stop",
                                          .help = "When a run ends before its duration.",
                                          .rows = stop_rows,
                                          .count = sizeof stop_rows / sizeof stop_rows[0],
                                          .size = sizeof((ll_experiment_head *)0)->stop};

#define ROW(member) .name = #member, .offset = offsetof(ll_experiment_head, member)

static const ll_param head_rows[] = {
    {ROW(title), .type = LL_PARAM_TEXT, .max = LL_TITLE_MAX, .help = "A short name for people."},
    {ROW(text), .type = LL_PARAM_TEXT, .max = LL_TEXT_MAX, .help = "What it asks."},
    {ROW(scenario_id), .type = LL_PARAM_TEXT, .max = LL_EXPERIMENT_PATH_MAX,
     .help = "Where a scenario that is given whole was read from."},
    {ROW(error), .type = LL_PARAM_TEXT, .max = LL_EXPERIMENT_PATH_MAX,
     .help = "The metric that is to be small; empty: the first."},
    {ROW(cost), .type = LL_PARAM_TEXT, .max = LL_EXPERIMENT_PATH_MAX,
     .help = "The metric that this is paid with; empty: the second, if there is one."},
    {ROW(repeats), .type = LL_PARAM_INT, .min = 1, .max = 100000, .standard = 1,
     .help = "Runs of each point, with seeds that count up from the scenario's."},
    {ROW(traces), .type = LL_PARAM_BOOL,
     .help = "Write each run's trace beside the rows: for at most 1000 runs."},
    {ROW(sample), .type = LL_PARAM_OBJECT, .child = &sample_table, .help = "How points are drawn."},
    {ROW(stop), .type = LL_PARAM_OBJECT, .child = &stop_table, .help = "When a run ends early."},
};

static const ll_param_table head_table = {.name = "experiment",
                                          .help = "A scenario, what is varied, and which metrics are kept.",
                                          .rows = head_rows,
                                          .count = sizeof head_rows / sizeof head_rows[0],
                                          .size = sizeof(ll_experiment_head)};

/* Keys that are not values of one type, so not in the table. */
static const char *const other_keys[] = {"scenario", "set", "axes", "metrics"};

/* ---- schema ---- */

static void add_other(cJSON *properties, const char *name, const char *schema)
{
    cJSON_AddItemToObject(properties, name, cJSON_Parse(schema));
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
        "{\"description\":\"What is varied: the product of all, the last one fastest. Axes in a `zip` go "
        "together.\",\"type\":\"array\",\"items\":{\"anyOf\":[{\"$ref\":\"#/$defs/"
        "axis\"},{\"type\":\"object\","
        "\"properties\":{\"zip\":{\"type\":\"array\",\"minItems\":1,\"items\":{\"$ref\":\"#/$defs/axis\"}}},"
        "\"required\":[\"zip\"],\"additionalProperties\":false}]}}");
    add_other(
        properties, "metrics",
        "{\"description\":\"Paths of numbers in the metrics of a run.\",\"type\":\"array\",\"minItems\":1,"
        "\"maxItems\":32,\"items\":{\"type\":\"string\"}}");
    cJSON_AddItemToObject(
        cJSON_GetObjectItem(axis, "properties"), "values",
        cJSON_Parse("{\"description\":\"A list in place of a range.\",\"type\":\"array\",\"minItems\":1,"
                    "\"items\":{\"type\":[\"number\",\"string\",\"boolean\"]}}"));
    cJSON_DeleteItemFromObject(axis, "$schema");
    cJSON_DeleteItemFromObject(axis, "$defs");
    cJSON_AddItemToObject(defs, "axis", axis);
    cJSON_AddItemToObject(schema, "required", cJSON_Parse("[\"scenario\",\"metrics\"]"));
    return schema;
}

/* ---- points ---- */

static double coordinate(const ll_experiment *e, int dimension, int64_t point)
{
    uint64_t seed = (uint64_t)e->head.sample.seed;
    if (e->head.sample.method == LL_SAMPLE_RANDOM)
        return ll_rng_unit(seed, (uint64_t)dimension, (uint64_t)point);
    return ll_sobol(dimension, (uint32_t)point, (uint32_t)(ll_rng_u64(seed, (uint64_t)dimension, 0) >> 32));
}

cJSON *ll_experiment_point(const ll_experiment *e, int64_t point)
{
    cJSON *values = cJSON_CreateObject(), *value[LL_EXPERIMENT_AXES_MAX];
    int64_t left = point;
    for (int a = e->axis_count - 1; a >= 0; a--) { /* the last is the fastest */
        const ll_axis *axis = &e->axes[a];
        if (e->head.sample.method != LL_SAMPLE_NONE) {
            value[a] = ll_axis_sample(axis, coordinate(e, e->dimension[a], point));
        } else {
            value[a] = ll_axis_at(axis, left % axis->count);
            if (a == 0 || e->dimension[a - 1] != e->dimension[a])
                left /= axis->count;
        }
    }
    for (int a = 0; a < e->axis_count; a++)
        cJSON_AddItemToObject(values, e->axes[a].path, value[a]);
    return values;
}

int64_t ll_experiment_seed(const ll_experiment *e, int64_t run)
{
    return ((const ll_scenario_head *)e->base.config)->seed + run % e->head.repeats;
}

char *ll_experiment_text(const ll_experiment *e)
{
    return cJSON_PrintUnformatted(e->json);
}

uint64_t ll_experiment_key(const ll_experiment *e)
{
    char *text = ll_experiment_text(e);
    uint64_t key = ll_hash(0, text, text ? strlen(text) : 0);
    free(text);
    return key;
}

/* ---- reading ---- */

static ll_status check_keys(const cJSON *json)
{
    char known[160] = "";
    const cJSON *item;
    for (size_t i = 0; i < sizeof other_keys / sizeof other_keys[0]; i++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s, ", other_keys[i]);
    for (int i = 0; i < head_table.count; i++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", head_rows[i].name,
                 i + 1 < head_table.count ? ", " : "");
    cJSON_ArrayForEach(item, json)
    {
        bool found = ll_param_find(&head_table, NULL, item->string, NULL) != NULL;
        for (size_t i = 0; i < sizeof other_keys / sizeof other_keys[0]; i++)
            found |= strcmp(item->string, other_keys[i]) == 0;
        if (!found)
            return ll_field_error(LL_BAD_INPUT, item->string, "%.40s is unknown; an experiment has %s",
                                  item->string, known);
    }
    return ll_ok();
}

static ll_status read_head(ll_experiment *e, const cJSON *json)
{
    ll_status status = check_keys(json);
    if (ll_failed(&status))
        return status;
    cJSON *rest = cJSON_Duplicate(json, true);
    for (size_t i = 0; i < sizeof other_keys / sizeof other_keys[0]; i++)
        cJSON_DeleteItemFromObjectCaseSensitive(rest, other_keys[i]);
    ll_param_defaults(&head_table, &e->head);
    status = ll_param_parse(&head_table, rest, &e->head);
    cJSON_Delete(rest);
    return status;
}

/* Puts the scenario in place of its id. */
static ll_status read_scenario(ll_experiment *e, const char *scenarios)
{
    cJSON *scenario = cJSON_GetObjectItemCaseSensitive(e->json, "scenario"), *loaded = NULL;
    if (!cJSON_IsString(scenario) && !cJSON_IsObject(scenario))
        return ll_field_error(LL_BAD_INPUT, "scenario",
                              "scenario must be an id of the library, or a scenario");
    ll_status status = ll_ok();
    if (cJSON_IsString(scenario)) {
        status = ll_scenario_load(scenarios, scenario->valuestring, &loaded);
        if (status.code == LL_NOT_FOUND)
            status.code = LL_BAD_INPUT;
        if (ll_failed(&status))
            return status;
        snprintf(e->head.scenario_id, sizeof e->head.scenario_id, "%s", scenario->valuestring);
        cJSON_DeleteItemFromObjectCaseSensitive(e->json, "scenario_id");
        cJSON_AddStringToObject(e->json, "scenario_id", e->head.scenario_id);
        cJSON_ReplaceItemInObjectCaseSensitive(e->json, "scenario", loaded);
        scenario = loaded;
    }
    status = ll_scenario_parse(scenario, &e->base);
    if (ll_failed(&status))
        return ll_field_error(LL_BAD_INPUT, "scenario", "scenario: %s", status.text);
    return status;
}

/* Merges values into a configuration and makes dependent ones agree. */
static ll_status apply(const ll_sim_kind *kind, const cJSON *values, void *config)
{
    void *before = malloc(kind->table->size);
    if (!before)
        return ll_error(LL_NO_MEMORY, "no memory for a scenario");
    memcpy(before, config, kind->table->size);
    ll_status status = ll_param_merge(kind->table, values, config);
    if (!ll_failed(&status))
        kind->settle(config, before);
    free(before);
    return status;
}

static ll_status read_set(ll_experiment *e)
{
    e->set = cJSON_GetObjectItemCaseSensitive(e->json, "set");
    if (!e->set)
        return ll_ok();
    if (!cJSON_IsObject(e->set))
        return ll_field_error(LL_BAD_INPUT, "set", "set must be an object of values by path");
    if (cJSON_HasObjectItem(e->set, "kind"))
        return ll_field_error(LL_BAD_INPUT, "set.kind", "set cannot change kind: it is what the scenario is");
    ll_status status = apply(e->base.kind, e->set, e->base.config);
    if (!ll_failed(&status))
        return status;
    char field[80];
    snprintf(field, sizeof field, "set.%s", status.field);
    return ll_field_error(LL_BAD_INPUT, field, "set: %s", status.text);
}

static ll_status add_axis(ll_experiment *e, const cJSON *json, const char *field)
{
    if (e->axis_count == LL_EXPERIMENT_AXES_MAX)
        return ll_field_error(LL_BAD_INPUT, "axes", "axes must be at most %d", LL_EXPERIMENT_AXES_MAX);
    ll_axis *axis = &e->axes[e->axis_count];
    bool sampled = e->head.sample.method != LL_SAMPLE_NONE;
    ll_status status = ll_axis_parse(json, field, sampled, e->base.kind->table, e->base.config, axis);
    if (ll_failed(&status))
        return status;
    e->dimension[e->axis_count] = e->dimension_count;
    e->axis_count++;
    for (int i = 0; i < e->axis_count - 1; i++)
        if (strcmp(e->axes[i].path, axis->path) == 0)
            return ll_field_error(LL_BAD_INPUT, field, "%s.path: %s is on an axis already", field,
                                  axis->path);
    return status;
}

static ll_status add_zip(ll_experiment *e, const cJSON *zip, const char *field)
{
    int first = e->axis_count, i = 0;
    const cJSON *item;
    if (!cJSON_IsArray(zip) || cJSON_GetArraySize(zip) == 0)
        return ll_field_error(LL_BAD_INPUT, field, "%s.zip must be an array of axes", field);
    cJSON_ArrayForEach(item, zip)
    {
        char inner[64];
        snprintf(inner, sizeof inner, "%s.zip.%d", field, i++);
        ll_status status = add_axis(e, item, inner);
        if (ll_failed(&status))
            return status;
        const ll_axis *a = &e->axes[first], *b = &e->axes[e->axis_count - 1];
        if (a->count != b->count)
            return ll_field_error(LL_BAD_INPUT, inner,
                                  "%s has %lld values and %s.zip.0 has %lld; zipped axes have as many each",
                                  inner, (long long)b->count, field, (long long)a->count);
    }
    return ll_ok();
}

static ll_status read_axes(ll_experiment *e)
{
    const cJSON *axes = cJSON_GetObjectItemCaseSensitive(e->json, "axes"), *item;
    int i = 0;
    if (axes && !cJSON_IsArray(axes))
        return ll_field_error(LL_BAD_INPUT, "axes", "axes must be an array");
    cJSON_ArrayForEach(item, axes)
    {
        char field[32];
        const cJSON *zip = cJSON_GetObjectItemCaseSensitive(item, "zip");
        snprintf(field, sizeof field, "axes.%d", i++);
        if (zip && cJSON_GetArraySize(item) > 1)
            return ll_field_error(LL_BAD_INPUT, field, "%s has a zip, so nothing else", field);
        ll_status status = zip ? add_zip(e, zip, field) : add_axis(e, item, field);
        if (ll_failed(&status))
            return status;
        e->dimension_count++;
    }
    return ll_ok();
}

static ll_status count_runs(ll_experiment *e)
{
    double points = 1;
    char product[96] = "";
    for (int a = 0; a < e->axis_count; a++) {
        if (a > 0 && e->dimension[a] == e->dimension[a - 1])
            continue;
        points *= (double)e->axes[a].count;
        size_t used = strlen(product);
        snprintf(product + used, sizeof product - used, "%s%lld", a ? " x " : "",
                 (long long)e->axes[a].count);
    }
    if (e->head.sample.method != LL_SAMPLE_NONE) {
        points = (double)e->head.sample.count;
        snprintf(product, sizeof product, "%.0f", points);
    }
    if (points * (double)e->head.repeats > LL_EXPERIMENT_RUNS_MAX)
        return ll_field_error(
            LL_BAD_INPUT, "axes", "axes give %s points, with %lld repeats %.6g runs; at most %d can be run",
            product, (long long)e->head.repeats, points * (double)e->head.repeats, LL_EXPERIMENT_RUNS_MAX);
    e->points = (int64_t)points;
    e->runs = e->points * e->head.repeats;
    if (e->head.traces && e->runs > LL_EXPERIMENT_TRACES_MAX)
        return ll_field_error(LL_BAD_INPUT, "traces", "traces are kept of at most %d runs; there are %lld",
                              LL_EXPERIMENT_TRACES_MAX, (long long)e->runs);
    return ll_ok();
}

/* ---- metrics ---- */

static const cJSON *metric_at(const cJSON *metrics, const char *path, char *reached, int size,
                              const char **missing)
{
    reached[0] = '\0';
    for (;;) {
        char name[64];
        size_t length = strcspn(path, ".");
        snprintf(name, sizeof name, "%.*s", (int)length, path);
        char *end;
        long index = strtol(name, &end, 10);
        const cJSON *next = cJSON_IsArray(metrics) && end != name && *end == '\0' && index >= 0
                                ? cJSON_GetArrayItem(metrics, (int)index)
                                : cJSON_GetObjectItemCaseSensitive(metrics, name);
        *missing = path;
        if (!next)
            return NULL;
        size_t used = strlen(reached);
        snprintf(reached + used, (size_t)size - used, "%s%s", used ? "." : "", name);
        metrics = next;
        path += length;
        if (*path == '\0')
            return metrics;
        path++;
    }
}

/* What is there where the path ends, in as many names as fit. */
static ll_status no_metric(const cJSON *metrics, const char *field, const char *path)
{
    char reached[160], names[120] = "", found[160];
    const char *missing;
    const cJSON *at = metric_at(metrics, path, reached, sizeof reached, &missing), *item;
    if (!at)
        at = reached[0] ? metric_at(metrics, reached, found, sizeof found, &missing) : metrics;
    if (cJSON_IsArray(at))
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: the scenario has no metric %s; %s has %d elements, from 0", field, path,
                              reached, cJSON_GetArraySize(at));
    cJSON_ArrayForEach(item, at)
    {
        size_t used = strlen(names);
        if (used + strlen(item->string) + sizeof ", " + sizeof ", ..." > sizeof names) {
            strcat(names, ", ...");
            break;
        }
        snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", item->string);
    }
    if (names[0] == '\0')
        return ll_field_error(LL_BAD_INPUT, field, "%s: %s is no number", field, path);
    return ll_field_error(LL_BAD_INPUT, field, "%s: the scenario has no metric %s; %s has %s", field, path,
                          reached[0] ? reached : "it", names);
}

static bool is_number(const cJSON *item)
{
    return cJSON_IsNumber(item) || cJSON_IsRaw(item) || cJSON_IsBool(item);
}

static ll_status check_metric(const cJSON *metrics, const char *field, const char *path)
{
    char reached[160];
    const char *missing;
    const cJSON *found = metric_at(metrics, path, reached, sizeof reached, &missing);
    return found && (is_number(found) || cJSON_IsNull(found)) ? ll_ok() : no_metric(metrics, field, path);
}

static ll_status find_metric(const ll_experiment *e, const char *field, const char *path, int standard,
                             int *index)
{
    *index = standard < e->metric_count ? standard : -1;
    for (int i = 0; path[0] && i < e->metric_count; i++)
        if (strcmp(e->metrics[i], path) == 0) {
            *index = i;
            return ll_ok();
        }
    return path[0]
               ? ll_field_error(LL_BAD_INPUT, field, "%s must be one of the metrics; got %.100s", field, path)
               : ll_ok();
}

static ll_status read_trade(ll_experiment *e)
{
    ll_status status = find_metric(e, "error", e->head.error, 0, &e->error_metric);
    return ll_failed(&status) ? status : find_metric(e, "cost", e->head.cost, 1, &e->cost_metric);
}

static ll_status read_metrics(ll_experiment *e, const cJSON *present)
{
    const cJSON *metrics = cJSON_GetObjectItemCaseSensitive(e->json, "metrics"), *item;
    if (!cJSON_IsArray(metrics) || cJSON_GetArraySize(metrics) == 0 ||
        cJSON_GetArraySize(metrics) > LL_EXPERIMENT_METRICS_MAX)
        return ll_field_error(
            LL_BAD_INPUT, "metrics",
            "metrics must be an array of 1 to %d paths, such as \"players.0.own_error_m.mean\"",
            LL_EXPERIMENT_METRICS_MAX);
    cJSON_ArrayForEach(item, metrics)
    {
        char field[32];
        snprintf(field, sizeof field, "metrics.%d", e->metric_count);
        if (!cJSON_IsString(item) || strlen(item->valuestring) > LL_EXPERIMENT_PATH_MAX)
            return ll_field_error(LL_BAD_INPUT, field, "%s must be a path of at most %d characters", field,
                                  LL_EXPERIMENT_PATH_MAX);
        ll_status status = check_metric(present, field, item->valuestring);
        if (ll_failed(&status))
            return status;
        for (int i = 0; i < e->metric_count; i++)
            if (strcmp(e->metrics[i], item->valuestring) == 0)
                return ll_field_error(LL_BAD_INPUT, field, "%s: %s is given twice", field, item->valuestring);
        snprintf(e->metrics[e->metric_count++], sizeof e->metrics[0], "%s", item->valuestring);
    }
    ll_status status = read_trade(e);
    if (ll_failed(&status))
        return status;
    return e->head.stop.metric[0] ? check_metric(present, "stop.metric", e->head.stop.metric) : ll_ok();
}

/* ---- runs ---- */

const char *const ll_row_status_names[] = {"ok", "stopped", "diverged", "refused"};

ll_status ll_experiment_open(const ll_experiment *e, int64_t run, ll_scenario *scenario)
{
    size_t size = e->base.kind->table->size;
    *scenario = (ll_scenario){e->base.kind, malloc(size)};
    if (!scenario->config)
        return ll_error(LL_NO_MEMORY, "no memory for a scenario");
    memcpy(scenario->config, e->base.config, size);
    cJSON *values = ll_experiment_point(e, run / e->head.repeats);
    ll_status status = apply(scenario->kind, values, scenario->config);
    cJSON_Delete(values);
    ((ll_scenario_head *)scenario->config)->seed = ll_experiment_seed(e, run);
    if (ll_failed(&status))
        ll_scenario_free(scenario);
    return status;
}

static double value_at(const cJSON *metrics, const char *path)
{
    char reached[160];
    const char *missing;
    const cJSON *item = metric_at(metrics, path, reached, sizeof reached, &missing);
    return cJSON_IsBool(item) ? cJSON_IsTrue(item) : is_number(item) ? item->valuedouble : NAN;
}

static bool stops(const ll_experiment *e, ll_session *session)
{
    cJSON *report = ll_session_metrics(session);
    double value = value_at(cJSON_GetObjectItem(report, "metrics"), e->head.stop.metric);
    cJSON_Delete(report);
    return value > e->head.stop.above;
}

static bool is_cancelled(const atomic_bool *cancel)
{
    return cancel && atomic_load_explicit(cancel, memory_order_relaxed);
}

static ll_status run_to(ll_session *session, int64_t tick, const atomic_bool *cancel)
{
    enum { TICKS_AT_ONCE = 64 };
    ll_status status = ll_ok();
    for (int64_t at = ll_session_get_info(session).tick;
         at < tick && !ll_failed(&status) && !is_cancelled(cancel);) {
        at = tick - at > TICKS_AT_ONCE ? at + TICKS_AT_ONCE : tick;
        status = ll_session_run_to(session, at);
    }
    return status;
}

static ll_status advance(const ll_experiment *e, ll_session *session, const atomic_bool *cancel,
                         bool *stopped)
{
    ll_session_info info = ll_session_get_info(session);
    if (!e->head.stop.metric[0])
        return run_to(session, info.end_tick, cancel);
    ll_status status = ll_ok();
    for (int64_t k = 1;
         !ll_failed(&status) && !*stopped && info.tick < info.end_tick && !is_cancelled(cancel); k++) {
        int64_t to = ll_tick_at((ll_time)((double)k * e->head.stop.every_s * 1e9), info.tick_freq);
        status = run_to(session, to < info.end_tick ? to : info.end_tick, cancel);
        info = ll_session_get_info(session);
        *stopped = !ll_failed(&status) && info.tick < info.end_tick && stops(e, session);
    }
    return status;
}

static void read_row(const ll_experiment *e, ll_session *session, ll_row *row)
{
    cJSON *report = ll_session_metrics(session), *metrics = cJSON_GetObjectItem(report, "metrics");
    for (int i = 0; i < e->metric_count; i++)
        row->metrics[i] = value_at(metrics, e->metrics[i]);
    row->hash = ll_session_hash(session);
    row->t_s = ll_to_s(ll_session_get_info(session).time);
    cJSON_Delete(report);
}

void ll_row_clear(ll_row *row)
{
    memset(row, 0, sizeof *row);
    for (int i = 0; i < LL_EXPERIMENT_METRICS_MAX; i++)
        row->metrics[i] = NAN;
}

/* A sentence may be cut within a character, which no database of text takes. */
static void tell_error(ll_row *row, const ll_status *status)
{
    snprintf(row->error, sizeof row->error, "%.*s", (int)sizeof row->error - 1, status->text);
    for (char *at = row->error; *at;) {
        int length = ll_utf8_printable(at);
        if (length == 0)
            *at = '?';
        at += length ? length : 1;
    }
}

ll_status ll_experiment_run(const ll_experiment *e, int64_t run, const atomic_bool *cancel, ll_row *row)
{
    ll_scenario scenario;
    ll_session *session = NULL;
    bool stopped = false;
    ll_row_clear(row);
    row->run = run;
    ll_status status = ll_experiment_open(e, run, &scenario);
    if (!ll_failed(&status))
        status = ll_session_open(&scenario, NULL, NULL, &session);
    if (status.code == LL_NO_MEMORY)
        return status;
    if (ll_failed(&status)) {
        row->status = LL_ROW_REFUSED;
        tell_error(row, &status);
        return ll_ok();
    }
    status = advance(e, session, cancel, &stopped);
    if (is_cancelled(cancel)) {
        ll_session_destroy(session);
        return ll_error(LL_CONFLICT, "run %lld was cancelled", (long long)run);
    }
    row->status = ll_failed(&status) ? LL_ROW_DIVERGED : stopped ? LL_ROW_STOPPED : LL_ROW_OK;
    if (ll_failed(&status))
        tell_error(row, &status);
    read_row(e, session, row);
    ll_session_destroy(session);
    return ll_ok();
}

ll_status ll_experiment_trace(const ll_experiment *e, int64_t run,
                              void (*write)(void *context, const char *text, size_t length), void *context)
{
    ll_scenario scenario;
    ll_session *session = NULL;
    bool stopped = false;
    ll_status status = ll_experiment_open(e, run, &scenario);
    if (!ll_failed(&status))
        status = ll_session_open(&scenario, NULL, NULL, &session);
    if (ll_failed(&status))
        return status;
    ll_status ended = advance(e, session, NULL, &stopped);
    int64_t tick = ll_session_get_info(session).tick;
    status = ll_session_trace(session, 0, ll_failed(&ended) && tick > 0 ? tick - 1 : tick, write, context);
    ll_session_destroy(session);
    return status;
}

/* ---- whole ---- */

/* Paths of metrics are held against those of the first point at its first tick, or of the scenario itself
 * where the first point's values are refused. */
static ll_status check_with_metrics(ll_experiment *e)
{
    ll_scenario scenario;
    ll_session *session = NULL;
    ll_status status = ll_experiment_open(e, 0, &scenario);
    if (status.code == LL_BAD_INPUT) {
        scenario = (ll_scenario){e->base.kind, malloc(e->base.kind->table->size)};
        if (!scenario.config)
            return ll_error(LL_NO_MEMORY, "no memory for a scenario");
        memcpy(scenario.config, e->base.config, e->base.kind->table->size);
        status = ll_ok();
    }
    if (!ll_failed(&status))
        status = ll_session_open(&scenario, NULL, NULL, &session);
    if (ll_failed(&status))
        return status;
    cJSON *report = ll_session_metrics(session);
    status = read_metrics(e, cJSON_GetObjectItem(report, "metrics"));
    cJSON_Delete(report);
    ll_session_destroy(session);
    return status;
}

ll_status ll_experiment_parse(const cJSON *json, const char *scenarios, ll_experiment **experiment)
{
    *experiment = NULL;
    if (!cJSON_IsObject(json))
        return ll_error(LL_BAD_INPUT, "an experiment is a JSON object");
    ll_experiment *e = calloc(1, sizeof *e);
    if (!e || !(e->json = cJSON_Duplicate(json, true))) {
        free(e);
        return ll_error(LL_NO_MEMORY, "no memory for an experiment");
    }
    ll_status status = read_head(e, json);
    if (!ll_failed(&status))
        status = read_scenario(e, scenarios);
    if (!ll_failed(&status))
        status = read_set(e);
    if (!ll_failed(&status))
        status = read_axes(e);
    if (!ll_failed(&status))
        status = count_runs(e);
    if (!ll_failed(&status))
        status = check_with_metrics(e);
    if (ll_failed(&status)) {
        ll_experiment_free(e);
        return status;
    }
    *experiment = e;
    return ll_ok();
}

void ll_experiment_free(ll_experiment *e)
{
    if (!e)
        return;
    for (int i = 0; i < e->axis_count; i++)
        ll_axis_free(&e->axes[i]);
    ll_scenario_free(&e->base);
    cJSON_Delete(e->json);
    free(e);
}
