/* Reports of a fluid: state, metrics, layout and trace. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/run_status.h"
#include "fluid/grid/grid.h"
#include "fluid/particle/particle.h"
#include "fluid/scenes/scenes.h"
#include "sim/core/scenario_rows.h"
#include "sim/fluid/fluid.h"

/* ---- state ---- */

#define HEADS(X)                                                                                             \
    X(text, scene, NULL, scene->name, "name of the scene", NULL)                                             \
    X(text, method, NULL, scene->method->name, "method of the scene: grid, particles or ocean", NULL)        \
    X(text, status, NULL, ll_run_status_names[s->failed ? LL_RUN_DIVERGED : LL_RUN_OK],                      \
      "ok; diverged: a value is not finite, or something moved too far in a substep", NULL)                  \
    X(text, reason, NULL, s->failed ? s->reason : NULL,                                                      \
      "reason for the status diverged, and when it happened", "The status is ok: the reason is left out.")   \
    X(number, t_s, "s", ll_to_s(s->now), "virtual time that the fluid has reached", NULL)

#define NOTICES(X)                                                                                           \
    X(notices, notices, NULL, ,                                                                              \
      "sentences that say why results differ from the open sea, the free stream or the equations", NULL)

static const ll_metric_table head_table = {
    .path = "", .also = LL_FLUID_AGAIN, .help = "The fluid and its status.", LL_METRICS_FROM(HEADS)};
static const ll_metric_table notice_table = {
    .path = "", .also = LL_FLUID_AGAIN, .help = "Notices about the results.", LL_METRICS_FROM(NOTICES)};

const ll_metric_table *const ll_fluid_sim_metric_tables[] = {&head_table, LL_FLUID_METRIC_TABLES,
                                                             &notice_table, NULL};

/* Null of a fluid that has failed. */
static cJSON *numbers_of(const void *block, int place)
{
    const ll_fluid_sim *s = ll_fluid_sim_at(block, place);
    ll_fluid_number all[LL_FLUID_NUMBERS_MAX];
    const ll_fluid_scene *scene = ll_fluid_sim_scene(&s->setup);
    cJSON *o = cJSON_CreateObject();
    LL_METRICS_PUT(o, &head_table, HEADS);
    int count = ll_fluid_sim_numbers(s, all);
    for (int i = 0; i < count; i++)
        cJSON_AddItemToObject(o, all[i].name, ll_param_number(s->failed ? NAN : all[i].value));
    return o;
}

static int count_of(const ll_fluid_sim *first)
{
    return 1 + first->setup.following;
}

cJSON *ll_fluid_sim_state(const void *block)
{
    return ll_side_by_side_report(block, count_of(block), numbers_of);
}

/* ---- metrics ---- */

static void add_profiles(cJSON *metrics, const ll_fluid_sim *s)
{
    const ll_fluid_scene *scene = ll_fluid_sim_scene(&s->setup);
    double pairs[LL_FLUID_POINTS_MAX][2];
    const char *name;
    if (!scene->profile || s->failed)
        return;
    cJSON *profiles = cJSON_AddObjectToObject(metrics, "profiles");
    for (int index = 0, count; (count = scene->profile(ll_fluid_sim_block(s), index, &name, pairs)) > 0;
         index++) {
        cJSON *curve = cJSON_AddArrayToObject(profiles, name);
        for (int i = 0; i < count; i++) {
            cJSON *pair = cJSON_CreateArray();
            cJSON_AddItemToArray(pair, ll_param_number(pairs[i][0]));
            cJSON_AddItemToArray(pair, ll_param_number(pairs[i][1]));
            cJSON_AddItemToArray(curve, pair);
        }
    }
}

static void add_notices(cJSON *o, const ll_fluid_sim *s)
{
    const ll_fluid_scene *scene = ll_fluid_sim_scene(&s->setup);
    ll_fluid_notice all[LL_FLUID_NOTICES_MAX];
    int count = scene->notices ? scene->notices(ll_fluid_sim_block(s), all) : 0;
    cJSON *notices = cJSON_AddArrayToObject(o, "notices");
    for (int i = 0; i < count; i++)
        cJSON_AddItemToArray(notices, cJSON_CreateString(all[i].text));
}

static cJSON *metrics_of(const void *block, int place)
{
    cJSON *metrics = numbers_of(block, place);
    add_notices(metrics, ll_fluid_sim_at(block, place));
    add_profiles(metrics, ll_fluid_sim_at(block, place));
    return metrics;
}

cJSON *ll_fluid_sim_metrics(const void *block)
{
    return ll_side_by_side_report(block, count_of(block), metrics_of);
}

void ll_fluid_sim_costs(const void *config, const ll_step_profiler *step_profiler, cJSON *cost)
{
    cJSON *parts = cJSON_AddArrayToObject(cost, "parts");
    for (int i = 0; i <= ((const ll_fluid_config *)config)->side_by_side_count; i++) {
        cJSON *part = cJSON_CreateObject();
        cJSON_AddItemToObject(cJSON_AddObjectToObject(part, "all"), "ns_per_sim_s",
                              ll_param_number(ll_step_profiler_ns_per_s(step_profiler, i)));
        cJSON_AddItemToArray(parts, part);
    }
}

/* ---- layout ---- */

/* The start of a simulation; NULL: out of memory. */
static ll_fluid_sim *started(const void *config)
{
    ll_fluid_sim *s = malloc(ll_fluid_sim_size(config));
    if (!s)
        return NULL;
    ll_status status = ll_fluid_sim_init(s, config);
    if (!ll_failed(&status))
        return s;
    free(s);
    return NULL;
}

static void add_layers(cJSON *fluid, const ll_fluid_method *method)
{
    static const char *const shapes[] = {"field", "points"};
    cJSON *layers = cJSON_AddArrayToObject(fluid, "layers");
    for (int i = 0; i < method->layer_count; i++) {
        const ll_fluid_layer *layer = &method->layers[i];
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "name", layer->name);
        cJSON_AddStringToObject(o, "help", layer->help);
        cJSON_AddStringToObject(o, "shape", shapes[layer->shape]);
        cJSON *columns = cJSON_AddArrayToObject(o, "columns");
        for (int k = 0; layer->columns[k]; k++)
            cJSON_AddItemToArray(columns, cJSON_CreateString(layer->columns[k]));
        cJSON_AddItemToArray(layers, o);
    }
}

static void add_numbers(cJSON *fluid, const ll_fluid_sim *s)
{
    ll_fluid_number all[LL_FLUID_NUMBERS_MAX];
    cJSON *numbers = cJSON_AddArrayToObject(fluid, "numbers");
    int count = ll_fluid_sim_numbers(s, all);
    for (int i = 0; i < count; i++)
        cJSON_AddItemToArray(numbers, cJSON_CreateString(all[i].name));
}

/* Left, right, bottom, top. */
static void add_view(cJSON *fluid, const ll_fluid_sim *s)
{
    double x0, y0, x1, y1;
    ll_fluid_sim_scene(&s->setup)->method->extent(ll_fluid_sim_block(s), &x0, &y0, &x1, &y1);
    const double view[4] = {x0, x1, y0, y1};
    cJSON *array = cJSON_AddArrayToObject(fluid, "view");
    for (int i = 0; i < 4; i++)
        cJSON_AddItemToArray(array, ll_param_number(view[i]));
}

static cJSON *layout_of(const void *block, int place)
{
    const ll_fluid_sim *s = ll_fluid_sim_at(block, place);
    const ll_fluid_scene *scene = ll_fluid_sim_scene(&s->setup);
    cJSON *fluid = cJSON_CreateObject();
    cJSON_AddStringToObject(fluid, "scene", scene->name);
    cJSON_AddStringToObject(fluid, "title", scene->title);
    cJSON_AddStringToObject(fluid, "help", scene->help);
    cJSON_AddStringToObject(fluid, "source", scene->source);
    cJSON_AddStringToObject(fluid, "method", scene->method->name);
    cJSON_AddNumberToObject(fluid, "hz", s->setup.hz);
    add_layers(fluid, scene->method);
    add_view(fluid, s);
    add_numbers(fluid, s);
    add_notices(fluid, s);
    return fluid;
}

cJSON *ll_fluid_sim_layout(const void *config)
{
    cJSON *layout = cJSON_CreateObject();
    ll_fluid_sim *s = started(config);
    if (s)
        cJSON_AddItemToObject(layout, "fluid", ll_side_by_side_report(s, count_of(s), layout_of));
    free(s);
    return layout;
}

/* ---- trace: some numbers of the method and all of the scene ---- */

const ll_metric_table *const ll_fluid_sim_trace_tables[] = {LL_FLUID_TRACE_TABLES, NULL};

void ll_fluid_sim_trace(const void *block, ll_trace_line *trace)
{
    ll_fluid_number all[LL_FLUID_NUMBERS_MAX];
    int place = 0;
    for (const ll_fluid_sim *s = block; s != NULL; s = ll_fluid_sim_next(s), place++) {
        const ll_fluid_method *method = ll_fluid_sim_scene(&s->setup)->method;
        int count = ll_fluid_sim_numbers(s, all);
        ll_side_by_side_trace(trace, place);
        for (int i = 0; i < count; i++)
            if (i < method->traced->count || i >= method->metrics->count)
                ll_trace_add(trace, "", 0, all[i].name, all[i].value);
    }
}
