/* Reports of a simulation of rigid bodies: state, cost, layout and trace. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/run_status.h"
#include "sim/core/scenario_rows.h"
#include "sim/rigid/rigid.h"

static void number(cJSON *object, const char *name, double value)
{
    cJSON_AddItemToObject(object, name, value - value == 0 ? ll_param_number(value) : cJSON_CreateNull());
}

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
            number(cJSON_AddObjectToObject(part, name), "ns_per_sim_s",
                   ll_step_profiler_ns_per_s(step_profiler, i * LL_RIGID_PARTS + k));
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

enum { SUMMARY = 11, TRACED = 8 /* bodies */, OF_A_BODY = 5 };

static const char *const summary_names[SUMMARY] = {
    "kinetic_j",     "energy_change_j", "penetration_max_m", "sag_m", "drift_m",  "tilt_rad",
    "speed_max_mps", "joint_error",     "contacts",          "awake", "tunnelled"};
static const char *const body_names[OF_A_BODY] = {"x_m", "y_m", "angle_rad", "vx_mps", "vy_mps"};

int ll_rigid_sim_trace_columns(const void *config, char (*names)[48], int capacity)
{
    const ll_rigid_config *c = config;
    int n = 0, bodies_told = c->setup.scene > 0 || c->body_count > TRACED ? TRACED : c->body_count;
    if (capacity < ll_rigid_sim_worlds(&c->setup) * (SUMMARY + bodies_told * OF_A_BODY))
        return 0;
    for (int i = 0; i < ll_rigid_sim_worlds(&c->setup); i++) {
        for (int k = 0; k < SUMMARY; k++)
            ll_side_by_side_column(names[n++], i, summary_names[k]);
        for (int b = 0; b < bodies_told; b++)
            for (int k = 0; k < OF_A_BODY; k++) {
                char name[32];
                snprintf(name, sizeof name, "%d_%s", b, body_names[k]);
                ll_side_by_side_column(names[n++], i, name);
            }
    }
    return n;
}

/* 0 for a body that does not exist (yet). */
static void body_row(const ll_rigid *w, int32_t index, double *values)
{
    ll_body_state b = {0};
    if (index < ll_rigid_body_end(w)) {
        ll_status status = ll_rigid_get_body(w, ll_rigid_body_at(w, index), &b);
        (void)status;
    }
    const double all[OF_A_BODY] = {b.position.x, b.position.y, b.angle, b.velocity.x, b.velocity.y};
    for (int k = 0; k < OF_A_BODY; k++)
        values[k] = all[k];
}

int ll_rigid_sim_trace_row(const void *block, double *values, int capacity)
{
    const ll_rigid_sim *s = block;
    int n = 0, bodies_told = s->setup.scene > 0 || s->references > TRACED ? TRACED : (int)s->references;
    if (capacity < count_of(s) * (SUMMARY + bodies_told * OF_A_BODY))
        return 0;
    for (int i = 0; i < count_of(s); i++) {
        const ll_rigid *w = ll_rigid_sim_world(s, i);
        const ll_rigid_metrics *m = &s->record[i].now;
        const double all[SUMMARY] = {m->kinetic_energy,
                                     m->kinetic_energy + m->potential_energy - s->record[i].energy_start,
                                     m->penetration_max,
                                     m->sag_max,
                                     m->drift_max,
                                     m->tilt_max,
                                     m->speed_max,
                                     m->joint_error,
                                     ll_rigid_get_stats(w).touching,
                                     ll_rigid_get_stats(w).awake,
                                     m->passed};
        for (int k = 0; k < SUMMARY; k++)
            values[n++] = all[k];
        for (int b = 0; b < bodies_told; b++, n += OF_A_BODY)
            body_row(w, b, &values[n]);
    }
    return n;
}
