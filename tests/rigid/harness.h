/* A scene under test: build, step and measure it. */
#pragma once

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rigid/scenes/scene.h"
#include "support/near.h"

typedef struct lab {
    const ll_scene *scene;
    ll_scene_args args;
    ll_rigid *world;
    size_t size;
    ll_body_reference *first;
    int32_t count;
} lab;

static inline void ok(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static inline ll_rigid_params standard_params(void)
{
    ll_rigid_params p;
    ll_param_defaults(&ll_rigid_table, &p);
    return p;
}

static inline ll_rigid_limits small_limits(int32_t bodies)
{
    return (ll_rigid_limits){.bodies = bodies,
                             .shapes = bodies,
                             .hulls = bodies,
                             .contacts = 8 * bodies,
                             .joints = bodies,
                             .broad = LL_BROAD_GRID};
}

static inline ll_rigid *world_of(const ll_rigid_limits *limits, const ll_rigid_params *params)
{
    ok(ll_rigid_check(limits));
    size_t size = ll_rigid_size(limits);
    void *block = malloc(size);
    memset(block, 0xa5, size); /* unset bytes must not matter */
    return ll_rigid_init(block, limits, params);
}

static inline ll_scene_args scene_args(const ll_scene *scene, ll_scene_args given)
{
    return ll_scene_args_of(scene, &given);
}

/* Parameters of a scene: the defaults without sleeping, and the scene's own changes. */
static inline ll_rigid_params scene_params(const char *name, ll_scene_args given)
{
    const ll_scene *scene = ll_scene_named(name);
    assert_non_null(scene);
    ll_rigid_params p = standard_params();
    ll_scene_args args = scene_args(scene, given);
    p.sleep = false;
    if (scene->params != NULL)
        scene->params(&args, &p);
    return p;
}

static inline lab lab_open(const char *name, ll_scene_args given, const ll_rigid_params *params,
                           int32_t broad)
{
    lab l = {.scene = ll_scene_named(name)};
    l.args = scene_args(l.scene, given);
    ll_rigid_limits limits = {.broad = broad};
    l.scene->limits(&l.args, &limits);
    l.world = world_of(&limits, params);
    l.size = ll_rigid_size(&limits);
    ok(l.scene->build(l.world, &l.args));
    l.count = ll_rigid_body_end(l.world);
    l.first = calloc((size_t)l.count, sizeof *l.first);
    ll_rigid_refer(l.world, ll_scene_fall(l.scene, &l.args), l.first, l.count);
    return l;
}

static inline lab lab_standard(const char *name, ll_scene_args given)
{
    ll_rigid_params p = scene_params(name, given);
    return lab_open(name, given, &p, LL_BROAD_GRID);
}

static inline void lab_run(lab *l, int steps)
{
    for (int i = 0; i < steps; i++) {
        if (l->scene->drive != NULL)
            ok(l->scene->drive(l->world, &l->args, ll_rigid_get_stats(l->world).step));
        ok(ll_rigid_step(l->world, 1.0 / 60, NULL));
    }
}

static inline ll_rigid_metrics lab_measure(const lab *l)
{
    return ll_rigid_measure(l->world, l->first, l->count, INFINITY);
}

static inline void lab_close(lab *l)
{
    free(l->first);
    free(l->world);
}

static inline ll_body_id add_box(ll_rigid *w, ll_body_def def, double width, double height,
                                 ll_material material)
{
    ll_body_id id;
    ll_geometry g;
    ok(ll_rigid_add_body(w, &def, &id));
    ok(ll_shape_box(width, height, ll_vec(0, 0), 0, &g));
    ok(ll_rigid_add_shape(w, id, &g, &material));
    return id;
}

static inline ll_body_id add_ball(ll_rigid *w, ll_body_def def, double radius, ll_material material)
{
    ll_body_id id;
    ll_geometry g;
    ok(ll_rigid_add_body(w, &def, &id));
    ok(ll_shape_circle(ll_vec(0, 0), radius, &g));
    ok(ll_rigid_add_shape(w, id, &g, &material));
    return id;
}

static inline ll_body_state body(const ll_rigid *w, ll_body_id id)
{
    ll_body_state s;
    ok(ll_rigid_get_body(w, id, &s));
    return s;
}
