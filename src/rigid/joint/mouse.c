/* Mouse joint: a spring from a point of the world to an anchor of b, to drag a body. */
#include "rigid/joint/joint.h"

static void rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
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

const ll_joint_row_type ll_joint_mouse = {.name = "mouse", .rows = rows};
