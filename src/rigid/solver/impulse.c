/* Impulses as in beginners' code: one pass over the contacts reverses each approaching point by itself, then
 * every overlap is pushed out at once. One contact undoes what another did, and pushing lifts bodies without
 * slowing them, which adds energy: a resting stack is thrown about until it falls (the paper's example). */
#include "rigid/solver/solver.h"

static void hit(ll_rigid *w, ll_contact_constraint *r, ll_contact_constraint_point *cp)
{
    ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    double vn = ll_dot(ll_relative(a, b, cp), r->n);
    cp->normal_impulse = cp->tangent_impulse = 0;
    if (vn >= 0 || ll_constraint_separation(w, r, cp) > 0)
        return;
    cp->normal_impulse = -(1 + r->restitution) * vn * cp->normal_mass;
    ll_apply_contact_impulse(a, b, r, cp, ll_scale(cp->normal_impulse, r->n));
    ll_vec2 t = ll_right(r->n);
    double most = r->friction * cp->normal_impulse;
    double impulse = -ll_dot(ll_relative(a, b, cp), t) * cp->tangent_mass;
    cp->tangent_impulse = ll_min(ll_max(impulse, -most), most);
    ll_apply_contact_impulse(a, b, r, cp, ll_scale(cp->tangent_impulse, t));
}

static void push_out(ll_rigid *w, const ll_contact_constraint *r)
{
    double deepest = 0;
    for (int k = 0; k < r->count; k++)
        deepest = ll_min(deepest, ll_constraint_separation(w, r, &r->at[k]));
    double share = r->ma + r->mb > 0 ? -deepest / (r->ma + r->mb) : 0;
    ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    a->d = ll_madd(a->d, -r->ma * share, r->n);
    b->d = ll_madd(b->d, r->mb * share, r->n);
}

static void solve(ll_rigid *w, ll_team *team)
{
    (void)team;
    ll_group all = ll_whole(w);
    ll_contact_constraints rows = ll_prepare_contacts(w);
    ll_prepare_body_steps(w, all.bodies, w->dt);
    ll_integrate_velocities(w, all.bodies, w->dt);
    ll_clear_joint_impulses(w);
    ll_joint_set joints = ll_prepare_joints(w, all.joints);
    ll_solve_joints(w, &joints, w->dt, (ll_softness){w->params.baumgarte / w->dt, 1, 0}, true);
    for (int32_t i = 0; i < rows.count; i++)
        for (int k = 0; k < rows.at[i].count; k++)
            hit(w, &rows.at[i], &rows.at[i].at[k]);
    ll_integrate_positions(w, all.bodies, w->dt);
    for (int32_t i = 0; i < rows.count; i++)
        push_out(w, &rows.at[i]);
    ll_store_contacts(w, rows);
}

const ll_solver ll_solver_impulse = {
    .name = "impulse",
    .help = "Each contact by itself, once, and overlaps pushed out at once, as in beginners' code: 2 passes.",
    .passes = {[LL_PER_STEP] = 2},
    .size = ll_contact_constraints_size,
    .solve = solve};
