/* Projected Gauss-Seidel on velocities without correction, then nonlinear Gauss-Seidel on positions: removes
 * overlaps without leaving velocity (Box2D 2). Passes over contacts: 1 + iterations + position_iterations. */
#include "rigid/solver/solver.h"

static const double longest_push = 0.2; /* m per pass */

static void turn(ll_solver_body *m, double angle)
{
    m->q = ll_rot_mul(m->q, ll_rot_small(angle));
    m->turn += angle;
}

static double asked(const ll_rigid *w, double separation)
{
    double c = w->params.baumgarte * (separation + LL_LINEAR_SLOP);
    return -ll_max(ll_min(c, 0), -longest_push);
}

typedef struct lever { /* of the normal, at the current positions */
    double a, b, mass;
} lever;

static lever lever_of(const ll_rigid *w, const ll_contact_constraint *r,
                      const ll_contact_constraint_point *cp)
{
    double a = ll_cross(ll_rotate(ll_solver_bodies(w)[r->a].q, cp->ra), r->n);
    double b = ll_cross(ll_rotate(ll_solver_bodies(w)[r->b].q, cp->rb), r->n);
    double k = r->ma + r->mb + r->ia * a * a + r->ib * b * b;
    return (lever){a, b, k > 0 ? 1 / k : 0};
}

/* Corrects both points, like ll_solve_both for velocities. */
static bool correct(ll_rigid *w, const ll_contact_constraint *r)
{
    ll_solver_body *a = &ll_solver_bodies(w)[r->a], *b = &ll_solver_bodies(w)[r->b];
    lever at[2] = {{0}};
    double s[2] = {0}, one[2] = {0}, push[2];
    for (int k = 0; k < r->count; k++) {
        at[k] = lever_of(w, r, &r->at[k]);
        s[k] = ll_constraint_separation(w, r, &r->at[k]);
        one[k] = at[k].mass * asked(w, s[k]);
    }
    if (one[0] == 0 && one[1] == 0)
        return false;
    double coupling = r->ma + r->mb + r->ia * at[0].a * at[1].a + r->ib * at[0].b * at[1].b;
    for (int k = 0; k < 2; k++)
        push[k] = 0.5 * (one[k] + at[k].mass * asked(w, s[k] + coupling * one[1 - k]));
    if (r->count < 2)
        push[0] = one[0];
    double along = push[0] + push[1];
    a->d = ll_madd(a->d, -r->ma * along, r->n);
    turn(a, -r->ia * (at[0].a * push[0] + at[1].a * push[1]));
    b->d = ll_madd(b->d, r->mb * along, r->n);
    turn(b, r->ib * (at[0].b * push[0] + at[1].b * push[1]));
    return true;
}

/* Returns whether anything was corrected. */
static bool correct_all(ll_rigid *w, ll_contact_constraints rows)
{
    bool corrected = false;
    for (int32_t i = 0; i < rows.count; i++)
        corrected |= correct(w, &rows.at[i]);
    return corrected;
}

static void solve(ll_rigid *w, ll_team *team)
{
    (void)team;
    ll_contact_constraints rows = ll_pgs_velocities(w, 0);
    ll_integrate_positions(w, ll_whole(w).bodies, w->dt);
    for (int64_t n = 0; n < w->params.position_iterations && correct_all(w, rows); n++)
        ;
    ll_store_contacts(w, rows);
}

const ll_solver ll_solver_pgs_ngs = {
    .name = "pgs_ngs",
    .help = "Projected Gauss-Seidel, then overlaps corrected in the positions (Box2D 2): 1 + iterations + "
            "position_iterations passes.",
    .passes = {[LL_PER_STEP] = 1, [LL_PER_ITERATION] = 1, [LL_PER_POSITION_ITERATION] = 1},
    .size = ll_contact_constraints_size,
    .solve = solve};
