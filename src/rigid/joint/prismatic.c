/* Prismatic joint: b moves along an axis fixed in a, without rotation relative to a. */
#include "rigid/joint/joint.h"

static void rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
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
    out[2] = ll_row_angle(angle - j->def.angle);
    ll_constraint_row along = {.n = axis, .ja = ll_cross(arm, axis), .jb = ll_cross(rb, axis)};
    ll_rows_range(j, along, ll_dot(gap, axis), j->def.max_force, out);
}

const ll_joint_row_type ll_joint_prismatic = {.name = "prismatic", .rows = rows};
