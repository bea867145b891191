/* Reports of a simulation of rigid bodies: state, cost, layout and trace. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/run_status.h"
#include "sim/core/scenario_rows.h"
#include "sim/rigid/rigid.h"

static int count_of(const ll_rigid_sim *s)
{
    return ll_rigid_sim_worlds(&s->setup);
}

static cJSON *state_of(const void *block, int i)
{
    cJSON *o = cJSON_CreateObject();
    ll_rigid_sim_add_bodies(o, block, i);
    return o;
}

cJSON *ll_rigid_sim_state(const void *block)
{
    return ll_side_by_side_report(block, count_of(block), state_of);
}

/* ---- cost ---- */

void ll_rigid_sim_costs(const void *config, const ll_step_profiler *step_profiler, cJSON *cost)
{
    const ll_rigid_config *c = config;
    cJSON *parts = cJSON_AddArrayToObject(cost, "parts");
    for (int i = 0; i < ll_rigid_sim_worlds(&c->setup); i++) {
        cJSON *part = cJSON_CreateObject();
        int count = c->setup.compare_volumes ? LL_RIGID_PARTS : LL_PHASES + 1;
        for (int k = 0; k < count; k++) {
            char name[32];
            snprintf(name, sizeof name, "%s%s", k > LL_PHASES ? "volume_" : "",
                     k > LL_PHASES    ? ll_volume_names[k - LL_PHASES - 1]
                     : k == LL_PHASES ? "all"
                                      : ll_rigid_phase_names[k]);
            double ns = ll_step_profiler_ns_per_s(step_profiler, i * LL_RIGID_PARTS + k);
            cJSON_AddItemToObject(cJSON_AddObjectToObject(part, name), "ns_per_sim_s", ll_param_number(ns));
        }
        cJSON_AddItemToArray(parts, part);
    }
}

/* ---- layout ---- */

static void add_view(cJSON *layout, const void *config)
{
    ll_rigid_sim *s = malloc(ll_rigid_sim_size(config));
    cJSON *view = cJSON_AddArrayToObject(layout, "view");
    if (s == NULL)
        return;
    ll_status status = ll_rigid_sim_init(s, config);
    for (int i = 0; i < 4 && !ll_failed(&status); i++)
        cJSON_AddItemToArray(view, ll_param_number(s->view[i]));
    free(s);
}

cJSON *ll_rigid_sim_layout(const void *config)
{
    const ll_rigid_setup *setup = &((const ll_rigid_config *)config)->setup;
    const ll_scene *scene = ll_rigid_sim_scene(setup);
    cJSON *layout = cJSON_CreateObject(), *rigid = cJSON_AddObjectToObject(layout, "rigid");
    cJSON_AddStringToObject(rigid, "scene", ll_scene_names[setup->scene]);
    cJSON_AddStringToObject(rigid, "title", scene != NULL ? scene->title : "");
    cJSON_AddStringToObject(rigid, "help", scene != NULL ? scene->help : "");
    cJSON_AddNumberToObject(rigid, "worlds", ll_rigid_sim_worlds(setup));
    cJSON_AddNumberToObject(rigid, "hz", setup->hz);
    add_view(rigid, config);
    cJSON *solvers = cJSON_AddArrayToObject(rigid, "solvers");
    for (int i = 0; i < LL_SOLVERS; i++) {
        cJSON *o = cJSON_CreateObject();
        cJSON_AddStringToObject(o, "name", ll_rigid_solver_names[i]);
        cJSON_AddStringToObject(o, "help", ll_rigid_solver_help((ll_rigid_solver_kind)i));
        cJSON_AddItemToArray(solvers, o);
    }
    return layout;
}

/* ---- trace ---- */

enum { TRACED = 8 /* bodies */ };

#define WORLD_COLUMNS(X)                                                                                     \
    X(number, kinetic_j, "J", m->kinetic_energy, "kinetic energy of all bodies", NULL)                       \
    X(signed_number, energy_change_j, "J",                                                                   \
      m->kinetic_energy + m->potential_energy - s->record[i].energy_start,                                   \
      "change of the kinetic and potential energy since the start", NULL)                                    \
    X(number, penetration_max_m, "m", m->penetration_max, "largest penetration of a contact point", NULL)    \
    X(number, sag_m, "m", m->sag_max, "largest distance of a dynamic body below its resting position", NULL) \
    X(number, drift_m, "m", m->drift_max,                                                                    \
      "largest sideways distance of a dynamic body from its position at the start", NULL)                    \
    X(number, tilt_rad, "rad", m->tilt_max,                                                                  \
      "largest rotation of a dynamic body from its angle at the start", NULL)                                \
    X(number, speed_max_mps, "m/s", m->speed_max, "speed of the fastest body", NULL)                         \
    X(number, joint_error, "m or rad", m->joint_error, "largest error of a joint that is not a spring",      \
      NULL)                                                                                                  \
    X(count, contacts, NULL, ll_rigid_get_stats(w).touching, "pairs of shapes that touch", NULL)             \
    X(count, awake, NULL, ll_rigid_get_stats(w).awake, "bodies that do not sleep", NULL)                     \
    X(count, tunnelled, NULL, m->passed, "dynamic bodies whose centre is beyond tunnel_x", NULL)

#define BODY_COLUMNS(X)                                                                                      \
    X(signed_number, x_m, "m", b.position.x, "position of the body frame: x", NULL)                          \
    X(signed_number, y_m, "m", b.position.y, "position of the body frame: y", NULL)                          \
    X(signed_number, angle_rad, "rad", b.angle, "angle of the body frame", NULL)                             \
    X(signed_number, vx_mps, "m/s", b.velocity.x, "velocity of the centre of mass: x", NULL)                 \
    X(signed_number, vy_mps, "m/s", b.velocity.y, "velocity of the centre of mass: y", NULL)

static const ll_metric_table world_columns = {.path = "", .help = "A world.", LL_METRICS_FROM(WORLD_COLUMNS)};
static const ll_metric_table body_columns = {
    .path = "*_",
    .help = "A body: one of the first 8; 0 for a body that does not exist (yet).",
    LL_METRICS_FROM(BODY_COLUMNS)};

const ll_metric_table *const ll_rigid_sim_trace_tables[] = {&world_columns, &body_columns, NULL};

static void trace_body(const ll_rigid *w, int32_t index, ll_trace_line *trace)
{
    ll_body_state b = {0};
    if (index < ll_rigid_body_end(w)) {
        ll_status status = ll_rigid_get_body(w, ll_rigid_body_at(w, index), &b);
        (void)status;
    }
    LL_TRACE_PUT(trace, &body_columns, index, BODY_COLUMNS);
}

void ll_rigid_sim_trace(const void *block, ll_trace_line *trace)
{
    const ll_rigid_sim *s = block;
    int bodies = s->setup.scene > 0 || s->references > TRACED ? TRACED : (int)s->references;
    for (int i = 0; i < count_of(s); i++) {
        const ll_rigid *w = ll_rigid_sim_world(s, i);
        const ll_rigid_metrics *m = &s->record[i].now;
        ll_side_by_side_trace(trace, i);
        LL_TRACE_PUT(trace, &world_columns, 0, WORLD_COLUMNS);
        for (int32_t b = 0; b < bodies; b++)
            trace_body(w, b, trace);
    }
}
