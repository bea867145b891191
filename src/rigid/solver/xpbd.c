/* Extended position-based dynamics of rigid bodies (Mueller, Macklin, Chentanez, Jeschke, Kim, "Detailed
 * Rigid Body Simulation with Extended Position Based Dynamics", 2020). In each substep bodies move freely,
 * overlaps and joints are corrected in the positions, velocities are derived from the positions, and a
 * velocity pass applies friction and restitution.
 *
 * As published: pairs are found once per step, contact points in every substep, at the current positions.
 * Static friction moves a contact's points back along the surface, completely or not at all. The velocity
 * pass slows sliding contacts by at most the coefficient times the normal impulse. It also replaces the
 * normal velocity that the correction of overlap left by restitution times the earlier one, so that no
 * overlap becomes velocity.
 *
 * Different: static friction comes after the correction of all overlaps, and takes back what velocities and
 * friction have moved, but not what these corrections have (as published, a pile of 820 boxes gains 450 J and
 * spreads by 37 m in 10 s of 8 substeps; so by 14 cm). An overlap from before the substep is corrected no
 * faster than contact_push_speed. The velocity pass never takes more than the correction has pushed (contacts
 * do not pull). Chains of impacts are resolved first (bounce.c). Passes over contacts with n substeps: 3 n,
 * and the narrow phase n times. */
#include "rigid/solver/solver.h"

#include <string.h>

typedef struct past { /* pose of a body at the beginning of the substep */
    ll_vec2 d;
    double turn;
    ll_rot q;
    ll_vec2 apart; /* d and turn after overlaps were corrected */
    double turned_apart;
} past;

static size_t size(const ll_rigid_limits *limits)
{
    return ll_contact_constraints_size(limits) + (size_t)(limits->bodies + 1) * sizeof(past);
}

static past *pasts(const ll_rigid *w)
{
    return (past *)((char *)ll_solver_memory(w) + ll_contact_constraints_size(&w->limits));
}

static void shift(ll_solver_body *m, double inverse_mass, double inverse_inertia, ll_vec2 n, double lever,
                  double amount)
{
    double angle = inverse_inertia * lever * amount;
    m->d = ll_madd(m->d, inverse_mass * amount, n);
    m->q = ll_rot_mul(m->q, ll_rot_small(angle));
    m->turn += angle;
}

/* Motion of a point of a body in this substep; `arm`: its current anchor. */
static ll_vec2 gone(const ll_solver_body *m, const past *before, ll_vec2 arm)
{
    ll_rot turned = ll_rot_between(before->q, m->q);
    ll_vec2 arm_before = ll_rotate((ll_rot){turned.c, -turned.s}, arm);
    return ll_add(ll_sub(m->d, before->d), ll_sub(arm, arm_before));
}

/* The same of b's point relative to a's. */
static ll_vec2 relative_shift(const ll_rigid *w, const ll_contact_constraint *r,
                              const ll_contact_constraint_point *cp)
{
    return ll_sub(gone(&ll_solver_bodies(w)[r->b], &pasts(w)[r->b], cp->rb),
                  gone(&ll_solver_bodies(w)[r->a], &pasts(w)[r->a], cp->ra));
}

static void shift_both(ll_rigid *w, const ll_contact_constraint *r, ll_vec2 axis, const double amount[2])
{
    for (int k = 0; k < r->count; k++) {
        const ll_contact_constraint_point *cp = &r->at[k];
        shift(&ll_solver_bodies(w)[r->a], r->ma, r->ia, axis, ll_cross(cp->ra, axis), -amount[k]);
        shift(&ll_solver_bodies(w)[r->b], r->mb, r->ib, axis, ll_cross(cp->rb, axis), amount[k]);
    }
}

static double inverse(const ll_contact_constraint *r, const ll_contact_constraint_point *cp, ll_vec2 axis)
{
    double a = ll_cross(cp->ra, axis), b = ll_cross(cp->rb, axis);
    double k = r->ma + r->mb + r->ia * a * a + r->ib * b * b;
    return k > 0 ? 1 / k : 0;
}

/* Whether two bodies may have tunnelled in this substep. */
static bool went_far(const ll_rigid *w, const ll_contact_constraint *r)
{
    const ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    double core_a = ll_body_sims(w)[r->a].core, core_b = ll_body_sims(w)[r->b].core;
    double core = r->ma == 0 ? core_b : r->mb == 0 ? core_a : ll_min(core_a, core_b);
    ll_vec2 way = ll_sub(ll_sub(b->d, pasts(w)[r->b].d), ll_sub(a->d, pasts(w)[r->a].d));
    return ll_dot(way, way) > 0.25 * core * core;
}

static void take_point(const ll_rigid *w, ll_contact_constraint *r, int k, ll_vec2 ra, ll_vec2 rb)
{
    ll_contact_constraint_point *cp = &r->at[k];
    *cp = (ll_contact_constraint_point){.ra = ra, .rb = rb};
    cp->normal_mass = inverse(r, cp, r->n);
    cp->tangent_mass = inverse(r, cp, ll_right(r->n));
    cp->before = ll_dot(ll_relative(&ll_solver_bodies(w)[r->a], &ll_solver_bodies(w)[r->b], cp), r->n);
}

/* The points of the beginning of the step: they know on which side of each other the bodies were. */
static void keep_points(const ll_rigid *w, ll_contact_constraint *r, double separation[2])
{
    const ll_contact *c = &ll_contacts(w)[r->contact];
    ll_relative_motion since = ll_relative_motion_of(w, c);
    const ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    r->count = c->count;
    r->n = c->normal;
    for (int k = 0; k < c->count; k++) {
        const ll_contact_point *p = &c->at[k];
        take_point(w, r, k, p->a, p->b);
        separation[k] = p->separation + ll_dot(ll_add(ll_point_gap(p, &since), ll_sub(b->d, a->d)), r->n);
    }
}

/* The contact points at the current positions, with their separations. */
static void find_points(const ll_rigid *w, ll_contact_constraint *r, double separation[2])
{
    ll_pose a = ll_pose_now(w, r->a), b = ll_pose_now(w, r->b), rel = ll_pose_between(a, b);
    ll_manifold m = ll_manifold_of(w, &ll_contacts(w)[r->contact], a, b, LL_LINEAR_SLOP);
    r->count = m.count;
    r->n = ll_rotate(a.q, m.normal);
    for (int k = 0; k < m.count; k++) {
        take_point(w, r, k, ll_rotate(a.q, m.at[k].point), ll_rotate(b.q, ll_to_local(rel, m.at[k].point)));
        separation[k] = m.at[k].separation;
    }
}

/* Corrects the overlap of this substep at once, an older one no faster than contact_push_speed. */
static bool push_apart(ll_rigid *w, ll_contact_constraint *r, const double separation[2], double h)
{
    double c[2] = {0}, mass[2] = {0}, amount[2] = {0};
    for (int k = 0; k < r->count; k++) {
        double before = separation[k] - ll_dot(relative_shift(w, r, &r->at[k]), r->n);
        c[k] = separation[k] - ll_min(before + w->params.contact_push_speed * h, 0);
        mass[k] = r->at[k].normal_mass;
    }
    ll_solve_both(c, mass, r->count == 2 ? ll_coupling(r, r->n) : 0, (double[2]){0, 0},
                  (double[2]){INFINITY, INFINITY}, amount);
    shift_both(w, r, r->n, amount);
    for (int k = 0; k < r->count; k++)
        r->at[k].normal_impulse = amount[k] / h;
    return amount[0] + amount[1] > 0;
}

/* Motion since overlaps were corrected. */
static ll_vec2 moved_since(const ll_solver_body *m, const past *before, ll_vec2 arm)
{
    return ll_add(ll_sub(m->d, before->apart), ll_cross_sv(m->turn - before->turned_apart, arm));
}

static void hold(ll_rigid *w, ll_contact_constraint *r, double h)
{
    const ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    ll_vec2 t = ll_right(r->n);
    double c[2] = {0}, mass[2] = {0}, amount[2] = {0}, pushed = 0;
    for (int k = 0; k < r->count; k++) {
        const ll_contact_constraint_point *cp = &r->at[k];
        ll_vec2 moved =
            ll_sub(moved_since(b, &pasts(w)[r->b], cp->rb), moved_since(a, &pasts(w)[r->a], cp->ra));
        c[k] = ll_dot(ll_madd(moved, h, ll_relative(a, b, cp)), t);
        pushed += h * cp->normal_impulse;
        mass[k] = r->at[k].tangent_mass;
    }
    ll_solve_both(c, mass, r->count == 2 ? ll_coupling(r, t) : 0, (double[2]){-INFINITY, -INFINITY},
                  (double[2]){INFINITY, INFINITY}, amount);
    if (fabs(amount[0] + amount[1]) > r->friction * pushed)
        return;
    shift_both(w, r, t, amount);
    for (int k = 0; k < r->count; k++)
        r->at[k].tangent_impulse = amount[k] / h;
}

static void correct_overlap(ll_rigid *w, ll_contact_constraint *r, double h)
{
    double separation[2] = {0};
    if (ll_contacts(w)[r->contact].count > 0 && went_far(w, r))
        keep_points(w, r, separation);
    else
        find_points(w, r, separation);
    if (r->count > 0 && !push_apart(w, r, separation, h))
        r->count = 0;
}

/* ---- velocity pass ---- */

static void push_both(ll_rigid *w, ll_contact_constraint *r, ll_vec2 axis, const double impulse[2])
{
    for (int k = 0; k < r->count; k++)
        ll_apply_contact_impulse(&ll_solver_bodies(w)[r->a], &ll_solver_bodies(w)[r->b], r, &r->at[k],
                                 ll_scale(impulse[k], axis));
}

/* The friction limit that static friction has left. */
static void slow_down(ll_rigid *w, ll_contact_constraint *r)
{
    ll_vec2 t = ll_right(r->n);
    double v[2] = {0}, mass[2] = {0}, low[2] = {0}, high[2] = {0}, sum[2] = {0}, impulse[2];
    for (int k = 0; k < r->count; k++) {
        const ll_contact_constraint_point *cp = &r->at[k];
        v[k] = ll_dot(ll_relative(&ll_solver_bodies(w)[r->a], &ll_solver_bodies(w)[r->b], cp), t);
        mass[k] = cp->tangent_mass;
        sum[k] = cp->tangent_impulse;
        high[k] = ll_max(r->friction * cp->normal_impulse, fabs(sum[k]));
        low[k] = -high[k];
    }
    ll_solve_both(v, mass, r->count == 2 ? ll_coupling(r, t) : 0, low, high, sum);
    for (int k = 0; k < r->count; k++) {
        impulse[k] = sum[k] - r->at[k].tangent_impulse;
        r->at[k].tangent_impulse = sum[k];
    }
    push_both(w, r, t, impulse);
}

static void turn_round(ll_rigid *w, ll_contact_constraint *r)
{
    double v[2] = {0}, mass[2] = {0}, sum[2] = {0}, impulse[2];
    for (int k = 0; k < r->count; k++) {
        const ll_contact_constraint_point *cp = &r->at[k];
        double now = ll_dot(ll_relative(&ll_solver_bodies(w)[r->a], &ll_solver_bodies(w)[r->b], cp), r->n);
        double wanted = cp->before < -w->params.restitution_threshold ? -r->restitution * cp->before : 0;
        v[k] = now - ll_max(wanted, ll_min(now, cp->before));
        mass[k] = cp->normal_mass;
        sum[k] = cp->normal_impulse;
    }
    ll_solve_both(v, mass, r->count == 2 ? ll_coupling(r, r->n) : 0, (double[2]){0, 0},
                  (double[2]){INFINITY, INFINITY}, sum);
    for (int k = 0; k < r->count; k++) {
        impulse[k] = sum[k] - r->at[k].normal_impulse;
        r->at[k].normal_impulse = sum[k];
    }
    push_both(w, r, r->n, impulse);
}

/* ---- joints ---- */

static void solve_joint(ll_rigid *w, ll_joint *j, double h)
{
    const ll_body *a = &ll_bodies(w)[j->body[0]], *b = &ll_bodies(w)[j->body[1]];
    ll_solver_body *ma = &ll_solver_bodies(w)[j->body[0]], *mb = &ll_solver_bodies(w)[j->body[1]];
    const past *pa = &pasts(w)[j->body[0]], *pb = &pasts(w)[j->body[1]];
    for (int i = 0; i < LL_ROWS; i++) {
        ll_constraint_row rows[LL_ROWS];
        memset(rows, 0, sizeof rows);
        ll_joint_row_types[j->def.type].rows(j, ll_pose_now(w, j->body[0]), ll_pose_now(w, j->body[1]),
                                             ll_angle_now(w, j), rows);
        const ll_constraint_row *r = &rows[i];
        double k = (a->inv_mass + b->inv_mass) * ll_dot(r->n, r->n) + a->inv_inertia * r->ja * r->ja +
                   b->inv_inertia * r->jb * r->jb;
        if (r->kind == LL_ROW_NONE || k <= 0 || (r->kind == LL_ROW_LIMIT && r->c >= 0))
            continue;
        ll_vec2 way = ll_sub(ll_sub(mb->d, pb->d), ll_sub(ma->d, pa->d));
        double moved = /* impulse of the row in this substep */
            ll_dot(r->n, way) + r->jb * (mb->turn - pb->turn) - r->ja * (ma->turn - pa->turn);
        double c = r->c, share = 1, omega_h = 2 * 3.14159265358979323846 * r->hertz * h;
        if (r->kind == LL_ROW_MOTOR)
            c = moved - r->speed * h;
        if (r->hertz > 0) {
            /* Of compliance 1 / (mass omega^2) and damping 2 zeta omega mass (equation 26 of Macklin,
             * Mueller, Chentanez, "XPBD", 2016). */
            double damped = 2 * r->damping / omega_h;
            c += damped * moved;
            share = 1 / (1 + damped + 1 / (omega_h * omega_h));
        }
        double amount = -share * c / k, most = r->most * h * h;
        amount = ll_min(ll_max(amount, -most), most);
        j->impulse[i] = amount / h;
        shift(ma, a->inv_mass, a->inv_inertia, r->n, r->ja, -amount);
        shift(mb, b->inv_mass, b->inv_inertia, r->n, r->jb, amount);
    }
}

static void velocities_from_positions(ll_rigid *w, ll_index_list bodies, double h)
{
    for (int32_t i = 0; i < bodies.count; i++) {
        int32_t k = bodies.at[i];
        ll_solver_body *m = &ll_solver_bodies(w)[k];
        if (ll_bodies(w)[k].inv_mass == 0)
            continue;
        m->v = ll_scale(1 / h, ll_sub(m->d, pasts(w)[k].d));
        m->w = (m->turn - pasts(w)[k].turn) / h;
    }
}

/* ---- a step ---- */

static bool may_move(const ll_rigid *w, int32_t body)
{
    return ll_bodies(w)[body].type != LL_BODY_DYNAMIC || ll_bodies(w)[body].awake != LL_NONE;
}

static ll_contact_constraint row_of(const ll_rigid *w, int32_t contact)
{
    const ll_contact *c = &ll_contacts(w)[contact];
    const ll_body_sim *a = &ll_body_sims(w)[c->body[0]], *b = &ll_body_sims(w)[c->body[1]];
    return (ll_contact_constraint){.contact = contact,
                                   .a = c->body[0],
                                   .b = c->body[1],
                                   .ma = a->inv_mass,
                                   .ia = a->inv_inertia,
                                   .mb = b->inv_mass,
                                   .ib = b->inv_inertia,
                                   .friction = c->friction,
                                   .restitution = c->restitution};
}

/* All pairs that could meet: first the touching ones, by colour. */
static ll_contact_constraints prepare(ll_rigid *w, ll_index_list contacts)
{
    ll_colour_spans spans;
    ll_contact_counts counts = ll_order_contacts(w, NULL, contacts, &spans);
    ll_contact_constraints rows = {ll_solver_memory(w), counts.touching};
    ll_count_contacts(w, &counts);
    for (int32_t i = 0; i < rows.count; i++)
        rows.at[i] = row_of(w, ll_orders(w)[i]);
    for (int32_t i = 0; i < contacts.count; i++) {
        const ll_contact *c = &ll_contacts(w)[contacts.at[i]];
        if (c->colour == LL_NONE && may_move(w, c->body[0]) && may_move(w, c->body[1]))
            rows.at[rows.count++] = row_of(w, contacts.at[i]);
    }
    return rows;
}

static void substep(ll_rigid *w, ll_index_list bodies, ll_contact_constraints rows, double h)
{
    for (int32_t i = 0; i < bodies.count; i++) {
        int32_t k = bodies.at[i];
        const ll_solver_body *m = &ll_solver_bodies(w)[k];
        pasts(w)[k] = (past){.d = m->d, .turn = m->turn, .q = m->q};
    }
    ll_integrate_velocities(w, bodies, h);
    ll_integrate_positions(w, bodies, h);
    for (int32_t i = 0; i < w->joint_end; i++)
        if (ll_joints(w)[i].body[0] != LL_NONE)
            solve_joint(w, &ll_joints(w)[i], h);
    for (int32_t i = 0; i < rows.count; i++)
        correct_overlap(w, &rows.at[i], h);
    for (int32_t i = 0; i < bodies.count; i++) {
        int32_t k = bodies.at[i];
        pasts(w)[k].apart = ll_solver_bodies(w)[k].d;
        pasts(w)[k].turned_apart = ll_solver_bodies(w)[k].turn;
    }
    for (int32_t i = 0; i < rows.count; i++)
        hold(w, &rows.at[i], h);
    velocities_from_positions(w, bodies, h);
    for (int32_t i = 0; i < rows.count; i++) {
        slow_down(w, &rows.at[i]);
        turn_round(w, &rows.at[i]);
    }
}

/* Of the points of the beginning of the step; those of the next are matched by their impulses. */
static void store(ll_rigid *w, ll_contact_constraints rows)
{
    for (int32_t i = 0; i < rows.count; i++) {
        const ll_contact_constraint *r = &rows.at[i];
        ll_contact *c = &ll_contacts(w)[r->contact];
        for (int k = 0; k < c->count; k++) {
            c->at[k].normal_impulse = k < r->count ? r->at[k].normal_impulse : 0;
            c->at[k].tangent_impulse = k < r->count ? r->at[k].tangent_impulse : 0;
        }
    }
}

static void solve(ll_rigid *w, ll_team *team)
{
    (void)team;
    double h = w->dt / (double)w->params.substeps;
    ll_group all = ll_whole(w);
    ll_contact_constraints rows = prepare(w, all.contacts);
    for (int32_t i = 0; i < w->body_end; i++) /* immovable bodies too */
        pasts(w)[i] = (past){.q = {1, 0}};
    ll_prepare_body_steps(w, all.bodies, h);
    ll_bounces bounces = ll_begin_bounces(w, NULL, all.contacts, NULL, 0);
    for (int64_t i = 0; i < w->params.substeps; i++) {
        ll_bounce(w, &bounces, h, h);
        substep(w, all.bodies, rows, h);
    }
    ll_end_bounces(w, &bounces);
    store(w, rows);
}

const ll_solver ll_solver_xpbd = {
    .name = "xpbd",
    .help = "Extended position-based dynamics (Mueller et al. 2020): corrects positions, derives velocities, "
            "then applies friction and restitution; 3 passes per substep, and new contact points in each.",
    .passes = {[LL_PER_SUBSTEP] = 3},
    .size = size,
    .solve = solve};
