/* Scenes of fluids, set up by their tables and stepped. */
#pragma once

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/hash.h"
#include "fluid/core/fluid.h"
#include "support/near.h"

typedef struct tank {
    const ll_fluid_scene *scene;
    void *block;
    size_t size;
    _Alignas(8) char params[LL_FLUID_PARAMS_MAX], solver[LL_FLUID_PARAMS_MAX];
} tank;

/* `settings`: `params.n=32 solver.pressure=direct`, parted by spaces. */
static inline ll_status tank_set(tank *t, const char *settings)
{
    char text[400];
    snprintf(text, sizeof text, "%s", settings);
    ll_status status = ll_ok();
    for (char *word = strtok(text, " "); word && !ll_failed(&status); word = strtok(NULL, " ")) {
        char *value = strchr(word, '=');
        assert_non_null(value);
        *value++ = '\0';
        bool own = strncmp(word, "params.", 7) == 0;
        status = ll_param_set(own ? t->scene->params : t->scene->solver, own ? t->params : t->solver,
                              word + 7, value, false);
    }
    return status;
}

static inline ll_status tank_check(tank *t, const char *scene, const char *settings)
{
    memset(t, 0, sizeof *t);
    t->scene = ll_fluid_scene_find(scene);
    assert_non_null(t->scene);
    ll_param_defaults(t->scene->params, t->params);
    ll_param_defaults(t->scene->solver, t->solver);
    ll_status status = tank_set(t, settings);
    return ll_failed(&status) ? status : t->scene->check(t->params, t->solver);
}

static inline tank tank_open(const char *scene, const char *settings)
{
    tank t;
    ll_status status = tank_check(&t, scene, settings);
    if (ll_failed(&status))
        fail_msg("%s %s: %s", scene, settings, status.text);
    t.size = t.scene->size(t.params, t.solver);
    t.block = malloc(t.size);
    assert_non_null(t.block);
    t.scene->init(t.block, t.params, t.solver);
    return t;
}

static inline void tank_close(tank *t)
{
    free(t->block);
}

static inline ll_status tank_try(tank *t, int steps, double dt)
{
    ll_status status = ll_ok();
    for (int i = 0; i < steps && !ll_failed(&status); i++)
        status = t->scene->method->step(t->block, dt, NULL);
    return status;
}

static inline void tank_run(tank *t, int steps, double dt)
{
    ll_status status = tank_try(t, steps, dt);
    if (ll_failed(&status))
        fail_msg("%s: %s", t->scene->name, status.text);
}

static inline uint64_t tank_hash(const tank *t)
{
    return t->scene->method->hash ? t->scene->method->hash(t->block) : ll_hash(0, t->block, t->size);
}

static inline double tank_number(const tank *t, const char *name)
{
    ll_fluid_number all[LL_FLUID_NUMBERS_MAX];
    int count = t->scene->method->numbers(t->block, all);
    if (t->scene->numbers)
        count += t->scene->numbers(t->block, all + count);
    for (int i = 0; i < count; i++)
        if (strcmp(all[i].name, name) == 0)
            return all[i].value;
    fail_msg("%s tells no %s", t->scene->name, name);
    return 0;
}

/* Opens, runs and closes; the number at the end. */
static inline double tank_result(const char *scene, const char *settings, int steps, double dt,
                                 const char *name)
{
    tank t = tank_open(scene, settings);
    tank_run(&t, steps, dt);
    double value = tank_number(&t, name);
    tank_close(&t);
    return value;
}
