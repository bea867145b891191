/* Reports of a simulation of rigid bodies: state, metrics, cost, layout and trace. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/run_status.h"
#include "sim/core/scenario_rows.h"
#include "sim/rigid/rigid.h"

enum { BODIES_REPORTED = 1000 };

static void number(cJSON *object, const char *name, double value)
{
    cJSON_AddItemToObject(object, name, value - value == 0 ? ll_param_number(value) : cJSON_CreateNull());
}

static void vector(cJSON *object, const char *name, ll_vec2 v)
{
    cJSON *array = cJSON_AddArrayToObject(object, name);
    cJSON_AddItemToArray(array, v.x - v.x == 0 ? ll_param_number(v.x) : cJSON_CreateNull());
    cJSON_AddItemToArray(array, v.y - v.y == 0 ? ll_param_number(v.y) : cJSON_CreateNull());
}

/* ---- bodies ---- */

static cJSON *body_json(const ll_rigid *w, ll_body_id id)
{
    ll_body_state b;
    cJSON *o = cJSON_CreateObject();
    ll_status status = ll_rigid_get_body(w, id, &b);
    if (ll_failed(&status))
        return o;
    cJSON_AddNumberToObject(o, "body", id.index);
    cJSON_AddStringToObject(o, "type", ll_body_type_names[b.type]);
    vector(o, "position", b.position);
    number(o, "angle", b.angle);
    vector(o, "velocity", b.velocity);
    number(o, "angular_velocity", b.angular_velocity);
    cJSON_AddBoolToObject(o, "awake", b.awake);
    return o;
}

/* Element i of a list of bodies is body i. Of a large scene only the first bodies are reported. */
static void bodies(cJSON *object, const ll_rigid_sim *s, int i)
{
    const ll_rigid *w = ll_rigid_sim_world(s, i);
    cJSON *array = cJSON_AddArrayToObject(object, "bodies");
    int count = 0;
    for (int32_t k = 0; k < ll_rigid_body_end(w) && count < BODIES_REPORTED; k++) {
        ll_body_id id = ll_rigid_body_at(w, k);
        if (id.index == 0 || id.index == s->record[i].hand.index)
            continue;
        cJSON_AddItemToArray(array, body_json(w, id));
        count++;
    }
}

static int count_of(const ll_rigid_sim *s)
{
    return ll_rigid_sim_worlds(&s->setup);
}

static cJSON *state_of(const void *block, int i)
{
    cJSON *o = cJSON_CreateObject();
    bodies(o, block, i);
    return o;
}

cJSON *ll_rigid_sim_state(const void *block)
{
    return ll_side_by_side_report(block, count_of(block), state_of);
}

/* ---- metrics ---- */

const char *const ll_rigid_sim_signed_metrics[] = {"energy_j", "energy_change_j",  "spin_momentum_kgm2ps",
                                                   "angle",    "angular_velocity", NULL};

/* Change beyond that by gravity; unknown with static or kinematic bodies, for which momentum is not
 * conserved. */
static double momentum_error(const ll_rigid_sim *s, int i)
{
    const ll_rigid *w = ll_rigid_sim_world(s, i);
    const ll_rigid_record *r = &s->record[i];
    if (r->now.bodies != ll_rigid_get_stats(w).bodies)
        return NAN;
    double t = (double)ll_rigid_get_stats(w).step / s->setup.hz;
    ll_vec2 gravity = ll_vec(r->mass * t * s->setup.gravity[0], r->mass * t * s->setup.gravity[1]);
    ll_vec2 start = ll_vec(r->momentum_start[0], r->momentum_start[1]);
    return ll_length(ll_sub(ll_sub(r->now.momentum, start), gravity));
}

/* Null for a world that has failed. */
static void measured(cJSON *o, const ll_rigid_sim *s, int i)
{
    const ll_rigid_record *r = &s->record[i];
    const ll_rigid_metrics *m = &r->now;
    double energy = m->kinetic_energy + m->potential_energy, known = r->diverged_at < 0 ? 1 : NAN;
    const struct {
        const char *name;
        double value;
    } all[] = {{"penetration_max_m", m->penetration_max},
               {"penetration_mean_m", m->penetration_mean},
               {"penetration_worst_m", r->penetration_worst},
               {"drift_m", m->drift_max},
               {"drift_worst_m", r->drift_worst},
               {"sag_m", m->sag_max},
               {"sag_worst_m", r->sag_worst},
               {"tilt_rad", m->tilt_max},
               {"tilt_worst_rad", r->tilt_worst},
               {"joint_error", m->joint_error},
               {"joint_error_worst", r->joint_error_worst},
               {"speed_max_mps", m->speed_max},
               {"kinetic_j", m->kinetic_energy},
               {"energy_j", energy},
               {"energy_change_j", energy - r->energy_start},
               {"energy_added_j", r->energy_most},
               {"momentum_error_kgmps", momentum_error(s, i)},
               {"spin_momentum_kgm2ps", m->spin_momentum},
               {"tunnelled", m->passed},
               {"stopped", (double)r->stopped},
               {"steps_asleep", (double)r->steps_asleep},
               {"asleep_at_step", r->asleep_at < 0 ? NAN : (double)r->asleep_at},
               {"over_limit_steps", (double)r->over_limit}};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        number(o, all[k].name, known * all[k].value);
    vector(o, "momentum_kgmps", ll_vec(known * m->momentum.x, known * m->momentum.y));
}

static void counted(cJSON *o, const ll_rigid *w)
{
    ll_rigid_stats t = ll_rigid_get_stats(w);
    const struct {
        const char *name;
        int32_t value;
    } all[] = {{"body_count", t.bodies}, {"awake", t.awake},       {"joints", t.joints},
               {"pairs", t.pairs},       {"contacts", t.touching}, {"points", t.points},
               {"recycled", t.recycled}, {"tested", t.tested},     {"colours", t.colours},
               {"overflow", t.overflow}, {"islands", t.islands}};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++)
        cJSON_AddNumberToObject(o, all[k].name, all[k].value);
}

/* Over the solid shapes: total area of the volumes above that of the shapes, in percent. */
static double overestimate(const ll_rigid *w, ll_volume volume)
{
    double exact = 0, bound = 0;
    for (int32_t i = 0; i < ll_rigid_shape_end(w); i++) {
        ll_shape_view v;
        if (!ll_rigid_shape_at(w, i, &v) || !ll_shape_is_solid((ll_shape_kind)v.geometry.kind))
            continue;
        exact += ll_shape_area(&v.geometry);
        bound += ll_bound_area(volume, &v.geometry, v.pose.q);
    }
    return exact > 0 ? 100 * (bound / exact - 1) : 0;
}

static void volumes(cJSON *o, const ll_rigid_sim *s, int i)
{
    cJSON *all = cJSON_AddObjectToObject(o, "volumes");
    for (int v = 0; v < LL_VOLUMES; v++) {
        const ll_volume_record *r = &s->record[i].volume[v];
        cJSON *one = cJSON_AddObjectToObject(all, ll_volume_names[v]);
        number(one, "area_overestimated_pct", overestimate(ll_rigid_sim_world(s, i), (ll_volume)v));
        number(one, "tests", (double)r->tests);
        number(one, "hits", (double)r->hits);
        number(one, "false_hits", (double)r->false_hits);
        number(one, "missed_hits", (double)r->missed_hits);
        number(one, "gap_mean_m", r->false_hits > 0 ? r->gap_sum / (double)r->false_hits : 0);
        number(one, "gap_max_m", r->gap_max);
    }
}

static cJSON *metrics_of(const void *block, int i)
{
    const ll_rigid_sim *s = block;
    const ll_rigid_record *r = &s->record[i];
    ll_rigid_params p = ll_rigid_sim_params(&s->setup, i);
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "scene", ll_scene_names[s->setup.scene]);
    cJSON_AddStringToObject(o, "method", ll_rigid_solver_names[p.solver]);
    cJSON_AddStringToObject(o, "status",
                            ll_run_status_names[r->diverged_at >= 0 ? LL_RUN_DIVERGED : LL_RUN_OK]);
    if (r->diverged_at >= 0)
        cJSON_AddStringToObject(o, "reason", r->reason);
    measured(o, s, i);
    number(o, "passes_per_s", s->setup.hz * ll_rigid_passes(&p));
    counted(o, ll_rigid_sim_world(s, i));
    volumes(o, s, i);
    bodies(o, s, i);
    return o;
}

cJSON *ll_rigid_sim_metrics(const void *block)
{
    return ll_side_by_side_report(block, count_of(block), metrics_of);
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

static void time_volumes(const ll_rigid *w, cJSON *o, int64_t (*now_ns)(void))
{
    cJSON *all = cJSON_GetObjectItemCaseSensitive(o, "volumes");
    for (int v = 0; v < LL_VOLUMES; v++)
        number(cJSON_GetObjectItemCaseSensitive(all, ll_volume_names[v]), "ns_per_test",
               ll_rigid_sim_time_volume(w, (ll_volume)v, now_ns));
}

void ll_rigid_sim_time_parts(const void *config, cJSON *metrics, int64_t (*now_ns)(void))
{
    ll_rigid_sim *s = malloc(ll_rigid_sim_size(config));
    if (s == NULL)
        return;
    ll_status status = ll_rigid_sim_init(s, config);
    for (int i = 0; i < count_of(s) && !ll_failed(&status); i++) {
        cJSON *o = metrics;
        if (i > 0)
            o = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(metrics, "side_by_side"), i - 1);
        if (s->setup.compare_volumes)
            time_volumes(ll_rigid_sim_world(s, i), o, now_ns);
    }
    free(s);
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
