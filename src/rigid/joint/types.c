/* Types of joints: the rows that each makes. */
#include "rigid/joint/joint.h"

/* ---- rows that types share ---- */

/* Keeps the anchors together. */
static void point_rows(const ll_joint *j, ll_pose a, ll_pose b, ll_constraint_row out[2])
{
    ll_vec2 ra = ll_rotate(a.q, j->def.anchor_a), rb = ll_rotate(b.q, j->def.anchor_b);
    ll_vec2 gap = ll_sub(ll_add(b.p, rb), ll_add(a.p, ra));
    out[0] = (ll_constraint_row){
        .kind = LL_ROW_EQUAL, .c = gap.x, .n = {1, 0}, .ja = -ra.y, .jb = -rb.y, .most = INFINITY};
    out[1] = (ll_constraint_row){
        .kind = LL_ROW_EQUAL, .c = gap.y, .n = {0, 1}, .ja = ra.x, .jb = rb.x, .most = INFINITY};
}

/* Of the angle of b relative to a. */
static ll_constraint_row angle_row(double c)
{
    return (ll_constraint_row){.kind = LL_ROW_EQUAL, .c = c, .ja = 1, .jb = 1, .most = INFINITY};
}

/* Limits and motor of `value` in rows 3 to 5; `base` is a row of the same direction. */
static void range_rows(const ll_joint *j, ll_constraint_row base, double value, double most,
                       ll_constraint_row out[LL_ROWS])
{
    if (j->def.limited) {
        out[3] = out[4] = base;
        out[3].kind = out[4].kind = LL_ROW_LIMIT;
        out[3].most = out[4].most = INFINITY;
        out[3].c = value - j->def.lower;
        out[4].c = j->def.upper - value;
        out[4].n = ll_neg(base.n);
        out[4].ja = -base.ja;
        out[4].jb = -base.jb;
    }
    if (j->def.motored) {
        out[5] = base;
        out[5].kind = LL_ROW_MOTOR;
        out[5].speed = j->def.motor_speed;
        out[5].most = most;
    }
}

/* ---- types ---- */

/* Distance joint: two anchors at a distance; a rod, a rope (pulls only) or a spring. */
static void distance_rows(const ll_joint *j, ll_pose a, ll_pose b, double angle,
                          ll_constraint_row out[LL_ROWS])
{
    (void)angle;
    ll_vec2 ra = ll_rotate(a.q, j->def.anchor_a), rb = ll_rotate(b.q, j->def.anchor_b);
    ll_vec2 gap = ll_sub(ll_add(b.p, rb), ll_add(a.p, ra));
    double length = ll_length(gap);
    ll_vec2 n = length > 0 ? ll_scale(1 / length, gap) : ll_vec(0, 1);
    ll_constraint_row row = {.kind = LL_ROW_EQUAL,
                             .c = length - j->def.length,
                             .n = n,
                             .ja = ll_cross(ra, n),
                             .jb = ll_cross(rb, n),
                             .most = INFINITY,
                             .hertz = j->def.hertz,
                             .damping = j->def.damping};
    if (j->def.rope) {
        row.kind = LL_ROW_LIMIT;
        row.c = -row.c;
        row.n = ll_neg(n);
        row.ja = -row.ja;
        row.jb = -row.jb;
    }
    out[0] = row;
}

/* Revolute joint: two anchors are at one point. */
static void revolute_rows(const ll_joint *j, ll_pose a, ll_pose b, double angle,
                          ll_constraint_row out[LL_ROWS])
{
    point_rows(j, a, b, out);
    range_rows(j, angle_row(0), angle - j->def.angle, j->def.max_torque, out);
}

/* Prismatic joint: b moves along an axis fixed in a, without rotation relative to a. */
static void prismatic_rows(const ll_joint *j, ll_pose a, ll_pose b, double angle,
                           ll_constraint_row out[LL_ROWS])
{
    ll_vec2 ra = ll_rotate(a.q, j->def.anchor_a), rb = ll_rotate(b.q, j->def.anchor_b);
    ll_vec2 gap = ll_sub(ll_add(b.p, rb), ll_add(a.p, ra));
    ll_vec2 axis = ll_rotate(a.q, j->def.axis), across = ll_cross_sv(1, axis), arm = ll_add(ra, gap);
    out[0] = (ll_constraint_row){.kind = LL_ROW_EQUAL,
                                 .c = ll_dot(gap, across),
                                 .n = across,
                                 .ja = ll_cross(arm, across),
                                 .jb = ll_cross(rb, across),
                                 .most = INFINITY};
    out[2] = angle_row(angle - j->def.angle);
    ll_constraint_row along = {.n = axis, .ja = ll_cross(arm, axis), .jb = ll_cross(rb, axis)};
    range_rows(j, along, ll_dot(gap, axis), j->def.max_force, out);
}

/* Weld joint: two bodies rigidly connected, or by springs. */
static void weld_rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
{
    point_rows(j, a, b, out);
    out[2] = angle_row(angle - j->def.angle);
    for (int i = 0; i < 3; i++) {
        out[i].hertz = j->def.hertz;
        out[i].damping = j->def.damping;
    }
}

/* Mouse joint: a spring from a point of the world to an anchor of b, to drag a body. */
static void mouse_rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
{
    (void)a, (void)angle;
    ll_vec2 rb = ll_rotate(b.q, j->def.anchor_b), gap = ll_sub(ll_add(b.p, rb), j->def.target);
    for (int i = 0; i < 2; i++) {
        ll_vec2 n = i == 0 ? ll_vec(1, 0) : ll_vec(0, 1);
        out[i] = (ll_constraint_row){.kind = LL_ROW_EQUAL,
                                     .c = ll_dot(gap, n),
                                     .n = n,
                                     .jb = ll_cross(rb, n),
                                     .most = j->def.max_force,
                                     .hertz = j->def.hertz > 0 ? j->def.hertz : 5,
                                     .damping = j->def.damping > 0 ? j->def.damping : 1};
    }
}

/* Motor joint: drives b's angular velocity to a speed, and holds b's anchor at a's, with a largest force
 * each. */
static void motor_rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
{
    (void)angle;
    point_rows(j, a, b, out);
    out[0].most = out[1].most = j->def.max_force;
    out[2] = angle_row(0);
    out[2].kind = LL_ROW_MOTOR;
    out[2].speed = j->def.motor_speed;
    out[2].most = j->def.max_torque;
}

/* Friction joint: friction of a body on a plane, seen from above (b2FrictionJoint of Box2D 2). b takes a's
 * velocity and angular velocity, with a largest force, the same in every direction, and a largest torque.
 * xpbd and avbd limit the two axes separately: along a diagonal, friction is up to 41 % stronger. */

static ll_constraint_row drag_row(ll_constraint_row row, double most)
{
    row.kind = LL_ROW_MOTOR;
    row.most = most;
    return row;
}

static void friction_rows(const ll_joint *j, ll_pose a, ll_pose b, double angle,
                          ll_constraint_row out[LL_ROWS])
{
    (void)angle;
    point_rows(j, a, b, out);
    out[0] = drag_row(out[0], j->def.max_force);
    out[1] = drag_row(out[1], j->def.max_force);
    out[5] = drag_row(angle_row(0), j->def.max_torque);
}

/* X(type, name, members) */
#define TYPES(X)                                                                                             \
    X(DISTANCE, distance, .rows = distance_rows)                                                             \
    X(REVOLUTE, revolute, .rows = revolute_rows, .block = true)                                              \
    X(PRISMATIC, prismatic, .rows = prismatic_rows)                                                          \
    X(WELD, weld, .rows = weld_rows, .block = true)                                                          \
    X(MOUSE, mouse, .rows = mouse_rows)                                                                      \
    X(MOTOR, motor, .rows = motor_rows)                                                                      \
    X(FRICTION, friction, .rows = friction_rows)

#define ROW(type, name, ...) [LL_JOINT_##type] = {__VA_ARGS__},
#define NAME(type, name, ...) [LL_JOINT_##type] = #name,

const ll_joint_row_type ll_joint_row_types[LL_JOINT_TYPES] = {TYPES(ROW)};
const char *const ll_joint_type_names[LL_JOINT_TYPES + 1] = {TYPES(NAME)};
