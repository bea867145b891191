#include "fluid/scenes.h"
#include "sim/fluid.h"
#include "sim/kinds.h"

#define SETUP(field, ...)                                                                                    \
    {                                                                                                        \
        .name = #field, .offset = offsetof(ll_fluid_config, setup.field), __VA_ARGS__                        \
    }

static const ll_param rows[] = {
    LL_SCENARIO_ROWS,
    SETUP(scene, .type = LL_PARAM_CHOICE, .choices = ll_fluid_scene_names, .required = true,
          .help = "What flows where."),
    SETUP(params, .type = LL_PARAM_VARIANT, .variants = ll_fluid_params_tables,
          .count_offset = offsetof(ll_fluid_config, setup.scene), .help = "What varies in the scene."),
    SETUP(solver, .type = LL_PARAM_VARIANT, .variants = ll_fluid_solver_tables,
          .count_offset = offsetof(ll_fluid_config, setup.scene), .live = true,
          .help = "How it is stepped; the defaults are those that suit the scene."),
    SETUP(hz, .type = LL_PARAM_REAL, .min = 1, .max = 10000, .standard = 60, .unit = "Hz",
          .help = "Ticks per second; the method makes as many substeps of one as it needs."),
    SETUP(shown, .type = LL_PARAM_INT, .max = 15, .live = true,
          .help = "Which field frames carry, by its place in the layout; the last one for what is beyond."),
};

static ll_status check(const void *object, const char *path)
{
    const ll_fluid_setup *setup = &((const ll_fluid_config *)object)->setup;
    (void)path;
    return ll_fluid_sim_scene(setup)->check(setup->params, setup->solver);
}

const ll_param_table ll_fluid_scenario_table = {.name = "fluid",
                                                .help =
                                                    "A fluid: particles, a grid, or the surface of an ocean.",
                                                .rows = rows,
                                                .count = sizeof rows / sizeof rows[0],
                                                .size = sizeof(ll_fluid_config),
                                                .check = check};
