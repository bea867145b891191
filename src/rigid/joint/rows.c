/* Rows that types share. */
#include "rigid/joint/joint.h"

void ll_row_point(const ll_joint *j, ll_pose a, ll_pose b, ll_constraint_row out[2])
{
    ll_vec2 ra = ll_rotate(a.q, j->def.anchor_a), rb = ll_rotate(b.q, j->def.anchor_b);
    ll_vec2 gap = ll_sub(ll_add(b.p, rb), ll_add(a.p, ra));
    out[0] = (ll_constraint_row){
        .kind = LL_ROW_EQUAL, .c = gap.x, .n = {1, 0}, .ja = -ra.y, .jb = -rb.y, .most = INFINITY};
    out[1] = (ll_constraint_row){
        .kind = LL_ROW_EQUAL, .c = gap.y, .n = {0, 1}, .ja = ra.x, .jb = rb.x, .most = INFINITY};
}

ll_constraint_row ll_row_angle(double c)
{
    return (ll_constraint_row){.kind = LL_ROW_EQUAL, .c = c, .ja = 1, .jb = 1, .most = INFINITY};
}

void ll_rows_range(const ll_joint *j, ll_constraint_row base, double value, double most,
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
