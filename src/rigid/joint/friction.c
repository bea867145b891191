/* Friction joint: friction of a body on a plane, seen from above (b2FrictionJoint of Box2D 2). b takes a's
 * velocity and angular velocity, with a largest force, the same in every direction, and a largest torque.
 * xpbd and avbd limit the two axes separately: along a diagonal, friction is up to 41 % stronger. */
#include "rigid/joint/joint.h"

static ll_constraint_row of(ll_constraint_row row, double most)
{
    row.kind = LL_ROW_MOTOR;
    row.most = most;
    return row;
}

static void rows(const ll_joint *j, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS])
{
    (void)angle;
    ll_row_point(j, a, b, out);
    out[0] = of(out[0], j->def.max_force);
    out[1] = of(out[1], j->def.max_force);
    out[5] = of(ll_row_angle(0), j->def.max_torque);
}

const ll_joint_row_type ll_joint_friction = {.name = "friction", .rows = rows};
