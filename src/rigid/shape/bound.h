/* Bounding volumes: simple shapes that replace the exact one (the paper's AABB, sphere and OBB).
 *
 * A world can collide any of them instead of the shapes, to show how much each overestimates. */
#pragma once

#include "rigid/shape/shape.h"

typedef enum ll_volume {
    LL_VOLUME_EXACT,
    LL_VOLUME_AABB,
    LL_VOLUME_SPHERE, /* smallest enclosing circle */
    LL_VOLUME_OBB,    /* enclosing rectangle of least area */
    LL_VOLUMES
} ll_volume;

extern const char *const ll_volume_names[LL_VOLUMES + 1]; /* NULL-terminated */

/* The bounding volume of `g` in the body frame. An AABB is aligned with the world's axes and so depends on
 * the body's rotation `q`; the others do not. */
ll_geometry ll_bound_of(ll_volume volume, const ll_geometry *g, ll_rot q);

double ll_bound_area(ll_volume volume, const ll_geometry *g, ll_rot q);

/* A bounding volume is made once, placed whenever its body has moved, and tested once per pair. Both structs
 * point to the shape, which must outlive them. */
typedef struct ll_bound { /* in the body frame */
    const ll_geometry *shape;
    ll_vec2 centre, half; /* of a sphere and an OBB; half sides of an OBB */
    ll_rot axis;          /* of the OBB */
    double radius;
} ll_bound;

typedef struct ll_placed_bound { /* in the world; only the members of its kind are set */
    const ll_geometry *shape;
    ll_pose pose;
    ll_aabb box;
    ll_vec2 centre, half;
    ll_rot axis;
    double radius;
} ll_placed_bound;

ll_bound ll_bound_make(ll_volume volume, const ll_geometry *g);
void ll_bound_place(ll_volume volume, const ll_bound *made, ll_pose pose, ll_placed_bound *out);
bool ll_bounds_meet(ll_volume volume, const ll_placed_bound *a, const ll_placed_bound *b);
