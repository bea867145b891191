/* The lists of joints that hang on bodies: whether two are joined. */
#include "rigid/contact/contact.h"

bool ll_joint_blocks_collision(const ll_rigid *w, int32_t a, int32_t b)
{
    for (int32_t e = ll_bodies(w)[a].joint; e != LL_NONE; e = ll_joints(w)[e >> 1].next[e & 1]) {
        const ll_joint *j = &ll_joints(w)[e >> 1];
        if (j->body[1 - (e & 1)] == b && !j->def.collide)
            return true;
    }
    return false;
}
