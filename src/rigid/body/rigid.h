/* A world of rigid bodies in the plane: m, kg, s, rad.
 *
 * A world is one block of known size: indices, no pointers. A copy of the block is a snapshot, a rollback or
 * a fork. A step calls neither malloc nor a clock. Its results are the same bits on every compiler,
 * optimisation level and SIMD width, and with every broad phase.
 *
 * A scene pays for what it uses: joints, hulls and bounding volumes take memory only if the limits ask for
 * them, and sleeping bodies are not visited. */
#pragma once

#include <stddef.h>

#include "base/team.h"
#include "param/param.h"
#include "rigid/broad/broad.h"
#include "rigid/shape/bound.h"

typedef struct ll_rigid ll_rigid;

typedef struct ll_body_id { /* all zero: none */
    int32_t index;          /* from 1 */
    uint32_t generation;    /* number of bodies that have had this index */
} ll_body_id;

typedef struct ll_joint_id {
    int32_t index; /* from 1 */
    uint32_t generation;
} ll_joint_id;

/* ---- limits: they fix the block's size ---- */

typedef struct ll_rigid_limits {
    int32_t bodies, shapes;
    int32_t hulls; /* shapes other than circles */
    int32_t contacts;
    int32_t joints;
    int32_t broad;   /* ll_broad_kind */
    int32_t volumes; /* 1: room for bounding volumes */
    int32_t broads;  /* 1: room for every broad phase, to change it while running */
} ll_rigid_limits;

/* ---- parameters: all can change between steps ---- */

typedef enum ll_continuous {
    LL_CONTINUOUS_OFF,
    LL_CONTINUOUS_SPECULATIVE, /* contacts are made ahead, as far as bodies move in a step */
    LL_CONTINUOUS_SWEPT,       /* CCD: a fast body is put where it first touched */
    LL_CONTINUOUS_KINDS
} ll_continuous;

typedef enum ll_simd { LL_SIMD_AUTO, LL_SIMD_SCALAR, LL_SIMD_SSE2, LL_SIMD_AVX2, LL_SIMDS } ll_simd;

/* Names, ranges and defaults: ll_rigid_table. */
typedef struct ll_rigid_params {
    double gravity_x, gravity_y;  /* m/s^2 */
    int32_t solver;               /* index into ll_rigid_solvers */
    int32_t continuous;           /* ll_continuous */
    int32_t bounding_volume;      /* ll_volume that collides instead of the shapes; needs limits.volumes */
    int32_t simd;                 /* ll_simd; auto: the widest of the CPU */
    int64_t substeps;             /* of solvers with substeps */
    int64_t iterations;           /* over the velocities, of solvers that iterate */
    int64_t position_iterations;  /* over the positions, of pgs_ngs */
    double contact_hertz;         /* stiffness of contacts; at most an eighth of the substep rate is used */
    double contact_damping_ratio; /* damping ratio */
    double contact_push_speed;    /* m/s: largest speed at which an overlap is pushed apart */
    double joint_hertz;           /* at most a quarter of the substep rate is used */
    double joint_damping_ratio;   /* damping ratio */
    double baumgarte;             /* fraction of an overlap that pgs corrects per step */
    double restitution_threshold; /* m/s: slower impacts do not bounce */
    double recycle_distance; /* m: largest relative motion of two bodies at which their manifold is kept */
    double sleep_threshold;  /* m/s: slower bodies may sleep after half a second */
    bool warm_start, recycle, sleep;
    bool reserved[5]; /* no padding: configurations are compared byte by byte */
} ll_rigid_params;

extern const ll_param_table ll_rigid_table;
extern const ll_param_table ll_rigid_solver_table; /* without gravity */

/* ---- making ---- */

ll_status ll_rigid_check(const ll_rigid_limits *limits); /* ranges */
size_t ll_rigid_size(const ll_rigid_limits *limits);     /* bytes of the block */
/* Size of the part at the block's beginning that a snapshot must hold; the rest is rewritten in each step. */
size_t ll_rigid_state_size(const ll_rigid *world);

/* `block` has ll_rigid_size bytes, aligned to 16. The world is at its beginning. */
ll_rigid *ll_rigid_init(void *block, const ll_rigid_limits *limits, const ll_rigid_params *params);
ll_status ll_rigid_set_params(ll_rigid *world, const ll_rigid_params *params);
const ll_rigid_params *ll_rigid_get_params(const ll_rigid *world);
void ll_rigid_set_broad(ll_rigid *world, ll_broad_kind broad); /* needs limits.broads; keeps the pairs */

typedef enum ll_body_type { LL_BODY_STATIC, LL_BODY_KINEMATIC, LL_BODY_DYNAMIC, LL_BODY_TYPES } ll_body_type;
extern const char *const ll_body_type_names[LL_BODY_TYPES + 1];

typedef struct ll_body_def {
    int32_t type;   /* ll_body_type */
    int32_t bullet; /* 1: continuous collision detection against all dynamic bodies */
    ll_vec2 position;
    double angle;
    ll_vec2 velocity;
    double angular_velocity;         /* rad/s */
    double gravity_scale;            /* 1 */
    double damping, angular_damping; /* 1/s */
    int32_t may_sleep, fixed_rotation;
} ll_body_def;

ll_body_def ll_body_defaults(ll_body_type type);

typedef struct ll_material {
    double density; /* kg/m^2 */
    double friction, restitution;
    uint32_t category, mask; /* two shapes collide if each one's category is in the other's mask */
    int32_t group;           /* shapes of the same group other than 0 never collide */
} ll_material;

ll_material ll_material_defaults(void); /* density 1, friction 0.6, restitution 0, collides with all */

ll_status ll_rigid_add_body(ll_rigid *world, const ll_body_def *def, ll_body_id *out);
/* Adds a shape in the body frame, and its mass to the body's. */
ll_status ll_rigid_add_shape(ll_rigid *world, ll_body_id body, const ll_geometry *shape,
                             const ll_material *material);
/* A chain of at least 4 points. If open, the first and the last are ghost vertices and collide with
 * nothing. */
ll_status ll_rigid_add_chain(ll_rigid *world, ll_body_id body, const ll_vec2 *points, int count, bool loop,
                             const ll_material *material);
/* Replaces the shapes' mass and inertia; both finite and above zero. */
ll_status ll_rigid_set_mass(ll_rigid *world, ll_body_id body, double mass, double inertia);
ll_status ll_rigid_remove_body(ll_rigid *world, ll_body_id body);

/* ---- bodies ---- */

typedef struct ll_body_state {
    ll_vec2 position; /* of the body frame's origin */
    double angle;     /* not wrapped */
    ll_vec2 velocity; /* of the centre of mass */
    double angular_velocity;
    ll_vec2 centre; /* of mass, in the world */
    double mass, inertia;
    int32_t type;
    int32_t awake;
} ll_body_state;

ll_status ll_rigid_get_body(const ll_rigid *world, ll_body_id body, ll_body_state *out);
ll_body_id ll_rigid_body_at(const ll_rigid *world,
                            int32_t index); /* false if free; index from 0 to body_end - 1 */
int32_t ll_rigid_body_end(const ll_rigid *world);
/* Moves the body at once, without collision detection on the way. */
ll_status ll_rigid_set_pose(ll_rigid *world, ll_body_id body, ll_vec2 position, double angle);
ll_status ll_rigid_set_velocity(ll_rigid *world, ll_body_id body, ll_vec2 velocity, double spin);
/* Adds to the forces of the next step: N at the centre of mass, and N m. */
ll_status ll_rigid_apply_force(ll_rigid *world, ll_body_id body, ll_vec2 force, double torque);
ll_status ll_rigid_apply_impulse(ll_rigid *world, ll_body_id body, ll_vec2 impulse, ll_vec2 at);

/* ---- joints ---- */

typedef enum ll_joint_type {
    LL_JOINT_DISTANCE,  /* anchors `length` apart; with `rope` at most; with `hertz` a spring */
    LL_JOINT_REVOLUTE,  /* anchors together; with limits of the angle, and a motor */
    LL_JOINT_PRISMATIC, /* b moves along `axis` without rotation; with limits and a motor */
    LL_JOINT_WELD,      /* no relative motion; with `hertz` springs */
    LL_JOINT_MOUSE,     /* a spring of at most `max_force` pulls b's anchor to `target` */
    LL_JOINT_MOTOR, /* drives b at the angular velocity `motor_speed`, and holds its offset with max_force */
    LL_JOINT_FRICTION, /* b slides and rotates on a, against at most max_force and max_torque */
    LL_JOINT_TYPES
} ll_joint_type;

extern const char *const ll_joint_type_names[LL_JOINT_TYPES + 1];

typedef struct ll_joint_def {
    int32_t type;    /* ll_joint_type */
    int32_t collide; /* 1: the two bodies collide */
    ll_body_id a, b;
    ll_vec2 anchor_a, anchor_b; /* in the body frames */
    ll_vec2 axis;               /* in a's frame */
    double angle;               /* of b relative to a at rest */
    double length;
    double lower, upper;          /* m or rad */
    double hertz, damping;        /* 0: params.joint_hertz */
    double motor_speed;           /* m/s or rad/s */
    double max_force, max_torque; /* of mouse, motor and friction joints: N, N m */
    ll_vec2 target;               /* of a mouse joint, in the world */
    int32_t limited, motored, rope, pad;
} ll_joint_def;

/* All zero but the bodies, and angle and length from the current poses. */
ll_joint_def ll_joint_defaults(const ll_rigid *world, ll_joint_type type, ll_body_id a, ll_body_id b,
                               ll_vec2 anchor);
ll_status ll_rigid_add_joint(ll_rigid *world, const ll_joint_def *def, ll_joint_id *out);
ll_status ll_rigid_remove_joint(ll_rigid *world, ll_joint_id joint);
ll_status ll_rigid_set_target(ll_rigid *world, ll_joint_id joint, ll_vec2 target); /* of a mouse joint */

/* ---- stepping ---- */

typedef enum ll_rigid_phase {
    LL_PHASE_BROAD,
    LL_PHASE_NARROW,
    LL_PHASE_SOLVE,
    LL_PHASE_CONTINUOUS,
    LL_PHASE_FINISH, /* poses, boxes, sleeping */
    LL_PHASES
} ll_rigid_phase;

extern const char *const ll_rigid_phase_names[LL_PHASES + 1];

/* Called at the end of each phase, to measure times. NULL costs nothing. */
typedef struct ll_rigid_probe {
    void (*ended)(void *context, ll_rigid_phase phase);
    void *context;
} ll_rigid_probe;

/* One step of `dt` seconds, 1e-5 to 1. LL_DIVERGED: the pose or velocity of the named body is not finite or
 * beyond LL_WORLD_MAX; the world cannot be used any more. LL_LIMIT: more contacts than the limit; the step
 * was made without the excess ones. */
ll_status ll_rigid_step(ll_rigid *world, double dt, const ll_rigid_probe *probe);

/* The same by the threads of a team, with the same bits for every number of threads. In parts are done: the
 * search for pairs, manifolds, contacts of the soft step solver, times of impact, poses and boxes. One thread
 * does what has an order: contacts that come and go, joints, bounces, bullets, sleep, and all of the other
 * solvers. Worlds of a few hundred bodies gain nothing. NULL: one thread. */
ll_status ll_rigid_step_by_team(ll_rigid *world, double dt, const ll_rigid_probe *probe, ll_team *team);

/* Equal for equal histories, for every SIMD width and broad phase. */
uint64_t ll_rigid_hash(const ll_rigid *world);

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: it is a part of the block */
typedef struct ll_rigid_stats {
    int64_t step;
    int32_t bodies, awake, joints;
    int32_t pairs;    /* overlapping boxes: allocated contacts */
    int32_t touching; /* contacts with a manifold */
    int32_t points;
    int32_t recycled; /* manifolds recycled in the last step */
    int32_t tested;   /* pairs computed by the narrow phase in the last step */
    int32_t colours;  /* graph colours in use */
    int32_t overflow; /* contacts without a colour, solved one by one */
    int32_t swept;    /* bodies swept by CCD in the last step */
    int32_t stopped;  /* of these, stopped at an impact */
    int32_t islands;  /* at the last check for sleeping */
    int32_t reserved;
} ll_rigid_stats;
#pragma GCC diagnostic pop

ll_rigid_stats ll_rigid_get_stats(const ll_rigid *world);

/* ---- queries ---- */

typedef struct ll_contact_view {
    ll_body_id a, b;
    ll_vec2 normal; /* from a to b */
    int32_t count;
    int32_t recycled;
    struct {
        ll_vec2 point;
        double separation;
        double impulse, friction_impulse; /* N s, of the last (sub)step */
    } at[2];
} ll_contact_view;

int32_t ll_rigid_contact_end(const ll_rigid *world);
bool ll_rigid_contact_at(const ll_rigid *world, int32_t index,
                         ll_contact_view *out); /* false if not touching */

/* The bodies of a contact, touching or not: their boxes overlap. False if there is none. */
bool ll_rigid_pair_at(const ll_rigid *world, int32_t index, ll_body_id *a, ll_body_id *b);

typedef struct ll_joint_view {
    ll_joint_id id;
    int32_t type; /* ll_joint_type */
    ll_body_id a, b;
    ll_vec2 anchor_a, anchor_b; /* in the world; anchor_a of a mouse joint is its target */
} ll_joint_view;

int32_t ll_rigid_joint_end(const ll_rigid *world);
bool ll_rigid_joint_at(const ll_rigid *world, int32_t index, ll_joint_view *out); /* false if free */

typedef struct ll_shape_view {
    ll_body_id body;
    ll_geometry geometry; /* in the frame of `pose` */
    ll_pose pose;
    ll_aabb box; /* of the broad phase */
} ll_shape_view;

int32_t ll_rigid_shape_end(const ll_rigid *world);
bool ll_rigid_shape_at(const ll_rigid *world, int32_t index, ll_shape_view *out);

ll_body_id ll_rigid_pick(const ll_rigid *world, ll_vec2 point); /* dynamic body at the point, or none */

/* Checks every invariant of the block, for LL_VALIDATE and tests. */
bool ll_rigid_valid(const ll_rigid *world);

/* ---- solvers ---- */

/* The table of solvers: LL_SOLVER_KIND, and the name of a constant ll_solver_NAME that a file of rigid/solver
 * defines. */
/* clang-format off */
#define LL_RIGID_SOLVERS(ROW) \
    ROW(IMPULSE, impulse) \
    ROW(PGS, pgs) \
    ROW(PGS_NGS, pgs_ngs) \
    ROW(SOFT_STEP, soft_step) \
    ROW(TGS_STICKY, tgs_sticky) \
    ROW(XPBD, xpbd) \
    ROW(AVBD, avbd)
/* clang-format on */

#define LL_SOLVER_KIND(KIND, NAME) LL_SOLVER_##KIND,
typedef enum ll_rigid_solver_kind { LL_RIGID_SOLVERS(LL_SOLVER_KIND) LL_SOLVERS } ll_rigid_solver_kind;
#undef LL_SOLVER_KIND

extern const char *const ll_rigid_solver_names[LL_SOLVERS + 1]; /* NULL-terminated */
double ll_rigid_passes(const ll_rigid_params *params);          /* over contacts and joints per step */
const char *ll_rigid_solver_help(ll_rigid_solver_kind kind);    /* method, cost and source */
