/* Extended position-based dynamics of rigid bodies (Mueller, Macklin, Chentanez, Jeschke, Kim, "Detailed
 * Rigid Body Simulation with Extended Position Based Dynamics", 2020): in each substep the bodies fly freely,
 * overlaps and joints are corrected in the positions, and velocities are what the positions then say. Passes
 * over contacts with n substeps: 2 n. */
#include "rigid/solve.h"

#include <string.h>

typedef struct past { /* where a body was at the beginning of the substep */
    ll_vec2 d;
    double turn;
    ll_rot q;
    double pad[3];
} past;

static size_t size(const ll_rigid_limits *limits)
{
    return ll_touch_rows_size(limits) + (size_t)(limits->bodies + 1) * sizeof(past);
}

static past *pasts(const ll_rigid *w)
{
    return (past *)((char *)ll_solver_memory(w) + ll_touch_rows_size(&w->limits));
}

static void shift(ll_motion *m, double inverse_mass, double inverse_inertia, ll_vec2 n, double lever,
                  double amount)
{
    double angle = inverse_inertia * lever * amount;
    m->d = ll_madd(m->d, inverse_mass * amount, n);
    m->q = ll_rot_mul(m->q, ll_rot_small(angle));
    m->turn += angle;
}

/* Moves both bodies so that c along n goes to 0, but by no more than `most` in all. */
static double correct(ll_rigid *w, const ll_touch_row *r, ll_vec2 ra, ll_vec2 rb, ll_vec2 n, double c,
                      double most)
{
    double na = ll_cross(ra, n), nb = ll_cross(rb, n), k = r->ma + r->mb + r->ia * na * na + r->ib * nb * nb;
    double amount = k > 0 ? ll_min(ll_max(-c / k, -most), most) : 0;
    shift(&ll_motions(w)[r->a], r->ma, r->ia, n, na, -amount);
    shift(&ll_motions(w)[r->b], r->mb, r->ib, n, nb, amount);
    return amount;
}

static double separation_before(const ll_rigid *w, const ll_touch_row *r, const ll_line *line)
{
    const past *a = &pasts(w)[r->a], *b = &pasts(w)[r->b];
    ll_vec2 gap = ll_sub(ll_add(ll_sub(ll_poses(w)[r->b].p, ll_poses(w)[r->a].p), b->d), a->d);
    gap = ll_add(gap, ll_sub(ll_rotate(b->q, line->rb), ll_rotate(a->q, line->ra)));
    return ll_dot(gap, r->n) + line->adjust;
}

static void solve_line(ll_rigid *w, ll_touch_row *r, ll_line *line, double h)
{
    double s = ll_line_separation(w, r, line);
    line->normal_impulse = line->tangent_impulse = 0;
    if (s >= 0)
        return;
    const ll_motion *a = &ll_motions(w)[r->a], *b = &ll_motions(w)[r->b];
    ll_vec2 ra = ll_rotate(a->q, line->ra), rb = ll_rotate(b->q, line->rb), t = ll_right(r->n);
    /* What came on in this substep goes at once, an older overlap no faster than the push speed. */
    s -= ll_min(separation_before(w, r, line) + w->params.push_speed * h, 0);
    if (s >= 0)
        return;
    double lambda = correct(w, r, ra, rb, r->n, s, INFINITY);
    line->normal_impulse = lambda / h;
    line->most = ll_max(line->most, line->normal_impulse);
    /* Static friction: the points go back along the surface to where they were to each other. */
    const past *pa = &pasts(w)[r->a], *pb = &pasts(w)[r->b];
    ll_vec2 slid =
        ll_sub(ll_sub(ll_add(b->d, ll_rotate(b->q, line->rb)), ll_add(pb->d, ll_rotate(pb->q, line->rb))),
               ll_sub(ll_add(a->d, ll_rotate(a->q, line->ra)), ll_add(pa->d, ll_rotate(pa->q, line->ra))));
    line->tangent_impulse = correct(w, r, ra, rb, t, ll_dot(slid, t), r->friction * lambda) / h;
}

static void solve_joint(ll_rigid *w, ll_joint *j, double h)
{
    const ll_body *a = &ll_bodys(w)[j->body[0]], *b = &ll_bodys(w)[j->body[1]];
    ll_motion *ma = &ll_motions(w)[j->body[0]], *mb = &ll_motions(w)[j->body[1]];
    const past *pa = &pasts(w)[j->body[0]], *pb = &pasts(w)[j->body[1]];
    for (int i = 0; i < LL_ROWS; i++) {
        ll_row rows[LL_ROWS];
        memset(rows, 0, sizeof rows);
        ll_joint_row_types[j->def.type]->rows(j, ll_pose_now(w, j->body[0]), ll_pose_now(w, j->body[1]),
                                              ll_angle_now(w, j), rows);
        const ll_row *r = &rows[i];
        double k = (a->inv_mass + b->inv_mass) * ll_dot(r->n, r->n) + a->inv_inertia * r->ja * r->ja +
                   b->inv_inertia * r->jb * r->jb;
        if (r->kind == LL_ROW_NONE || k <= 0 || (r->kind == LL_ROW_LIMIT && r->c >= 0))
            continue;
        ll_vec2 way = ll_sub(ll_sub(mb->d, pb->d), ll_sub(ma->d, pa->d));
        double moved = /* by the row in this substep */
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

static void velocities_from_positions(ll_rigid *w, ll_list bodies, double h)
{
    for (int32_t i = 0; i < bodies.count; i++) {
        int32_t k = bodies.at[i];
        ll_motion *m = &ll_motions(w)[k];
        if (ll_bodys(w)[k].inv_mass == 0)
            continue;
        m->v = ll_scale(1 / h, ll_sub(m->d, pasts(w)[k].d));
        m->w = (m->turn - pasts(w)[k].turn) / h;
    }
}

static void substep(ll_rigid *w, ll_list bodies, ll_touch_rows rows, double h)
{
    for (int32_t i = 0; i < bodies.count; i++) {
        int32_t k = bodies.at[i];
        const ll_motion *m = &ll_motions(w)[k];
        pasts(w)[k] = (past){.d = m->d, .turn = m->turn, .q = m->q};
    }
    ll_integrate_velocities(w, bodies, h);
    ll_integrate_positions(w, bodies, h);
    for (int32_t i = 0; i < w->joint_end; i++)
        if (ll_joints(w)[i].body[0] != LL_NONE)
            solve_joint(w, &ll_joints(w)[i], h);
    for (int32_t i = 0; i < rows.count; i++)
        for (int k = 0; k < rows.at[i].count; k++)
            solve_line(w, &rows.at[i], &rows.at[i].at[k], h);
    velocities_from_positions(w, bodies, h);
}

static void solve(ll_rigid *w)
{
    double h = w->dt / (double)w->params.substeps;
    ll_list bodies = ll_whole(w).bodies;
    ll_touch_rows rows = ll_prepare_touch_rows(w);
    for (int32_t i = 0; i < w->body_end; i++) /* also of what does not move */
        pasts(w)[i] = (past){.q = {1, 0}};
    ll_prepare_drives(w, bodies, h);
    for (int64_t i = 0; i < w->params.substeps; i++)
        substep(w, bodies, rows, h);
    ll_apply_restitution(w, rows);
    ll_store_touch_rows(w, rows);
}

const ll_solver ll_solver_xpbd = {.name = "xpbd",
                                  .help = "Extended position-based dynamics (Mueller et al. 2020): positions "
                                          "are corrected, velocities follow; 1 pass a "
                                          "substep.",
                                  .passes = {[LL_PER_SUBSTEP] = 1},
                                  .size = size,
                                  .solve = solve};
