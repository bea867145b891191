/* Helpers that build scenes. A builder keeps its first error and then does nothing. */
#pragma once

#include "rigid/scenes/scene.h"

typedef struct ll_builder {
    ll_rigid *world;
    ll_status status;
    ll_material material; /* of the next shape */
    ll_body_def body;     /* velocity, damping and so on of the next body */
} ll_builder;

ll_builder ll_build(ll_rigid *world, double friction);
ll_body_id ll_build_body(ll_builder *b, ll_body_type type, double x, double y, double angle);
void ll_build_box_on(ll_builder *b, ll_body_id body, double w, double h, double x, double y, double angle);
void ll_build_segment_on(ll_builder *b, ll_body_id body, double x0, double y0, double x1, double y1);
void ll_build_polygon_on(ll_builder *b, ll_body_id body, const ll_vec2 *points, int count);
void ll_build_capsule_on(ll_builder *b, ll_body_id body, double x0, double y0, double x1, double y1,
                         double radius);
void ll_build_circle_on(ll_builder *b, ll_body_id body, double radius, double x, double y);
void ll_build_chain_on(ll_builder *b, ll_body_id body, const ll_vec2 *points, int count, bool loop);
ll_body_id ll_build_box(ll_builder *b, double w, double h, double x, double y, double angle); /* dynamic */
ll_body_id ll_build_circle(ll_builder *b, double radius, double x, double y);                 /* dynamic */
ll_body_id ll_build_capsule(ll_builder *b, double x0, double y0, double x1, double y1,
                            double r);                        /* dynamic */
ll_body_id ll_build_ground(ll_builder *b, double half_width); /* static, its surface at y = 0 */
ll_joint_id ll_build_joint(ll_builder *b, const ll_joint_def *def);
ll_joint_id ll_build_revolute(ll_builder *b, ll_body_id a, ll_body_id c, double x, double y);

/* Limits for `bodies` bodies with one hull and `contacts_per_body` contacts each. */
void ll_build_limits(ll_rigid_limits *limits, int64_t bodies, int64_t contacts_per_body, int64_t joints);
