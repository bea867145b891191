#include "rigid/solver/solver.h"

#include <string.h>

#include "base/assert.h"

ll_softness ll_soft(double hertz, double damping, double h)
{
    LL_VALIDATE(h > 0 && damping >= 0); /* or it would gain energy */
    double omega = 2 * 3.14159265358979323846 * hertz;
    double a1 = 2 * damping + h * omega, a2 = h * omega * a1, a3 = 1 / (1 + a2);
    return hertz > 0 ? (ll_softness){omega / a1, a2 * a3, a3} : (ll_softness){0, 1, 0};
}

/* ---- bodies ---- */

void ll_prepare_body_steps(ll_rigid *w, ll_index_list bodies, double h)
{
    ll_vec2 gravity = {w->params.gravity_x, w->params.gravity_y};
    for (int32_t i = 0; i < bodies.count; i++) {
        int32_t k = bodies.at[i];
        const ll_body *b = &ll_bodies(w)[k];
        ll_body_step *d = &ll_body_steps(w)[k];
        *d = (ll_body_step){.keep = 1, .keep_angular = 1};
        if (b->inv_mass > 0) {
            d->a = ll_madd(ll_scale(b->gravity_scale, gravity), b->inv_mass, b->force);
            d->angular_acceleration = b->inv_inertia * b->torque;
            d->keep = 1 / (1 + h * b->damping);
            d->keep_angular = 1 / (1 + h * b->angular_damping);
            LL_VALIDATE(d->keep > 0 && d->keep <= 1 && d->keep_angular > 0 && d->keep_angular <= 1);
        }
    }
}

void ll_integrate_velocities(ll_rigid *w, ll_index_list bodies, double h)
{
    for (int32_t i = 0; i < bodies.count; i++) {
        int32_t k = bodies.at[i];
        const ll_body_step *d = &ll_body_steps(w)[k];
        ll_solver_body *m = &ll_solver_bodies(w)[k];
        m->v = ll_scale(d->keep, ll_madd(m->v, h, d->a));
        m->w = d->keep_angular * (m->w + h * d->angular_acceleration);
    }
}

void ll_integrate_positions(ll_rigid *w, ll_index_list bodies, double h)
{
    for (int32_t i = 0; i < bodies.count; i++) {
        ll_solver_body *m = &ll_solver_bodies(w)[bodies.at[i]];
        double turn = h * m->w;
        m->d = ll_madd(m->d, h, m->v);
        m->q = ll_rot_mul(m->q, ll_rot_small(turn));
        m->turn += turn;
    }
}

ll_pose ll_pose_now(const ll_rigid *w, int32_t body)
{
    ll_pose pose = ll_poses(w)[body];
    const ll_solver_body *m = &ll_solver_bodies(w)[body];
    return (ll_pose){ll_add(pose.p, m->d), ll_rot_mul(pose.q, m->q)};
}

double ll_angle_now(const ll_rigid *w, const ll_joint *j)
{
    const ll_body *bodies = ll_bodies(w);
    const ll_solver_body *m = ll_solver_bodies(w);
    return (bodies[j->body[1]].angle - bodies[j->body[0]].angle) + (m[j->body[1]].turn - m[j->body[0]].turn);
}

/* ---- contacts ---- */

/* A counting sort in parts: each counts its colours, and then writes behind the parts before it. */
typedef struct ordering {
    const ll_rigid *w;
    ll_index_list contacts;
    uint8_t *colours; /* of the contacts: a copy, so that they are read once */
    int32_t *orders;
    int32_t points[LL_TEAM_PARTS_MAX];
    uint64_t used[LL_TEAM_PARTS_MAX];               /* colours */
    int32_t at[LL_TEAM_PARTS_MAX][LL_COLOUR_SLOTS]; /* counts, then the places of the next ones */
} ordering;

static void count_colours(void *context, int part, int parts)
{
    ordering *o = context;
    const ll_contact *all = ll_contacts(o->w);
    ll_share of = ll_share_of(o->contacts.count, part, parts);
    int32_t points = 0, *count = o->at[part];
    uint64_t used = 0;
    for (int32_t i = of.begin; i < of.end; i++) {
        const ll_contact *c = &all[o->contacts.at[i]];
        LL_VALIDATE(c->colour == LL_NONE || (c->colour >= 0 && c->colour < LL_COLOUR_SLOTS));
        if (i + 8 < of.end)
            __builtin_prefetch(&all[o->contacts.at[i + 8]]);
        points += c->count;
        o->colours[i] = (uint8_t)c->colour;
        if (c->colour != LL_NONE) {
            count[c->colour]++;
            used |= UINT64_C(1) << c->colour;
        }
    }
    o->points[part] = points;
    o->used[part] = used;
}

static void place_contacts(void *context, int part, int parts)
{
    ordering *o = context;
    int32_t *orders = o->orders, *at = o->at[part];
    ll_share of = ll_share_of(o->contacts.count, part, parts);
    for (int32_t i = of.begin; i < of.end; i++)
        if (o->colours[i] != (uint8_t)LL_NONE)
            orders[at[o->colours[i]]++] = o->contacts.at[i];
}

ll_contact_counts ll_order_contacts(const ll_rigid *w, ll_team *team, ll_index_list contacts,
                                    ll_colour_spans *spans)
{
    enum { least = 512 }; /* a contact takes 10 to 20 ns */
    int parts = ll_team_parts_of(team, contacts.count, least);
    ordering o; /* not all of it is used, nor cleared */
    o.w = w;
    o.contacts = contacts;
    o.colours = (uint8_t *)ll_scratch(w) + contacts.first;
    o.orders = ll_orders(w) + contacts.first;
    memset(o.at, 0, (size_t)parts * sizeof *o.at);
    ll_team_run(team, contacts.count, least, count_colours, &o);
    int32_t total = 0, coloured = 0;
    ll_contact_counts counts = {0};
    spans->used = 0;
    for (int k = 0; k < parts; k++) {
        counts.points += o.points[k];
        spans->used |= o.used[k];
    }
    for (uint64_t left = spans->used; left != 0; left &= left - 1) {
        int c = __builtin_ctzll(left);
        spans->begin[c] = total;
        for (int k = 0; k < parts; k++) {
            int32_t count = o.at[k][c];
            o.at[k][c] = total;
            total += count;
        }
        spans->end[c] = total;
        coloured = c < LL_COLOURS ? total : coloured;
    }
    LL_ASSERT(total <= contacts.count && total <= w->limits.contacts);
    ll_team_run(team, contacts.count, least, place_contacts, &o);
    counts.colours = spans->used & ((UINT64_C(1) << LL_COLOURS) - 1);
    counts.touching = total;
    counts.overflow = total - coloured;
    return counts;
}

void ll_count_contacts(ll_rigid *w, const ll_contact_counts *counts)
{
    w->colours |= counts->colours;
    w->stats.points += counts->points;
    w->stats.touching += counts->touching;
    w->stats.overflow += counts->overflow;
}

size_t ll_contact_constraints_size(const ll_rigid_limits *limits)
{
    return ((size_t)limits->contacts * sizeof(ll_contact_constraint) + 63) & ~(size_t)63;
}

static double inverse(double k)
{
    return k > 0 ? 1 / k : 0;
}

static void prepare_point(const ll_rigid *w, ll_contact_constraint *r, ll_contact_constraint_point *cp,
                          const ll_contact_point *p, const ll_relative_motion *since)
{
    cp->ra = ll_rotate(since->a, p->a);
    cp->rb = ll_rotate(since->b, p->b);
    cp->adjust = p->separation;
    cp->normal_impulse = w->params.warm_start ? p->normal_impulse : 0;
    cp->tangent_impulse = w->params.warm_start ? p->tangent_impulse : 0;
    LL_VALIDATE(!(fabs(ll_dot(r->n, r->n) - 1) > 1e-9)); /* a unit vector, or NaN in a diverged world */
    ll_vec2 t = ll_right(r->n);
    double na = ll_cross(cp->ra, r->n), nb = ll_cross(cp->rb, r->n);
    double ta = ll_cross(cp->ra, t), tb = ll_cross(cp->rb, t);
    cp->normal_mass = inverse(r->ma + r->mb + r->ia * na * na + r->ib * nb * nb);
    cp->tangent_mass = inverse(r->ma + r->mb + r->ia * ta * ta + r->ib * tb * tb);
}

ll_contact_constraints ll_prepare_contacts(ll_rigid *w)
{
    ll_colour_spans spans;
    ll_contact_counts counts = ll_order_contacts(w, NULL, ll_whole(w).contacts, &spans);
    ll_contact_constraints rows = {ll_solver_memory(w), counts.touching};
    ll_count_contacts(w, &counts);
    for (int32_t i = 0; i < rows.count; i++) {
        ll_contact_constraint *r = &rows.at[i];
        const ll_contact *c = &ll_contacts(w)[ll_orders(w)[i]];
        const ll_body_sim *a = &ll_body_sims(w)[c->body[0]], *b = &ll_body_sims(w)[c->body[1]];
        r->contact = ll_orders(w)[i];
        r->a = c->body[0];
        r->b = c->body[1];
        r->count = c->count;
        r->ma = a->inv_mass;
        r->ia = a->inv_inertia;
        r->mb = b->inv_mass;
        r->ib = b->inv_inertia;
        r->friction = c->friction;
        r->restitution = c->restitution;
        r->fixed = a->inv_mass == 0 || b->inv_mass == 0;
        ll_relative_motion since = {.a = {1, 0}, .b = {1, 0}};
        if (c->recycled)
            since = ll_relative_motion_of(w, c);
        r->n = ll_rotate(since.a, c->normal);
        for (int k = 0; k < c->count; k++)
            prepare_point(w, r, &r->at[k], &c->at[k], &since);
    }
    return rows;
}

void ll_store_contacts(ll_rigid *w, ll_contact_constraints rows)
{
    for (int32_t i = 0; i < rows.count; i++) {
        ll_contact *c = &ll_contacts(w)[rows.at[i].contact];
        for (int k = 0; k < c->count; k++) {
            LL_VALIDATE(!(rows.at[i].at[k].normal_impulse < 0)); /* contacts do not pull */
            c->at[k].normal_impulse = rows.at[i].at[k].normal_impulse;
            c->at[k].tangent_impulse = rows.at[i].at[k].tangent_impulse;
        }
    }
}

void ll_warm_start_contacts(ll_rigid *w, ll_contact_constraints rows)
{
    for (int32_t i = 0; i < rows.count; i++) {
        ll_contact_constraint *r = &rows.at[i];
        ll_vec2 t = ll_right(r->n);
        for (int k = 0; k < r->count; k++) {
            const ll_contact_constraint_point *cp = &r->at[k];
            ll_apply_contact_impulse(&ll_solver_bodies(w)[r->a], &ll_solver_bodies(w)[r->b], r, cp,
                                     ll_madd(ll_scale(cp->normal_impulse, r->n), cp->tangent_impulse, t));
        }
    }
}

double ll_constraint_separation(const ll_rigid *w, const ll_contact_constraint *r,
                                const ll_contact_constraint_point *cp)
{
    const ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    const ll_pose *poses = ll_poses(w);
    ll_vec2 gap = ll_add(ll_sub(poses[r->b].p, poses[r->a].p), ll_sub(b->d, a->d));
    gap = ll_add(gap, ll_sub(ll_rotate(b->q, cp->rb), ll_rotate(a->q, cp->ra)));
    return ll_dot(gap, r->n) + cp->adjust;
}
