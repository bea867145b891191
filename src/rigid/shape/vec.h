/* Vectors, rotations and poses of the plane, in metres and radians.
 *
 * This room uses double throughout. Momentum then balances to 1e-12, a scene 10,000 km from the origin is as
 * accurate as one at it, and a pendulum can be compared with the motion lab; float allows none of that. It
 * costs half of the lanes: four with AVX2, as many as single precision has with SSE2. */
#pragma once

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct ll_vec2 {
    double x, y;
} ll_vec2;

typedef struct ll_rot { /* cosine and sine */
    double c, s;
} ll_rot;

typedef struct ll_pose { /* of a body: its centre of mass and its rotation */
    ll_vec2 p;
    ll_rot q;
} ll_pose;

typedef struct ll_aabb {
    ll_vec2 lower, upper;
} ll_aabb;

/* Of two zeros the second, for any signs; fmin and fmax leave that to the library. */
static inline double ll_min(double a, double b)
{
    return a < b ? a : b;
}

static inline double ll_max(double a, double b)
{
    return a > b ? a : b;
}

static inline ll_vec2 ll_vec(double x, double y)
{
    return (ll_vec2){x, y};
}

static inline ll_vec2 ll_add(ll_vec2 a, ll_vec2 b)
{
    return (ll_vec2){a.x + b.x, a.y + b.y};
}

static inline ll_vec2 ll_sub(ll_vec2 a, ll_vec2 b)
{
    return (ll_vec2){a.x - b.x, a.y - b.y};
}

static inline ll_vec2 ll_neg(ll_vec2 a)
{
    return (ll_vec2){-a.x, -a.y};
}

static inline ll_vec2 ll_scale(double s, ll_vec2 a)
{
    return (ll_vec2){s * a.x, s * a.y};
}

static inline ll_vec2 ll_madd(ll_vec2 a, double s, ll_vec2 b) /* a + s b */
{
    return (ll_vec2){a.x + s * b.x, a.y + s * b.y};
}

static inline double ll_dot(ll_vec2 a, ll_vec2 b)
{
    return a.x * b.x + a.y * b.y;
}

static inline double ll_cross(ll_vec2 a, ll_vec2 b)
{
    return a.x * b.y - a.y * b.x;
}

static inline ll_vec2 ll_cross_sv(double s, ll_vec2 a) /* s z x a */
{
    return (ll_vec2){-s * a.y, s * a.x};
}

static inline ll_vec2 ll_right(ll_vec2 a) /* a rotated by -90 degrees: outward normal of an edge */
{
    return (ll_vec2){a.y, -a.x};
}

static inline double ll_length(ll_vec2 a)
{
    return sqrt(a.x * a.x + a.y * a.y);
}

static inline ll_vec2 ll_normalised(ll_vec2 a) /* zero stays zero */
{
    double length = ll_length(a);
    return length > 0 ? ll_scale(1 / length, a) : a;
}

static inline ll_vec2 ll_lerp(ll_vec2 a, ll_vec2 b, double t)
{
    return (ll_vec2){(1 - t) * a.x + t * b.x, (1 - t) * a.y + t * b.y};
}

static inline ll_vec2 ll_rotate(ll_rot q, ll_vec2 a)
{
    return (ll_vec2){q.c * a.x - q.s * a.y, q.s * a.x + q.c * a.y};
}

static inline ll_vec2 ll_unrotate(ll_rot q, ll_vec2 a)
{
    return (ll_vec2){q.c * a.x + q.s * a.y, -q.s * a.x + q.c * a.y};
}

static inline ll_rot ll_rot_mul(ll_rot a, ll_rot b)
{
    return (ll_rot){a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s};
}

static inline ll_rot ll_rot_between(ll_rot a, ll_rot b) /* a^-1 b */
{
    return (ll_rot){a.c * b.c + a.s * b.s, a.c * b.s - a.s * b.c};
}

static inline ll_rot ll_rot_normalised(ll_rot q)
{
    double scale = 1 / sqrt(q.c * q.c + q.s * q.s);
    return (ll_rot){q.c * scale, q.s * scale};
}

/* Rotation by a small angle without sine or cosine, from the half angle's tangent to fifth order. Of length 1
 * up to rounding; the angle is off by angle^5 / 120. */
static inline ll_rot ll_rot_small(double angle)
{
    double h = 0.5 * angle, t = h * (1 + h * h * (1.0 / 3)), t2 = t * t, scale = 1 / (1 + t2);
    return (ll_rot){(1 - t2) * scale, 2 * t * scale};
}

static inline ll_vec2 ll_to_world(ll_pose pose, ll_vec2 local)
{
    return ll_add(pose.p, ll_rotate(pose.q, local));
}

static inline ll_vec2 ll_to_local(ll_pose pose, ll_vec2 world)
{
    return ll_unrotate(pose.q, ll_sub(world, pose.p));
}

static inline ll_pose ll_pose_between(ll_pose a, ll_pose b) /* b in the frame of a */
{
    return (ll_pose){ll_to_local(a, b.p), ll_rot_between(a.q, b.q)};
}

static inline ll_pose ll_pose_mul(ll_pose a, ll_pose b) /* pose b of a's frame, in the world */
{
    return (ll_pose){ll_to_world(a, b.p), ll_rot_mul(a.q, b.q)};
}

static inline bool ll_aabb_overlap(ll_aabb a, ll_aabb b)
{
    return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y &&
           b.lower.y <= a.upper.y;
}

static inline bool ll_aabb_contains(ll_aabb a, ll_aabb b)
{
    return a.lower.x <= b.lower.x && a.lower.y <= b.lower.y && b.upper.x <= a.upper.x &&
           b.upper.y <= a.upper.y;
}

static inline ll_aabb ll_aabb_union(ll_aabb a, ll_aabb b)
{
    return (ll_aabb){
        {a.lower.x < b.lower.x ? a.lower.x : b.lower.x, a.lower.y < b.lower.y ? a.lower.y : b.lower.y},
        {a.upper.x > b.upper.x ? a.upper.x : b.upper.x, a.upper.y > b.upper.y ? a.upper.y : b.upper.y}};
}

static inline ll_aabb ll_aabb_grown(ll_aabb a, double by)
{
    return (ll_aabb){{a.lower.x - by, a.lower.y - by}, {a.upper.x + by, a.upper.y + by}};
}
