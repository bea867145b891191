#include "rigid/shape/manifold.h"

#include "base/assert.h"

static inline int after(const ll_geometry *g, int i)
{
    return i + 1 < g->count ? i + 1 : 0;
}

static ll_manifold one_point(ll_vec2 normal, ll_vec2 on_a, ll_vec2 on_b, uint32_t id)
{
    LL_VALIDATE(!(fabs(ll_dot(normal, normal) - 1) > 1e-9)); /* a unit vector, or NaN in a diverged world */
    ll_manifold m = {.normal = normal, .count = 1};
    m.at[0] = (ll_manifold_point){ll_lerp(on_a, on_b, 0.5), ll_dot(ll_sub(on_b, on_a), normal), id};
    return m;
}

/* Two rounded points; the normal points upwards if they coincide. */
static ll_manifold points_meet(ll_vec2 a, double radius_a, ll_vec2 b, double radius_b, double margin,
                               uint32_t id)
{
    ll_vec2 gap = ll_sub(b, a);
    double length = ll_length(gap);
    if (length > radius_a + radius_b + margin)
        return (ll_manifold){0};
    ll_vec2 normal = length > 0 ? ll_scale(1 / length, gap) : ll_vec(0, 1);
    return one_point(normal, ll_madd(a, radius_a, normal), ll_madd(b, -radius_b, normal), id);
}

typedef struct axis {
    int edge;
    double separation;
} axis;

/* The edge of `g` with the largest separation from the first `count` points of `other`. */
static axis best_axis(const ll_geometry *g, const ll_vec2 *other, int count)
{
    axis best = {-1, -INFINITY};
    for (int i = 0; i < g->count; i++) {
        double least = INFINITY;
        for (int k = 0; k < count; k++) {
            double s = ll_dot(g->normal[i], ll_sub(other[k], g->vertex[i]));
            least = s < least ? s : least;
        }
        if (least > best.separation)
            best = (axis){i, least};
    }
    return best;
}

/* Before or after a chain segment, contacts belong to its neighbour, unless the corner there is convex and
 * the direction is between the normals of the two edges. Then the nearer segment takes it; the earlier, if
 * equal. */
static bool segment_takes(const ll_geometry *link, ll_vec2 normal)
{
    ll_vec2 along = ll_normalised(ll_sub(link->vertex[1], link->vertex[0]));
    double lean = ll_dot(normal, along);
    if (ll_dot(normal, link->normal[0]) < 0)
        return false;
    ll_vec2 ghost_edge =
        lean < 0 ? ll_sub(link->vertex[0], link->vertex[2]) : ll_sub(link->vertex[3], link->vertex[1]);
    ll_vec2 neighbour = ll_normalised(ll_right(ghost_edge));
    double turn = ll_cross(neighbour, link->normal[0]) * (lean < 0 ? -1 : 1);
    if (fabs(lean) < 1e-6)
        return true;
    if (turn >= 0) /* concave or straight */
        return false;
    ll_vec2 half = ll_normalised(ll_add(neighbour, link->normal[0]));
    double own = ll_dot(normal, link->normal[0]), limit = ll_dot(half, link->normal[0]);
    return lean < 0 ? own > limit : own >= limit;
}

static ll_manifold circle_on_chain(const ll_geometry *link, ll_vec2 c, double radius, double margin)
{
    ll_vec2 a = link->vertex[0], b = link->vertex[1], edge = ll_sub(b, a);
    double u = ll_dot(ll_sub(c, a), edge) / ll_dot(edge, edge);
    if (ll_dot(ll_sub(c, a), link->normal[0]) < 0)
        return (ll_manifold){0};
    ll_vec2 nearest = u <= 0 ? a : u >= 1 ? b : ll_madd(a, u, edge);
    ll_vec2 normal = ll_normalised(ll_sub(c, nearest));
    if ((u <= 0 || u >= 1) && !segment_takes(link, normal))
        return (ll_manifold){0};
    return points_meet(nearest, 0, c, radius, margin, 0);
}

/* Circle b against hull a. Inside the hull the nearest edge decides, outside the nearest point. */
static ll_manifold hull_circle(const ll_geometry *a, const ll_geometry *b, ll_pose rel, double margin)
{
    ll_vec2 c = ll_to_world(rel, b->vertex[0]);
    if (a->kind == LL_SHAPE_CHAIN_SEGMENT)
        return circle_on_chain(a, c, b->radius, margin);
    axis best = best_axis(a, &c, 1);
    if (best.separation > a->radius + b->radius + margin)
        return (ll_manifold){0};
    ll_vec2 v = a->vertex[best.edge], w = a->vertex[after(a, best.edge)], edge = ll_sub(w, v);
    double u = ll_dot(ll_sub(c, v), edge) / ll_dot(edge, edge);
    if (u <= 0)
        return points_meet(v, a->radius, c, b->radius, margin, 0);
    if (u >= 1)
        return points_meet(w, a->radius, c, b->radius, margin, 0);
    ll_vec2 normal = a->normal[best.edge];
    ll_vec2 on_a = ll_madd(c, a->radius - best.separation, normal), on_b = ll_madd(c, -b->radius, normal);
    return one_point(normal, on_a, on_b, 0);
}

/* The edge of `g` that faces `normal` most directly. */
static int facing_edge(const ll_geometry *g, ll_vec2 normal)
{
    int best = 0;
    double least = INFINITY;
    for (int i = 0; i < g->count; i++) {
        double d = ll_dot(g->normal[i], normal);
        if (d < least) {
            least = d;
            best = i;
        }
    }
    return best;
}

/* Clips the edge p-q to the strip over the reference edge v-w and keeps points nearer than `margin`. `flip`:
 * the reference edge is b's. */
static ll_manifold clip(const ll_geometry *reference, int edge, const ll_geometry *incident, int facing,
                        double margin, bool flip)
{
    ll_vec2 v = reference->vertex[edge], w = reference->vertex[after(reference, edge)];
    ll_vec2 normal = reference->normal[edge], along = ll_normalised(ll_sub(w, v));
    int i0 = facing, i1 = after(incident, facing);
    ll_vec2 p = incident->vertex[i1], q = incident->vertex[i0]; /* reversed: along the reference edge */
    double length = ll_dot(ll_sub(w, v), along);
    double tp = ll_dot(ll_sub(p, v), along), tq = ll_dot(ll_sub(q, v), along);
    ll_manifold m = {.normal = flip ? ll_neg(normal) : normal};
    if (tq < 0 || tp > length)
        return m;
    /* A capsule may be perpendicular to the edge: then there is nothing to clip. */
    bool slanted = tq > tp;
    ll_vec2 ends[2] = {slanted && tp < 0 ? ll_lerp(p, q, -tp / (tq - tp)) : p,
                       slanted && tq > length ? ll_lerp(p, q, (length - tp) / (tq - tp)) : q};
    uint32_t ids[2] = {(uint32_t)(edge << 8 | i1), (uint32_t)(edge << 8 | i0)};
    for (int k = 0; k < 2; k++) {
        double s = ll_dot(ll_sub(ends[k], v), normal);
        double separation = s - reference->radius - incident->radius;
        if (separation > margin)
            continue;
        ll_vec2 middle = ll_madd(ends[k], 0.5 * (reference->radius - incident->radius - s), normal);
        m.at[m.count++] = (ll_manifold_point){middle, separation, ids[k] | (uint32_t)flip << 16};
    }
    return m;
}

static double clamped(double x)
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}

/* Nearest points of two edges, as fractions of them (Ericson, Real-Time Collision Detection, 5.1.9). */
static void nearest_of_edges(ll_vec2 p, ll_vec2 d1, ll_vec2 q, ll_vec2 d2, double *s, double *t)
{
    ll_vec2 r = ll_sub(p, q);
    double a = ll_dot(d1, d1), e = ll_dot(d2, d2), f = ll_dot(d2, r), c = ll_dot(d1, r), b = ll_dot(d1, d2);
    double denominator = a * e - b * b;
    *s = denominator > 1e-12 * a * e ? clamped((b * f - c * e) / denominator) : 0;
    *t = (b * *s + f) / e;
    if (*t < 0 || *t > 1) {
        *t = clamped(*t);
        *s = clamped((b * *t - c) / a);
    }
}

/* Facing sides keep two points if their ends are opposite each other: below this sine a corner counts as part
 * of the side. */
static const double beside_edge = 0.01; /* sine */

/* Corner against corner: separated, and nearest at an end of each edge, so that no edge normal is the
 * direction of least separation. `m`: the manifold of the edges. */
static void corners_meet(const ll_geometry *a, int edge_a, const ll_geometry *b, int edge_b, double margin,
                         ll_manifold *m)
{
    ll_vec2 p = a->vertex[edge_a], q = b->vertex[edge_b];
    ll_vec2 d1 = ll_sub(a->vertex[after(a, edge_a)], p), d2 = ll_sub(b->vertex[after(b, edge_b)], q);
    double s, t;
    nearest_of_edges(p, d1, q, d2, &s, &t);
    if ((s > 0 && s < 1) || (t > 0 && t < 1))
        return;
    ll_vec2 on_a = ll_madd(p, s, d1), on_b = ll_madd(q, t, d2);
    ll_vec2 gap = ll_sub(on_b, on_a);
    double length = ll_length(gap);
    if (length < 0.1 * LL_LINEAR_SLOP ||
        (m->count == 2 && fabs(ll_cross(gap, m->normal)) < beside_edge * length))
        return;
    int va = s > 0 ? after(a, edge_a) : edge_a, vb = t > 0 ? after(b, edge_b) : edge_b;
    *m = points_meet(on_a, a->radius, on_b, b->radius, margin, (uint32_t)(va << 8 | vb | 1 << 17));
}

/* `b` is in a's frame here. */
static ll_manifold hulls(const ll_geometry *a, const ll_geometry *b, double margin)
{
    double reach = a->radius + b->radius + margin;
    axis axis_a = best_axis(a, b->vertex, b->count);
    if (axis_a.separation > reach)
        return (ll_manifold){0};
    axis axis_b = best_axis(b, a->vertex, a->count);
    if (axis_b.separation > reach)
        return (ll_manifold){0};
    /* Of nearly equal axes take the first, or the manifold would jump between them. */
    bool flip = axis_b.separation > axis_a.separation + 0.1 * LL_LINEAR_SLOP;
    int edge_a = flip ? facing_edge(a, b->normal[axis_b.edge]) : axis_a.edge;
    int edge_b = flip ? axis_b.edge : facing_edge(b, a->normal[axis_a.edge]);
    double separation = flip ? axis_b.separation : axis_a.separation;
    ll_manifold m =
        flip ? clip(b, edge_b, a, edge_a, margin, true) : clip(a, edge_a, b, edge_b, margin, false);
    if (separation > 0.1 * LL_LINEAR_SLOP)
        corners_meet(a, edge_a, b, edge_b, margin, &m);
    return m;
}

/* A hull against a chain segment: the segment's normal, or an axis of the hull that the segment may take. */
static ll_manifold hull_on_chain(const ll_geometry *link, const ll_geometry *b, double margin)
{
    if (ll_dot(ll_sub(b->centre, link->vertex[0]), link->normal[0]) < 0)
        return (ll_manifold){0};
    ll_geometry face = *link; /* as a one-sided edge */
    face.count = 2;
    ll_manifold m = hulls(&face, b, margin);
    ll_vec2 along = ll_sub(link->vertex[1], link->vertex[0]);
    if (m.count == 0 || (ll_dot(m.normal, link->normal[0]) > 0 && fabs(ll_dot(m.normal, along)) < 1e-9))
        return m;
    if (segment_takes(link, m.normal))
        return m;
    return clip(&face, 0, b, facing_edge(b, link->normal[0]), margin, false);
}

static ll_geometry moved(const ll_geometry *g, ll_pose rel)
{
    ll_geometry out;
    out.kind = g->kind;
    out.count = g->count;
    out.radius = g->radius;
    out.centre = ll_to_world(rel, g->centre);
    int vertices = g->kind == LL_SHAPE_CHAIN_SEGMENT ? 4 : g->count;
    for (int i = 0; i < vertices; i++)
        out.vertex[i] = ll_to_world(rel, g->vertex[i]);
    for (int i = 0; i < g->count; i++)
        out.normal[i] = ll_rotate(rel.q, g->normal[i]);
    return out;
}

static ll_manifold turned_round(ll_manifold m)
{
    m.normal = ll_neg(m.normal);
    return m;
}

ll_manifold ll_collide(const ll_geometry *a, const ll_geometry *b, ll_pose rel, double margin)
{
    if (a->count == 1 && b->count == 1)
        return points_meet(a->vertex[0], a->radius, ll_to_world(rel, b->vertex[0]), b->radius, margin, 0);
    if (b->count == 1)
        return hull_circle(a, b, rel, margin);
    ll_geometry other = moved(b, rel);
    const ll_pose same = {{0, 0}, {1, 0}};
    if (a->count == 1)
        return turned_round(hull_circle(&other, a, same, margin));
    if (a->kind == LL_SHAPE_CHAIN_SEGMENT)
        return hull_on_chain(a, &other, margin);
    if (other.kind == LL_SHAPE_CHAIN_SEGMENT)
        return turned_round(hull_on_chain(&other, a, margin));
    return hulls(a, &other, margin);
}
