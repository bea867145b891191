/* Methods and problems as lists of names, for parameters, in the order of their tables. */
#pragma once

#include "param/param.h"

extern const char *const ll_ode_method_names[];
extern const char *const ll_ode_problem_names[];
extern const ll_param_table *const ll_ode_problem_tables[];
