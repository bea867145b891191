#include "rigid/solve.h"
static void solve(ll_rigid *w)
{
    ll_solver_soft_step.solve(w);
}
const ll_solver ll_solver_avbd = {.name = "avbd", .help = "", .size = ll_touch_rows_size, .solve = solve};
