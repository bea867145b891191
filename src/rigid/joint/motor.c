/* Motor joint: drives b's angular velocity to a speed, and holds b's anchor at a's, with a largest force
 * each. */
#include "rigid/joint/joint.h"

static void rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
{
    (void)angle;
    ll_row_point(j, a, b, out);
    out[0].most = out[1].most = j->def.max_force;
    out[2] = ll_row_angle(0);
    out[2].kind = LL_ROW_MOTOR;
    out[2].speed = j->def.motor_speed;
    out[2].most = j->def.max_torque;
}

const ll_joint_row_type ll_joint_motor = {.name = "motor", .rows = rows};
