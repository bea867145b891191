/* Scenes: worlds that are known to be hard, or that other engines use as benchmarks.
 *
 * Tests, benchmarks and the page build the same ones; each is one row of a table. */
#pragma once

#include "rigid/world/metrics.h"

/* Arguments of a scene. 0 stands for the scene's default, which ll_scene_args_of fills in. A scene ignores
 * what its help does not name. */
typedef struct ll_scene_args {
    int64_t size;  /* rows, bodies per side, links */
    double ratio;  /* mass ratio */
    double offset; /* m */
    double speed;  /* m/s or rad/s */
    double friction;
} ll_scene_args;

extern const ll_param_table ll_scene_args_table;

typedef struct ll_scene {
    const char *name, *title;
    const char *help; /* contents, difficulty, source */
    ll_scene_args default_value;
    double (*fall)(const ll_scene_args *args); /* m that bodies fall before they rest; NULL: 0 */
    void (*limits)(const ll_scene_args *args, ll_rigid_limits *limits); /* other than `broad` and `volumes` */
    void (*params)(const ll_scene_args *args, ll_rigid_params *params); /* changed parameters; NULL: none */
    ll_status (*build)(ll_rigid *world, const ll_scene_args *args);
    /* Called before each step, for driven, added or removed bodies; NULL: none. `step` counts from 0. */
    ll_status (*drive)(ll_rigid *world, const ll_scene_args *args, int64_t step);
} ll_scene;

extern const ll_scene *const ll_scenes[];
extern const int ll_scene_count;
extern const char *const ll_scene_names[];        /* `none`, then the scenes; NULL-terminated */
const ll_scene *ll_scene_named(const char *name); /* NULL if there is no such scene */
ll_scene_args ll_scene_args_of(const ll_scene *scene, const ll_scene_args *given);
double ll_scene_fall(const ll_scene *scene, const ll_scene_args *args);
