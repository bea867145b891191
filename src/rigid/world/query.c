/* Queries of a world, and the change of its broad phase. */
#include "rigid/body/world_state.h"

#include "base/assert.h"

void ll_rigid_set_broad(ll_rigid *w, ll_broad_kind broad)
{
    LL_ASSERT(w->limits.broads);
    if (w->limits.broad == (int32_t)broad)
        return;
    w->limits.broad = (int32_t)broad;
    ll_broad_of(w)->init(ll_broad_state(w), w->limits.shapes);
    for (int32_t i = 0; i < w->shape_end; i++)
        if (ll_shapes(w)[i].body != LL_NONE)
            ll_broad_of(w)->insert(ll_broad_state(w), ll_boxes(w), i);
}

bool ll_rigid_pair_at(const ll_rigid *w, int32_t index, ll_body_id *a, ll_body_id *b)
{
    const ll_contact *c = &ll_contacts(w)[index];
    if (c->shape[0] == LL_NONE)
        return false;
    *a = ll_rigid_body_at(w, c->body[0]);
    *b = ll_rigid_body_at(w, c->body[1]);
    return true;
}

int32_t ll_rigid_joint_end(const ll_rigid *w)
{
    return w->joint_end;
}

bool ll_rigid_joint_at(const ll_rigid *w, int32_t index, ll_joint_view *out)
{
    const ll_joint *j = &ll_joints(w)[index];
    if (j->body[0] == LL_NONE)
        return false;
    *out = (ll_joint_view){.id = {index + 1, j->generation},
                           .type = j->def.type,
                           .a = ll_rigid_body_at(w, j->body[0]),
                           .b = ll_rigid_body_at(w, j->body[1]),
                           .anchor_a = ll_to_world(ll_poses(w)[j->body[0]], j->def.anchor_a),
                           .anchor_b = ll_to_world(ll_poses(w)[j->body[1]], j->def.anchor_b)};
    if (j->def.type == LL_JOINT_MOUSE)
        out->anchor_a = j->def.target;
    return true;
}
