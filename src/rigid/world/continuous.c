/* Continuous collision detection: a body that would tunnel through another in this step is put where they
 * first touched.
 *
 * The solver has moved every body; poses are not written yet. A body that moved more than half of its core is
 * swept against all that its path's box overlaps and that is static, kinematic or at least four times as
 * heavy: of two bodies the lighter one yields, and bodies of similar mass are left to their contacts. From
 * the earliest time of impact on, the body keeps its position relative to the other, which goes on to its own
 * end. So nothing tunnels and nothing is left overlapping, at any speed. If that would carry the body through
 * something that does not move, it stays at the impact instead. The rest of its motion in this step is lost;
 * its velocity is not, and the contact of the next step deals with it.
 *
 * A fast bullet is then swept against every dynamic body too, each on its own path up to where it stops. Both
 * stop at an impact, for any masses. Impacts are handled in the order of time, and bullets that hit a
 * body which had stopped by then are swept again.
 *
 * Costs a query and a few distances for each fast body, or, if there are fewer obstacles than fast bodies, a
 * query for each obstacle. A fast bullet costs another query, and a pass over all bullets per impact. */
#include "rigid/world/continuous.h"

#include <string.h>

#include "base/detmath.h"
#include "rigid/contact/contact.h"
#include "rigid/shape/distance.h"

static const double ccd_mass_ratio = 4; /* mass ratio above which a body is an obstacle */

typedef struct toi_event { /* a bullet's next impact with a dynamic body */
    int32_t body, other;   /* LL_NONE: no impact */
    double t;              /* fraction of the step */
} toi_event;

typedef struct search {
    ll_rigid *world;
    int32_t body, shape; /* the swept one */
    int32_t obstacle;    /* a shape */
    bool still;          /* only against bodies that do not move in this step */
    toi_event *next;     /* of a bullet */
    int part, parts;     /* only bodies of this part */
} search;

static ll_sweep sweep_of(const ll_rigid *w, int32_t body)
{
    const ll_solver_body *m = &ll_solver_bodies(w)[body];
    return (ll_sweep){ll_poses(w)[body], m->d, m->turn};
}

static ll_pose end_of(const ll_rigid *w, int32_t body)
{
    const ll_solver_body *m = &ll_solver_bodies(w)[body];
    ll_pose start = ll_poses(w)[body];
    return (ll_pose){ll_add(start.p, m->d), ll_rot_normalised(ll_rot_mul(start.q, m->q))};
}

static bool collide_at_all(const ll_shape *a, const ll_shape *b)
{
    return (a->category & b->mask) != 0 && (b->category & a->mask) != 0 &&
           (a->group == 0 || a->group != b->group);
}

/* A body whose surface already touches can still pass or rotate through. It is then swept as if it were
 * smaller, by as little as separates it. */
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

static bool is_still(const ll_solver_body *m)
{
    return m->d.x == 0 && m->d.y == 0 && m->turn == 0;
}

/* Largest motion of a point of `a` relative to `b`. The rotation of `b` counts at the lever that `a` can
 * reach. */
static double relative_motion(const ll_rigid *w, int32_t a, const ll_sweep *sweep_a, int32_t b,
                              const ll_sweep *sweep_b)
{
    double path = ll_length(ll_sub(sweep_a->shift, sweep_b->shift)), extent = ll_bodies(w)[a].extent;
    double distance = ll_length(ll_sub(sweep_a->start.p, sweep_b->start.p));
    double lever = ll_min(distance + extent + path, ll_bodies(w)[b].extent);
    return path + fabs(sweep_a->turn) * extent + fabs(sweep_b->turn) * lever;
}

/* Lower bound of a point's distance from a hull: the distance from its farthest edge line. */
static double outside_of(const ll_geometry *g, ll_vec2 point)
{
    double most = -INFINITY;
    for (int i = 0; i < g->count; i++)
        most = ll_max(most, g->count > 1 ? ll_dot(g->normal[i], ll_sub(point, g->vertex[i]))
                                         : ll_length(ll_sub(point, g->vertex[0])));
    return most - g->radius;
}

/* Whether two bodies whose points move by up to `moved` relative to each other may tunnel, and come near
 * enough: a's centre against b's hull. */
static bool may_pass(const ll_rigid *w, int32_t a, int32_t b, const ll_geometry *hull, double moved)
{
    ll_vec2 at = ll_to_local(ll_poses(w)[b], ll_poses(w)[a].p);
    return moved > 0.5 * ll_body_sims(w)[a].core &&
           outside_of(hull, at) <= ll_bodies(w)[a].extent + moved + LL_LINEAR_SLOP;
}

static bool may_stop(const ll_rigid *w, int32_t body, int32_t other)
{
    return ccd_mass_ratio * ll_body_sims(w)[other].inv_mass <= ll_body_sims(w)[body].inv_mass;
}

/* Distance at which shapes are left at an impact. */
static double target_of(const ll_shape *shape)
{
    return ll_min(0.25 * LL_LINEAR_SLOP, 0.1 * shape->core);
}

static void consider(const ll_rigid *w, int32_t swept, int32_t obstacle)
{
    const ll_shape *shape = &ll_shapes(w)[swept], *other = &ll_shapes(w)[obstacle];
    ll_geometry room_a, room_b;
    const ll_geometry *b = ll_geometry_of(w, other, &room_b);
    ll_sweep sweep_a = sweep_of(w, shape->body), sweep_b = sweep_of(w, other->body);
    double moved = relative_motion(w, shape->body, &sweep_a, other->body, &sweep_b);
    if (!collide_at_all(shape, other) || !may_pass(w, shape->body, other->body, b, moved) ||
        ll_joint_blocks_collision(w, shape->body, other->body))
        return;
    const ll_geometry *whole = ll_geometry_of(w, shape, &room_a);
    if (b->kind == LL_SHAPE_CHAIN_SEGMENT &&
        ll_dot(b->normal[0], ll_sub(ll_to_local(sweep_b.start, ll_to_world(sweep_a.start, whole->centre)),
                                    b->vertex[0])) < 0)
        return;
    double target = target_of(shape);
    /* More than the tolerances of set_apart and ll_time_of_impact: both are left out only where they would
     * not find a hit. */
    double margin = target + 0.1 * LL_LINEAR_SLOP;
    if (ll_sweeps_stay_apart(b, &sweep_b, whole, &sweep_a, margin))
        return;
    ll_geometry a = *whole;
    if (!set_apart(&a, sweep_a.start, b, sweep_b.start, target))
        return;
    ll_toi_result touch = ll_time_of_impact(b, &sweep_b, &a, &sweep_a, target);
    ll_body_step *d = &ll_body_steps(w)[shape->body];
    if (touch.hit && (touch.t < d->touch || (touch.t == d->touch && other->body < d->stopper))) {
        d->touch = touch.t;
        d->stopper = other->body;
    }
}

static void consider_obstacle(void *context, int32_t obstacle)
{
    const search *s = context;
    int32_t other = ll_shapes(s->world)[obstacle].body;
    if (other != s->body && may_stop(s->world, s->body, other) &&
        !(s->still && !is_still(&ll_solver_bodies(s->world)[other])))
        consider(s->world, s->shape, obstacle);
}

static void consider_swept(void *context, int32_t shape)
{
    const search *s = context;
    int32_t body = ll_shapes(s->world)[shape].body, other = ll_shapes(s->world)[s->obstacle].body;
    if (body % s->parts == s->part && body != other && !is_still(&ll_solver_bodies(s->world)[body]) &&
        ll_body_steps(s->world)[body].touch >= 0 && may_stop(s->world, body, other))
        consider(s->world, shape, s->obstacle);
}

/* From the impact on, the body keeps its pose relative to the other body. */
static void carry(ll_rigid *w, int32_t body, const ll_body_step *at)
{
    ll_sweep sweep = sweep_of(w, body), other = sweep_of(w, at->stopper);
    ll_pose touched = ll_sweep_at(&sweep, at->touch);
    ll_pose seen = ll_pose_between(ll_sweep_at(&other, at->touch), touched);
    ll_pose end = ll_pose_mul(end_of(w, at->stopper), seen);
    ll_solver_body *m = &ll_solver_bodies(w)[body];
    m->d = ll_sub(end.p, sweep.start.p);
    m->turn = at->touch * m->turn + (1 - at->touch) * other.turn;
}

/* A body stops at its impact. */
static void stop(ll_rigid *w, int32_t body)
{
    const ll_body_step *at = &ll_body_steps(w)[body];
    ll_solver_body *m = &ll_solver_bodies(w)[body];
    if (at->stopper == body) {
        m->d = ll_scale(at->touch, m->d);
        m->turn *= at->touch;
    } else {
        carry(w, body, at);
    }
    m->q = (ll_rot){ll_cos(m->turn), ll_sin(m->turn)};
    w->stats.stopped++;
}

static bool is_fast(const ll_rigid *w, int32_t body)
{
    const ll_body *b = &ll_bodies(w)[body];
    const ll_solver_body *m = &ll_solver_bodies(w)[body];
    return b->type == LL_BODY_DYNAMIC && ll_length(m->d) + fabs(m->turn) * b->extent > 0.5 * b->core;
}

/* Bounds of a shape over the whole step. */
static ll_aabb path_box(const ll_rigid *w, int32_t body, int32_t shape)
{
    const ll_solver_body *m = &ll_solver_bodies(w)[body];
    const ll_shape *s = &ll_shapes(w)[shape];
    ll_aabb box = ll_aabb_union(ll_tight_box(w, s, ll_poses(w)[body]), ll_tight_box(w, s, end_of(w, body)));
    double turn = fabs(m->turn);
    return ll_aabb_grown(box, (turn < 1 ? 0.5 * turn : 2) * ll_bodies(w)[body].extent);
}

/* Bodies that a job lists. */
typedef struct listing {
    ll_rigid *w;
    int32_t *at;
    ll_share wrote[LL_TEAM_PARTS_MAX]; /* for ll_team_join */
} listing;

/* Returns the count. */
static int32_t run_listing(ll_rigid *w, ll_team *team, ll_team_job *job, int32_t *at)
{
    enum { least = 512 }; /* a body takes about 10 ns */
    listing l = {.w = w, .at = at};
    ll_team_run(team, w->awake, least, job, &l);
    return ll_team_join(l.wrote, at, sizeof *at);
}

static void cover_part(void *context, int part, int parts)
{
    listing *l = context;
    ll_rigid *w = l->w;
    ll_share of = ll_share_of(w->awake, part, parts);
    int32_t end = of.begin;
    for (int32_t i = of.begin; i < of.end; i++) {
        int32_t body = ll_awake_bodies(w)[i];
        const ll_solver_body *m = &ll_solver_bodies(w)[body];
        ll_body *b = &ll_bodies(w)[body];
        if (b->drift + ll_length(m->d) + fabs(m->turn) * b->extent <= b->slack)
            continue;
        b->drift = INFINITY; /* its boxes are recomputed at the end of the step */
        for (int32_t s = b->shape; s != LL_NONE; s = ll_shapes(w)[s].next)
            ll_boxes(w)[s] = path_box(w, body, s);
        l->at[end++] = body;
    }
    l->wrote[part] = (ll_share){of.begin, end};
}

/* Makes other bodies' queries find the swept ones. */
static void cover_paths(ll_rigid *w, ll_team *team, int32_t *room)
{
    int32_t count = run_listing(w, team, cover_part, room);
    for (int32_t i = 0; i < count; i++)
        for (int32_t s = ll_bodies(w)[room[i]].shape; s != LL_NONE; s = ll_shapes(w)[s].next)
            ll_broad_of(w)->move(ll_broad_state(w), ll_boxes(w), s);
}

static void find_time_of_impact(ll_rigid *w, int32_t body, bool still)
{
    search s = {.world = w, .body = body, .still = still};
    ll_body_steps(w)[body].touch = 1;
    ll_body_steps(w)[body].stopper = LL_NONE;
    for (s.shape = ll_bodies(w)[body].shape; s.shape != LL_NONE; s.shape = ll_shapes(w)[s.shape].next)
        ll_broad_of(w)->query(ll_broad_state(w), ll_boxes(w), path_box(w, body, s.shape), consider_obstacle,
                              &s);
}

/* Lists fast bodies and marks the others as not swept. */
static void list_fast(void *context, int part, int parts)
{
    listing *l = context;
    ll_share of = ll_share_of(l->w->awake, part, parts);
    int32_t end = of.begin;
    for (int32_t i = of.begin; i < of.end; i++) {
        int32_t body = ll_awake_bodies(l->w)[i];
        bool fast = is_fast(l->w, body);
        ll_body_steps(l->w)[body].touch = fast ? 1 : -1;
        ll_body_steps(l->w)[body].stopper = LL_NONE;
        if (fast)
            l->at[end++] = body;
    }
    l->wrote[part] = (ll_share){of.begin, end};
}

static double largest_inverse_mass(const ll_rigid *w, const int32_t *bodies, int32_t count)
{
    double most = 0;
    for (int32_t i = 0; i < count; i++)
        most = ll_max(most, ll_body_sims(w)[bodies[i]].inv_mass);
    return most;
}

/* The shapes that bodies may be swept against, if there are fewer than `most`; else returns -1. */
static int32_t obstacles(const ll_rigid *w, double lightest, int32_t *list, int32_t most)
{
    int32_t count = 0;
    for (int32_t i = 0; i < w->shape_end; i++) {
        int32_t body = ll_shapes(w)[i].body;
        if (body == LL_NONE || ccd_mass_ratio * ll_body_sims(w)[body].inv_mass > lightest)
            continue;
        if (count == most)
            return -1;
        list[count++] = i;
    }
    return count;
}

/* ---- times of impact, in parts: a body's is found by one thread ---- */

typedef struct times_of_impact {
    ll_rigid *w;
    const int32_t *fast, *obstacles;
    int32_t count, obstacle_count;
} times_of_impact;

static void sweep_bodies(void *context, int part, int parts)
{
    const times_of_impact *all = context;
    ll_share of = ll_share_of(all->count, part, parts);
    for (int32_t i = of.begin; i < of.end; i++)
        find_time_of_impact(all->w, all->fast[i], false);
}

/* Every part makes all queries, and sweeps the bodies whose slots are its own: the distances cost most. */
static void sweep_by_obstacle(void *context, int part, int parts)
{
    const times_of_impact *all = context;
    ll_rigid *w = all->w;
    for (int32_t i = 0; i < all->obstacle_count; i++) {
        search s = {.world = w, .obstacle = all->obstacles[i], .part = part, .parts = parts};
        ll_broad_of(w)->query(ll_broad_state(w), ll_boxes(w), ll_boxes(w)[s.obstacle], consider_swept, &s);
    }
}

static void find_times_of_impact(ll_rigid *w, ll_team *team, const int32_t *fast, int32_t count,
                                 int32_t *room)
{
    enum { least = 16 }; /* a body takes about a microsecond */
    /* Searching for obstacles costs as much as some queries. */
    double lightest = largest_inverse_mass(w, fast, count);
    int32_t found = count > w->shape_end / 16 ? obstacles(w, lightest, room, count) : -1;
    times_of_impact all = {w, fast, room, count, found};
    ll_team_run(team, count, least, found < 0 ? sweep_bodies : sweep_by_obstacle, &all);
}

/* ---- bullets ---- */

size_t ll_toi_events_size(const ll_rigid_limits *limits)
{
    return (size_t)limits->bodies * sizeof(toi_event);
}

/* Time at which the body stops; 1: not in this step. */
static double end_time(const ll_rigid *w, int32_t body)
{
    const ll_body_step *d = &ll_body_steps(w)[body];
    return ll_bodies(w)[body].awake != LL_NONE && d->stopper != LL_NONE ? d->touch : 1;
}

/* A body's path between two times. It stops at the first of them or not at all. */
static ll_sweep leg(const ll_rigid *w, int32_t body, double from, double to)
{
    ll_sweep whole = sweep_of(w, body);
    double end = end_time(w, body), begin = ll_min(from, end), share = ll_min(to, end) - begin;
    return (ll_sweep){ll_sweep_at(&whole, begin), ll_scale(share, whole.shift), share * whole.turn};
}

/* First impact of a bullet's shape with another, before the bullet stops; 1: none. The other may stop on the
 * way: then there are two legs, with a slightly smaller target in the second, so that it can succeed. */
static double first_toi_event(const ll_rigid *w, const ll_shape *shape, const ll_shape *other)
{
    double end = end_time(w, shape->body), times[3] = {0, ll_min(end_time(w, other->body), end), end};
    double moved = 0, target = target_of(shape);
    ll_sweep a[2], b[2];
    ll_geometry room_a, room_b;
    for (int i = 0; i < 2; i++) {
        a[i] = leg(w, shape->body, times[i], times[i + 1]);
        b[i] = leg(w, other->body, times[i], times[i + 1]);
        moved += relative_motion(w, shape->body, &a[i], other->body, &b[i]);
    }
    const ll_geometry *hull = ll_geometry_of(w, other, &room_b);
    ll_geometry g = *ll_geometry_of(w, shape, &room_a);
    if (!may_pass(w, shape->body, other->body, hull, moved) ||
        !set_apart(&g, a[0].start, hull, b[0].start, target))
        return 1;
    for (int i = 0; i < 2; i++) {
        ll_toi_result touch = ll_time_of_impact(hull, &b[i], &g, &a[i], i == 0 ? target : 0.9 * target);
        if (touch.hit)
            return times[i] + touch.t * (times[i + 1] - times[i]);
    }
    return 1;
}

static void consider_toi_event(void *context, int32_t shape)
{
    const search *s = context;
    const ll_shape *own = &ll_shapes(s->world)[s->shape], *other = &ll_shapes(s->world)[shape];
    if (other->body == s->body || ll_bodies(s->world)[other->body].type != LL_BODY_DYNAMIC ||
        !collide_at_all(own, other) || ll_joint_blocks_collision(s->world, s->body, other->body))
        return;
    double t = first_toi_event(s->world, own, other);
    if (t < s->next->t || (t == s->next->t && other->body < s->next->other))
        *s->next = (toi_event){s->body, other->body, t};
}

static toi_event next_toi_event(ll_rigid *w, int32_t bullet)
{
    toi_event next = {bullet, LL_NONE, end_time(w, bullet)};
    search s = {.world = w, .body = bullet, .next = &next};
    for (s.shape = ll_bodies(w)[bullet].shape; s.shape != LL_NONE; s.shape = ll_shapes(w)[s.shape].next)
        ll_broad_of(w)->query(ll_broad_state(w), ll_boxes(w), path_box(w, bullet, s.shape),
                              consider_toi_event, &s);
    return next;
}

/* Bounds of all positions from this time to the end of the step. */
static ll_aabb way_box(const ll_rigid *w, int32_t body, double from)
{
    ll_vec2 start = ll_poses(w)[body].p, shift = ll_solver_bodies(w)[body].d;
    double until = end_time(w, body);
    ll_vec2 p = ll_madd(start, ll_min(from, until), shift), end = ll_madd(start, until, shift);
    ll_aabb box = ll_aabb_union((ll_aabb){p, p}, (ll_aabb){end, end});
    return ll_aabb_grown(box, ll_bodies(w)[body].extent + LL_LINEAR_SLOP);
}

/* bodies that must stop */
typedef struct stops {
    int32_t *list, count;
} stops;

/* Stops the body at that time. Bullets that may now hit it there search again. */
static void stay(ll_rigid *w, int32_t body, double t, stops *all, toi_event *bullets, int32_t count)
{
    if (ll_bodies(w)[body].awake == LL_NONE || t >= end_time(w, body))
        return;
    ll_body_step *d = &ll_body_steps(w)[body];
    if (d->touch < 0)
        all->list[all->count++] = body;
    d->touch = t;
    d->stopper = body;
    ll_aabb place = way_box(w, body, t);
    for (int32_t i = 0; i < count; i++) {
        toi_event *m = &bullets[i];
        if (m->body == body)
            m->other = LL_NONE;
        else if (ll_body_steps(w)[m->body].stopper != m->body &&
                 (m->other == body || ll_aabb_overlap(way_box(w, m->body, 0), place)))
            *m = next_toi_event(w, m->body);
    }
}

static void stop_bullets_where_they_meet(ll_rigid *w, stops *all)
{
    toi_event *bullets = ll_solver_memory(w); /* the solver no longer needs it */
    int32_t count = 0;
    for (int32_t i = 0; i < all->count; i++)
        if (ll_bodies(w)[all->list[i]].bullet)
            bullets[count++] = next_toi_event(w, all->list[i]);
    for (;;) {
        toi_event first = {LL_NONE, LL_NONE, 1};
        for (int32_t i = 0; i < count; i++)
            if (bullets[i].other != LL_NONE && bullets[i].t < first.t)
                first = bullets[i];
        if (first.other == LL_NONE)
            return;
        stay(w, first.body, first.t, all, bullets, count);
        stay(w, first.other, first.t, all, bullets, count);
    }
}

void ll_solve_continuous(ll_rigid *w, ll_team *team)
{
    w->stats.swept = w->stats.stopped = 0;
    if (w->params.continuous != LL_CONTINUOUS_SWEPT)
        return;
    stops all = {.list = ll_scratch(w)};
    all.count = w->stats.swept = run_listing(w, team, list_fast, all.list);
    if (all.count == 0)
        return;
    cover_paths(w, team, all.list + all.count);
    find_times_of_impact(w, team, all.list, all.count, all.list + all.count);
    if (w->bullets > 0)
        stop_bullets_where_they_meet(w, &all);
    for (int32_t i = 0; i < all.count; i++) {
        int32_t body = all.list[i];
        const ll_body_step *d = &ll_body_steps(w)[body];
        if (d->stopper == LL_NONE)
            continue;
        bool carried = d->stopper != body && !is_still(&ll_solver_bodies(w)[d->stopper]);
        stop(w, body);
        if (!carried)
            continue;
        find_time_of_impact(w, body, true); /* its obstacle's motion may carry it through a wall */
        if (d->stopper != LL_NONE)
            stop(w, body);
    }
}
