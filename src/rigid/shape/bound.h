/* Bounding volumes: simpler shapes that stand for the true one (the paper's AABB, sphere and OBB).
 *
 * A world can let any of them collide in the shape's place, so that one sees what each overestimates. */
#pragma once

#include "rigid/shape/shape.h"

typedef enum ll_volume {
    LL_VOLUME_EXACT,
    LL_VOLUME_AABB,
    LL_VOLUME_SPHERE, /* the smallest circle around */
    LL_VOLUME_OBB,    /* the rectangle of least area around */
    LL_VOLUMES
} ll_volume;

extern const char *const ll_volume_names[LL_VOLUMES + 1]; /* NULL-terminated */

/* The volume of `g` in the body's own frame. An AABB is aligned with the world's axes and so depends on the
 * body's rotation `q`; the others do not. */
ll_geometry ll_bound_of(ll_volume volume, const ll_geometry *g, ll_rot q);

double ll_bound_area(ll_volume volume, const ll_geometry *g, ll_rot q);

/* A volume is made once, brought to a pose whenever its body has moved, and tested as often as there are
 * pairs. Both point to the shape, which must stay. */
typedef struct ll_bound { /* in the body's frame */
    const ll_geometry *shape;
    ll_vec2 centre, half; /* of a sphere and an OBB; half the OBB's sides */
    ll_rot axis;          /* of the OBB */
    double radius;
} ll_bound;

typedef struct ll_placed_bound { /* in the world; only what the volume has is set */
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

/* All three at once. Whether two bodies hit each other by the volumes: a false hit when the exact shapes do
 * not, a missed one when they do and the volumes do not (which encloses, hence never). */
bool ll_bound_hit(ll_volume volume, const ll_geometry *a, ll_pose pose_a, const ll_geometry *b,
                  ll_pose pose_b);
