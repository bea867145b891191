/* Swept detection: a body that would pass through another in this step is put where it first touched.
 *
 * The solver has moved every body; nothing is written to the poses yet. A body that moved more than half of
 * its core is swept against whatever its path's box overlaps, also what moves itself, but is not lighter: of
 * two bodies the lighter one yields. At the earliest touch it stays at the same place of the other body,
 * which goes on to its own end: so nothing passes and nothing is left overlapping, however fast either is.
 * Where that would carry it through something that does not move, it stays there instead. What remains of its
 * motion in this step is lost; its velocity is not, and the next step's contact deals with it. There is no
 * limit to the speed. */
#include "rigid/internal.h"

#include "base/detmath.h"
#include "rigid/distance.h"

typedef struct search {
    ll_rigid *world;
    int32_t body, other;
    int32_t shape; /* of the body */
    bool still;    /* only against what does not move in this step */
    double t;
} search;

static ll_sweep sweep_of(const ll_rigid *w, int32_t body)
{
    const ll_motion *m = &ll_motions(w)[body];
    return (ll_sweep){ll_poses(w)[body], m->d, m->turn};
}

static ll_pose end_of(const ll_rigid *w, int32_t body)
{
    const ll_motion *m = &ll_motions(w)[body];
    ll_pose start = ll_poses(w)[body];
    return (ll_pose){ll_add(start.p, m->d), ll_rot_normalised(ll_rot_mul(start.q, m->q))};
}

static bool collide_at_all(const ll_shape *a, const ll_shape *b)
{
    return (a->category & b->mask) != 0 && (b->category & a->mask) != 0 &&
           (a->group == 0 || a->group != b->group);
}

/* A body whose surface is in touch already can still go through, or turn through: then it is swept as if it
 * were smaller, by as little as sets it apart. */
static bool set_apart(ll_geometry *g, ll_pose pose, const ll_geometry *other, ll_pose other_pose,
                      double target)
{
    static const double sizes[] = {1, 0.8, 0.5, 0.2};
    const ll_geometry whole = *g;
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < g->count; k++)
            g->vertex[k] = ll_lerp(whole.centre, whole.vertex[k], sizes[i]);
        g->radius = sizes[i] * whole.radius;
        if (ll_distance(g, pose, other, other_pose).distance > 1.1 * target)
            return true;
    }
    return false;
}

/* Whether two bodies move enough to each other in this step for one to get through the other, and come near
 * enough: the circles around them, one of which goes along a segment. */
static bool may_pass(const ll_rigid *w, int32_t a, int32_t b)
{
    const ll_motion *ma = &ll_motions(w)[a], *mb = &ll_motions(w)[b];
    const ll_body *body_a = &ll_bodys(w)[a], *body_b = &ll_bodys(w)[b];
    double turning = fabs(ma->turn) * body_a->extent + fabs(mb->turn) * body_b->extent;
    ll_vec2 path = ll_sub(ma->d, mb->d), gap = ll_sub(ll_poses(w)[b].p, ll_poses(w)[a].p);
    double length2 = ll_dot(path, path), enough = 0.5 * body_a->core - turning;
    if (enough > 0 && length2 <= enough * enough)
        return false;
    double t = length2 > 0 ? ll_min(ll_max(ll_dot(gap, path) / length2, 0), 1) : 0;
    ll_vec2 nearest = ll_madd(gap, -t, path);
    double reach = body_a->extent + body_b->extent + LL_LINEAR_SLOP;
    return ll_dot(nearest, nearest) <= reach * reach;
}

static bool is_still(const ll_motion *m)
{
    return m->d.x == 0 && m->d.y == 0 && m->turn == 0;
}

static void consider(void *context, int32_t other_shape)
{
    search *s = context;
    const ll_rigid *w = s->world;
    const ll_shape *shape = &ll_shapes(w)[s->shape], *other = &ll_shapes(w)[other_shape];
    if (other->body == s->body || ll_traits(w)[other->body].inv_mass > ll_traits(w)[s->body].inv_mass ||
        (s->still && !is_still(&ll_motions(w)[other->body])) || !may_pass(w, s->body, other->body) ||
        !collide_at_all(shape, other) || ll_joined(w, s->body, other->body))
        return;
    ll_geometry room_a, room_b, a = *ll_geometry_of(w, shape, &room_a);
    const ll_geometry *b = ll_geometry_of(w, other, &room_b);
    ll_sweep sweep_a = sweep_of(w, s->body), sweep_b = sweep_of(w, other->body);
    double target = ll_min(0.25 * LL_LINEAR_SLOP, 0.1 * shape->core);
    if (!set_apart(&a, sweep_a.start, b, sweep_b.start, target))
        return;
    if (b->kind == LL_SHAPE_LINK &&
        ll_dot(b->normal[0],
               ll_sub(ll_to_local(sweep_b.start, ll_to_world(sweep_a.start, a.centre)), b->vertex[0])) < 0)
        return;
    ll_touch touch = ll_first_touch(b, &sweep_b, &a, &sweep_a, target);
    if (touch.hit && (touch.t < s->t || (touch.t == s->t && other->body < s->other))) {
        s->t = touch.t;
        s->other = other->body;
    }
}

/* The body keeps its place at the other from the touch on. */
static void stop(ll_rigid *w, const search *s)
{
    ll_sweep sweep = sweep_of(w, s->body), other = sweep_of(w, s->other);
    ll_pose touched = ll_sweep_at(&sweep, s->t);
    ll_pose seen = ll_pose_between(ll_sweep_at(&other, s->t), touched);
    ll_pose end = ll_pose_mul(end_of(w, s->other), seen);
    ll_motion *m = &ll_motions(w)[s->body];
    m->d = ll_sub(end.p, sweep.start.p);
    m->turn = s->t * m->turn + (1 - s->t) * other.turn;
    m->q = (ll_rot){ll_cos(m->turn), ll_sin(m->turn)};
    w->stats.stopped++;
}

static bool is_fast(const ll_rigid *w, int32_t body)
{
    const ll_body *b = &ll_bodys(w)[body];
    const ll_motion *m = &ll_motions(w)[body];
    return b->type == LL_BODY_DYNAMIC && ll_length(m->d) + fabs(m->turn) * b->extent > 0.5 * b->core;
}

/* Where a shape is at any time of this step. */
static ll_aabb path_box(const ll_rigid *w, int32_t body, int32_t shape)
{
    const ll_motion *m = &ll_motions(w)[body];
    const ll_shape *s = &ll_shapes(w)[shape];
    ll_aabb box = ll_aabb_union(ll_tight_box(w, s, ll_poses(w)[body]), ll_tight_box(w, s, end_of(w, body)));
    double turn = fabs(m->turn);
    return ll_aabb_grown(box, (turn < 1 ? 0.5 * turn : 2) * ll_bodys(w)[body].extent);
}

/* So that the query of another finds it there. */
static void cover_paths(ll_rigid *w)
{
    for (int32_t i = 0; i < w->awake; i++) {
        int32_t body = ll_awakes(w)[i];
        const ll_motion *m = &ll_motions(w)[body];
        ll_body *b = &ll_bodys(w)[body];
        if (b->drift + ll_length(m->d) + fabs(m->turn) * b->extent <= b->slack)
            continue;
        b->drift = INFINITY; /* made anew at the end of the step */
        for (int32_t s = b->shape; s != LL_NONE; s = ll_shapes(w)[s].next) {
            ll_boxs(w)[s] = path_box(w, body, s);
            ll_broad_of(w)->move(ll_broad_state(w), ll_boxs(w), s);
        }
    }
}

static void find_first_touch(ll_rigid *w, search *s)
{
    for (s->shape = ll_bodys(w)[s->body].shape; s->shape != LL_NONE; s->shape = ll_shapes(w)[s->shape].next)
        ll_broad_of(w)->query(ll_broad_state(w), ll_boxs(w), path_box(w, s->body, s->shape), consider, s);
}

void ll_stop_at_first_touch(ll_rigid *w)
{
    w->stats.swept = w->stats.stopped = 0;
    if (w->params.continuous != LL_CONTINUOUS_SWEPT)
        return;
    cover_paths(w);
    for (int32_t i = 0; i < w->awake; i++) {
        search s = {.world = w, .body = ll_awakes(w)[i], .other = LL_NONE, .t = 1};
        if (!is_fast(w, s.body))
            continue;
        w->stats.swept++;
        find_first_touch(w, &s);
        if (s.other == LL_NONE)
            continue;
        bool carried = !is_still(&ll_motions(w)[s.other]);
        stop(w, &s);
        if (!carried)
            continue;
        s = (search){.world = w, .body = s.body, .other = LL_NONE, .still = true, .t = 1};
        find_first_touch(w, &s); /* what moves it may carry it through a wall */
        if (s.other != LL_NONE)
            stop(w, &s);
    }
}
