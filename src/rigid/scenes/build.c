#include "rigid/scenes/build.h"

#include <string.h>

ll_builder ll_build(ll_rigid *world, double friction)
{
    ll_builder b = {.world = world,
                    .status = ll_ok(),
                    .material = ll_material_defaults(),
                    .body = ll_body_defaults(LL_BODY_DYNAMIC)};
    b.material.friction = friction;
    return b;
}

ll_body_id ll_build_body(ll_builder *b, ll_body_type type, double x, double y, double angle)
{
    ll_body_id id = {0, 0};
    ll_body_def def = b->body;
    def.type = (int32_t)type;
    def.position = ll_vec(x, y);
    def.angle = angle;
    if (!ll_failed(&b->status))
        b->status = ll_rigid_add_body(b->world, &def, &id);
    return id;
}

static void add(ll_builder *b, ll_body_id body, ll_status made, const ll_geometry *g)
{
    if (!ll_failed(&b->status))
        b->status = made;
    if (!ll_failed(&b->status))
        b->status = ll_rigid_add_shape(b->world, body, g, &b->material);
}

void ll_build_box_on(ll_builder *b, ll_body_id body, double w, double h, double x, double y, double angle)
{
    ll_geometry g;
    ll_status made = ll_shape_box(w, h, ll_vec(x, y), angle, &g);
    add(b, body, made, &g);
}

void ll_build_segment_on(ll_builder *b, ll_body_id body, double x0, double y0, double x1, double y1)
{
    ll_geometry g;
    ll_status made = ll_shape_segment(ll_vec(x0, y0), ll_vec(x1, y1), &g);
    add(b, body, made, &g);
}

void ll_build_polygon_on(ll_builder *b, ll_body_id body, const ll_vec2 *points, int count)
{
    ll_geometry g;
    ll_status made = ll_shape_polygon(points, count, &g);
    add(b, body, made, &g);
}

void ll_build_capsule_on(ll_builder *b, ll_body_id body, double x0, double y0, double x1, double y1,
                         double radius)
{
    ll_geometry g;
    ll_status made = ll_shape_capsule(ll_vec(x0, y0), ll_vec(x1, y1), radius, &g);
    add(b, body, made, &g);
}

void ll_build_circle_on(ll_builder *b, ll_body_id body, double radius, double x, double y)
{
    ll_geometry g;
    ll_status made = ll_shape_circle(ll_vec(x, y), radius, &g);
    add(b, body, made, &g);
}

void ll_build_chain_on(ll_builder *b, ll_body_id body, const ll_vec2 *points, int count, bool loop)
{
    if (!ll_failed(&b->status))
        b->status = ll_rigid_add_chain(b->world, body, points, count, loop, &b->material);
}

ll_body_id ll_build_box(ll_builder *b, double w, double h, double x, double y, double angle)
{
    ll_body_id body = ll_build_body(b, LL_BODY_DYNAMIC, x, y, angle);
    ll_build_box_on(b, body, w, h, 0, 0, 0);
    return body;
}

ll_body_id ll_build_circle(ll_builder *b, double radius, double x, double y)
{
    ll_body_id body = ll_build_body(b, LL_BODY_DYNAMIC, x, y, 0);
    ll_build_circle_on(b, body, radius, 0, 0);
    return body;
}

ll_body_id ll_build_capsule(ll_builder *b, double x0, double y0, double x1, double y1, double r)
{
    double x = 0.5 * (x0 + x1), y = 0.5 * (y0 + y1);
    ll_body_id body = ll_build_body(b, LL_BODY_DYNAMIC, x, y, 0);
    ll_build_capsule_on(b, body, x0 - x, y0 - y, x1 - x, y1 - y, r);
    return body;
}

ll_body_id ll_build_ground(ll_builder *b, double half_width)
{
    ll_body_id body = ll_build_body(b, LL_BODY_STATIC, 0, -1, 0);
    ll_build_box_on(b, body, 2 * half_width, 2, 0, 0, 0);
    return body;
}

ll_joint_id ll_build_joint(ll_builder *b, const ll_joint_def *def)
{
    ll_joint_id id = {0, 0};
    if (!ll_failed(&b->status))
        b->status = ll_rigid_add_joint(b->world, def, &id);
    return id;
}

ll_joint_id ll_build_revolute(ll_builder *b, ll_body_id a, ll_body_id c, double x, double y)
{
    ll_joint_def def = ll_joint_defaults(b->world, LL_JOINT_REVOLUTE, a, c, ll_vec(x, y));
    return ll_build_joint(b, &def);
}

static int32_t bounded(int64_t count) /* ll_rigid_check rejects what is too large */
{
    return (int32_t)(count < INT32_MAX ? count : INT32_MAX);
}

void ll_build_limits(ll_rigid_limits *limits, int64_t bodies, int64_t contacts_per_body, int64_t joints)
{
    limits->bodies = limits->shapes = limits->hulls = bounded(bodies);
    limits->contacts = bounded(bodies * contacts_per_body + 16);
    limits->joints = bounded(joints);
}
