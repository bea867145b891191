#include "rigid/shape/distance.h"

#include "base/detmath.h"

enum { TOI_ITERATIONS = 100 };

typedef struct corner { /* of the Minkowski difference b - a */
    ll_vec2 a, b, w;
    double weight;
    int index_a, index_b;
} corner;

/* The first `count` corners span the part that is nearest to the origin. */
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

/* The part of a segment that is nearest to the origin. */
typedef struct segment_part {
    int first, count; /* of its two ends */
    double weight[2]; /* of those */
    ll_vec2 p;        /* the nearest point */
} segment_part;

static inline segment_part part_of_segment(ll_vec2 w0, ll_vec2 w1)
{
    ll_vec2 edge = ll_sub(w1, w0);
    double to0 = -ll_dot(w0, edge), to1 = ll_dot(w1, edge);
    if (to0 <= 0)
        return (segment_part){.first = 0, .count = 1, .weight = {1}, .p = w0};
    if (to1 <= 0)
        return (segment_part){.first = 1, .count = 1, .weight = {1}, .p = w1};
    segment_part both = {.first = 0, .count = 2, .weight = {to1 / (to0 + to1), to0 / (to0 + to1)}};
    both.p = ll_madd(ll_scale(both.weight[0], w0), both.weight[1], w1);
    return both;
}

static inline void take_part(const corner *c0, const corner *c1, const segment_part *part, simplex *out)
{
    out->count = part->count;
    out->at[0] = part->first == 0 ? *c0 : *c1;
    out->at[0].weight = part->weight[0];
    if (part->count == 2) {
        out->at[1] = *c1;
        out->at[1].weight = part->weight[1];
    }
}

/* Each of these returns the nearest point. */
static inline ll_vec2 reduce_two(const corner at[2], simplex *out)
{
    segment_part part = part_of_segment(at[0].w, at[1].w);
    take_part(&at[0], &at[1], &part, out);
    return part.p;
}

/* Of a triangle: all, if the origin is inside, or the nearest part of its edges. */
static ll_vec2 reduce_three(const corner at[3], simplex *out)
{
    ll_vec2 w0 = at[0].w, w1 = at[1].w, w2 = at[2].w;
    double a0 = ll_cross(w1, w2), a1 = ll_cross(w2, w0), a2 = ll_cross(w0, w1);
    double area = ll_cross(ll_sub(w1, w0), ll_sub(w2, w0));
    if (area != 0 && a0 * area > 0 && a1 * area > 0 && a2 * area > 0) {
        const double weight[3] = {a0 / (a0 + a1 + a2), a1 / (a0 + a1 + a2), a2 / (a0 + a1 + a2)};
        ll_vec2 p = {0, 0};
        for (int i = 0; i < 3; i++) {
            out->at[i] = at[i];
            out->at[i].weight = weight[i];
            p = ll_madd(p, weight[i], at[i].w);
        }
        out->count = 3;
        return p;
    }
    int best = 0;
    segment_part part = part_of_segment(w1, w2), second = part_of_segment(w2, w0),
                 third = part_of_segment(w0, w1);
    if (ll_dot(second.p, second.p) < ll_dot(part.p, part.p)) {
        best = 1;
        part = second;
    }
    if (ll_dot(third.p, third.p) < ll_dot(part.p, part.p)) {
        best = 2;
        part = third;
    }
    take_part(&at[(best + 1) % 3], &at[(best + 2) % 3], &part, out);
    return part.p;
}

static bool holds(const simplex *s, const corner *c)
{
    for (int i = 0; i < s->count; i++)
        if (s->at[i].index_a == c->index_a && s->at[i].index_b == c->index_b)
            return true;
    return false;
}

typedef struct walk_end {
    simplex part; /* count 3: the hulls overlap */
    ll_vec2 p;    /* its nearest point */
    int iterations;
} walk_end;

/* Moves the simplex towards the origin. Each iteration adds a new corner or ends, so their count is bounded
 * by that of the corners. Rounding cannot make it cycle, because a corner must also come nearer to the
 * origin. */
static inline void walk(const ll_geometry *a, const ll_geometry *b, ll_pose rel, walk_end *end)
{
    simplex next;
    end->part.count = 1;
    end->part.at[0] = corner_at(a, b, rel, 0, 0);
    end->p = end->part.at[0].w;
    for (end->iterations = 1;;) {
        double least = ll_dot(end->p, end->p);
        if (least == 0)
            return;
        simplex *s = &end->part;
        corner c = corner_at(a, b, rel, support(a, end->p), support(b, ll_unrotate(rel.q, ll_neg(end->p))));
        if (holds(s, &c) || ++end->iterations > 2 * LL_HULL_MAX * LL_HULL_MAX)
            return;
        s->at[s->count] = c;
        ll_vec2 p = s->count == 1 ? reduce_two(s->at, &next) : reduce_three(s->at, &next);
        if (next.count < 3 && ll_dot(p, p) >= least)
            return;
        *s = next;
        end->p = p;
        if (next.count == 3)
            return;
    }
}

/* Distance, normal and iterations; ll_distance adds the points. */
static inline ll_distance_result distance_of(const ll_geometry *a, ll_pose pose_a, const ll_geometry *b,
                                             ll_pose pose_b, walk_end *end)
{
    ll_distance_result result = {0};
    walk(a, b, ll_pose_between(pose_a, pose_b), end);
    result.iterations = end->iterations;
    double length = end->part.count == 3 ? 0 : ll_length(end->p), radii = a->radius + b->radius;
    if (length > 0)
        result.normal = ll_rotate(pose_a.q, ll_scale(1 / length, end->p));
    result.distance = length > radii ? length - radii : 0;
    return result;
}

ll_distance_result ll_distance(const ll_geometry *a, ll_pose pose_a, const ll_geometry *b, ll_pose pose_b)
{
    walk_end end;
    ll_distance_result result = distance_of(a, pose_a, b, pose_b, &end);
    ll_vec2 point_a = {0, 0}, point_b = {0, 0};
    for (int i = 0; i < end.part.count; i++) {
        point_a = ll_madd(point_a, end.part.at[i].weight, end.part.at[i].a);
        point_b = ll_madd(point_b, end.part.at[i].weight, end.part.at[i].b);
    }
    double length = end.part.count == 3 ? 0 : ll_length(end.p);
    if (length > 0) {
        ll_vec2 normal = ll_scale(1 / length, end.p);
        point_a = ll_madd(point_a, a->radius, normal);
        point_b = ll_madd(point_b, -b->radius, normal);
    }
    result.point_a = ll_to_world(pose_a, point_a);
    result.point_b = ll_to_world(pose_a, point_b);
    return result;
}

ll_pose ll_sweep_at(const ll_sweep *sweep, double t)
{
    double angle = sweep->turn * t; /* most obstacles do not turn */
    ll_rot turn = angle == 0 ? (ll_rot){1, 0} : (ll_rot){ll_cos(angle), ll_sin(angle)};
    return (ll_pose){ll_madd(sweep->start.p, t, sweep->shift), ll_rot_mul(sweep->start.q, turn)};
}

/* A side of a's hull that separates the shapes at the start, with enough room for all of the motion. The room
 * that is added to the margin is a fiftieth of the largest motion: an iteration of ll_time_of_impact then
 * passes at least a fiftieth of the step, so that it never uses up its iterations. */
bool ll_sweeps_stay_apart(const ll_geometry *a, const ll_sweep *sweep_a, const ll_geometry *b,
                          const ll_sweep *sweep_b, double margin)
{
    ll_vec2 at[LL_HULL_MAX], shift = ll_sub(sweep_b->shift, sweep_a->shift);
    ll_pose rel = ll_pose_between(sweep_a->start, sweep_b->start);
    double turns = fabs(sweep_a->turn) * ll_shape_extent(a) + fabs(sweep_b->turn) * ll_shape_extent(b);
    double needed = margin + a->radius + b->radius + (turns + ll_length(shift)) / (TOI_ITERATIONS / 2);
    ll_vec2 local = ll_unrotate(sweep_a->start.q, shift);
    for (int k = 0; k < b->count; k++)
        at[k] = ll_to_world(rel, b->vertex[k]);
    for (int i = 0; i < a->count && a->count > 1; i++) {
        double nearest = INFINITY, closing = ll_max(turns - ll_dot(a->normal[i], local), 0);
        for (int k = 0; k < b->count; k++)
            nearest = ll_min(nearest, ll_dot(a->normal[i], ll_sub(at[k], a->vertex[i])));
        if (nearest >= needed + closing)
            return true;
    }
    return false;
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
    walk_end end;
    for (touch.iterations = 1; touch.iterations <= TOI_ITERATIONS; touch.iterations++) {
        ll_distance_result d =
            distance_of(a, ll_sweep_at(sweep_a, touch.t), b, ll_sweep_at(sweep_b, touch.t), &end);
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
