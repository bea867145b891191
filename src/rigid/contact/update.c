/* Updates the contacts of a step: recomputes their manifolds or recycles them. */
#include <string.h>

#include "rigid/contact/contact.h"

/* Largest rotation of a body before its manifolds are recomputed, 5.7 degrees: the error of its anchors
 * relative to their length. */
static const double recycle_cos = 0.995;

static const ll_geometry *collider(const ll_rigid *w, int32_t s, ll_rot q, ll_geometry *room)
{
    const ll_shape *shape = &ll_shapes(w)[s];
    const ll_geometry *exact = ll_geometry_of(w, shape, room);
    if (!w->limits.volumes || w->params.bounding_volume == LL_VOLUME_EXACT)
        return exact;
    if (w->params.bounding_volume != LL_VOLUME_AABB)
        return &ll_bounds(w)[s];
    *room = ll_bound_of(LL_VOLUME_AABB, exact, q);
    return room;
}

/* A manifold of two points still holds while its bodies have rotated and moved little relative to each other
 * since it was made. Recomputing it would only add noise from points that come and go (Box2D 3's contact
 * recycling). */
static bool may_recycle(const ll_rigid *w, const ll_contact *c, ll_pose a, ll_pose b)
{
    if (!w->params.recycle || c->count < 2 || w->params.bounding_volume == LL_VOLUME_AABB)
        return false;
    double turned_a = a.q.c * c->turned[0].c + a.q.s * c->turned[0].s;
    double turned_b = b.q.c * c->turned[1].c + b.q.s * c->turned[1].s;
    ll_vec2 shift = ll_sub(ll_to_local(a, b.p), c->rel);
    double core_a = ll_body_sims(w)[c->body[0]].core, core_b = ll_body_sims(w)[c->body[1]].core;
    double core = ll_min(core_a, core_b), least = ll_max(core_a, core_b);
    double far = ll_min(w->params.recycle_distance, 0.1 * (core > 0 ? core : least));
    return ll_dot(shift, shift) < far * far && turned_a > recycle_cos && turned_b > recycle_cos;
}

static double margin_of(const ll_rigid *w, const ll_contact *c)
{
    double margin = ll_body_sims(w)[c->body[0]].margin + ll_body_sims(w)[c->body[1]].margin;
    if (w->params.continuous != LL_CONTINUOUS_SPECULATIVE)
        return margin;
    double reach = margin + w->dt * ll_length(ll_sub(ll_solver_bodies(w)[c->body[1]].v,
                                                     ll_solver_bodies(w)[c->body[0]].v));
    for (int side = 0; side < 2; side++)
        reach += ll_min(w->dt * fabs(ll_solver_bodies(w)[c->body[side]].w), 2) *
                 ll_bodies(w)[c->body[side]].extent;
    return reach;
}

ll_manifold ll_manifold_of(const ll_rigid *w, const ll_contact *c, ll_pose a, ll_pose b, double margin)
{
    ll_geometry room_a, room_b;
    return ll_collide(collider(w, c->shape[0], a.q, &room_a), collider(w, c->shape[1], b.q, &room_b),
                      ll_pose_between(a, b), margin);
}

static void compute(ll_rigid *w, ll_contact *c, ll_pose a, ll_pose b)
{
    ll_pose rel = ll_pose_between(a, b);
    ll_manifold m = ll_manifold_of(w, c, a, b, margin_of(w, c));
    ll_contact_point old[2] = {c->at[0], c->at[1]};
    int32_t old_count = c->count;
    memset(c->at, 0, sizeof c->at);
    c->normal = ll_rotate(a.q, m.normal);
    c->rel = rel.p;
    c->turned[0] = a.q;
    c->turned[1] = b.q;
    c->count = m.count;
    c->recycled = 0;
    for (int i = 0; i < m.count; i++) {
        ll_contact_point *p = &c->at[i];
        p->a = ll_rotate(a.q, m.at[i].point);
        p->b = ll_rotate(b.q, ll_to_local(rel, m.at[i].point));
        p->separation = m.at[i].separation;
        p->id = m.at[i].id;
        for (int k = 0; k < old_count; k++)
            if (old[k].id == p->id) {
                p->normal_impulse = old[k].normal_impulse;
                p->tangent_impulse = old[k].tangent_impulse;
                p->penalty = old[k].penalty;
            }
    }
}

static void begin_or_end(ll_rigid *w, int32_t contact)
{
    ll_contact *c = &ll_contacts(w)[contact];
    if (c->count == 0) {
        ll_give_colour(w, c);
        return;
    }
    ll_take_colour(w, c);
    for (int side = 0; side < 2; side++)
        if (ll_bodies(w)[c->body[side]].type == LL_BODY_DYNAMIC)
            ll_wake(w, c->body[side]);
}

/* The awake contacts, in parts. A part writes what has changed into its own part of `changed`. */
typedef struct narrow_phase {
    ll_rigid *w;
    int32_t *changed; /* indices; ~index: its boxes no longer overlap */
    struct {
        int32_t begin, changes, recycled, pad;
    } part[LL_TEAM_PARTS_MAX];
} narrow_phase;

static void update_part(void *context, int part, int parts)
{
    narrow_phase *n = context;
    ll_rigid *w = n->w;
    const uint8_t *moved = ll_moved_flags(w);
    const ll_aabb *boxes = ll_boxes(w);
    const ll_pose *poses = ll_poses(w);
    ll_share of = ll_share_of(w->awake_contacts, part, parts);
    int32_t *changed = n->changed + of.begin, changes = 0, recycled = 0;
    for (int32_t i = of.begin; i < of.end; i++) {
        int32_t index = ll_awake_contacts(w)[i];
        if (i + 6 < w->awake_contacts)
            ll_prefetch_contact(&ll_contacts(w)[ll_awake_contacts(w)[i + 6]]);
        ll_contact *c = &ll_contacts(w)[index];
        int32_t a = c->shape[0], b = c->shape[1];
        if ((moved[a] | moved[b]) && !ll_aabb_overlap(boxes[a], boxes[b])) {
            changed[changes++] = ~index;
            continue;
        }
        ll_pose pose_a = poses[c->body[0]], pose_b = poses[c->body[1]];
        if (may_recycle(w, c, pose_a, pose_b)) {
            c->recycled = 1;
            recycled++;
            continue;
        }
        compute(w, c, pose_a, pose_b);
        if ((c->count > 0) != (c->colour != LL_NONE))
            changed[changes++] = index;
    }
    n->part[part].begin = of.begin;
    n->part[part].changes = changes;
    n->part[part].recycled = recycled;
}

static void apply_changes(ll_rigid *w, const int32_t *changed, int32_t changes)
{
    for (int32_t i = 0; i < changes; i++) {
        if (changed[i] < 0)
            ll_remove_contact(w, ~changed[i]);
        else
            begin_or_end(w, changed[i]);
    }
}

void ll_update_contacts(ll_rigid *w, ll_team *team)
{
    enum { least = 256 }; /* a contact takes 20 to 200 ns */
    narrow_phase n;
    n.w = w;
    n.changed = ll_scratch(w);
    int parts = ll_team_parts_of(team, w->awake_contacts, least);
    int32_t recycled = 0, tested = w->awake_contacts;
    ll_team_run(team, w->awake_contacts, least, update_part, &n);
    for (int i = 0; i < parts; i++) {
        recycled += n.part[i].recycled;
        apply_changes(w, n.changed + n.part[i].begin, n.part[i].changes);
    }
    w->stats.recycled = recycled;
    w->stats.tested = tested - recycled;
    for (int32_t i = 0; i < w->moved; i++)
        ll_moved_flags(w)[ll_moved_lists(w)[i]] = 0;
    w->moved = 0;
}
