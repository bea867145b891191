#include "rigid/joint/joint.h"

#include <stddef.h>

/* ---- making and removing ---- */

ll_joint_def ll_joint_defaults(const ll_rigid *w, ll_joint_type type, ll_body_id a, ll_body_id b,
                               ll_vec2 anchor)
{
    ll_joint_def def = {.type = (int32_t)type, .a = a, .b = b, .axis = {1, 0}, .target = anchor};
    ll_body_state sa, sb;
    ll_status status = ll_rigid_get_body(w, a, &sa);
    LL_THEN(status, ll_rigid_get_body(w, b, &sb));
    if (ll_failed(&status))
        return def; /* ll_rigid_add_joint reports the error */
    ll_rot qa = ll_poses(w)[a.index - 1].q, qb = ll_poses(w)[b.index - 1].q;
    def.anchor_a = ll_unrotate(qa, ll_sub(anchor, sa.position));
    def.anchor_b = ll_unrotate(qb, ll_sub(anchor, sb.position));
    def.angle = sb.angle - sa.angle;
    return def;
}

static ll_status check_joint(const ll_joint_def *d)
{
    if (d->type < 0 || d->type >= LL_JOINT_TYPES)
        return ll_field_error(LL_BAD_INPUT, "type", "type: must be one of the %d joint types; got %d.",
                              LL_JOINT_TYPES, d->type);
    static const char *const fields[] = {"anchor_a.x", "anchor_a.y",  "anchor_b.x", "anchor_b.y",
                                         "axis.x",     "axis.y",      "angle",      "lower",
                                         "upper",      "motor_speed", "target.x",   "target.y"};
    const double values[] = {d->anchor_a.x, d->anchor_a.y,  d->anchor_b.x, d->anchor_b.y,
                             d->axis.x,     d->axis.y,      d->angle,      d->lower,
                             d->upper,      d->motor_speed, d->target.x,   d->target.y};
    for (int i = 0; i < 12; i++)
        if (!(fabs(values[i]) <= LL_WORLD_MAX))
            return ll_field_error(LL_BAD_INPUT, fields[i],
                                  "%s: must be finite and at most %g in size; got %g.", fields[i],
                                  LL_WORLD_MAX, values[i]);
    static const char *const sizes[] = {"length", "hertz", "damping", "max_force", "max_torque"};
    const double amounts[] = {d->length, d->hertz, d->damping, d->max_force, d->max_torque};
    for (int i = 0; i < 5; i++)
        if (!(amounts[i] >= 0 && amounts[i] <= 1e15))
            return ll_field_error(LL_BAD_INPUT, sizes[i], "%s: must be 0 to 1e15; got %g.", sizes[i],
                                  amounts[i]);
    if (d->limited && d->lower > d->upper)
        return ll_field_error(LL_BAD_INPUT, "lower", "lower: must be at most upper, %g; got %g.", d->upper,
                              d->lower);
    return ll_ok();
}

ll_status ll_rigid_add_joint(ll_rigid *w, const ll_joint_def *def, ll_joint_id *out)
{
    int32_t body[2];
    LL_TRY(ll_body_slot(w, def->a, &body[0]));
    LL_TRY(ll_body_slot(w, def->b, &body[1]));
    LL_TRY(check_joint(def));
    if (body[0] == body[1])
        return ll_field_error(LL_BAD_INPUT, "b", "b: must be another body than a; got %d.", def->b.index);
    if (w->joints == w->limits.joints)
        return ll_error(LL_LIMIT, "world: full; its limit is %d joints.", w->limits.joints);
    int32_t i = w->free_joint;
    if (i == LL_NONE)
        i = w->joint_end++;
    else
        w->free_joint = ll_joints(w)[i].free;
    ll_joint *j = &ll_joints(w)[i];
    *j =
        (ll_joint){.def = *def, .body = {body[0], body[1]}, .generation = j->generation + 1, .free = LL_NONE};
    j->def.axis = ll_normalised(def->axis);
    j->def.anchor_a = ll_add(def->anchor_a, ll_bodies(w)[body[0]].origin);
    j->def.anchor_b = ll_add(def->anchor_b, ll_bodies(w)[body[1]].origin);
    for (int side = 0; side < 2; side++) {
        ll_body *b = &ll_bodies(w)[body[side]];
        j->previous[side] = LL_NONE;
        j->next[side] = b->joint;
        if (b->joint != LL_NONE)
            ll_joints(w)[b->joint >> 1].previous[b->joint & 1] = 2 * i + side;
        b->joint = 2 * i + side;
        ll_wake(w, body[side]);
    }
    w->joints++;
    *out = (ll_joint_id){i + 1, j->generation};
    return ll_ok();
}

void ll_unlink_joint(ll_rigid *w, int32_t joint)
{
    ll_joint *j = &ll_joints(w)[joint];
    for (int side = 0; side < 2; side++) {
        ll_wake(w, j->body[side]);
        int32_t next = j->next[side], previous = j->previous[side];
        if (previous == LL_NONE)
            ll_bodies(w)[j->body[side]].joint = next;
        else
            ll_joints(w)[previous >> 1].next[previous & 1] = next;
        if (next != LL_NONE)
            ll_joints(w)[next >> 1].previous[next & 1] = previous;
    }
    *j = (ll_joint){.body = {LL_NONE, LL_NONE}, .generation = j->generation, .free = w->free_joint};
    w->free_joint = joint;
    w->joints--;
}

static ll_status joint_slot(const ll_rigid *w, ll_joint_id id, int32_t *slot)
{
    int32_t i = id.index - 1;
    *slot = 0;
    if (i < 0 || i >= w->joint_end || ll_joints(w)[i].body[0] == LL_NONE ||
        ll_joints(w)[i].generation != id.generation)
        return ll_error(LL_NOT_FOUND, "joint: no joint %d of generation %u.", id.index, id.generation);
    *slot = i;
    return ll_ok();
}

ll_status ll_rigid_remove_joint(ll_rigid *w, ll_joint_id id)
{
    int32_t slot;
    ll_status status = joint_slot(w, id, &slot);
    if (!ll_failed(&status))
        ll_unlink_joint(w, slot);
    return status;
}

ll_status ll_rigid_set_target(ll_rigid *w, ll_joint_id id, ll_vec2 target)
{
    int32_t slot;
    LL_TRY(joint_slot(w, id, &slot));
    if (!(fabs(target.x) <= LL_WORLD_MAX && fabs(target.y) <= LL_WORLD_MAX))
        return ll_field_error(LL_BAD_INPUT, "target",
                              "target: must be finite and at most %g in size; got (%g, %g).", LL_WORLD_MAX,
                              target.x, target.y);
    ll_joints(w)[slot].def.target = target;
    ll_wake(w, ll_joints(w)[slot].body[1]);
    return ll_ok();
}
