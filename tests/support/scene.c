#include "support/scene.h"
#include "library/library.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

/* Deletes `json`. */
static scene start(cJSON *json, const char *const *sets)
{
    scene s = {0};
    must(ll_scenario_parse(json, &s.scenario));
    cJSON_Delete(json);
    const ll_param_table *table = s.scenario.kind->table;
    void *before = malloc(table->size);
    memcpy(before, s.scenario.config, table->size);
    int count = 0;
    while (sets && sets[count])
        count++;
    must(ll_param_put(table, s.scenario.config, sets, count));
    must(ll_param_check(table, s.scenario.config));
    s.scenario.kind->settle(s.scenario.config, before);
    free(before);
    s.game = malloc(s.scenario.kind->size(s.scenario.config));
    must(s.scenario.kind->init(s.game, s.scenario.config));
    return s;
}

scene scene_open(const char *id, const char *const *sets)
{
    cJSON *json;
    must(ll_scenario_load("scenarios", id, &json));
    return start(json, sets);
}

scene scene_make(const char *text, const char *const *sets)
{
    cJSON *json;
    must(ll_json_parse(text, strlen(text), &json));
    return start(json, sets);
}

void scene_run(scene *s, double until_s, const ll_recorder *recorder)
{
    must(s->scenario.kind->advance(s->game, (ll_time)(until_s * 1e9 + 0.5), recorder, NULL, NULL, NULL));
}

void scene_run_whole(scene *s)
{
    const ll_param_table *table = s->scenario.kind->table;
    const ll_scenario_head *head = s->scenario.config;
    void *config = malloc(table->size);
    memcpy(config, s->scenario.config, table->size);
    for (int i = 0; i < head->timeline_count; i++) {
        cJSON *patch = cJSON_Parse(head->timeline[i].set);
        scene_run(s, head->timeline[i].at_s, NULL);
        must(ll_param_patch(table, patch, config, NULL, NULL));
        s->scenario.kind->change(s->game, config, s->game->now);
        cJSON_Delete(patch);
    }
    scene_run(s, head->duration_s, NULL);
    free(config);
}

void scene_close(scene *s)
{
    free(s->game);
    ll_scenario_free(&s->scenario);
}

static void keep(void *context, const void *row)
{
    const ll_event *event = row;
    tape *t = context;
    if (t->count == t->capacity) {
        t->capacity = t->capacity ? 2 * t->capacity : 1024;
        t->events = realloc(t->events, t->capacity * sizeof *t->events);
    }
    t->events[t->count++] = *event;
}

ll_recorder tape_recorder(tape *t)
{
    return (ll_recorder){.record = keep, .context = t};
}

void tape_free(tape *t)
{
    free(t->events);
    *t = (tape){0};
}
