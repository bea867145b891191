#include "ode/core/method.h"

int ll_ode_order(const ll_ode_method *method, const ll_ode *ode)
{
    return ode->velocity_dependent && method->order_velocity > 0 ? method->order_velocity : method->order;
}

ll_status ll_ode_method_fits(const ll_ode_method *method, const ll_ode *ode)
{
    if ((method->needs & LL_ODE_NEEDS_MECHANICAL) && !ll_ode_mechanical(ode))
        return ll_field_error(LL_BAD_INPUT, "method",
                              "method: %s needs a mechanical problem, with positions and velocities.",
                              method->name);
    if ((method->needs & LL_ODE_NEEDS_MAGNETIC) && ode->magnetic == NULL)
        return ll_field_error(LL_BAD_INPUT, "method", "method: %s needs a problem with a magnetic force.",
                              method->name);
    if ((method->needs & LL_ODE_NEEDS_POSITIONS) && ode->velocity_dependent && ode->magnetic == NULL)
        return ll_field_error(LL_BAD_INPUT, "method",
                              "method: %s needs forces that are magnetic or independent of velocities.",
                              method->name);
    if ((method->needs & LL_ODE_NEEDS_TAYLOR) && ode->series == NULL)
        return ll_field_error(LL_BAD_INPUT, "method",
                              "method: %s needs a problem that is smooth and gives Taylor coefficients.",
                              method->name);
    return ll_ok();
}
