/* Temporal Gauss-Seidel with sticky friction (solver2d's TGS Sticky): substeps, hard contacts, and friction
 * that holds a point where it was rather than its speed at zero, so that piles do not creep. Then passes
 * without correction take out the speed that it left.
 *
 * Where a point was is what its anchors say: both are one point when the manifold is made, and move with
 * their bodies while it is recycled. A contact that slides has its manifold made anew. Impulses of contacts
 * add up over the whole step, from 0: what one substep pushed too much the next takes back. Those of joints
 * are a substep's, and begin as they were in the one before: springs and largest forces are rates. Passes
 * over contacts with n substeps: 1.5 n. */
#include "rigid/solve.h"

/* Shares of an error that a substep corrects. */
static const double normal_share = 0.8, friction_share = 0.5;

typedef struct gap_now {
    double normal, tangent;
} gap_now;

static gap_now gap_of(const ll_rigid *w, const ll_touch_row *r, const ll_line *line)
{
    const ll_motion *a = &ll_motions(w)[r->a], *b = &ll_motions(w)[r->b];
    const ll_pose *poses = ll_poses(w);
    ll_vec2 gap = ll_add(ll_sub(poses[r->b].p, poses[r->a].p), ll_sub(b->d, a->d));
    gap = ll_add(gap, ll_sub(ll_rotate(b->q, line->rb), ll_rotate(a->q, line->ra)));
    return (gap_now){ll_dot(gap, r->n) + line->adjust, ll_dot(gap, ll_right(r->n))};
}

static void solve_normal(ll_rigid *w, ll_touch_row *r, ll_line *line, double rate, bool bias)
{
    ll_motion *a = &ll_motions(w)[r->a], *b = &ll_motions(w)[r->b];
    double gap = gap_of(w, r, line).normal, share = bias ? normal_share * rate : 0;
    double wanted = gap > 0 ? gap * rate : ll_max(share * gap, -w->params.push_speed);
    double vn = ll_dot(ll_relative(a, b, line), r->n);
    double sum = ll_max(line->normal_impulse - line->normal_mass * (vn + wanted), 0);
    ll_push(a, b, r, line, ll_scale(sum - line->normal_impulse, r->n));
    line->normal_impulse = sum;
    line->most = ll_max(line->most, sum);
}

static void solve_friction(ll_rigid *w, ll_touch_row *r, ll_line *line, double most, double rate, bool bias)
{
    ll_motion *a = &ll_motions(w)[r->a], *b = &ll_motions(w)[r->b];
    ll_vec2 t = ll_right(r->n);
    double push = w->params.push_speed, share = bias ? friction_share * rate : 0;
    double back = ll_min(ll_max(share * gap_of(w, r, line).tangent, -push), push);
    double vt = ll_dot(ll_relative(a, b, line), t);
    double held = line->tangent_impulse - line->tangent_mass * (vt + back);
    double sum = ll_min(ll_max(held, -most), most);
    if (sum != held && most > 0 && !bias) /* slides */
        ll_contacts(w)[r->contact].rel.x = INFINITY;
    ll_push(a, b, r, line, ll_scale(sum - line->tangent_impulse, t));
    line->tangent_impulse = sum;
}

/* Both points' friction has the mean of what presses on them for its limit. */
static void pass(ll_rigid *w, ll_touch_rows rows, double rate, bool bias)
{
    for (int32_t i = 0; i < rows.count; i++) {
        ll_touch_row *r = &rows.at[i];
        double sum = 0;
        for (int k = 0; k < r->count; k++) {
            solve_normal(w, r, &r->at[k], rate, bias);
            sum += r->at[k].normal_impulse;
        }
        for (int k = 0; k < r->count; k++)
            solve_friction(w, r, &r->at[k], r->friction * sum / r->count, rate, bias);
    }
}

static void solve(ll_rigid *w)
{
    double h = w->dt / (double)w->params.substeps, rate = 1 / h;
    ll_softness stiff = ll_soft(ll_min(w->params.joint_hertz, 0.25 * rate), w->params.joint_damping, h);
    ll_group all = ll_whole(w);
    ll_touch_rows rows = ll_prepare_touch_rows(w);
    ll_prepare_drives(w, all.bodies, h);
    ll_joint_set joints = ll_prepare_joints(w, all.joints);
    for (int32_t i = 0; i < rows.count; i++)
        for (int k = 0; k < rows.at[i].count; k++)
            rows.at[i].at[k].normal_impulse = rows.at[i].at[k].tangent_impulse = 0;
    for (int64_t i = 0; i < w->params.substeps; i++) {
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
    ll_apply_restitution(w, rows);
    ll_store_touch_rows(w, rows);
    ll_store_joints(w, &joints);
}

const ll_solver ll_solver_tgs_sticky = {.name = "tgs_sticky",
                                        .help = "Substeps with hard contacts and friction that holds places "
                                                "(solver2d's TGS Sticky): 1.5 passes a substep.",
                                        .passes = {[LL_PER_SUBSTEP] = 1.5},
                                        .size = ll_touch_rows_size,
                                        .solve = solve};
