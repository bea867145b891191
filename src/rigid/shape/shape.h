/* Shapes: a convex hull of 1 to 8 vertices, swept by a radius.
 *
 * One vertex is a circle, two a capsule or a segment, three and more a polygon. A chain (rugged terrain) is a
 * row of segments that know the vertices before and after, so that nothing catches at an inner vertex
 * (Box2D's ghost vertices); it stops only what comes from the right of its direction. */
#pragma once

#include "base/status.h"
#include "rigid/shape/vec.h"

#define LL_HULL_MAX 8

/* Lengths below this cannot be told apart: half of the slop that contacts rest in. */
#define LL_LINEAR_SLOP 0.005

/* No coordinate of a shape or position is larger; 1e9 m leaves 1e-7 m between neighbouring doubles. */
#define LL_WORLD_MAX 1e9

typedef enum ll_shape_kind {
    LL_SHAPE_CIRCLE,
    LL_SHAPE_CAPSULE,
    LL_SHAPE_POLYGON,
    LL_SHAPE_SEGMENT,
    LL_SHAPE_LINK, /* segment of a chain: vertex[2] and vertex[3] are the ghosts before and after */
    LL_SHAPE_KINDS
} ll_shape_kind;

typedef struct ll_geometry {
    int32_t kind; /* ll_shape_kind */
    int32_t count;
    double radius;
    ll_vec2 centre;              /* of area */
    ll_vec2 vertex[LL_HULL_MAX]; /* counter-clockwise */
    ll_vec2 normal[LL_HULL_MAX]; /* of the edge from vertex i to i + 1 */
} ll_geometry;

typedef struct ll_mass {
    double mass;    /* kg, of 1 m depth */
    double inertia; /* about `centre` */
    ll_vec2 centre;
} ll_mass;

/* What is not finite, degenerate, not convex or out of range is refused with a sentence. */
ll_status ll_shape_circle(ll_vec2 centre, double radius, ll_geometry *out);
ll_status ll_shape_capsule(ll_vec2 a, ll_vec2 b, double radius, ll_geometry *out);
ll_status ll_shape_segment(ll_vec2 a, ll_vec2 b, ll_geometry *out);
ll_status ll_shape_link(ll_vec2 before, ll_vec2 a, ll_vec2 b, ll_vec2 after, ll_geometry *out);
ll_status ll_shape_polygon(const ll_vec2 *points, int count, ll_geometry *out); /* either direction */
ll_status ll_shape_box(double width, double height, ll_vec2 centre, double angle, ll_geometry *out);

const char *ll_shape_name(ll_shape_kind kind);
bool ll_shape_is_solid(ll_shape_kind kind); /* has an area: segments and links have none */

ll_mass ll_shape_mass(const ll_geometry *g, double density);
double ll_shape_area(const ll_geometry *g);
ll_aabb ll_shape_aabb(const ll_geometry *g, ll_pose pose);
double ll_shape_extent(const ll_geometry *g); /* the farthest point's distance from the local origin */
double ll_shape_core(const ll_geometry *g); /* radius of a circle about `centre` within it; 0 for segments */
void ll_shape_shift(ll_geometry *g, ll_vec2 by);
