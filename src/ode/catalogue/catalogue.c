#include "ode/catalogue/catalogue.h"

#include <string.h>

#include "ode/core/problem_rows.h"
#include "ode/core/scale.h"
#include "ode/methods/methods.h"

#define ROW(NAME) &ll_ode_##NAME,
#define NAMED(NAME) #NAME,
#define TABLE(NAME) &ll_ode_##NAME##_table,

const ll_ode_method *const ll_ode_methods[] = {LL_ODE_METHODS(ROW) NULL};
const char *const ll_ode_method_names[] = {LL_ODE_METHODS(NAMED) NULL};
const ll_ode_problem *const ll_ode_problems[] = {LL_ODE_PROBLEMS(ROW) NULL};
const char *const ll_ode_problem_names[] = {LL_ODE_PROBLEMS(NAMED) NULL};
const ll_param_table *const ll_ode_problem_tables[] = {LL_ODE_PROBLEMS(TABLE)};

const ll_ode_method *ll_ode_method_find(const char *name)
{
    for (int i = 0; ll_ode_methods[i] != NULL; i++)
        if (strcmp(ll_ode_methods[i]->name, name) == 0)
            return ll_ode_methods[i];
    return NULL;
}

const ll_ode_method *ll_ode_reference_method(const ll_ode_problem *problem, int which)
{
    static const ll_ode_method *const references[2][LL_ODE_REFERENCES] = {
        {&ll_ode_dop853, &ll_ode_extrapolated_midpoint}, {&ll_ode_radau13, &ll_ode_radau9}};
    return references[problem->stiff][which];
}

const ll_ode_problem *ll_ode_problem_find(const char *name)
{
    for (int i = 0; ll_ode_problems[i]; i++)
        if (strcmp(ll_ode_problems[i]->name, name) == 0)
            return ll_ode_problems[i];
    return NULL;
}
