/* Distance joint: two anchors at a distance; a rod, a rope (pulls only) or a spring. */
#include "rigid/joint/joint.h"

static void rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
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

const ll_joint_row_type ll_joint_distance = {.name = "distance", .rows = rows};
