/* Contact manifolds: separating axis test, and clipping of facing edges.
 *
 * All is in the frame of the first shape's body. Method: Gottschalk's separating axes with Sutherland-Hodgman
 * clipping, as in Box2D; rounded shapes are hulls with a radius. */
#pragma once

#include "rigid/shape/shape.h"

typedef struct ll_manifold_point {
    ll_vec2 point; /* midway between the surfaces */
    double separation;
    uint32_t id; /* of the features that touch; unchanged in the next step while they are the same */
} ll_manifold_point;

typedef struct ll_manifold {
    ll_vec2 normal; /* from a to b */
    int32_t count;  /* 0, 1 or 2 */
    ll_manifold_point at[2];
} ll_manifold;

/* `rel`: pose of b's body in a's frame. Points farther apart than `margin` are omitted. */
ll_manifold ll_collide(const ll_geometry *a, const ll_geometry *b, ll_pose rel, double margin);
