/* Revolute joint: two anchors are at one point. */
#include "rigid/joint/joint.h"

static void rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
{
    ll_row_point(j, a, b, out);
    ll_rows_range(j, ll_row_angle(0), angle - j->def.angle, j->def.max_torque, out);
}

const ll_joint_row_type ll_joint_revolute = {.name = "revolute", .rows = rows, .block = true};
