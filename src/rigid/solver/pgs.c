/* Projected Gauss-Seidel on velocities with accumulated impulses (Catto, "Iterative Dynamics with Temporal
 * Coherence", 2005). A fraction of each overlap is added to the target velocity (Baumgarte 1972) and stays in
 * the bodies. Passes over contacts: 1 + iterations. */
#include "rigid/solver/solver.h"

#include <string.h>

/* Updates the accumulated impulses along `axis`. Returns whether one changed. */
static bool push_both(ll_solver_body *a, ll_solver_body *b, const ll_contact_constraint *r, ll_vec2 axis,
                      const double sum[2], const double old[2])
{
    bool changed = false;
    for (int k = 0; k < r->count; k++) {
        ll_apply_contact_impulse(a, b, r, &r->at[k], ll_scale(sum[k] - old[k], axis));
        changed |= sum[k] != old[k];
    }
    return changed;
}

static bool solve_friction(ll_solver_body *a, ll_solver_body *b, ll_contact_constraint *r)
{
    ll_vec2 t = ll_right(r->n);
    double v[2] = {0}, mass[2] = {0}, low[2] = {0}, high[2] = {0}, sum[2] = {0}, old[2];
    for (int k = 0; k < r->count; k++) {
        const ll_contact_constraint_point *cp = &r->at[k];
        v[k] = ll_dot(ll_relative(a, b, cp), t);
        mass[k] = cp->tangent_mass;
        high[k] = r->friction * cp->normal_impulse;
        low[k] = -high[k];
        sum[k] = cp->tangent_impulse;
    }
    memcpy(old, sum, sizeof old);
    ll_solve_both(v, mass, r->count == 2 ? ll_coupling(r, t) : 0, low, high, sum);
    for (int k = 0; k < r->count; k++)
        r->at[k].tangent_impulse = sum[k];
    return push_both(a, b, r, t, sum, old);
}

static bool solve_normal(ll_solver_body *a, ll_solver_body *b, ll_contact_constraint *r, const double bias[2])
{
    double v[2] = {0}, mass[2] = {0}, sum[2] = {0}, old[2];
    for (int k = 0; k < r->count; k++) {
        const ll_contact_constraint_point *cp = &r->at[k];
        v[k] = ll_dot(ll_relative(a, b, cp), r->n) + bias[k];
        mass[k] = cp->normal_mass;
        sum[k] = cp->normal_impulse;
    }
    memcpy(old, sum, sizeof old);
    ll_solve_both(v, mass, r->count == 2 ? ll_coupling(r, r->n) : 0, (double[2]){0, 0},
                  (double[2]){INFINITY, INFINITY}, sum);
    for (int k = 0; k < r->count; k++)
        r->at[k].normal_impulse = sum[k];
    return push_both(a, b, r, r->n, sum, old);
}

/* Returns whether an impulse changed. */
static bool pass(ll_rigid *w, ll_contact_constraints rows, double baumgarte)
{
    double rate = 1 / w->dt;
    bool changed = false;
    for (int32_t i = 0; i < rows.count; i++) {
        ll_contact_constraint *r = &rows.at[i];
        ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
        double bias[2] = {0};
        for (int k = 0; k < r->count; k++) {
            double s = ll_constraint_separation(w, r, &r->at[k]);
            bias[k] = s > 0 ? s * rate
                            : ll_max(baumgarte * rate * ll_min(0, s + LL_LINEAR_SLOP),
                                     -w->params.contact_push_speed);
        }
        changed |= solve_friction(a, b, r);
        changed |= solve_normal(a, b, r, bias);
    }
    return changed;
}

ll_contact_constraints ll_pgs_velocities(ll_rigid *w, double baumgarte)
{
    ll_group all = ll_whole(w);
    ll_contact_constraints rows = ll_prepare_contacts(w);
    ll_softness stiff = {w->params.baumgarte / w->dt, 1, 0};
    ll_prepare_body_steps(w, all.bodies, w->dt);
    ll_bounces bounces = ll_begin_bounces(w, NULL, all.contacts, NULL, 0);
    ll_bounce(w, &bounces, w->dt, w->dt);
    ll_integrate_velocities(w, all.bodies, w->dt);
    ll_joint_set joints = ll_prepare_joints(w, all.joints);
    ll_warm_start_joints(w, &joints);
    ll_warm_start_contacts(w, rows);
    /* After a pass that changes nothing, no other pass would. */
    bool changed = true;
    for (int64_t i = 0; i < w->params.iterations && changed; i++) {
        changed = ll_solve_joints(w, &joints, w->dt, stiff, true);
        changed |= pass(w, rows, baumgarte);
    }
    ll_end_bounces(w, &bounces);
    ll_store_joints(w, &joints);
    return rows;
}

static void solve(ll_rigid *w, ll_team *team)
{
    (void)team;
    ll_contact_constraints rows = ll_pgs_velocities(w, w->params.baumgarte);
    ll_integrate_positions(w, ll_whole(w).bodies, w->dt);
    ll_store_contacts(w, rows);
}

const ll_solver ll_solver_pgs = {
    .name = "pgs",
    .help =
        "Projected Gauss-Seidel with Baumgarte's correction of overlap (Catto 2005): 1 + iterations passes.",
    .passes = {[LL_PER_STEP] = 1, [LL_PER_ITERATION] = 1},
    .size = ll_contact_constraints_size,
    .solve = solve};
