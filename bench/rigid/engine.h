/* One interface for laglab and its peers: a scene comes in as numbers that every engine reads alike. */
#pragma once

#include <stdbool.h>
#include <time.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SHAPE_VERTICES_MAX 8

typedef enum shape_kind { SHAPE_CIRCLE, SHAPE_CAPSULE, SHAPE_POLYGON, SHAPE_CHAIN } shape_kind;

/* In the frame of the body's centre of mass, in metres. */
typedef struct bench_shape {
    int kind, count;
    double radius;
    double (*vertex)[2]; /* of a polygon counter-clockwise; of a chain a closed loop, solid from the right */
    double density, friction, restitution;
    unsigned category, mask;
    int group; /* negative: shapes of the same number never collide */
} bench_shape;

typedef struct bench_body {
    int type; /* 0 static, 1 kinematic, 2 dynamic */
    double x, y, angle, vx, vy, angular_velocity;
    bench_shape *shapes;
    int shape_count;
} bench_body;

/* A revolute joint between two bodies, counted from 0 as they are made. The angle is that of b to a. */
typedef struct bench_joint {
    int a, b;
    double ax, ay, bx, by; /* anchors in the frames of the centres of mass */
    bool limited, motored;
    double angle, lower, upper; /* angle: where lower and upper count from */
    double speed, torque;
} bench_joint;

typedef struct bench_world {
    double gravity_x, gravity_y, dt;
    bool continuous;                      /* swept detection is asked for */
    int bodies, shapes, contacts, joints; /* at most at one time */
    int made;                             /* bodies in the whole run */
} bench_world;

/* What comes and goes before a step. */
typedef struct bench_event {
    int step;
    int *removed, removed_count;
    bench_body *bodies;
    int body_count;
    bench_joint *joints;
    int joint_count;
} bench_event;

typedef struct bench_scene {
    bench_world world;
    bench_event *events; /* the first is before step 0 */
    int event_count;
} bench_scene;

typedef struct engine {
    const char *name;
    /* `set` is a setting of the engine by its name, or `default_value` where none was given. */
    void *(*open)(const bench_world *world, double (*set)(const char *name, double default_value));
    void (*add_body)(void *state, const bench_body *body);
    void (*add_joint)(void *state, const bench_joint *joint);
    void (*remove_body)(void *state, int body);
    void (*step)(void *state, double dt);
    void (*get)(void *state, int body, double pose[3]); /* x and y of the centre of mass, angle */
} engine;

/* SCENE.json STEPS SECONDS [setting=value]...: makes as many steps, or fewer when they take longer, and
 * prints one JSON object. Settings of every engine: `wall=1` for wall time in place of CPU time. The exit
 * status. */
int run_engine(const engine *e, int argc, char **argv);

const bench_scene *read_scene(const char *file); /* ends the program when it cannot be read */

static inline double cpu_now(void) /* s of this thread */
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#ifdef __cplusplus
}
#endif
