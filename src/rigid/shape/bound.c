#include "rigid/shape/bound.h"

#include <stddef.h>

#include "rigid/shape/distance.h"

const char *const ll_volume_names[LL_VOLUMES + 1] = {"exact", "aabb", "sphere", "obb", NULL};

static ll_geometry rectangle(ll_aabb box, ll_rot q) /* `box` in a frame turned by q */
{
    ll_pose pose = {{0, 0}, q};
    ll_vec2 lo = box.lower, hi = box.upper;
    return (ll_geometry){.kind = LL_SHAPE_POLYGON,
                         .count = 4,
                         .centre = ll_to_world(pose, ll_lerp(lo, hi, 0.5)),
                         .vertex = {ll_to_world(pose, lo), ll_to_world(pose, ll_vec(hi.x, lo.y)),
                                    ll_to_world(pose, hi), ll_to_world(pose, ll_vec(lo.x, hi.y))},
                         .normal = {ll_rotate(q, ll_vec(0, -1)), ll_rotate(q, ll_vec(1, 0)),
                                    ll_rotate(q, ll_vec(0, 1)), ll_rotate(q, ll_vec(-1, 0))}};
}

/* The box of `g` along the axes of a frame turned by q. */
static ll_aabb box_along(const ll_geometry *g, ll_rot q)
{
    return ll_shape_aabb(g, (ll_pose){{0, 0}, {q.c, -q.s}});
}

/* One side of the least rectangle lies along an edge of the hull (Freeman and Shapira, 1975). */
static ll_geometry oriented(const ll_geometry *g)
{
    double least = INFINITY;
    ll_rot best = {1, 0};
    for (int i = 0; i < g->count; i++) {
        ll_rot q = {-g->normal[i].y, g->normal[i].x};
        if (g->count == 1)
            q = (ll_rot){1, 0};
        ll_aabb box = box_along(g, q);
        double area = (box.upper.x - box.lower.x) * (box.upper.y - box.lower.y);
        if (area < least) {
            least = area;
            best = q;
        }
    }
    return rectangle(box_along(g, best), best);
}

static bool encloses(const ll_geometry *g, ll_vec2 centre, double radius)
{
    for (int i = 0; i < g->count; i++)
        if (ll_length(ll_sub(g->vertex[i], centre)) > radius * (1 + 1e-12))
            return false;
    return true;
}

static ll_vec2 circumcentre(ll_vec2 a, ll_vec2 b, ll_vec2 c)
{
    ll_vec2 u = ll_sub(b, a), v = ll_sub(c, a);
    double d = 2 * ll_cross(u, v), uu = ll_dot(u, u), vv = ll_dot(v, v);
    return ll_add(a, ll_scale(1 / d, ll_vec(v.y * uu - u.y * vv, u.x * vv - v.x * uu)));
}

/* The smallest circle goes through two or three of the vertices: there are at most 84 such circles. */
static ll_geometry enclosing_circle(const ll_geometry *g)
{
    ll_vec2 centre = g->vertex[0];
    double radius = g->count == 1 ? 0 : INFINITY;
    for (int i = 0; i < g->count; i++)
        for (int j = i + 1; j < g->count; j++)
            for (int k = j; k < g->count; k++) {
                ll_vec2 a = g->vertex[i], b = g->vertex[j];
                ll_vec2 c = k == j ? ll_lerp(a, b, 0.5) : circumcentre(a, b, g->vertex[k]);
                double r = ll_length(ll_sub(a, c));
                if (r < radius && encloses(g, c, r)) {
                    centre = c;
                    radius = r;
                }
            }
    return (ll_geometry){.kind = LL_SHAPE_CIRCLE,
                         .count = 1,
                         .radius = radius + g->radius,
                         .centre = centre,
                         .vertex[0] = centre};
}

ll_geometry ll_bound_of(ll_volume volume, const ll_geometry *g, ll_rot q)
{
    ll_rot upright = {q.c, -q.s}; /* world axes in the body frame */
    switch (volume) {
    case LL_VOLUME_AABB:
        return rectangle(box_along(g, upright), upright);
    case LL_VOLUME_SPHERE:
        return enclosing_circle(g);
    case LL_VOLUME_OBB:
        return oriented(g);
    default:
        return *g;
    }
}

double ll_bound_area(ll_volume volume, const ll_geometry *g, ll_rot q)
{
    ll_geometry bound = ll_bound_of(volume, g, q);
    return ll_shape_area(&bound);
}

/* ---- made once, placed at each pose, tested ---- */

ll_bound ll_bound_make(ll_volume volume, const ll_geometry *g)
{
    ll_bound b = {.shape = g, .axis = {1, 0}};
    if (volume == LL_VOLUME_SPHERE) {
        ll_geometry circle = enclosing_circle(g);
        b.centre = circle.centre;
        b.radius = circle.radius;
    } else if (volume == LL_VOLUME_OBB) {
        ll_geometry box = oriented(g);
        b.centre = ll_lerp(box.vertex[0], box.vertex[2], 0.5);
        b.axis = (ll_rot){box.normal[1].x, box.normal[1].y};
        b.half = ll_vec(0.5 * ll_length(ll_sub(box.vertex[1], box.vertex[0])),
                        0.5 * ll_length(ll_sub(box.vertex[2], box.vertex[1])));
    }
    return b;
}

/* Like ll_shape_aabb, but adds the position once. */
static ll_aabb box_at(const ll_geometry *g, ll_pose pose)
{
    double c = pose.q.c, s = pose.q.s, left = INFINITY, right = -INFINITY, low = INFINITY, high = -INFINITY;
    for (int i = 0; i < g->count; i++) {
        double x = c * g->vertex[i].x - s * g->vertex[i].y, y = s * g->vertex[i].x + c * g->vertex[i].y;
        left = ll_min(left, x);
        right = ll_max(right, x);
        low = ll_min(low, y);
        high = ll_max(high, y);
    }
    return (ll_aabb){{pose.p.x + left - g->radius, pose.p.y + low - g->radius},
                     {pose.p.x + right + g->radius, pose.p.y + high + g->radius}};
}

void ll_bound_place(ll_volume volume, const ll_bound *made, ll_pose pose, ll_placed_bound *out)
{
    switch (volume) {
    case LL_VOLUME_AABB:
        out->box = box_at(made->shape, pose);
        return;
    case LL_VOLUME_SPHERE:
        out->centre = ll_to_world(pose, made->centre);
        out->radius = made->radius;
        return;
    case LL_VOLUME_OBB:
        out->centre = ll_to_world(pose, made->centre);
        out->axis = ll_rot_mul(pose.q, made->axis);
        out->half = made->half;
        return;
    default:
        out->shape = made->shape;
        out->pose = pose;
    }
}

/* Four axes are enough for two rectangles (Gottschalk, Lin, Manocha, "OBBTree", 1996). */
static bool rectangles_meet(const ll_placed_bound *a, const ll_placed_bound *b)
{
    ll_rot q = ll_rot_between(a->axis, b->axis);
    double c = fabs(q.c), s = fabs(q.s);
    ll_vec2 gap = ll_sub(b->centre, a->centre), seen = ll_unrotate(a->axis, gap);
    if (fabs(seen.x) > a->half.x + (c * b->half.x + s * b->half.y) ||
        fabs(seen.y) > a->half.y + (s * b->half.x + c * b->half.y))
        return false;
    seen = ll_unrotate(b->axis, gap);
    return fabs(seen.x) <= b->half.x + (c * a->half.x + s * a->half.y) &&
           fabs(seen.y) <= b->half.y + (s * a->half.x + c * a->half.y);
}

bool ll_bounds_meet(ll_volume volume, const ll_placed_bound *a, const ll_placed_bound *b)
{
    ll_vec2 gap;
    switch (volume) {
    case LL_VOLUME_AABB:
        return ll_aabb_overlap(a->box, b->box);
    case LL_VOLUME_SPHERE:
        gap = ll_sub(b->centre, a->centre);
        return ll_dot(gap, gap) <= (a->radius + b->radius) * (a->radius + b->radius);
    case LL_VOLUME_OBB:
        return rectangles_meet(a, b);
    default:
        return ll_distance(a->shape, a->pose, b->shape, b->pose).distance <= 0;
    }
}
