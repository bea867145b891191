/* Scenes: worlds that are known to be hard, or that others measure their speed with.
 *
 * Tests, benchmarks and the page build the same ones from here: one row of a table each. */
#pragma once

#include "rigid/world/metrics.h"

/* What varies in a scene. 0 stands for the scene's own value, which ll_scene_args_of fills in; what a scene
 * does not speak of in its help it does not use. */
typedef struct ll_scene_args {
    int64_t size;  /* rows, bodies along a side, links */
    double ratio;  /* of masses */
    double offset; /* m */
    double speed;  /* m/s or rad/s */
    double friction;
} ll_scene_args;

extern const ll_param_table ll_scene_args_table;

typedef struct ll_scene {
    const char *name, *title;
    const char *help; /* what is in it, what makes it hard, where it is from */
    ll_scene_args standard;
    double (*fall)(const ll_scene_args *args); /* m that bodies fall before they lie; NULL: 0 */
    void (*limits)(const ll_scene_args *args, ll_rigid_limits *limits); /* beside `broad` and `volumes` */
    void (*params)(const ll_scene_args *args, ll_rigid_params *params); /* what it changes; NULL: nothing */
    ll_status (*build)(ll_rigid *world, const ll_scene_args *args);
    /* Before each step, for what is driven or comes and goes; NULL: nothing. `step` counts from 0. */
    ll_status (*drive)(ll_rigid *world, const ll_scene_args *args, int64_t step);
} ll_scene;

extern const ll_scene *const ll_scenes[];
extern const int ll_scene_count;
extern const char *const ll_scene_names[];        /* `none`, then the scenes; NULL-terminated */
const ll_scene *ll_scene_named(const char *name); /* NULL with no such scene */
ll_scene_args ll_scene_args_of(const ll_scene *scene, const ll_scene_args *given);
double ll_scene_fall(const ll_scene *scene, const ll_scene_args *args);
