/* Projected Gauss-Seidel on velocities with accumulated impulses (Catto, "Iterative Dynamics with Temporal
 * Coherence", 2005). A share of each overlap is added to the speed asked for (Baumgarte 1972), which leaves
 * that speed in the bodies. Passes over contacts: 1 + iterations. */
#include "rigid/solve.h"

static bool solve_friction(ll_motion *a, ll_motion *b, const ll_touch_row *r, ll_line *line)
{
    ll_vec2 t = ll_right(r->n);
    double most = r->friction * line->normal_impulse;
    double sum = line->tangent_impulse - line->tangent_mass * ll_dot(ll_relative(a, b, line), t);
    sum = ll_min(ll_max(sum, -most), most);
    double impulse = sum - line->tangent_impulse;
    line->tangent_impulse = sum;
    ll_push(a, b, r, line, ll_scale(impulse, t));
    return impulse != 0;
}

static bool solve_normal(ll_motion *a, ll_motion *b, const ll_touch_row *r, ll_line *line, double bias)
{
    double vn = ll_dot(ll_relative(a, b, line), r->n);
    double sum = ll_max(line->normal_impulse - line->normal_mass * (vn + bias), 0),
           impulse = sum - line->normal_impulse;
    line->normal_impulse = sum;
    line->most = ll_max(line->most, sum);
    ll_push(a, b, r, line, ll_scale(impulse, r->n));
    return impulse != 0;
}

/* Whether an impulse has changed. */
static bool pass(ll_rigid *w, ll_touch_rows rows, double baumgarte)
{
    double rate = 1 / w->dt;
    bool changed = false;
    for (int32_t i = 0; i < rows.count; i++) {
        ll_touch_row *r = &rows.at[i];
        ll_motion *a = &ll_motions(w)[r->a], *b = &ll_motions(w)[r->b];
        for (int k = 0; k < r->count; k++)
            changed |= solve_friction(a, b, r, &r->at[k]);
        for (int k = 0; k < r->count; k++) {
            double s = ll_line_separation(w, r, &r->at[k]);
            double bias =
                s > 0 ? s * rate
                      : ll_max(baumgarte * rate * ll_min(0, s + LL_LINEAR_SLOP), -w->params.push_speed);
            changed |= solve_normal(a, b, r, &r->at[k], bias);
        }
    }
    return changed;
}

ll_touch_rows ll_pgs_velocities(ll_rigid *w, double baumgarte)
{
    ll_group all = ll_whole(w);
    ll_touch_rows rows = ll_prepare_touch_rows(w);
    ll_softness stiff = {w->params.baumgarte / w->dt, 1, 0};
    ll_prepare_drives(w, all.bodies, w->dt);
    ll_integrate_velocities(w, all.bodies, w->dt);
    ll_joint_set joints = ll_prepare_joints(w, all.joints);
    ll_warm_start_joints(w, &joints);
    ll_warm_start_touch(w, rows);
    /* A pass that changes nothing is followed by none that does. */
    bool changed = true;
    for (int64_t i = 0; i < w->params.iterations && changed; i++) {
        changed = ll_solve_joints(w, &joints, w->dt, stiff, true);
        changed |= pass(w, rows, baumgarte);
    }
    ll_apply_restitution(w, rows);
    ll_store_joints(w, &joints);
    return rows;
}

static void solve(ll_rigid *w)
{
    ll_touch_rows rows = ll_pgs_velocities(w, w->params.baumgarte);
    ll_integrate_positions(w, ll_whole(w).bodies, w->dt);
    ll_store_touch_rows(w, rows);
}

const ll_solver ll_solver_pgs = {
    .name = "pgs",
    .help =
        "Projected Gauss-Seidel with Baumgarte's correction of overlap (Catto 2005): 1 + iterations passes.",
    .passes = {[LL_PER_STEP] = 1, [LL_PER_ITERATION] = 1},
    .size = ll_touch_rows_size,
    .solve = solve};
