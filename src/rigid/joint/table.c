#include "rigid/joint/joint.h"

#include <stddef.h>

const ll_joint_row_type *const ll_joint_row_types[LL_JOINT_TYPES] = {
    &ll_joint_distance, &ll_joint_revolute, &ll_joint_prismatic, &ll_joint_weld,
    &ll_joint_mouse,    &ll_joint_motor,    &ll_joint_friction};
const char *const ll_joint_type_names[LL_JOINT_TYPES + 1] = {"distance", "revolute", "prismatic", "weld",
                                                             "mouse",    "motor",    "friction",  NULL};
