#include "rigid/shape/shape.h"

#include <string.h>

#include "base/detmath.h"

const char *ll_shape_name(ll_shape_kind kind)
{
    static const char *const names[LL_SHAPE_KINDS] = {"circle", "capsule", "polygon", "segment", "link"};
    return names[kind];
}

bool ll_shape_is_solid(ll_shape_kind kind)
{
    return kind != LL_SHAPE_SEGMENT && kind != LL_SHAPE_CHAIN_SEGMENT;
}

static ll_status check_points(const char *what, const ll_vec2 *points, int count)
{
    for (int i = 0; i < count; i++)
        if (!(fabs(points[i].x) <= LL_WORLD_MAX && fabs(points[i].y) <= LL_WORLD_MAX))
            return ll_error(
                LL_BAD_INPUT,
                "%s: coordinates must be finite and at most %g in size; got vertex %d at (%g, %g).", what,
                LL_WORLD_MAX, i, points[i].x, points[i].y);
    return ll_ok();
}

static ll_status check_radius(const char *what, double radius)
{
    if (radius >= LL_LINEAR_SLOP && radius <= LL_WORLD_MAX)
        return ll_ok();
    return ll_error(LL_BAD_INPUT, "%s: the radius must be %g to %g m; got %g.", what, LL_LINEAR_SLOP,
                    LL_WORLD_MAX, radius);
}

ll_status ll_shape_circle(ll_vec2 centre, double radius, ll_geometry *out)
{
    ll_status status = check_points("circle", &centre, 1);
    LL_THEN(status, check_radius("circle", radius));
    if (!ll_failed(&status))
        *out = (ll_geometry){
            .kind = LL_SHAPE_CIRCLE, .count = 1, .radius = radius, .centre = centre, .vertex[0] = centre};
    return status;
}

static ll_status two_points(ll_shape_kind kind, ll_vec2 a, ll_vec2 b, double radius, ll_geometry *out)
{
    ll_vec2 points[2] = {a, b};
    LL_TRY(check_points(ll_shape_name(kind), points, 2));
    double length = ll_length(ll_sub(b, a));
    if (length < LL_LINEAR_SLOP)
        return ll_error(LL_BAD_INPUT, "%s: the ends must be at least %g m apart; got %g.",
                        ll_shape_name(kind), LL_LINEAR_SLOP, length);
    ll_vec2 normal = ll_scale(1 / length, ll_right(ll_sub(b, a)));
    *out = (ll_geometry){.kind = (int32_t)kind,
                         .count = 2,
                         .radius = radius,
                         .centre = ll_lerp(a, b, 0.5),
                         .vertex = {a, b},
                         .normal = {normal, ll_neg(normal)}};
    return ll_ok();
}

ll_status ll_shape_capsule(ll_vec2 a, ll_vec2 b, double radius, ll_geometry *out)
{
    ll_status status = check_radius("capsule", radius);
    return ll_failed(&status) ? status : two_points(LL_SHAPE_CAPSULE, a, b, radius, out);
}

ll_status ll_shape_segment(ll_vec2 a, ll_vec2 b, ll_geometry *out)
{
    return two_points(LL_SHAPE_SEGMENT, a, b, 0, out);
}

ll_status ll_shape_chain_segment(ll_vec2 before, ll_vec2 a, ll_vec2 b, ll_vec2 after, ll_geometry *out)
{
    ll_vec2 ghosts[2] = {before, after};
    ll_status status = check_points("chain", ghosts, 2);
    LL_THEN(status, two_points(LL_SHAPE_CHAIN_SEGMENT, a, b, 0, out));
    if (!ll_failed(&status)) {
        out->vertex[2] = before;
        out->vertex[3] = after;
    }
    return status;
}

static double signed_area(const ll_vec2 *v, int count)
{
    double area = 0;
    for (int i = 1; i + 1 < count; i++)
        area += 0.5 * ll_cross(ll_sub(v[i], v[0]), ll_sub(v[i + 1], v[0]));
    return area;
}

/* Convex and closed once: every corner turns left, and all turn by one full circle together, unlike a star's.
 * The second part is checked by every vertex being left of every edge. */
static ll_status check_convex(const ll_geometry *g)
{
    for (int i = 0; i < g->count; i++)
        if (ll_length(ll_sub(g->vertex[(i + 1) % g->count], g->vertex[i])) < 0.1 * LL_LINEAR_SLOP)
            return ll_error(LL_BAD_INPUT, "polygon: vertices %d and %d are closer than %g m.", i,
                            (i + 1) % g->count, 0.1 * LL_LINEAR_SLOP);
    for (int i = 0; i < g->count; i++) {
        for (int k = 0; k < g->count; k++) {
            double inside = ll_dot(g->normal[i], ll_sub(g->vertex[i], g->vertex[k]));
            if (k != i && k != (i + 1) % g->count && inside < 0.1 * LL_LINEAR_SLOP)
                return ll_error(LL_BAD_INPUT,
                                "polygon: not convex, or degenerate: vertex %d is %g m inside the edge after "
                                "vertex %d and must be at least %g m.",
                                k, inside, i, 0.1 * LL_LINEAR_SLOP);
        }
    }
    return ll_ok();
}

ll_status ll_shape_polygon(const ll_vec2 *points, int count, ll_geometry *out)
{
    if (count < 3 || count > LL_HULL_MAX)
        return ll_error(LL_BAD_INPUT, "polygon: must have 3 to %d vertices; got %d.", LL_HULL_MAX, count);
    LL_TRY(check_points("polygon", points, count));
    ll_geometry g = {.kind = LL_SHAPE_POLYGON, .count = count};
    bool clockwise = signed_area(points, count) < 0;
    for (int i = 0; i < count; i++)
        g.vertex[i] = points[clockwise ? count - 1 - i : i];
    for (int i = 0; i < count; i++)
        g.normal[i] = ll_normalised(ll_right(ll_sub(g.vertex[(i + 1) % count], g.vertex[i])));
    ll_status status = check_convex(&g);
    if (!ll_failed(&status)) {
        g.centre = ll_shape_mass(&g, 1).centre;
        *out = g;
    }
    return status;
}

ll_status ll_shape_box(double width, double height, ll_vec2 centre, double angle, ll_geometry *out)
{
    if (!(width >= 0.2 * LL_LINEAR_SLOP && height >= 0.2 * LL_LINEAR_SLOP && width <= LL_WORLD_MAX &&
          height <= LL_WORLD_MAX))
        return ll_error(LL_BAD_INPUT, "box: both sides must be %g to %g m; got %g x %g.",
                        0.2 * LL_LINEAR_SLOP, LL_WORLD_MAX, width, height);
    if (!(fabs(angle) <= 1e6))
        return ll_error(LL_BAD_INPUT, "box: the angle must be finite and at most 1e6 rad; got %g.", angle);
    LL_TRY(check_points("box", &centre, 1));
    ll_rot q = {ll_cos(angle), ll_sin(angle)};
    ll_pose pose = {centre, q};
    double x = 0.5 * width, y = 0.5 * height;
    *out = (ll_geometry){.kind = LL_SHAPE_POLYGON,
                         .count = 4,
                         .centre = centre,
                         .vertex = {ll_to_world(pose, ll_vec(-x, -y)), ll_to_world(pose, ll_vec(x, -y)),
                                    ll_to_world(pose, ll_vec(x, y)), ll_to_world(pose, ll_vec(-x, y))},
                         .normal = {ll_rotate(q, ll_vec(0, -1)), ll_rotate(q, ll_vec(1, 0)),
                                    ll_rotate(q, ll_vec(0, 1)), ll_rotate(q, ll_vec(-1, 0))}};
    return ll_ok();
}

static const double pi = 3.14159265358979323846;

static ll_mass circle_mass(const ll_geometry *g, double density)
{
    double r2 = g->radius * g->radius, mass = density * pi * r2;
    return (ll_mass){mass, 0.5 * mass * r2, g->centre};
}

/* A rectangle and two half discs, whose centroids are 4 r / 3 pi from their flat side. */
static ll_mass capsule_mass(const ll_geometry *g, double density)
{
    double r = g->radius, length = ll_length(ll_sub(g->vertex[1], g->vertex[0]));
    double discs = density * pi * r * r, box = density * 2 * r * length;
    double centroid = 4 * r / (3 * pi), far = 0.5 * length + centroid;
    double inertia =
        discs * (0.5 * r * r - centroid * centroid + far * far) + box * (4 * r * r + length * length) / 12;
    return (ll_mass){discs + box, inertia, g->centre};
}

/* Sum over a triangle fan about the first vertex, which keeps digits far from the origin. */
static ll_mass polygon_mass(const ll_geometry *g, double density)
{
    ll_vec2 origin = g->vertex[0], centre = {0, 0};
    double area = 0, second = 0;
    for (int i = 1; i + 1 < g->count; i++) {
        ll_vec2 a = ll_sub(g->vertex[i], origin), b = ll_sub(g->vertex[i + 1], origin);
        double cross = ll_cross(a, b);
        area += 0.5 * cross;
        centre = ll_madd(centre, cross / 6, ll_add(a, b));
        second += cross / 12 * (ll_dot(a, a) + ll_dot(a, b) + ll_dot(b, b));
    }
    centre = ll_scale(1 / area, centre);
    double mass = density * area;
    return (ll_mass){mass, density * second - mass * ll_dot(centre, centre), ll_add(origin, centre)};
}

ll_mass ll_shape_mass(const ll_geometry *g, double density)
{
    switch ((ll_shape_kind)g->kind) {
    case LL_SHAPE_CIRCLE:
        return circle_mass(g, density);
    case LL_SHAPE_CAPSULE:
        return capsule_mass(g, density);
    case LL_SHAPE_POLYGON:
        return polygon_mass(g, density);
    default:
        return (ll_mass){0, 0, g->centre};
    }
}

double ll_shape_area(const ll_geometry *g)
{
    return ll_shape_mass(g, 1).mass;
}

ll_aabb ll_shape_aabb(const ll_geometry *g, ll_pose pose)
{
    ll_vec2 first = ll_to_world(pose, g->vertex[0]);
    ll_aabb box = {first, first};
    for (int i = 1; i < g->count; i++) {
        ll_vec2 v = ll_to_world(pose, g->vertex[i]);
        box = ll_aabb_union(box, (ll_aabb){v, v});
    }
    return ll_aabb_grown(box, g->radius);
}

double ll_shape_extent(const ll_geometry *g)
{
    double extent = 0;
    for (int i = 0; i < g->count; i++)
        extent = ll_max(extent, ll_length(g->vertex[i]));
    return extent + g->radius;
}

double ll_shape_core(const ll_geometry *g)
{
    if (g->kind != LL_SHAPE_POLYGON)
        return g->radius;
    double core = INFINITY;
    for (int i = 0; i < g->count; i++)
        core = ll_min(core, ll_dot(g->normal[i], ll_sub(g->vertex[i], g->centre)));
    return core;
}

void ll_shape_shift(ll_geometry *g, ll_vec2 by)
{
    int count = g->kind == LL_SHAPE_CHAIN_SEGMENT ? 4 : g->count;
    for (int i = 0; i < count; i++)
        g->vertex[i] = ll_add(g->vertex[i], by);
    g->centre = ll_add(g->centre, by);
}
