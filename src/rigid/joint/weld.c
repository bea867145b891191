/* Weld joint: two bodies rigidly connected, or by springs. */
#include "rigid/joint/joint.h"

static void rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
{
    ll_row_point(j, a, b, out);
    out[2] = ll_row_angle(angle - j->def.angle);
    for (int i = 0; i < 3; i++) {
        out[i].hertz = j->def.hertz;
        out[i].damping = j->def.damping;
    }
}

const ll_joint_row_type ll_joint_weld = {.name = "weld", .rows = rows, .block = true};
