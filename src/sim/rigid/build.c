/* Worlds from a configuration: a scene of the rigid room, or the listed bodies and joints. */
#include "sim/rigid/rigid.h"

#include "base/detmath.h"

static ll_vec2 pair(const double v[2])
{
    return ll_vec(v[0], v[1]);
}

static int points_of(const ll_rigid_body *b, ll_vec2 points[LL_RIGID_POINTS_MAX])
{
    for (int i = 0; i < b->point_count; i++)
        points[i] = pair(b->points[i]);
    return b->point_count;
}

static ll_status capsule(const ll_rigid_body *b, ll_geometry *out)
{
    double radius = 0.5 * b->size[1], half = 0.5 * b->size[0] - radius;
    return ll_shape_capsule(ll_vec(-half, 0), ll_vec(half, 0), radius, out);
}

static ll_status needs_points(const ll_rigid_body *b, int least, const char *what)
{
    if (b->point_count >= least)
        return ll_ok();
    return ll_error(LL_BAD_INPUT, "points: %s: must have at least %d; got %d", what, least, b->point_count);
}

/* Checks every link and reports the first error. */
static ll_status chain(const ll_rigid_body *b, const ll_vec2 *points, ll_geometry *out)
{
    int count = b->point_count, first = b->loop ? 0 : 1, last = b->loop ? count : count - 2;
    ll_status status = needs_points(b, 4, "a chain");
    for (int i = first; i < last && !ll_failed(&status); i++)
        status = ll_shape_chain_segment(points[(i + count - 1) % count], points[i], points[(i + 1) % count],
                                        points[(i + 2) % count], out);
    return status;
}

ll_status ll_rigid_sim_shape(const ll_rigid_body *b, ll_geometry *out)
{
    ll_vec2 points[LL_RIGID_POINTS_MAX];
    int count = points_of(b, points);
    ll_status status;
    switch ((ll_rigid_form)b->form) {
    case LL_FORM_BOX:
        return ll_shape_box(b->size[0], b->size[1], ll_vec(0, 0), 0, out);
    case LL_FORM_CIRCLE:
        return ll_shape_circle(ll_vec(0, 0), b->radius, out);
    case LL_FORM_CAPSULE:
        return capsule(b, out);
    case LL_FORM_POLYGON:
        return ll_shape_polygon(points, count, out);
    case LL_FORM_SEGMENT:
        status = needs_points(b, 2, "a segment");
        return ll_failed(&status) ? status : ll_shape_segment(points[0], points[1], out);
    default:
        return chain(b, points, out);
    }
}

static ll_status add_body(const ll_rigid_body *b, ll_rigid *world)
{
    ll_body_def def = ll_body_defaults((ll_body_type)b->type);
    ll_material material = ll_material_defaults();
    ll_geometry g;
    ll_body_id id;
    def.position = pair(b->position);
    def.angle = b->angle;
    def.velocity = b->type == LL_BODY_STATIC ? ll_vec(0, 0) : pair(b->velocity);
    def.angular_velocity = b->type == LL_BODY_STATIC ? 0 : b->angular_velocity;
    def.gravity_scale = b->gravity_scale;
    def.damping = b->damping;
    def.angular_damping = b->angular_damping;
    def.fixed_rotation = b->fixed_rotation;
    def.bullet = b->bullet;
    material.density = b->density;
    material.friction = b->friction;
    material.restitution = b->restitution;
    LL_TRY(ll_rigid_add_body(world, &def, &id));
    LL_TRY(ll_rigid_sim_shape(b, &g));
    if (b->form != LL_FORM_CHAIN)
        return ll_rigid_add_shape(world, id, &g, &material);
    ll_vec2 points[LL_RIGID_POINTS_MAX];
    int count = points_of(b, points);
    return ll_rigid_add_chain(world, id, points, count, b->loop, &material);
}

static ll_vec2 in_world(const ll_rigid_body *b, const double anchor[2])
{
    ll_rot q = {ll_cos(b->angle), ll_sin(b->angle)};
    return ll_add(pair(b->position), ll_rotate(q, pair(anchor)));
}

static double apart(const ll_rigid_config *c, const ll_rigid_joint *j)
{
    return ll_length(
        ll_sub(in_world(&c->bodies[j->b], j->anchor_b), in_world(&c->bodies[j->a], j->anchor_a)));
}

static ll_status add_joint(const ll_rigid_config *c, const ll_rigid_joint *j, ll_rigid *world)
{
    ll_joint_def def =
        ll_joint_defaults(world, (ll_joint_type)j->type, ll_rigid_body_at(world, (int32_t)j->a),
                          ll_rigid_body_at(world, (int32_t)j->b), ll_vec(0, 0));
    ll_joint_id id;
    def.anchor_a = pair(j->anchor_a);
    def.anchor_b = pair(j->anchor_b);
    def.axis = pair(j->axis);
    def.target = pair(j->target);
    def.length = j->length > 0 ? j->length : apart(c, j);
    def.lower = j->lower;
    def.upper = j->upper;
    def.hertz = j->hertz;
    def.damping = j->damping;
    def.motor_speed = j->motor_speed;
    def.max_force = j->max_force;
    def.max_torque = j->max_torque;
    def.collide = j->collide;
    def.limited = j->limited;
    def.motored = j->motored;
    def.rope = j->rope;
    return ll_rigid_add_joint(world, &def, &id);
}

ll_status ll_rigid_sim_build(const ll_rigid_config *c, ll_rigid *world)
{
    const ll_scene *scene = ll_rigid_sim_scene(&c->setup);
    ll_status status = ll_ok();
    if (scene != NULL) {
        ll_scene_args args = ll_scene_args_of(scene, &c->setup.params);
        status = scene->build(world, &args);
        return ll_failed(&status)
                   ? ll_field_error(LL_BAD_INPUT, "params", "params of %s: %s", scene->name, status.text)
                   : status;
    }
    for (int i = 0; i < c->body_count && !ll_failed(&status); i++)
        status = add_body(&c->bodies[i], world);
    for (int i = 0; i < c->joint_count && !ll_failed(&status); i++)
        status = add_joint(c, &c->joints[i], world);
    return status;
}
