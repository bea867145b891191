#include "fluid/core/fluid.h"

#include <string.h>

#include "fluid/scenes/scenes.h"

#define ROW(name) &ll_fluid_##name,
#define NAME(name) #name,
#define PARAMS(name) &ll_fluid_##name##_params,
#define SOLVER(name) &ll_fluid_##name##_solver,

const ll_fluid_scene *const ll_fluid_scenes[] = {LL_FLUID_SCENES(ROW) NULL};
const char *const ll_fluid_scene_names[] = {LL_FLUID_SCENES(NAME) NULL};
const ll_param_table *const ll_fluid_params_tables[] = {LL_FLUID_SCENES(PARAMS) NULL};
const ll_param_table *const ll_fluid_solver_tables[] = {LL_FLUID_SCENES(SOLVER) NULL};

const ll_fluid_scene *ll_fluid_scene_find(const char *name)
{
    for (int i = 0; ll_fluid_scenes[i]; i++)
        if (strcmp(ll_fluid_scenes[i]->name, name) == 0)
            return ll_fluid_scenes[i];
    return NULL;
}
