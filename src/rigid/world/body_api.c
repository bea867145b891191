/* Changes of bodies that wake them, and what they touch. */
#include <string.h>

#include "base/detmath.h"
#include "rigid/joint/joint.h"

static void remove_shape(ll_rigid *w, int32_t s)
{
    ll_shape *shape = &ll_shapes(w)[s];
    ll_broad_of(w)->remove(ll_broad_state(w), s);
    if (ll_moved_flags(w)[s]) {
        ll_moved_flags(w)[s] = 0;
        int32_t kept = 0, *list = ll_moved_lists(w);
        for (int32_t i = 0; i < w->moved; i++)
            if (list[i] != s)
                list[kept++] = list[i];
        w->moved = kept;
    }
    if (shape->hull != LL_NONE) {
        memset(&ll_hulls(w)[shape->hull], 0, sizeof(ll_geometry));
        ll_hulls(w)[shape->hull].count = w->free_hull;
        w->free_hull = shape->hull;
    }
    *shape = (ll_shape){.body = LL_NONE, .next = w->free_shape, .hull = LL_NONE};
    w->free_shape = s;
}

ll_status ll_rigid_remove_body(ll_rigid *w, ll_body_id id)
{
    int32_t slot;
    LL_TRY(ll_body_slot(w, id, &slot));
    ll_body *b = &ll_bodies(w)[slot];
    ll_wake(w, slot);
    while (b->joint != LL_NONE)
        ll_unlink_joint(w, b->joint >> 1);
    while (b->contact != LL_NONE) {
        const ll_contact *c = &ll_contacts(w)[b->contact >> 1];
        ll_wake(w, c->body[1 - (b->contact & 1)]);
        ll_remove_contact(w, b->contact >> 1);
    }
    while (b->shape != LL_NONE) {
        int32_t next = ll_shapes(w)[b->shape].next;
        remove_shape(w, b->shape);
        b->shape = next;
    }
    if (b->awake != LL_NONE)
        ll_take_from_awake_list(w, slot);
    uint32_t generation = b->generation;
    w->bullets -= b->bullet;
    *b = (ll_body){.type = LL_NONE, .generation = generation, .island = w->free_body};
    ll_poses(w)[slot] = (ll_pose){{0, 0}, {1, 0}};
    ll_solver_bodies(w)[slot] = (ll_solver_body){.q = {1, 0}};
    w->free_body = slot;
    w->bodies--;
    return ll_ok();
}

ll_status ll_rigid_set_pose(ll_rigid *w, ll_body_id id, ll_vec2 position, double angle)
{
    int32_t i;
    ll_status status = ll_body_slot(w, id, &i);
    static const char *const fields[] = {"position.x", "position.y", "angle"};
    LL_THEN(status, ll_check_numbers(3, fields, (double[]){position.x, position.y, angle}, LL_WORLD_MAX));
    if (ll_failed(&status))
        return status;
    ll_body *b = &ll_bodies(w)[i];
    ll_rot q = {ll_cos(angle), ll_sin(angle)};
    ll_wake(w, i);
    ll_poses(w)[i] = (ll_pose){ll_sub(position, ll_rotate(q, b->origin)), q};
    b->angle = angle;
    for (int32_t e = b->contact; e != LL_NONE; e = ll_contacts(w)[e >> 1].next[e & 1])
        ll_contacts(w)[e >> 1].rel.x = INFINITY; /* forbids recycling: the manifold belongs to the old pose */
    ll_refresh_boxes(w, i);
    return ll_ok();
}

ll_status ll_rigid_set_velocity(ll_rigid *w, ll_body_id id, ll_vec2 velocity, double spin)
{
    int32_t i;
    ll_status status = ll_body_slot(w, id, &i);
    static const char *const fields[] = {"velocity.x", "velocity.y", "angular_velocity"};
    LL_THEN(status, ll_check_numbers(3, fields, (double[]){velocity.x, velocity.y, spin}, 1e6));
    if (ll_failed(&status))
        return status;
    if (ll_bodies(w)[i].type == LL_BODY_STATIC)
        return ll_error(LL_CONFLICT, "body: body %d is static and has no velocity.", id.index);
    ll_wake(w, i);
    ll_solver_bodies(w)[i].v = velocity;
    ll_solver_bodies(w)[i].w = spin;
    if (w->params.continuous == LL_CONTINUOUS_SPECULATIVE)
        ll_refresh_boxes(w, i);
    return ll_ok();
}

static ll_status dynamic_slot(ll_rigid *w, ll_body_id id, const char *what, int32_t *slot)
{
    ll_status status = ll_body_slot(w, id, slot);
    if (!ll_failed(&status) && ll_bodies(w)[*slot].type != LL_BODY_DYNAMIC)
        status = ll_error(LL_CONFLICT, "body: body %d is not dynamic and takes no %s.", id.index, what);
    if (!ll_failed(&status))
        ll_wake(w, *slot);
    return status;
}

ll_status ll_rigid_apply_force(ll_rigid *w, ll_body_id id, ll_vec2 force, double torque)
{
    static const char *const fields[] = {"force.x", "force.y", "torque"};
    int32_t i;
    LL_TRY(ll_check_numbers(3, fields, (double[]){force.x, force.y, torque}, 1e15));
    LL_TRY(dynamic_slot(w, id, "force", &i));
    ll_bodies(w)[i].force = ll_add(ll_bodies(w)[i].force, force);
    ll_bodies(w)[i].torque += torque;
    return ll_ok();
}

ll_status ll_rigid_apply_impulse(ll_rigid *w, ll_body_id id, ll_vec2 impulse, ll_vec2 at)
{
    static const char *const fields[] = {"impulse.x", "impulse.y", "at.x", "at.y"};
    int32_t i;
    LL_TRY(ll_check_numbers(4, fields, (double[]){impulse.x, impulse.y, at.x, at.y}, 1e12));
    LL_TRY(dynamic_slot(w, id, "impulse", &i));
    ll_solver_body *m = &ll_solver_bodies(w)[i];
    m->v = ll_madd(m->v, ll_bodies(w)[i].inv_mass, impulse);
    m->w += ll_bodies(w)[i].inv_inertia * ll_cross(ll_sub(at, ll_poses(w)[i].p), impulse);
    return ll_ok();
}
