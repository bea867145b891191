/* Shared by the files of this room: the block's arrays and the stages of a step.
 *
 * Body slots count from 0. Arrays are split by how often they are used: `pose` and `solver_body` are streamed
 * through in each step, `body` is needed rarely. */
#pragma once

#include <assert.h>

#include "rigid/body/rigid.h"
#include "rigid/shape/manifold.h"

#define LL_NONE (-1)

/* Contact margin: shapes nearer than the sum of both bodies' margins make a contact, so that points do not
 * come and go in resting stacks. The margin of a small body is a quarter of its core. */
#define LL_MARGIN_SHARE (2 * LL_LINEAR_SLOP)

/* s of rest before a body may sleep */
#define LL_SLEEP_TIME 0.5

/* A contact takes the lowest colour that neither body has. Contacts with an immovable body use the upper
 * colours and are solved last, so that bodies on the ground are not pushed into it. */
#define LL_COLOURS_DYNAMIC 44
#define LL_COLOURS 60
#define LL_OVERFLOW_DYNAMIC LL_COLOURS
#define LL_OVERFLOW_STATIC (LL_COLOURS + 1)
#define LL_COLOUR_SLOTS (LL_COLOURS + 2)

typedef struct ll_body {
    double angle;
    double mass, inertia, inv_mass, inv_inertia;
    ll_vec2 origin; /* body frame's origin relative to the centre of mass */
    double gravity_scale, damping, angular_damping;
    ll_vec2 force;
    double torque;
    double sleep_time;
    double drift;     /* bound of any point's motion since its boxes were made */
    double slack;     /* largest allowed drift */
    double extent;    /* distance of the farthest point from the centre of mass */
    double core;      /* of its smallest shape */
    double margin;    /* its contact margin, m */
    uint64_t colours; /* used by contacts of this body */
    uint32_t generation;
    int32_t type;                  /* ll_body_type; LL_NONE when free */
    int32_t shape, contact, joint; /* heads of lists; index of a contact or joint times 2 plus the side */
    int32_t awake;                 /* index in the awake list, or LL_NONE */
    int32_t island; /* next body of the same sleeping island; of a free slot: the next free one */
    int32_t may_sleep, fixed_rotation, bullet;
} ll_body;

/* Velocity of a body and what it has moved in this step: a cache line. */
typedef struct ll_solver_body {
    ll_vec2 v;
    double w;
    ll_vec2 d;   /* translation */
    ll_rot q;    /* rotation */
    double turn; /* the same as an angle */
} ll_solver_body;

/* What the narrow phase and the solvers need of a body for each contact: a packed copy. */
typedef struct ll_body_sim {
    double inv_mass, inv_inertia, core, margin;
} ll_body_sim;

typedef struct ll_shape {
    ll_vec2 centre; /* of a circle; all shapes are in the frame of the centre of mass */
    double radius;
    double friction, restitution, density, core;
    int32_t body; /* LL_NONE when free */
    int32_t next; /* of the body; of a free slot: the next free one */
    int32_t hull; /* LL_NONE for a circle */
    uint32_t category, mask;
    int32_t group;
} ll_shape;

/* State at the time the manifold was made, in world directions. A recycled contact keeps its normal and
 * anchors: if they rotated with their bodies, a pile on soft contacts would buckle like a row of springs. Its
 * separation follows the bodies. */
typedef struct ll_contact_point {
    ll_vec2 a, b; /* anchors, from both centres of mass */
    double separation;
    double normal_impulse, tangent_impulse;
    uint32_t id;
    float penalty; /* avbd: N/m */
} ll_contact_point;

typedef struct ll_contact {
    int32_t shape[2], body[2];    /* LL_NONE in shape[0] when free */
    int32_t next[2], previous[2]; /* in the lists of both bodies: index times 2 plus side */
    int32_t awake;                /* index in the awake list, or LL_NONE; of a free slot: the next free one */
    int32_t colour;               /* LL_NONE when not touching */
    int32_t count;                /* points */
    int32_t recycled;             /* 1: the manifold was recycled; bounce.c sets other bits within a step */
    double friction, restitution;
    ll_vec2 normal;
    ll_vec2 rel; /* centre of b relative to a */
    ll_rot turned[2];
    ll_contact_point at[2];
} ll_contact;

typedef struct ll_joint {
    ll_joint_def def; /* anchors in the frames of the centres of mass */
    int32_t body[2];  /* LL_NONE in [0] when free */
    int32_t next[2], previous[2];
    uint32_t generation;
    int32_t free;
    double impulse[6];           /* of each row */
    double penalty[6], force[6]; /* for avbd */
} ll_joint;

typedef struct ll_pair_entry { /* a pair that has a contact; LL_NONE: empty */
    int32_t a, b;
} ll_pair_entry;

/* Accelerations of a body in this step, the impulses that its contacts hold it with, and its impact. */
typedef struct ll_body_step {
    ll_vec2 a;
    double angular_acceleration; /* rad/s^2 */
    double keep, keep_angular;   /* factor of the velocity per substep (damping) */
    ll_vec2 held;
    double held_angular;
    double touch;    /* time of impact as a fraction of the step; 1: none, negative: the body is not swept */
    int32_t stopper; /* body hit, or LL_NONE; the body itself: it stops where the impact is */
    int32_t rows;    /* bounce.c: the list of its rows */
} ll_body_step;

/* Connects two bodies of an island: a touching contact or a joint. */
typedef struct ll_island_edge {
    int32_t number, body[2];
} ll_island_edge;

typedef struct ll_rigid_layout { /* offsets from the block's beginning */
    size_t broad, pose, solver_body, body_sim, body, shape, box, moved, moved_list, hull, bound, contact,
        pair_set, joint;
    size_t awake, awake_contact;
    size_t state_end;
    size_t sink, body_step, pair, order, bounce_mark, scratch, group, revolute, revolute_limits, island_edge,
        solver;
    size_t end;
} ll_rigid_layout;

struct ll_rigid {
    ll_rigid_limits limits;
    ll_rigid_params params;
    ll_rigid_layout at;
    ll_rigid_stats stats;
    double dt;
    uint64_t colours;    /* of the contacts of the last step */
    int64_t whole_until; /* step number up to which islands are not grouped */
    int32_t free_body, free_shape, free_hull, free_contact, free_joint;
    int32_t body_end, shape_end, hull_end, contact_end, joint_end;
    int32_t bodies, contacts, joints;
    int32_t awake, awake_contacts, moved;
    int32_t pair_set_mask;
    int32_t bouncing; /* contacts with restitution */
    int32_t bullets;  /* bodies */
    int32_t pad[9];
};

#define LL_ARRAY(type, plural, name)                                                                         \
    static inline type *ll_##plural(const ll_rigid *w)                                                       \
    {                                                                                                        \
        return (type *)((char *)(uintptr_t)w + w->at.name);                                                  \
    }
LL_ARRAY(ll_pose, poses, pose)
LL_ARRAY(ll_solver_body, solver_bodies, solver_body)
LL_ARRAY(ll_body_sim, body_sims, body_sim)
LL_ARRAY(ll_body, bodies, body)
LL_ARRAY(ll_shape, shapes, shape)
LL_ARRAY(ll_aabb, boxes, box)
LL_ARRAY(uint8_t, moved_flags, moved)
LL_ARRAY(int32_t, moved_lists, moved_list)
LL_ARRAY(ll_geometry, hulls, hull)
LL_ARRAY(ll_geometry, bounds, bound)
LL_ARRAY(ll_contact, contacts, contact)
LL_ARRAY(ll_pair_entry, pair_entries, pair_set)
LL_ARRAY(ll_joint, joints, joint)
LL_ARRAY(int32_t, awake_bodies, awake)
LL_ARRAY(int32_t, awake_contacts, awake_contact)
LL_ARRAY(ll_body_step, body_steps, body_step)
LL_ARRAY(int32_t, orders, order)
LL_ARRAY(uint32_t, bounce_marks, bounce_mark)
LL_ARRAY(int32_t, scratch, scratch)
LL_ARRAY(ll_proxy_pair, pairs, pair)
LL_ARRAY(ll_island_edge, island_edges, island_edge)
#undef LL_ARRAY

/* Relative motion of two bodies since their contact's manifold was made. */
typedef struct ll_relative_motion {
    ll_vec2 gap; /* between the centres, now */
    ll_rot a, b;
} ll_relative_motion;

static inline ll_relative_motion ll_relative_motion_of(const ll_rigid *w, const ll_contact *c)
{
    const ll_pose *a = &ll_poses(w)[c->body[0]], *b = &ll_poses(w)[c->body[1]];
    return (ll_relative_motion){ll_sub(b->p, a->p), ll_rot_between(c->turned[0], a->q),
                                ll_rot_between(c->turned[1], b->q)};
}

/* Motion of the point with b relative to the point with a. */
static inline ll_vec2 ll_point_gap(const ll_contact_point *p, const ll_relative_motion *s)
{
    return ll_add(s->gap, ll_sub(ll_rotate(s->b, p->b), ll_rotate(s->a, p->a)));
}

/* Prefetches a contact. */
static inline void ll_prefetch_contact(const ll_contact *c)
{
    for (size_t at = 0; at < sizeof *c; at += 64)
        __builtin_prefetch((const char *)c + at);
}

/* Index among the solver bodies of a place for each part of a team, LL_TEAM_PARTS_MAX of them, which no body
 * has: what the parts would write to the same immovable bodies goes there. */
static inline int32_t ll_first_sink(const ll_rigid *w)
{
    return (int32_t)((w->at.sink - w->at.solver_body) / sizeof(ll_solver_body));
}

static inline void *ll_broad_state(const ll_rigid *w)
{
    return (char *)(uintptr_t)w + w->at.broad;
}

static inline void *ll_group_memory(const ll_rigid *w)
{
    return (char *)(uintptr_t)w + w->at.group;
}

static inline void *ll_solver_memory(const ll_rigid *w)
{
    return (char *)(uintptr_t)w + w->at.solver;
}

static inline const ll_broad_phase *ll_broad_of(const ll_rigid *w)
{
    return ll_broad_phases[w->limits.broad];
}

/* ---- body.c ---- */

/* Geometry of a shape: a hull of the pool, or `circle` filled in. */
const ll_geometry *ll_geometry_of(const ll_rigid *w, const ll_shape *shape, ll_geometry *circle);
ll_aabb ll_tight_box(const ll_rigid *w, const ll_shape *shape, ll_pose pose);
/* Broad-phase boxes around the current pose: renewed, which several threads may do for different bodies, and
 * then placed in the broad phase. */
void ll_renew_boxes(ll_rigid *w, int32_t body);
void ll_place_boxes(ll_rigid *w, int32_t body);
void ll_refresh_boxes(ll_rigid *w, int32_t body); /* both */
void ll_mark_moved(ll_rigid *w, int32_t shape);
void ll_bound_shapes(ll_rigid *w,
                     int32_t body); /* bounding volumes of its shapes, by params.bounding_volume */
ll_status ll_body_slot(const ll_rigid *w, ll_body_id id, int32_t *slot); /* error if the id is stale */
/* Whether all of them are finite and at most so large; the error names the field. */
ll_status ll_check_numbers(int count, const char *const *fields, const double *values, double most);

/* ---- awake.c ---- */

void ll_put_in_awake_list(ll_rigid *w, int32_t body);
void ll_take_from_awake_list(ll_rigid *w, int32_t body);
