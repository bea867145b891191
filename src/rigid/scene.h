/* Scenes: worlds that are known to be hard, or that other engines use as benchmarks.
 *
 * Tests, benchmarks and the page build the same ones; each is one row of a table. */
#pragma once

#include "rigid/rigid.h"

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
    ll_scene_args standard;
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

/* ---- metrics ---- */

typedef struct ll_body_reference { /* initial position of a body */
    ll_vec2 position;
    double angle;
} ll_body_reference;

typedef struct ll_rigid_metrics {
    double penetration_max; /* m, of current contacts */
    double penetration_mean;
    double drift_max;                        /* m sideways from the initial position, of dynamic bodies */
    double sag_max;                          /* m below its resting position */
    double tilt_max;                         /* rad */
    double kinetic_energy, potential_energy; /* J */
    ll_vec2 momentum;                        /* kg m/s */
    double spin_momentum;                    /* about the origin */
    double speed_max;                        /* m/s */
    double joint_error;                      /* m or rad: largest error of a joint other than a spring */
    int32_t contacts, points, passed;        /* passed: dynamic bodies beyond the given plane */
    int32_t bodies;
} ll_rigid_metrics;

/* `references` has ll_rigid_body_end elements. `fall`: initial height of bodies above their resting
 * positions, m. */
void ll_rigid_refer(const ll_rigid *world, double fall, ll_body_reference *references, int32_t count);
double ll_scene_fall(const ll_scene *scene, const ll_scene_args *args);
/* Whether anything may add energy: a kinematic body, a motor, a spring, a mouse joint. */
bool ll_rigid_is_driven(const ll_rigid *world);
/* `beyond_x`: bodies to the right of it count as passed; INFINITY: none. */
ll_rigid_metrics ll_rigid_measure(const ll_rigid *world, const ll_body_reference *references, int32_t count,
                                  double beyond_x);
