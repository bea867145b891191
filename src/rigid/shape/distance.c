#include "rigid/shape/distance.h"

#include "base/detmath.h"

typedef struct corner { /* of the Minkowski difference b - a */
    ll_vec2 a, b, w;
    double weight;
    int index_a, index_b;
} corner;

typedef struct simplex {
    corner at[3];
    int count;
} simplex;

static int support(const ll_geometry *g, ll_vec2 direction)
{
    int best = 0;
    double most = ll_dot(g->vertex[0], direction);
    for (int i = 1; i < g->count; i++) {
        double along = ll_dot(g->vertex[i], direction);
        if (along > most) {
            most = along;
            best = i;
        }
    }
    return best;
}

/* Everything is in a's frame; `rel` is the pose of b in it. */
static corner corner_at(const ll_geometry *a, const ll_geometry *b, ll_pose rel, int index_a, int index_b)
{
    corner c = {.index_a = index_a, .index_b = index_b, .weight = 1};
    c.a = a->vertex[index_a];
    c.b = ll_to_world(rel, b->vertex[index_b]);
    c.w = ll_sub(c.b, c.a);
    return c;
}

/* Reduces a segment to its part nearest to the origin. */
static void reduce_two(simplex *s)
{
    ll_vec2 w0 = s->at[0].w, w1 = s->at[1].w, edge = ll_sub(w1, w0);
    double to0 = -ll_dot(w0, edge), to1 = ll_dot(w1, edge);
    if (to0 <= 0) {
        s->count = 1;
    } else if (to1 <= 0) {
        s->at[0] = s->at[1];
        s->count = 1;
    } else {
        s->at[0].weight = to1 / (to0 + to1);
        s->at[1].weight = to0 / (to0 + to1);
        return;
    }
    s->at[0].weight = 1;
}

/* The same for a triangle: the origin is inside, or the nearest point is on the nearest of its edges. */
static void reduce_three(simplex *s)
{
    ll_vec2 w0 = s->at[0].w, w1 = s->at[1].w, w2 = s->at[2].w;
    double a0 = ll_cross(w1, w2), a1 = ll_cross(w2, w0), a2 = ll_cross(w0, w1);
    double area = ll_cross(ll_sub(w1, w0), ll_sub(w2, w0));
    if (area != 0 && a0 * area > 0 && a1 * area > 0 && a2 * area > 0) {
        s->at[0].weight = a0 / (a0 + a1 + a2);
        s->at[1].weight = a1 / (a0 + a1 + a2);
        s->at[2].weight = a2 / (a0 + a1 + a2);
        return;
    }
    simplex best = *s;
    double least = INFINITY;
    for (int skip = 0; skip < 3; skip++) {
        simplex edge = {.count = 2};
        edge.at[0] = s->at[(skip + 1) % 3];
        edge.at[1] = s->at[(skip + 2) % 3];
        reduce_two(&edge);
        ll_vec2 p = ll_scale(edge.at[0].weight, edge.at[0].w);
        if (edge.count == 2)
            p = ll_madd(p, edge.at[1].weight, edge.at[1].w);
        if (ll_dot(p, p) < least) {
            least = ll_dot(p, p);
            best = edge;
        }
    }
    *s = best;
}

static ll_vec2 nearest(const simplex *s)
{
    ll_vec2 p = {0, 0};
    for (int i = 0; i < s->count; i++)
        p = ll_madd(p, s->at[i].weight, s->at[i].w);
    return p;
}

static bool holds(const simplex *s, const corner *c)
{
    for (int i = 0; i < s->count; i++)
        if (s->at[i].index_a == c->index_a && s->at[i].index_b == c->index_b)
            return true;
    return false;
}

/* Moves the simplex towards the origin. Each iteration adds a new corner or ends, so their count is bounded
 * by that of the corners. Rounding cannot make it cycle, because a corner must also come nearer to the
 * origin. */
static simplex walk(const ll_geometry *a, const ll_geometry *b, ll_pose rel, int *iterations)
{
    simplex s = {.count = 1};
    s.at[0] = corner_at(a, b, rel, 0, 0);
    double least = INFINITY;
    simplex best = s;
    for (*iterations = 1; *iterations <= 2 * LL_HULL_MAX * LL_HULL_MAX; (*iterations)++) {
        if (s.count == 2)
            reduce_two(&s);
        else if (s.count == 3)
            reduce_three(&s);
        ll_vec2 p = nearest(&s);
        if (s.count == 3)
            return s;
        if (ll_dot(p, p) >= least)
            return best;
        least = ll_dot(p, p);
        best = s;
        if (least == 0)
            return s;
        corner next = corner_at(a, b, rel, support(a, p), support(b, ll_unrotate(rel.q, ll_neg(p))));
        if (holds(&s, &next))
            return s;
        s.at[s.count++] = next;
    }
    return best;
}

ll_distance_result ll_distance(const ll_geometry *a, ll_pose pose_a, const ll_geometry *b, ll_pose pose_b)
{
    ll_distance_result result = {0};
    simplex s = walk(a, b, ll_pose_between(pose_a, pose_b), &result.iterations);
    ll_vec2 point_a = {0, 0}, point_b = {0, 0};
    for (int i = 0; i < s.count; i++) {
        point_a = ll_madd(point_a, s.at[i].weight, s.at[i].a);
        point_b = ll_madd(point_b, s.at[i].weight, s.at[i].b);
    }
    ll_vec2 gap = nearest(&s);
    double length = s.count == 3 ? 0 : ll_length(gap);
    double radii = a->radius + b->radius;
    if (length > 0) {
        ll_vec2 normal = ll_scale(1 / length, gap);
        point_a = ll_madd(point_a, a->radius, normal);
        point_b = ll_madd(point_b, -b->radius, normal);
        result.normal = ll_rotate(pose_a.q, normal);
    }
    result.distance = length > radii ? length - radii : 0;
    result.point_a = ll_to_world(pose_a, point_a);
    result.point_b = ll_to_world(pose_a, point_b);
    return result;
}

ll_pose ll_sweep_at(const ll_sweep *sweep, double t)
{
    ll_rot turn = {ll_cos(sweep->turn * t), ll_sin(sweep->turn * t)};
    return (ll_pose){ll_madd(sweep->start.p, t, sweep->shift), ll_rot_mul(sweep->start.q, turn)};
}

/* Along the axis of separation, no point of a shape approaches faster than its body's speed along it plus the
 * rotation at the farthest point. So the shapes are still apart after (distance - target) / that speed. */
ll_toi_result ll_time_of_impact(const ll_geometry *a, const ll_sweep *sweep_a, const ll_geometry *b,
                                const ll_sweep *sweep_b, double target)
{
    const double tolerance = 0.05 * target;
    double revolute_limits =
        fabs(sweep_a->turn) * ll_shape_extent(a) + fabs(sweep_b->turn) * ll_shape_extent(b);
    ll_vec2 shift = ll_sub(sweep_b->shift, sweep_a->shift);
    ll_toi_result touch = {.t = 0};
    for (touch.iterations = 1; touch.iterations <= 100; touch.iterations++) {
        ll_distance_result d =
            ll_distance(a, ll_sweep_at(sweep_a, touch.t), b, ll_sweep_at(sweep_b, touch.t));
        if (d.distance <= target + tolerance) {
            touch.hit = touch.iterations > 1;
            touch.t = touch.hit ? touch.t : 1;
            return touch;
        }
        double speed = revolute_limits - ll_dot(shift, d.normal);
        if (speed <= 0 || touch.t + (d.distance - target) / speed >= 1) {
            touch.t = 1;
            return touch;
        }
        touch.t += (d.distance - target) / speed;
    }
    touch.hit = true; /* a grazing contact: still apart, and as near as the iteration came */
    return touch;
}
