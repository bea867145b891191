/* Temporal Gauss-Seidel with sticky friction (solver2d's TGS Sticky): substeps, hard contacts, and friction
 * that holds a point's position rather than zero velocity, so that piles do not creep. Passes without
 * correction then remove the velocity that it left.
 *
 * The anchors keep a point's position: both are one point when the manifold is made, and move with their
 * bodies while it is recycled. The manifold of a sliding contact is recomputed. Impulses of contacts
 * accumulate over the whole step, from 0: later substeps take back excess. Those of joints belong to a
 * substep and start from the previous one, since springs and largest forces are rates. Passes over contacts
 * with n substeps: 1.5 n. */
#include "rigid/solver/solver.h"

/* Fraction of an error that a substep corrects. */
static const double normal_share = 0.8, friction_share = 0.5;

typedef struct gap_now {
    double normal, tangent;
} gap_now;

static gap_now gap_of(const ll_rigid *w, const ll_contact_constraint *r,
                      const ll_contact_constraint_point *cp)
{
    const ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    const ll_pose *poses = ll_poses(w);
    ll_vec2 gap = ll_add(ll_sub(poses[r->b].p, poses[r->a].p), ll_sub(b->d, a->d));
    gap = ll_add(gap, ll_sub(ll_rotate(b->q, cp->rb), ll_rotate(a->q, cp->ra)));
    return (gap_now){ll_dot(gap, r->n) + cp->adjust, ll_dot(gap, ll_right(r->n))};
}

static void push_both(ll_rigid *w, ll_contact_constraint *r, ll_vec2 axis, const double sum[2],
                      const double old[2])
{
    for (int k = 0; k < r->count; k++)
        ll_apply_contact_impulse(&ll_solver_bodies(w)[r->a], &ll_solver_bodies(w)[r->b], r, &r->at[k],
                                 ll_scale(sum[k] - old[k], axis));
}

static void solve_normal(ll_rigid *w, ll_contact_constraint *r, const gap_now gap[2], double rate, bool bias)
{
    const ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    double v[2] = {0}, mass[2] = {0}, sum[2] = {0}, old[2], share = bias ? normal_share * rate : 0;
    for (int k = 0; k < r->count; k++) {
        double s = gap[k].normal;
        double wanted = s > 0 ? s * rate : ll_max(share * s, -w->params.contact_push_speed);
        v[k] = ll_dot(ll_relative(a, b, &r->at[k]), r->n) + wanted;
        mass[k] = r->at[k].normal_mass;
        sum[k] = old[k] = r->at[k].normal_impulse;
    }
    ll_solve_both(v, mass, r->count == 2 ? ll_coupling(r, r->n) : 0, (double[2]){0, 0},
                  (double[2]){INFINITY, INFINITY}, sum);
    for (int k = 0; k < r->count; k++)
        r->at[k].normal_impulse = sum[k];
    push_both(w, r, r->n, sum, old);
}

static void solve_friction(ll_rigid *w, ll_contact_constraint *r, const gap_now gap[2], double most,
                           double rate, bool bias)
{
    const ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    ll_vec2 t = ll_right(r->n);
    double v[2] = {0}, mass[2] = {0}, sum[2] = {0}, old[2];
    double push = w->params.contact_push_speed, share = bias ? friction_share * rate : 0;
    for (int k = 0; k < r->count; k++) {
        double back = ll_min(ll_max(share * gap[k].tangent, -push), push);
        v[k] = ll_dot(ll_relative(a, b, &r->at[k]), t) + back;
        mass[k] = r->at[k].tangent_mass;
        sum[k] = old[k] = r->at[k].tangent_impulse;
    }
    ll_solve_both(v, mass, r->count == 2 ? ll_coupling(r, t) : 0, (double[2]){-most, -most},
                  (double[2]){most, most}, sum);
    for (int k = 0; k < r->count; k++) {
        if (fabs(sum[k]) == most && most > 0 && !bias) /* sliding */
            ll_contacts(w)[r->contact].rel.x = INFINITY;
        r->at[k].tangent_impulse = sum[k];
    }
    push_both(w, r, t, sum, old);
}

/* The friction limit of both points uses the mean of their normal impulses. */
static void pass(ll_rigid *w, ll_contact_constraints rows, double rate, bool bias)
{
    for (int32_t i = 0; i < rows.count; i++) {
        ll_contact_constraint *r = &rows.at[i];
        gap_now gap[2] = {{0}};
        double sum = 0;
        for (int k = 0; k < r->count; k++)
            gap[k] = gap_of(w, r, &r->at[k]);
        solve_normal(w, r, gap, rate, bias);
        for (int k = 0; k < r->count; k++)
            sum += r->at[k].normal_impulse;
        solve_friction(w, r, gap, r->friction * sum / r->count, rate, bias);
    }
}

static void solve(ll_rigid *w, ll_team *team)
{
    (void)team;
    double h = w->dt / (double)w->params.substeps, rate = 1 / h;
    ll_softness stiff = ll_soft(ll_min(w->params.joint_hertz, 0.25 * rate), w->params.joint_damping_ratio, h);
    ll_group all = ll_whole(w);
    ll_contact_constraints rows = ll_prepare_contacts(w);
    ll_prepare_body_steps(w, all.bodies, h);
    ll_joint_set joints = ll_prepare_joints(w, all.joints);
    for (int32_t i = 0; i < rows.count; i++)
        for (int k = 0; k < rows.at[i].count; k++)
            rows.at[i].at[k].normal_impulse = rows.at[i].at[k].tangent_impulse = 0;
    ll_bounces bounces = ll_begin_bounces(w, NULL, all.contacts, NULL, 0);
    for (int64_t i = 0; i < w->params.substeps; i++) {
        ll_bounce(w, &bounces, h, 2 * h);
        ll_integrate_velocities(w, all.bodies, h);
        ll_warm_start_joints(w, &joints);
        ll_solve_joints(w, &joints, h, stiff, true);
        pass(w, rows, rate, true);
        ll_integrate_positions(w, all.bodies, h);
    }
    for (int64_t i = 0; i < (w->params.substeps + 1) / 2; i++) {
        ll_solve_joints(w, &joints, h, stiff, false);
        pass(w, rows, rate, false);
    }
    ll_end_bounces(w, &bounces);
    ll_store_contacts(w, rows);
    ll_store_joints(w, &joints);
}

const ll_solver ll_solver_tgs_sticky = {.name = "tgs_sticky",
                                        .help = "Substeps with hard contacts and friction that holds "
                                                "positions (solver2d's TGS Sticky): 1.5 passes per substep.",
                                        .passes = {[LL_PER_SUBSTEP] = 1.5},
                                        .size = ll_contact_constraints_size,
                                        .solve = solve};
