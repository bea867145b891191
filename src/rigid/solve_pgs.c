/* Projected Gauss-Seidel on velocities with accumulated impulses (Catto, "Iterative Dynamics with Temporal
 * Coherence", 2005). A fraction of each overlap is added to the target velocity (Baumgarte 1972) and stays in
 * the bodies. Passes over contacts: 1 + iterations. */
#include "rigid/solve.h"

#include <string.h>

/* Updates the accumulated impulses along `axis`. Returns whether one changed. */
static bool push_both(ll_motion *a, ll_motion *b, const ll_touch_row *r, ll_vec2 axis, const double sum[2],
                      const double old[2])
{
    bool changed = false;
    for (int k = 0; k < r->count; k++) {
        ll_push(a, b, r, &r->at[k], ll_scale(sum[k] - old[k], axis));
        changed |= sum[k] != old[k];
    }
    return changed;
}

static bool solve_friction(ll_motion *a, ll_motion *b, ll_touch_row *r)
{
    ll_vec2 t = ll_right(r->n);
    double v[2] = {0}, mass[2] = {0}, low[2] = {0}, high[2] = {0}, sum[2] = {0}, old[2];
    for (int k = 0; k < r->count; k++) {
        const ll_line *line = &r->at[k];
        v[k] = ll_dot(ll_relative(a, b, line), t);
        mass[k] = line->tangent_mass;
        high[k] = r->friction * line->normal_impulse;
        low[k] = -high[k];
        sum[k] = line->tangent_impulse;
    }
    memcpy(old, sum, sizeof old);
    ll_solve_both(v, mass, r->count == 2 ? ll_coupling(r, t) : 0, low, high, sum);
    for (int k = 0; k < r->count; k++)
        r->at[k].tangent_impulse = sum[k];
    return push_both(a, b, r, t, sum, old);
}

static bool solve_normal(ll_motion *a, ll_motion *b, ll_touch_row *r, const double bias[2])
{
    double v[2] = {0}, mass[2] = {0}, sum[2] = {0}, old[2];
    for (int k = 0; k < r->count; k++) {
        const ll_line *line = &r->at[k];
        v[k] = ll_dot(ll_relative(a, b, line), r->n) + bias[k];
        mass[k] = line->normal_mass;
        sum[k] = line->normal_impulse;
    }
    memcpy(old, sum, sizeof old);
    ll_solve_both(v, mass, r->count == 2 ? ll_coupling(r, r->n) : 0, (double[2]){0, 0},
                  (double[2]){INFINITY, INFINITY}, sum);
    for (int k = 0; k < r->count; k++)
        r->at[k].normal_impulse = sum[k];
    return push_both(a, b, r, r->n, sum, old);
}

/* Returns whether an impulse changed. */
static bool pass(ll_rigid *w, ll_touch_rows rows, double baumgarte)
{
    double rate = 1 / w->dt;
    bool changed = false;
    for (int32_t i = 0; i < rows.count; i++) {
        ll_touch_row *r = &rows.at[i];
        ll_motion *a = &ll_motions(w)[r->a], *b = &ll_motions(w)[r->b];
        double bias[2] = {0};
        for (int k = 0; k < r->count; k++) {
            double s = ll_line_separation(w, r, &r->at[k]);
            bias[k] = s > 0 ? s * rate
                            : ll_max(baumgarte * rate * ll_min(0, s + LL_LINEAR_SLOP), -w->params.push_speed);
        }
        changed |= solve_friction(a, b, r);
        changed |= solve_normal(a, b, r, bias);
    }
    return changed;
}

ll_touch_rows ll_pgs_velocities(ll_rigid *w, double baumgarte)
{
    ll_group all = ll_whole(w);
    ll_touch_rows rows = ll_prepare_touch_rows(w);
    ll_softness stiff = {w->params.baumgarte / w->dt, 1, 0};
    ll_prepare_drives(w, all.bodies, w->dt);
    ll_bounces bounces = ll_begin_bounces(w, all.contacts);
    ll_bounce(w, &bounces, w->dt, w->dt);
    ll_integrate_velocities(w, all.bodies, w->dt);
    ll_joint_set joints = ll_prepare_joints(w, all.joints);
    ll_warm_start_joints(w, &joints);
    ll_warm_start_touch(w, rows);
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
