/* Contact manifolds: the separating axis test, and clipping of the edges that face each other.
 *
 * All is in the frame of the first shape's body. Method: Gottschalk's separating axes with Sutherland-Hodgman
 * clipping, as in Box2D; rounded shapes are their hulls grown by the radius. */
#pragma once

#include "rigid/shape/shape.h"

typedef struct ll_manifold_point {
    ll_vec2 point; /* half way between the surfaces */
    double separation;
    uint32_t id; /* which features meet; the same in the next step while they are the same */
} ll_manifold_point;

typedef struct ll_manifold {
    ll_vec2 normal; /* from a to b */
    int32_t count;  /* 0, 1 or 2 */
    ll_manifold_point at[2];
} ll_manifold;

/* `rel` is b's body seen from a's. Points that are farther apart than `margin` are left out. */
ll_manifold ll_collide(const ll_geometry *a, const ll_geometry *b, ll_pose rel, double margin);
