#include "ode/methods/methods.h"

#include <string.h>

#include "ode/core/scale.h"

#define ROW(NAME) &ll_ode_##NAME,
const ll_ode_method *const ll_ode_methods[] = {LL_ODE_METHODS(ROW) NULL};

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
