/* Simulations of kind `rigid`: a world of rigid bodies, from a list or from a scene of the rigid room.
 *
 * A tick is a step. Each element of `side_by_side` adds a copy of the same bodies with its own parameters, so
 * that solvers run side by side from the same start; a person's drag acts on all copies. */
#pragma once

#include "rigid/scenes/scene.h"
#include "sim/core/side_by_side.h"
#include "sim/core/sim.h"

#define LL_RIGID_BODIES_MAX 4096 /* of a list; scenes have more */
#define LL_RIGID_JOINTS_MAX 4096
#define LL_RIGID_POINTS_MAX 16
#define LL_RIGID_BLOCK_MAX ((size_t)512 << 20) /* bytes of a session's worlds */
/* Profiler parts of a world: its phases, the whole step, then the time of each volume for testing the
 * pairs. */
#define LL_RIGID_PARTS (LL_PHASES + 1 + LL_VOLUMES)
#define LL_RIGID_COMPARED_MAX 256 /* shapes that compare_volumes tests */

typedef enum ll_rigid_form {
    LL_FORM_BOX,
    LL_FORM_CIRCLE,
    LL_FORM_CAPSULE,
    LL_FORM_POLYGON,
    LL_FORM_SEGMENT,
    LL_FORM_CHAIN,
    LL_FORMS
} ll_rigid_form;

/* A body of the list, and its one shape. */
typedef struct ll_rigid_body {
    int32_t type, form; /* ll_body_type, ll_rigid_form */
    double size[2];     /* m, of a box and a capsule */
    double radius;      /* m, of a circle */
    double position[2], angle, velocity[2], angular_velocity;
    double density, friction, restitution, gravity_scale, damping, angular_damping;
    int32_t point_count;
    bool loop, fixed_rotation, bullet;
    uint8_t pad[1];
    double points[LL_RIGID_POINTS_MAX][2]; /* of a polygon, a segment and a chain */
} ll_rigid_body;

typedef struct ll_rigid_joint {
    int32_t type; /* ll_joint_type */
    bool collide, limited, motored, rope;
    int64_t a, b; /* indices into the list of bodies */
    double anchor_a[2], anchor_b[2], axis[2], target[2];
    double length, lower, upper, hertz, damping, motor_speed, max_force, max_torque;
} ll_rigid_joint;

/* A world next to the first. */
typedef struct ll_rigid_side_by_side {
    ll_rigid_params solver; /* without gravity, which is the first's */
} ll_rigid_side_by_side;

/* Everything but the lists of bodies and joints. */
typedef struct ll_rigid_setup {
    double hz;
    double gravity[2];
    double tunnel_x;
    ll_rigid_params solver; /* without gravity, see above */
    ll_rigid_side_by_side side_by_side[LL_SIDE_BY_SIDE_MAX - 1];
    ll_scene_args params; /* of the scene */
    int32_t side_by_side_count;
    int32_t scene;       /* index into ll_scene_names; 0: the list of bodies */
    int32_t broad_phase; /* ll_broad_kind */
    bool compare_volumes;
    uint8_t pad[3];
} ll_rigid_setup;

typedef struct ll_rigid_config {
    ll_scenario_head head;
    int64_t reserved_after_head; /* keeps the layout of a block, and so its hash */
    ll_rigid_setup setup;
    int32_t body_count, joint_count;
    ll_rigid_body bodies[LL_RIGID_BODIES_MAX];
    ll_rigid_joint joints[LL_RIGID_JOINTS_MAX];
} ll_rigid_config;

extern const ll_param_table ll_rigid_scenario_table;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* Results of a bounding volume on the pairs of shapes, over all compared steps. */
typedef struct ll_volume_record {
    int64_t tests, hits, exact_hits; /* the last is of the hash of a state */
    int64_t false_hits, missed_hits;
    double gap_sum, gap_max; /* m, distance of the shapes at false hits */
} ll_volume_record;

/* Measures of a world at every step. */
typedef struct ll_rigid_record {
    double energy_start, momentum_start[2], mass;
    double energy_scale; /* J: initial kinetic energy, and the gain of all bodies by a fall through the view;
                            0: unknown, because a body or joint is driven */
    ll_rigid_metrics now;
    double penetration_worst, energy_most, joint_error_worst, tilt_worst, sag_worst, drift_worst;
    int64_t steps_asleep, asleep_at; /* asleep_at: the step since which all sleep; -1: not asleep */
    int64_t over_limit;              /* steps with more contacts than fit */
    int64_t stopped;                 /* total number of bodies that CCD stopped at their time of impact */
    int64_t diverged_at;             /* the step; -1: not diverged */
    ll_volume_record volume[LL_VOLUMES];
    ll_joint_id mouse; /* none: no person drags */
    ll_body_id hand;   /* a body without shape for the mouse joint, if there is no static body */
    char reason[256];
} ll_rigid_record;

/* The start of a block. Offsets are from here. */
typedef struct ll_rigid_sim {
    int64_t size;
    ll_time now;
    ll_rigid_setup setup;
    double view[4];        /* m: left, right, bottom and top of the view; a person's axes span it */
    double target[2];      /* m, pointer position */
    int64_t held, pressed; /* whether a person holds the button; whether it went down since the last step */
    int64_t references;    /* in `reference` */
    int64_t reference;     /* ll_body_reference */
    int64_t world[LL_SIDE_BY_SIDE_MAX];
    ll_rigid_record record[LL_SIDE_BY_SIDE_MAX];
} ll_rigid_sim;

#pragma GCC diagnostic pop

static inline ll_rigid *ll_rigid_sim_world(const ll_rigid_sim *s, int i)
{
    return (ll_rigid *)((char *)(uintptr_t)s + s->world[i]);
}

static inline ll_body_reference *ll_rigid_sim_references(const ll_rigid_sim *s)
{
    return (ll_body_reference *)((char *)(uintptr_t)s + s->reference);
}

/* Number of worlds side by side. */
static inline int ll_rigid_sim_worlds(const ll_rigid_setup *setup)
{
    return 1 + setup->side_by_side_count;
}

/* NULL with a list of bodies. */
static inline const ll_scene *ll_rigid_sim_scene(const ll_rigid_setup *setup)
{
    return setup->scene > 0 ? ll_scenes[setup->scene - 1] : NULL;
}

_Static_assert(LL_SIDE_BY_SIDE_MAX *LL_RIGID_PARTS <= LL_STEP_PROFILER_PARTS,
               "a profiler has room for all worlds");

/* ---- config.c ---- */

ll_rigid_limits ll_rigid_sim_limits(const ll_rigid_config *config);
ll_rigid_params ll_rigid_sim_params(const ll_rigid_setup *setup, int world);

/* ---- block.c: of all worlds side by side ---- */

size_t ll_rigid_sim_size(const void *config);
ll_status ll_rigid_sim_init(void *block, const void *config);

/* ---- rigid.c ---- */

/* One step of a world, without measures. A failure is stored in its record. */
ll_status ll_rigid_sim_step(ll_rigid_sim *s, int world, const ll_rigid_probe *probe, ll_team *team);

/* ---- build.c ---- */

/* The geometry of a body's shape; of a chain that of its first link. */
ll_status ll_rigid_sim_shape(const ll_rigid_body *body, ll_geometry *out);
ll_status ll_rigid_sim_build(const ll_rigid_config *config, ll_rigid *world);

/* ---- measure.c ---- */

void ll_rigid_sim_measure_start(ll_rigid_sim *s, int world);
/* LL_DIVERGED, also stored in the record: bodies have gained more than LL_BLOWN_UP times energy_scale. */
ll_status ll_rigid_sim_measure(ll_rigid_sim *s, int world, ll_step_profiler *step_profiler);
/* ns per pair of shapes, over pairs that are near each other now (if none, over the last two): to move the
 * volumes to their bodies' poses, and to test them. NAN for fewer than two shapes. */
double ll_rigid_sim_time_volume(const ll_rigid *world, ll_volume volume, int64_t (*now_ns)(void));

/* ---- metrics.c, report.c and frame.c: measurements, reports and stream records of a block ---- */

extern const ll_metric_table *const ll_rigid_sim_metric_tables[];
struct cJSON *ll_rigid_sim_metrics(const void *block);
void ll_rigid_sim_time_parts(const void *config, struct cJSON *metrics, int64_t (*now_ns)(void));
/* Adds the list `bodies` of a world. Of a list of bodies element i is body i. Of a large scene only the first
 * are listed. */
void ll_rigid_sim_add_bodies(struct cJSON *object, const ll_rigid_sim *s, int world);
struct cJSON *ll_rigid_sim_state(const void *block);
void ll_rigid_sim_costs(const void *config, const ll_step_profiler *step_profiler, struct cJSON *cost);
struct cJSON *ll_rigid_sim_layout(const void *config);
extern const ll_metric_table *const ll_rigid_sim_trace_tables[];
void ll_rigid_sim_trace(const void *block, ll_trace_line *trace);
extern const ll_record *const ll_rigid_sim_records[];
void ll_rigid_sim_fill(const void *block, ll_row_set *rows);
