/* Contact solvers and what they share.
 *
 * A solver does one step of the world: it changes the velocities, moves the bodies (in `ll_solver_body`;
 * poses are written when the step is finished) and stores the impulses in the contacts. Each is one file and
 * one row of the table. */
#pragma once

#include "base/team.h"
#include "rigid/joint/joint.h"

enum { LL_PER_STEP, LL_PER_SUBSTEP, LL_PER_ITERATION, LL_PER_POSITION_ITERATION, LL_PASSES };

typedef struct ll_solver {
    const char *name;
    const char *help;         /* method, cost in passes over contacts, source */
    double passes[LL_PASSES]; /* passes as numbers: per step, and per unit of each count */
    size_t (*size)(const ll_rigid_limits *limits); /* bytes of solver memory, a multiple of 64 */
    void (*solve)(ll_rigid *world, ll_team *team); /* NULL, or threads that a solver may use */
} ll_solver;

#define LL_SOLVER_DECLARE(KIND, NAME) extern const ll_solver ll_solver_##NAME;
LL_RIGID_SOLVERS(LL_SOLVER_DECLARE)
#undef LL_SOLVER_DECLARE

extern const ll_solver *const ll_solvers[LL_SOLVERS];

/* A spring and damper, integrated by an implicit Euler step of h (Catto, "Soft Constraints", GDC 2011). */
typedef struct ll_softness {
    double bias_rate, mass_scale, impulse_scale;
} ll_softness;

ll_softness ll_soft(double hertz, double damping, double h);

/* ---- groups: parts of the awake world that do not affect each other within a step ---- */

typedef struct ll_index_list {
    const int32_t *at; /* indices */
    int32_t count;
    int32_t first; /* of contacts: how many are in the groups before this one */
} ll_index_list;

typedef struct ll_group {
    ll_index_list bodies, contacts, joints; /* may include contacts that do not touch, and sleeping joints */
} ll_group;

typedef struct ll_groups { /* in the memory of `group`, valid until the end of the step */
    int32_t *parent, *of;  /* per body; `of`: its group */
    int32_t *bodies, *contacts, *joints;
    int32_t *body_end, *contact_end, *joint_end; /* per group, into the three arrays above */
    int32_t count, pad;
} ll_groups;

size_t ll_groups_size(const ll_rigid_limits *limits); /* bytes */
ll_group ll_whole(const ll_rigid *w);                 /* the awake world */

/* Groups of whole islands that fit the cache. Each group keeps the order of the whole world, so that solving
 * group after group gives the same bits as solving the world at once. */
ll_groups ll_group_islands(ll_rigid *w, ll_team *team);
ll_group ll_group_at(const ll_rigid *w, const ll_groups *groups, int32_t i);

/* ---- bodies ---- */

void ll_prepare_body_steps(ll_rigid *w, ll_index_list bodies,
                           double h); /* fills `body_step`, for substeps of h */
void ll_integrate_velocities(ll_rigid *w, ll_index_list bodies, double h);
void ll_integrate_positions(ll_rigid *w, ll_index_list bodies, double h);

/* ---- contacts, one by one ---- */

/* Where the contacts of a colour are behind the first of `order`; known for the colours in `used` alone, a
 * bit each. */
typedef struct ll_colour_spans {
    uint64_t used;
    int32_t begin[LL_COLOUR_SLOTS], end[LL_COLOUR_SLOTS];
} ll_colour_spans;

typedef struct ll_contact_counts { /* for the step's statistics */
    uint64_t colours;
    int32_t points, touching, overflow, pad;
} ll_contact_counts;

/* Sorts touching contacts by colour into `order` from contacts.first on, as `spans` says. Uses as many bytes
 * of `scratch`. Threads may do this for different groups at the same time. */
ll_contact_counts ll_order_contacts(const ll_rigid *w, ll_team *team, ll_index_list contacts,
                                    ll_colour_spans *spans);
void ll_count_contacts(ll_rigid *w, const ll_contact_counts *counts); /* adds to the statistics */

typedef struct ll_contact_constraint_point { /* contact point; normal and anchors rotate with their bodies */
    ll_vec2 ra, rb; /* anchors from the centres of mass, at the beginning of the step */
    double adjust;  /* separation = n . (relative motion of the anchors) + adjust */
    double normal_mass, tangent_mass;
    double normal_impulse, tangent_impulse;
    double before; /* xpbd: normal velocity before overlaps were corrected */
} ll_contact_constraint_point;

typedef struct ll_contact_constraint {
    int32_t contact, a, b, count;
    double ma, ia, mb, ib; /* inverse masses and moments */
    double friction, restitution;
    ll_vec2 n;
    int32_t fixed, pad; /* one of the bodies is immovable */
    ll_contact_constraint_point at[2];
} ll_contact_constraint;

typedef struct ll_contact_constraints {
    ll_contact_constraint *at;
    int32_t count;
} ll_contact_constraints;

size_t ll_contact_constraints_size(const ll_rigid_limits *limits);
ll_contact_constraints
ll_prepare_contacts(ll_rigid *w); /* into the solver's memory, with the impulses of the last step */
void ll_store_contacts(ll_rigid *w, ll_contact_constraints rows);
void ll_warm_start_contacts(ll_rigid *w, ll_contact_constraints rows);
double ll_constraint_separation(const ll_rigid *w, const ll_contact_constraint *row,
                                const ll_contact_constraint_point *cp); /* at the current positions */

/* Change of the velocity along `axis` (normal or tangent) at one point by an impulse at the other. */
static inline double ll_coupling(const ll_contact_constraint *r, ll_vec2 axis)
{
    return r->ma + r->mb + r->ia * ll_cross(r->at[0].ra, axis) * ll_cross(r->at[1].ra, axis) +
           r->ib * ll_cross(r->at[0].rb, axis) * ll_cross(r->at[1].rb, axis);
}

static inline double ll_clamped_sum(double sum, double mass, double v, double low, double high)
{
    return ll_min(ll_max(sum - mass * v, low), high);
}

/* Accumulated impulses of both points that remove the velocities `v`, each within its bounds: the mean of
 * solving the first before the second and the second before the first. Gauss-Seidel in one order prefers a
 * point and tilts a column of boxes that is exactly symmetric. */
static inline void ll_solve_both(const double v[2], const double mass[2], double coupling,
                                 const double low[2], const double high[2], double sum[2])
{
    double a = ll_clamped_sum(sum[0], mass[0], v[0], low[0], high[0]);
    double b = ll_clamped_sum(sum[1], mass[1], v[1], low[1], high[1]);
    double a_then = ll_clamped_sum(sum[0], mass[0], v[0] + coupling * (b - sum[1]), low[0], high[0]);
    double b_then = ll_clamped_sum(sum[1], mass[1], v[1] + coupling * (a - sum[0]), low[1], high[1]);
    sum[0] = 0.5 * (a + a_then);
    sum[1] = 0.5 * (b + b_then);
}

/* ---- impacts with restitution; see bounce.c ---- */

typedef struct ll_bounce_row ll_bounce_row;

typedef struct ll_bounces {
    ll_rigid *world;
    ll_team *team;
    int32_t *at; /* indices of contacts, in the memory of `order` */
    int32_t count, room;
    uint32_t *marked;    /* a bit for each: to be tried */
    ll_bounce_row *rows; /* of each; NULL: there are more than `room` */
    bool crowded;
} ll_bounces;

/* Contacts that may bounce in this step. Call after ll_prepare_body_steps and after the last use of `order`.
 * `memory`: free until ll_end_bounces, or NULL; it makes no difference to the results. */
ll_bounces ll_begin_bounces(ll_rigid *w, ll_team *team, ll_index_list contacts, void *memory, size_t bytes);
/* Whether more contacts of the whole world may bounce than can be followed through rows. For a solver that
 * solves groups one after the other: the groups must not decide each for itself. h: a substep. */
bool ll_bounces_crowded(ll_rigid *w, double h);
/* Call before velocities and positions of a substep of h change. Reverses what would meet within `reach`
 * seconds: h, or 2 h if contacts are solved again after the bodies moved, which would slow them down. */
void ll_bounce(ll_rigid *w, ll_bounces *bounces, double h, double reach);
void ll_end_bounces(ll_rigid *w, const ll_bounces *bounces);

/* Projected Gauss-Seidel on velocities, for pgs and pgs_ngs: all of the step but the positions. */
ll_contact_constraints ll_pgs_velocities(ll_rigid *w, double baumgarte);

static inline void ll_apply_contact_impulse(ll_solver_body *a, ll_solver_body *b,
                                            const ll_contact_constraint *r,
                                            const ll_contact_constraint_point *cp, ll_vec2 impulse)
{
    a->v = ll_madd(a->v, -r->ma, impulse);
    a->w -= r->ia * ll_cross(cp->ra, impulse);
    b->v = ll_madd(b->v, r->mb, impulse);
    b->w += r->ib * ll_cross(cp->rb, impulse);
}

static inline ll_vec2 ll_relative(const ll_solver_body *a, const ll_solver_body *b,
                                  const ll_contact_constraint_point *cp)
{
    return ll_sub(ll_add(b->v, ll_cross_sv(b->w, cp->rb)), ll_add(a->v, ll_cross_sv(a->w, cp->ra)));
}

/* ---- joints, one by one ---- */

/* joint_rows.c; limits and motor of a revolute joint are separate, since few joints have them. */
typedef struct ll_revolute_sim ll_revolute_sim;
typedef struct ll_revolute_limits ll_revolute_limits;
size_t ll_revolute_sim_size(void);
size_t ll_revolute_limits_size(void);

static inline ll_revolute_sim *ll_revolute_sims(const ll_rigid *w)
{
    return (ll_revolute_sim *)(void *)((char *)(uintptr_t)w + w->at.revolute);
}

static inline ll_revolute_limits *ll_revolute_limit_sets(const ll_rigid *w)
{
    return (ll_revolute_limits *)(void *)((char *)(uintptr_t)w + w->at.revolute_limits);
}

typedef struct ll_joint_set { /* joints of a group in this step */
    ll_revolute_sim *revolutes;
    ll_revolute_limits *revolute_limits; /* of those with limits or a motor */
    int32_t *others;                     /* indices */
    int32_t revolute_count, revolute_limits_count, other_count, pad;
} ll_joint_set;

ll_joint_set ll_prepare_joints(ll_rigid *w, ll_index_list joints); /* uses `scratch` until ll_store_joints */
void ll_store_joints(ll_rigid *w, const ll_joint_set *set);
void ll_warm_start_joints(ll_rigid *w, const ll_joint_set *set);
/* One pass over the rows of all joints; with `bias` it also corrects positions. Returns whether an impulse
 * changed. */
bool ll_solve_joints(ll_rigid *w, const ll_joint_set *set, double h, ll_softness stiff, bool bias);
void ll_clear_joint_impulses(ll_rigid *w);

ll_pose ll_pose_now(const ll_rigid *w, int32_t body);          /* pose including this step's motion so far */
double ll_angle_now(const ll_rigid *w, const ll_joint *joint); /* of b relative to a */
