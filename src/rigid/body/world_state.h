/* What the files of this room share: the block's arrays and the stages of a step.
 *
 * Body slots count from 0. Arrays are split by temperature: `pose` and `motion` are what a step streams
 * through, `body` is what it rarely needs. */
#pragma once

#include <assert.h>

#include "rigid/shape/manifold.h"
#include "rigid/body/rigid.h"

#define LL_NONE (-1)

/* Shapes nearer than the sum of both bodies' shares make a contact: stacks stay quiet when points do not come
 * and go. Of small bodies the share is a quarter of their core. */
#define LL_MARGIN_SHARE (2 * LL_LINEAR_SLOP)

/* Seconds of rest before sleep. */
#define LL_SLEEP_TIME 0.5

/* A contact takes the lowest colour that neither body has. Those with something that cannot be moved take
 * theirs from the upper ones and are solved last, so that what stands on the ground is not pushed into it. */
#define LL_COLOURS_DYNAMIC 44
#define LL_COLOURS 60
#define LL_OVERFLOW_DYNAMIC LL_COLOURS
#define LL_OVERFLOW_STATIC (LL_COLOURS + 1)
#define LL_COLOUR_SLOTS (LL_COLOURS + 2)

typedef struct ll_body {
    double angle;
    double mass, inertia, inv_mass, inv_inertia;
    ll_vec2 origin; /* of the body's frame, seen from the centre of mass */
    double gravity_scale, damping, spin_damping;
    ll_vec2 force;
    double torque;
    double sleep_time;
    double drift;     /* how far any point may have gone since its boxes were made */
    double slack;     /* and how far it may go */
    double extent;    /* the farthest point from the centre of mass */
    double core;      /* of its smallest shape */
    double margin;    /* its share of the distance at which contacts are made */
    uint64_t colours; /* taken by contacts of this body */
    uint32_t generation;
    int32_t type;                  /* ll_body_type; LL_NONE when free */
    int32_t shape, contact, joint; /* heads of lists; a contact's or joint's number times 2 plus the side */
    int32_t awake;                 /* place in the awake list, or LL_NONE */
    int32_t island; /* the next of those that sleep together; of a free slot: the next free one */
    int32_t may_sleep, fixed_rotation, bullet;
} ll_body;

/* A step's velocities and what it has moved so far: a cache line. */
typedef struct ll_motion {
    ll_vec2 v;
    double w;
    ll_vec2 d;   /* moved by */
    ll_rot q;    /* turned by */
    double turn; /* as an angle */
} ll_motion;

/* What the narrow phase and the solvers ask of a body for each contact: a copy, packed. */
typedef struct ll_trait {
    double inv_mass, inv_inertia, core, margin;
} ll_trait;

typedef struct ll_shape {
    ll_vec2 centre; /* a circle's; of all in the frame of the centre of mass */
    double radius;
    double friction, restitution, density, core;
    int32_t body; /* LL_NONE when free */
    int32_t next; /* of the body; of a free slot: the next free one */
    int32_t hull; /* LL_NONE for a circle */
    uint32_t category, mask;
    int32_t group;
} ll_shape;

/* All as it was when the manifold was made, in the world's directions. A recycled contact keeps normal and
 * arms: were they to lean with their bodies, a pile on soft contacts would buckle like a row of springs. Its
 * separation follows the bodies. */
typedef struct ll_contact_point {
    ll_vec2 a, b; /* from both centres of mass */
    double separation;
    double normal_impulse, tangent_impulse;
    uint32_t id;
    float penalty; /* avbd: N/m */
} ll_contact_point;

typedef struct ll_contact {
    int32_t shape[2], body[2];    /* LL_NONE in shape[0] when free */
    int32_t next[2], previous[2]; /* in the lists of the bodies: number times 2 plus side */
    int32_t awake;                /* place in the awake list, or LL_NONE; of a free slot: the next free one */
    int32_t colour;               /* LL_NONE when not touching */
    int32_t count;                /* points */
    int32_t recycled; /* 1: the manifold was kept; bounce.c marks others in the course of a step */
    double friction, restitution;
    ll_vec2 normal;
    ll_vec2 rel; /* b's centre seen from a */
    ll_rot turned[2];
    ll_contact_point at[2];
} ll_contact;

typedef struct ll_joint {
    ll_joint_def def; /* anchors in the frames of the centres of mass */
    int32_t body[2];  /* LL_NONE in [0] when free */
    int32_t next[2], previous[2];
    uint32_t generation;
    int32_t free;
    double impulse[6];           /* of the rows; a row keeps its number */
    double penalty[6], force[6]; /* avbd */
} ll_joint;

typedef struct ll_known { /* a pair that has a contact; LL_NONE: an empty place */
    int32_t a, b;
} ll_known;

/* What drives a body in this step, the impulses that its contacts hold it with, and what it is swept into. */
typedef struct ll_drive {
    ll_vec2 a;
    double spin;            /* rad/s^2 */
    double keep, keep_spin; /* of the velocity in a substep */
    ll_vec2 held;
    double held_spin;
    double touch;    /* share of the step; 1: never, negative: it is not swept */
    int32_t stopper; /* body, or LL_NONE; itself: it has met another and stays where that was */
    int32_t pad;
} ll_drive;

/* What makes two bodies hang together: a contact that touches, or a joint. */
typedef struct ll_link {
    int32_t number, body[2];
} ll_link;

typedef struct ll_rigid_layout { /* offsets from the block's beginning */
    size_t broad, pose, motion, trait, body, shape, box, moved, moved_list, hull, bound, contact, table,
        joint;
    size_t awake, awake_contact;
    size_t state_end;
    size_t drive, pair, order, scratch, group, hinge, turning, link, solver;
    size_t end;
} ll_rigid_layout;

struct ll_rigid {
    ll_rigid_limits limits;
    ll_rigid_params params;
    ll_rigid_layout at;
    ll_rigid_stats stats;
    double dt;
    uint64_t colours;    /* of the contacts of the last step */
    int64_t whole_until; /* step; before it islands are not grouped */
    int32_t free_body, free_shape, free_hull, free_contact, free_joint;
    int32_t body_end, shape_end, hull_end, contact_end, joint_end;
    int32_t bodies, contacts, joints;
    int32_t awake, awake_contacts, moved;
    int32_t table_mask;
    int32_t bouncing; /* contacts with restitution */
    int32_t bullets;  /* bodies */
    int32_t pad[9];
};

#define LL_ARRAY(type, name)                                                                                 \
    static inline type *ll_##name##s(const ll_rigid *w)                                                      \
    {                                                                                                        \
        return (type *)((char *)(uintptr_t)w + w->at.name);                                                  \
    }
LL_ARRAY(ll_pose, pose)
LL_ARRAY(ll_motion, motion)
LL_ARRAY(ll_trait, trait)
LL_ARRAY(ll_body, body)
LL_ARRAY(ll_shape, shape)
LL_ARRAY(ll_aabb, box)
LL_ARRAY(uint8_t, moved)
LL_ARRAY(int32_t, moved_list)
LL_ARRAY(ll_geometry, hull)
LL_ARRAY(ll_geometry, bound)
LL_ARRAY(ll_contact, contact)
LL_ARRAY(ll_known, table)
LL_ARRAY(ll_joint, joint)
LL_ARRAY(int32_t, awake)
LL_ARRAY(int32_t, awake_contact)
LL_ARRAY(ll_drive, drive)
LL_ARRAY(int32_t, order)
LL_ARRAY(int32_t, scratch)
LL_ARRAY(ll_proxy_pair, pair)
LL_ARRAY(ll_link, link)
#undef LL_ARRAY

/* What two bodies have moved since a contact's manifold was made. */
typedef struct ll_since {
    ll_vec2 gap; /* between the centres, now */
    ll_rot a, b;
} ll_since;

static inline ll_since ll_since_made(const ll_rigid *w, const ll_contact *c)
{
    const ll_pose *a = &ll_poses(w)[c->body[0]], *b = &ll_poses(w)[c->body[1]];
    return (ll_since){ll_sub(b->p, a->p), ll_rot_between(c->turned[0], a->q),
                      ll_rot_between(c->turned[1], b->q)};
}

/* From where the point has gone with a to where it has gone with b. */
static inline ll_vec2 ll_point_gap(const ll_contact_point *p, const ll_since *s)
{
    return ll_add(s->gap, ll_sub(ll_rotate(s->b, p->b), ll_rotate(s->a, p->a)));
}

/* Asks the cache for a contact that is soon needed. */
static inline void ll_prefetch_contact(const ll_contact *c)
{
    for (size_t at = 0; at < sizeof *c; at += 64)
        __builtin_prefetch((const char *)c + at);
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

/* A shape's geometry: a hull of the pool, or `circle` filled in. */
const ll_geometry *ll_geometry_of(const ll_rigid *w, const ll_shape *shape, ll_geometry *circle);
ll_aabb ll_tight_box(const ll_rigid *w, const ll_shape *shape, ll_pose pose);
void ll_refresh_boxes(ll_rigid *w, int32_t body); /* of the broad phase, around the present pose */
void ll_mark_moved(ll_rigid *w, int32_t shape);
void ll_bound_shapes(ll_rigid *w, int32_t body); /* the volumes of its shapes, as params.volume asks */
ll_status ll_body_slot(const ll_rigid *w, ll_body_id id, int32_t *slot); /* an id that is stale is an error */
/* Whether all of them are finite and at most so large; the error names the field. */
ll_status ll_check_numbers(int count, const char *const *fields, const double *values, double most);

/* ---- awake.c ---- */

void ll_put_in_awake_list(ll_rigid *w, int32_t body);
void ll_take_from_awake_list(ll_rigid *w, int32_t body);
