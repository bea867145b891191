/* Simulations of kind `fluid`: scenes of the fluid room, each with its methods.
 *
 * A tick is a step of 1 / hz, which the method divides as it needs. `side_by_side` names more fluids that run
 * side by side from the same start: other methods, parameters or sizes. A person's pointer acts on all of
 * them: the fluid under the pointer is dragged while the button is held. */
#pragma once

#include "base/run_status.h"
#include "fluid/core/fluid.h"
#include "sim/core/side_by_side.h"
#include "sim/core/sim.h"

/* One fluid: everything but the parts that all scenarios have. */
typedef struct ll_fluid_setup {
    double hz;
    int64_t shown;                                /* index of the field in frames */
    int32_t scene;                                /* index into ll_fluid_scenes */
    int16_t place;                                /* index among those side by side */
    int16_t following;                            /* number of fluids after this one in the block */
    _Alignas(8) char params[LL_FLUID_PARAMS_MAX]; /* of the scene */
    _Alignas(8) char solver[LL_FLUID_PARAMS_MAX]; /* of its method */
} ll_fluid_setup;

typedef struct ll_fluid_config {
    ll_scenario_head head;
    int64_t reserved_after_head; /* keeps the layout of a block, and so its hash */
    ll_fluid_setup setup;
    int32_t side_by_side_count, reserved;
    ll_fluid_setup side_by_side[LL_SIDE_BY_SIDE_MAX - 1];
} ll_fluid_config;

extern const ll_param_table ll_fluid_scenario_table;

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* A fluid. A block is a sequence of them, each at a multiple of 64 bytes. */
typedef struct ll_fluid_sim {
    int64_t size; /* of this one */
    ll_time now;
    int64_t ticks, held;
    double pointer[2], before[2]; /* m, pointer position now and one tick ago */
    int64_t fluid;                /* offset of the method's block from here */
    int64_t failed;               /* 1: it has failed */
    char reason[256];
    ll_fluid_setup setup;
} ll_fluid_sim;

#pragma GCC diagnostic pop

static inline const ll_fluid_scene *ll_fluid_sim_scene(const ll_fluid_setup *setup)
{
    return ll_fluid_scenes[setup->scene];
}

static inline void *ll_fluid_sim_block(const ll_fluid_sim *s)
{
    return (char *)(uintptr_t)s + s->fluid;
}

/* The next fluid; NULL after the last. */
static inline ll_fluid_sim *ll_fluid_sim_next(const ll_fluid_sim *s)
{
    return s->setup.following > 0 ? (ll_fluid_sim *)((char *)(uintptr_t)s + ((s->size + 63) & ~INT64_C(63)))
                                  : NULL;
}

/* The fluid at an index among those side by side. */
static inline const ll_fluid_sim *ll_fluid_sim_at(const void *block, int place)
{
    const ll_fluid_sim *s = block;
    for (int i = 0; i < place; i++)
        s = ll_fluid_sim_next(s);
    return s;
}

/* Fluid `i` of a scenario, in the form of its part of the block. */
ll_fluid_setup ll_fluid_sim_setup(const ll_fluid_config *config, int i);

/* Of the whole block. */
size_t ll_fluid_sim_size(const void *config);
ll_status ll_fluid_sim_init(void *block, const void *config);

/* Numbers that the method and the scene measure, at most LL_FLUID_NUMBERS_MAX; returns the count. */
int ll_fluid_sim_numbers(const ll_fluid_sim *s, ll_fluid_number *out);

/* report.c and frame.c: reports and streamed rows of a block */
struct cJSON *ll_fluid_sim_state(const void *block);
struct cJSON *ll_fluid_sim_metrics(const void *block);
extern const ll_metric_table *const ll_fluid_sim_metric_tables[];
void ll_fluid_sim_costs(const void *config, const ll_step_profiler *step_profiler, struct cJSON *cost);
struct cJSON *ll_fluid_sim_layout(const void *config);
extern const ll_metric_table *const ll_fluid_sim_trace_tables[];
void ll_fluid_sim_trace(const void *block, ll_trace_line *trace);
extern const ll_record *const ll_fluid_sim_records[];
void ll_fluid_sim_fill(const void *block, ll_row_set *rows);
