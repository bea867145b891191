/* Projected Gauss-Seidel on velocities without correction, then nonlinear Gauss-Seidel on positions: overlaps
 * are taken out where the bodies are, and no speed is left from it (Box2D 2). Passes over contacts: 1 +
 * iterations + position_iterations. */
#include "rigid/solve.h"

static const double longest_push = 0.2; /* m, in one pass */

static void turn(ll_motion *m, double angle)
{
    m->q = ll_rot_mul(m->q, ll_rot_small(angle));
    m->turn += angle;
}

static bool correct(ll_rigid *w, const ll_touch_row *r, const ll_line *line)
{
    ll_motion *a = &ll_motions(w)[r->a], *b = &ll_motions(w)[r->b];
    double c = w->params.baumgarte * (ll_line_separation(w, r, line) + LL_LINEAR_SLOP);
    c = ll_max(ll_min(c, 0), -longest_push);
    if (c == 0)
        return false;
    ll_vec2 ra = ll_rotate(a->q, line->ra), rb = ll_rotate(b->q, line->rb);
    double na = ll_cross(ra, r->n), nb = ll_cross(rb, r->n),
           k = r->ma + r->mb + r->ia * na * na + r->ib * nb * nb;
    double impulse = k > 0 ? -c / k : 0;
    a->d = ll_madd(a->d, -r->ma * impulse, r->n);
    turn(a, -r->ia * na * impulse);
    b->d = ll_madd(b->d, r->mb * impulse, r->n);
    turn(b, r->ib * nb * impulse);
    return true;
}

/* Whether anything had to be corrected. */
static bool correct_all(ll_rigid *w, ll_touch_rows rows)
{
    bool corrected = false;
    for (int32_t i = 0; i < rows.count; i++)
        for (int k = 0; k < rows.at[i].count; k++)
            corrected |= correct(w, &rows.at[i], &rows.at[i].at[k]);
    return corrected;
}

static void solve(ll_rigid *w)
{
    ll_touch_rows rows = ll_pgs_velocities(w, 0);
    ll_integrate_positions(w, ll_whole(w).bodies, w->dt);
    for (int64_t n = 0; n < w->params.position_iterations && correct_all(w, rows); n++)
        ;
    ll_store_touch_rows(w, rows);
}

const ll_solver ll_solver_pgs_ngs = {
    .name = "pgs_ngs",
    .help = "Projected Gauss-Seidel, then overlaps corrected in the positions (Box2D 2): 1 + iterations + "
            "position_iterations passes.",
    .passes = {[LL_PER_STEP] = 1, [LL_PER_ITERATION] = 1, [LL_PER_POSITION_ITERATION] = 1},
    .size = ll_touch_rows_size,
    .solve = solve};
