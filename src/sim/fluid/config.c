#include <stdio.h>
#include <string.h>

#include "fluid/scenes/scenes.h"
#include "sim/core/scenario_rows.h"
#include "sim/fluid/fluid.h"

/* The rows of one fluid; `first` is the prefix of its members in the struct. */
#define FLUID_ROWS(owner, first, needed)                                                                     \
    {.name = "scene",                                                                                        \
     .type = LL_PARAM_CHOICE,                                                                                \
     .offset = offsetof(owner, first scene),                                                                 \
     .choices = ll_fluid_scene_names,                                                                        \
     .required = needed,                                                                                     \
     .help = "Scene: the fluid and its container."},                                                         \
        {.name = "params",                                                                                   \
         .type = LL_PARAM_VARIANT,                                                                           \
         .offset = offsetof(owner, first params),                                                            \
         .variants = ll_fluid_params_tables,                                                                 \
         .count_offset = offsetof(owner, first scene),                                                       \
         .help = "Parameters of the scene."},                                                                \
        {.name = "solver",                                                                                   \
         .type = LL_PARAM_VARIANT,                                                                           \
         .offset = offsetof(owner, first solver),                                                            \
         .variants = ll_fluid_solver_tables,                                                                 \
         .count_offset = offsetof(owner, first scene),                                                       \
         .live = true,                                                                                       \
         .help = "Time stepping; the defaults are those that suit the scene."},                              \
    {                                                                                                        \
        .name = "shown", .type = LL_PARAM_INT, .offset = offsetof(owner, first shown), .max = 15,            \
        .live = true,                                                                                        \
        .help =                                                                                              \
            "Field that frames contain, by its index in the layout; a larger index selects the last one."    \
    }

static ll_status check_one(const void *object, const char *path)
{
    const ll_fluid_setup *setup = object;
    ll_status status = ll_fluid_sim_scene(setup)->check(setup->params, setup->solver);
    char field[sizeof status.field];
    if (!ll_failed(&status) || path[0] == '\0')
        return status;
    snprintf(field, sizeof field, "%.16s%.40s", path, status.field);
    return ll_field_error(status.code, field, "%s%s", path, status.text);
}

static const ll_param side_by_side_rows[] = {FLUID_ROWS(ll_fluid_setup, , false)};

static const ll_param_table side_by_side_table = {
    .name = "fluid_side_by_side",
    .help = "A fluid next to the first; parameters that are not given are the first one's.",
    LL_PARAM_ROWS(side_by_side_rows, ll_fluid_setup),
    .check = check_one};

static void as_the_first(const void *object, void *element)
{
    memcpy(element, &((const ll_fluid_config *)object)->setup, sizeof(ll_fluid_setup));
}

static const ll_param rows[] = {
    LL_SCENARIO_ROWS,
    FLUID_ROWS(ll_fluid_config, setup., true),
    {LL_PARAM_ROW("hz", REAL, ll_fluid_config, setup.hz), .min = 1, .max = 10000, .default_value = 60,
     .unit = "Hz", .help = "Ticks per second; the method makes as many substeps per tick as it needs."},
    {LL_PARAM_ROW("side_by_side", ARRAY, ll_fluid_config, side_by_side), .max = LL_SIDE_BY_SIDE_MAX - 1,
     .child = &side_by_side_table, .count_offset = offsetof(ll_fluid_config, side_by_side_count),
     .live = true, .begin = as_the_first,
     .help = "Fluids side by side with the first from the same start; each gives its differences from the "
             "first."},
};

static ll_status check(const void *object, const char *path)
{
    const ll_fluid_config *c = object;
    ll_status status = check_one(&c->setup, path);
    if (ll_failed(&status) || c->side_by_side_count == 0)
        return status;
    char what[32];
    snprintf(what, sizeof what, "%d fluids side by side", c->side_by_side_count + 1);
    return ll_fluid_check_bytes("side_by_side", what, (int64_t)ll_fluid_sim_size(c));
}

const ll_param_table ll_fluid_scenario_table = {.name = "fluid",
                                                .help =
                                                    "A fluid: particles, a grid, or the surface of an ocean.",
                                                LL_PARAM_ROWS(rows, ll_fluid_config),
                                                .check = check};
