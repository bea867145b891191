/* Shapes: a convex hull of 1 to 8 vertices, with a radius around it.
 *
 * One vertex is a circle, two a capsule or a segment, three and more a polygon. A chain (rugged terrain) is a
 * row of segments that know the vertices before and after, so that bodies do not catch at inner vertices
 * (Box2D's ghost vertices). It stops only what comes from the right of its direction. */
#pragma once

#include "base/status.h"
#include "rigid/shape/vec.h"

#define LL_HULL_MAX 8

/* Smaller lengths count as equal: half of the slop in which contacts rest. */
#define LL_LINEAR_SLOP 0.005

/* Largest coordinate of a shape or position; neighbouring doubles at 1e9 m are 1e-7 m apart. */
#define LL_WORLD_MAX 1e9

typedef enum ll_shape_kind {
    LL_SHAPE_CIRCLE,
    LL_SHAPE_CAPSULE,
    LL_SHAPE_POLYGON,
    LL_SHAPE_SEGMENT,
    LL_SHAPE_CHAIN_SEGMENT, /* chain segment: vertex[2] and vertex[3] are the ghosts before and after */
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

/* Rejects values that are not finite, degenerate, not convex or out of range. */
ll_status ll_shape_circle(ll_vec2 centre, double radius, ll_geometry *out);
ll_status ll_shape_capsule(ll_vec2 a, ll_vec2 b, double radius, ll_geometry *out);
ll_status ll_shape_segment(ll_vec2 a, ll_vec2 b, ll_geometry *out);
ll_status ll_shape_chain_segment(ll_vec2 before, ll_vec2 a, ll_vec2 b, ll_vec2 after, ll_geometry *out);
ll_status ll_shape_polygon(const ll_vec2 *points, int count, ll_geometry *out); /* in either direction */
ll_status ll_shape_box(double width, double height, ll_vec2 centre, double angle, ll_geometry *out);

const char *ll_shape_name(ll_shape_kind kind);
bool ll_shape_is_solid(ll_shape_kind kind); /* has an area; segments and chain segments have none */

ll_mass ll_shape_mass(const ll_geometry *g, double density);
double ll_shape_area(const ll_geometry *g);
ll_aabb ll_shape_aabb(const ll_geometry *g, ll_pose pose);
double ll_shape_extent(const ll_geometry *g); /* distance of the farthest point from the local origin */
double ll_shape_core(const ll_geometry *g);   /* radius of an inner circle about `centre`; 0 for segments */
void ll_shape_shift(ll_geometry *g, ll_vec2 by);
