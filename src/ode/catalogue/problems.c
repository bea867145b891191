#include <string.h>

#include "ode/core/problem_rows.h"

const ll_ode_problem *const ll_ode_problems[] = {&ll_ode_free_fall,
                                                 &ll_ode_jerk,
                                                 &ll_ode_forced,
                                                 &ll_ode_oscillator,
                                                 &ll_ode_damped,
                                                 &ll_ode_drag_vertical,
                                                 &ll_ode_drag_2d,
                                                 &ll_ode_lorentz,
                                                 &ll_ode_pendulum,
                                                 &ll_ode_kepler,
                                                 &ll_ode_henon_heiles,
                                                 &ll_ode_double_pendulum,
                                                 &ll_ode_elastic_pendulum,
                                                 &ll_ode_stiff_pendulum,
                                                 &ll_ode_spring_chain,
                                                 &ll_ode_arenstorf,
                                                 &ll_ode_pleiades,
                                                 &ll_ode_figure_eight,
                                                 &ll_ode_tennis_racket,
                                                 &ll_ode_euler_top,
                                                 &ll_ode_brusselator,
                                                 &ll_ode_lotka_volterra,
                                                 &ll_ode_van_der_pol,
                                                 &ll_ode_robertson,
                                                 &ll_ode_hires,
                                                 &ll_ode_oregonator,
                                                 &ll_ode_prothero_robinson,
                                                 &ll_ode_bouncing_ball,
                                                 &ll_ode_penalty_floor,
                                                 &ll_ode_coulomb,
                                                 &ll_ode_coulomb_naive,
                                                 NULL};

const ll_ode_problem *ll_ode_problem_find(const char *name)
{
    for (int i = 0; ll_ode_problems[i]; i++)
        if (strcmp(ll_ode_problems[i]->name, name) == 0)
            return ll_ode_problems[i];
    return NULL;
}
